"""The crank: prescribed motion as forcing, and the free crank."""

from __future__ import annotations

import numpy as np
import pytest
from support.layouts import random_drive

from beltsim.model import assemble, chain, crank

ORDERS = {
    "firing_order": 2.0,
    "speed_fluctuation": None,
    "orders": [
        {"order": 2.0, "angle_amplitude_deg": 1.5, "phase_deg": 30.0},
        {"order": 0.5, "speed_fluctuation": 0.02, "phase_deg": -100.0},
        {"order": 3.0, "angle_amplitude_deg": 0.3},
    ],
}


@pytest.mark.parametrize("travel", ["cw", "ccw"])
@pytest.mark.parametrize("seed", [1, 2])
def test_forcing_is_what_the_cranks_column_does(seed, travel):
    """The free-crank system, with the crank moved as prescribed, pulls on the rest like f."""
    drive = random_drive(np.random.default_rng(seed), 4, travel).changed(excitation=ORDERS)
    problem, driven = assemble(drive, n_functions=4), chain(drive, n_functions=4)
    full = crank.release(driven.system)
    name = next(p.name for p in drive.pulleys if p.role == "crank")
    c = full.coordinates.labels.index(f"theta_{name}")
    rest = [i for i in range(len(full.M)) if i != c]
    assert [full.coordinates.labels[i] for i in rest] == list(problem.labels)
    t = np.linspace(0.0, problem.period, 17)
    speed = drive.Omega / 2.0
    angle, rate, push = np.zeros((3, len(t)))
    for order in drive.orders:
        w = order.order * speed
        phase = w * t + order.phase_rad
        angle += order.angle_amplitude_rad * np.sin(phase)
        rate += order.angle_amplitude_rad * w * np.cos(phase)
        push -= order.angle_amplitude_rad * w**2 * np.sin(phase)
    expected = -(
        np.multiply.outer(push, full.M[rest, c])
        + np.multiply.outer(rate, full.G[rest, c])
        + np.multiply.outer(angle, full.K[rest, c])
    )
    assert problem.forcing.at(t) == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    for matrix in "MGK":
        reduced = getattr(full, matrix)[np.ix_(rest, rest)]
        assert np.array_equal(getattr(problem, matrix), reduced)


def test_tensions_follow_the_crank_and_the_coordinates():
    """P_d from the free-crank rows, with the crank's angle put in by hand."""
    drive = random_drive(np.random.default_rng(3), 4, "ccw").changed(excitation=ORDERS)
    problem, driven = assemble(drive, n_functions=4), chain(drive, n_functions=4)
    full = crank.release(driven.system)
    name = next(p.name for p in drive.pulleys if p.role == "crank")
    c = full.coordinates.labels.index(f"theta_{name}")
    t = np.linspace(0.0, problem.period, 9)
    q = np.random.default_rng(0).normal(size=(9, problem.n)) * 0.01
    angle = sum(
        o.angle_amplitude_rad * np.sin(o.order * drive.Omega / 2.0 * t + o.phase_rad)
        for o in drive.orders
    )
    everything = np.insert(q, c, angle, axis=1)
    steady = driven.system.state.p[driven.drive.frame.spans]
    expected = everything @ full.tension_rows.T + steady
    for i in range(4):
        found = problem.observables[i].at(t, q, problem.forcing.Omega)
        assert found == pytest.approx(expected[:, i], rel=1e-11)


def test_a_crank_that_does_not_oscillate_does_not_force():
    drive = random_drive(np.random.default_rng(4), 3)
    problem = assemble(drive.changed(excitation={"speed_fluctuation": 0.0}), n_functions=3)
    assert not problem.forcing.cos.any()
    assert not problem.forcing.sin.any()
