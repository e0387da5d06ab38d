"""The model against an evaluation of the nonlinear equations that shares no code with it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.layouts import drives, random_drive
from support.strong_form import StrongForm

from beltsim import linear
from beltsim.drive.presets import zhu_parker_2008
from beltsim.model import assemble, chain, crank

AGREEMENT = 1e-7
MATRIX_AGREEMENT = 1e-11  # quadrature and complex step leave rounding only


def close(found, expected, tolerance=AGREEMENT):
    assert np.abs(np.asarray(found) / expected - 1.0).max() < tolerance


def compare(drive, counts, residual_flexibility):
    options = {"n_functions": counts, "residual_flexibility": residual_flexibility}
    expected = StrongForm(drive, drive.Omega, counts, residual_flexibility)
    assert np.abs(expected.residual_at_rest).max() < 1e-11

    driven = chain(drive, **options)
    state, frame = driven.system.state, driven.drive.frame
    assert np.abs(state.p[frame.spans] - expected.p).max() < 1e-11
    assert abs(frame.sign * state.theta_t - expected.theta_t) < 1e-11

    full = crank.release(driven.system)
    for name in ("M", "G", "K"):
        right = getattr(expected, name)
        gap = np.abs(getattr(full, name) - right).max()
        assert gap < MATRIX_AGREEMENT * np.abs(right).max(), name

    problem = assemble(drive, **options)
    close(linear.frequencies(problem), expected.frequencies())
    if problem.joint is not None:
        close(linear.frequencies(problem, locked=True), expected.frequencies(locked=True))
        close(linear.critical_torque(problem), expected.critical_torque())


@settings(derandomize=True, deadline=None, max_examples=30)
@given(drives(), st.integers(1, 7), st.booleans())
def test_random_drives(drive, most, residual_flexibility):
    rng = np.random.default_rng(most)
    counts = rng.integers(1, most + 1, len(drive.pulleys)).tolist()
    compare(drive, counts, residual_flexibility)


@pytest.mark.parametrize("residual_flexibility", [True, False])
@pytest.mark.parametrize("travel", ["cw", "ccw"])
def test_fixed_centres(travel, residual_flexibility):
    drive = random_drive(np.random.default_rng(4), 5, travel, arm=False)
    compare(drive, [3, 5, 2, 4, 3], residual_flexibility)


@pytest.mark.parametrize("travel", ["cw", "ccw"])
def test_string_without_bending(travel):
    drive = random_drive(np.random.default_rng(5), 4, travel, epsilon=0.0)
    compare(drive, [4, 2, 5, 3], True)


@pytest.mark.parametrize("travel", ["cw", "ccw"])
def test_stiff_belt(travel):
    """Layers as wide as the span: the exponentials do not die out."""
    compare(random_drive(np.random.default_rng(6), 4, travel, epsilon=0.12), [3, 3, 3, 3], True)


@pytest.mark.parametrize("epsilon", [0.01, 0.05, 0.2])
def test_the_published_drive(epsilon):
    """Overrides, and for 0.2 a state far outside the linear geometry."""
    compare(zhu_parker_2008(epsilon=epsilon), [4, 5, 5], False)


@pytest.mark.parametrize("travel", ["cw", "ccw"])
def test_several_orders(travel):
    drive = random_drive(np.random.default_rng(8), 4, travel)
    drive = drive.changed(
        excitation={
            "firing_order": 2.0,
            "speed_fluctuation": None,
            "orders": [
                {"order": 2.0, "angle_amplitude_deg": 1.2, "phase_deg": 20.0},
                {"order": 0.5, "angle_amplitude_deg": 0.4},
                {"order": 4.0, "speed_fluctuation": 0.02, "phase_deg": -75.0},
            ],
        },
    )
    expected = StrongForm(drive, drive.Omega, [4] * 4)
    problem = assemble(drive, n_functions=4)
    close(problem.forcing.Omega, drive.Omega / 4.0)
    close(linear.critical_torque(problem), expected.critical_torque())
