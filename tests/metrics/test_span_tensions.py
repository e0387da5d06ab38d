"""Dynamic span tensions (eq. 28)."""

from __future__ import annotations

import numpy as np
import pytest
from support.layouts import random_drive
from support.problems import random_problem
from support.responses import stick_slip

from beltsim import linear
from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import InvalidProblemError
from beltsim.metrics.span_tensions import (
    dynamic_tensions,
    peak_dynamic_tensions,
    steady_tensions,
    tension_harmonics,
    tensions_of,
)
from beltsim.model import assemble, chain


def test_equation_28_of_the_published_drive():
    """Pulley and arm terms by hand from Table 1 (plain gamma = 400); the integral by quadrature."""
    drive = zhu_parker_2008()
    options = {"n_functions": 4, "residual_flexibility": False}
    problem, state = assemble(drive, 6.3, **options), chain(drive, 6.3, **options).system.state
    l = np.array([0.1548, 0.3449, 0.5518])
    r = np.array([0.0889, 0.0452, 0.0270])
    b1, b2 = np.radians([135.79, 178.74])
    rows = np.array([seen.row for seen in tensions_of(problem)])
    at = {label: i for i, label in enumerate(problem.labels)}
    expected = 400.0 * np.array([[-r[1], r[1], 0.0], [0.0, -r[2], r[2]]]) / l
    assert rows[:, at["theta_2"]] == pytest.approx(expected[0])
    assert rows[:, at["theta_3"]] == pytest.approx(expected[1])
    chord = [0.0970 / l[0] * np.cos(b1), -0.0970 / l[1] * np.cos(b2), 0.0]
    arm = 400.0 * np.array([-0.0970 * np.sin(b1), 0.0970 * np.sin(b2), 0.0]) / l
    assert rows[:, at["theta_t"]] == pytest.approx(arm + 400.0 * np.square(chord) * state.theta_t)
    crank = 0.1 / 3.0 * 400.0 * np.array([r[0], 0.0, -r[0]]) / l
    assert [seen.sin[1] for seen in tensions_of(problem)] == pytest.approx(crank)
    x = (np.arange(200_000) + 0.5) / 200_000
    slope = np.gradient(state.deflection(x), x, axis=1)
    for i in range(3):
        for k in (1, 4):
            moved = np.mean(k * np.pi * np.cos(k * np.pi * x) * slope[i])
            assert rows[i, at[f"span{i + 1}.sin{k}"]] == pytest.approx(400.0 * moved, rel=1e-4)


@pytest.mark.parametrize("travel", ["cw", "ccw"])
def test_peaks_are_those_of_the_time_series(travel):
    drive = random_drive(np.random.default_rng(1), 4, travel).changed(
        excitation={
            "speed_fluctuation": None,
            "orders": [
                {"order": 1.0, "angle_amplitude_deg": 0.3, "phase_deg": 40.0},
                {"order": 2.5, "angle_amplitude_deg": 0.1},
            ],
        }
    )
    problem = assemble(drive, n_functions=4)
    c = linear.response(problem)
    Omega = problem.forcing.Omega
    t = np.linspace(0.0, problem.period, 20001)
    q = (np.exp(1j * Omega * np.multiply.outer(t, np.arange(len(c)))) @ c).real
    peaks = peak_dynamic_tensions(problem, c)
    for i, seen in enumerate(tensions_of(problem)):
        dynamic = seen.at(t, q, Omega) - steady_tensions(problem)[i]
        assert np.abs(dynamic).max() == pytest.approx(peaks[i], rel=1e-6)


def test_the_cranks_part_counts_without_any_response():
    problem = assemble(zhu_parker_2008(), 6.3, n_functions=3)
    direct = tension_harmonics(problem, np.zeros((1, problem.n)))
    assert direct.shape == (2, 3)
    assert np.abs(direct[1, [0, 2]]).min() > 1.0
    assert direct[1, 1] == 0.0


def test_samples_of_a_response_without_the_steady_part():
    response = stick_slip()
    found = dynamic_tensions(response)
    assert found.shape == (len(response.t), 1)
    total = response.observe("tension of span 1")
    assert found[:, 0] == pytest.approx(total - 0.9)


def test_a_problem_without_tensions():
    with pytest.raises(InvalidProblemError, match=r"observables = .*an assembled drive"):
        steady_tensions(random_problem(0, 3))
