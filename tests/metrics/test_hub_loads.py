"""Forces of the belt on the pulleys: balance, and the arm's own equation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from support.layouts import drives, random_drive

from beltsim import linear
from beltsim.drive.presets import zhu_parker_2008
from beltsim.friction import Coulomb
from beltsim.metrics.hub_loads import (
    dynamic_hub_loads,
    hub_load_harmonics,
    hub_load_rows,
    newtons,
    steady_hub_loads,
)
from beltsim.model import assemble, chain
from beltsim.response import EventLog, NearGrazing, Response

N = 5


@settings(max_examples=25)
@given(drives())
def test_steady_loads_sum_to_zero(drive):
    loads = steady_hub_loads(chain(drive, n_functions=2).system.state)
    assert loads.shape == (len(drive.pulleys), 2)
    assert np.abs(loads.sum(axis=0)).max() < 1e-13 * np.abs(loads).max()


@settings(max_examples=25)
@given(drives())
def test_the_arm_feels_the_hub_load_of_its_pulley(drive):
    """nu.F is the belt's moment on the arm (over r_t): steady, and in every coefficient of the
    arm's row, where the residual flexibility and the weak shears must agree with Galerkin's."""
    driven = chain(drive, n_functions=N)
    scaled, state, arm = driven.drive, driven.system.state, drive.layout.arm
    nu, sign = drive.layout.arm_normal, driven.drive.frame.sign
    steady = steady_hub_loads(state)[arm] @ nu
    spring = sign * (scaled.k_s * state.theta_t + scaled.preload)
    assert steady == pytest.approx(spring, abs=1e-9)

    rows = hub_load_rows(driven)
    K, G, M = (getattr(driven, name)[-1].copy() for name in "KGM")
    K[-1] -= scaled.k_s
    M[-1] -= scaled.m_t
    for found, belt in ((rows.stiffness, K), (rows.velocity, G), (rows.mass, M)):
        assert nu @ found[arm] == pytest.approx(-belt, abs=1e-11 * np.abs(belt).max())
    crank = np.array([nu @ harmonic for harmonic in rows.crank[:, arm]])
    force = driven.cos[:, -1] - 1j * driven.sin[:, -1]
    assert crank == pytest.approx(force, abs=1e-11 * np.abs(force).max())


def test_a_string_at_rest_pulls_along_its_spans():
    """Without bending, torque and speed every span pulls with P0, so loads follow from wraps."""
    drive = random_drive(np.random.default_rng(1), 5, torques=False, epsilon=0.0)
    driven = chain(drive, 0.0, n_functions=2)
    loads = newtons(driven, steady_hub_loads(driven.system.state))
    expected = 2.0 * drive.belt.initial_tension_N * np.sin(0.5 * drive.layout.wrap_rad)
    assert np.hypot(*loads.T) == pytest.approx(np.abs(expected), rel=1e-9)


def test_travel_changes_nothing_at_rest():
    one = random_drive(np.random.default_rng(2), 5, "cw", torques=False)
    two = one.changed(crank_rotation="ccw")
    loads = [steady_hub_loads(chain(d, 0.0, n_functions=2).system.state) for d in (one, two)]
    assert loads[0] == pytest.approx(loads[1], rel=1e-10)


def test_overrides_miss_the_arms_row_by_their_own_error():
    """Directions come from the coordinates, so the published overrides leave about a thousandth."""
    drive = zhu_parker_2008()
    driven = chain(drive, 6.3, n_functions=N)
    state, scaled = driven.system.state, driven.drive
    moment = steady_hub_loads(state)[1] @ drive.layout.arm_normal
    gap = abs(moment - scaled.k_s * state.theta_t - scaled.preload)
    assert 1e-6 < gap < 2e-3


@pytest.mark.parametrize("travel", ["cw", "ccw"])
def test_samples_and_harmonics_agree(travel):
    """The steady locked response as a Response: accelerations from the equations of motion, with
    the reaction as friction torque."""
    drive = random_drive(np.random.default_rng(3), 4, travel)
    problem, driven = assemble(drive, n_functions=N), chain(drive, n_functions=N)
    problem = problem.with_friction(Coulomb(2.0 * linear.critical_torque(problem)))
    c, held = linear.response(problem, locked=True), linear.reaction(problem)
    Omega, k = problem.forcing.Omega, np.arange(len(c))
    t = np.linspace(0.0, problem.period, 9)
    wave = np.exp(1j * Omega * np.multiply.outer(t, k))
    q, q_dot = (wave @ c).real, (wave @ (1j * k[:, None] * Omega * c)).real
    ends = [np.concatenate([q[i], q_dot[i]]) for i in (0, -1)]
    response = Response(
        problem=problem,
        t=t,
        q=q,
        q_dot=q_dot,
        friction_torque=(wave @ held).real,
        initial_state=ends[0],
        final_state=ends[1],
        initial_mode="stick",
        events=EventLog.empty(problem.n),
        near_grazing=NearGrazing.empty(),
        window=(0.0, problem.period),
        stick_fraction=1.0,
        dissipated_energy=0.0,
        velocity_reversals=0.0,
        stops_per_period=0.0,
        energy_balance_residual=0.0,
        period_residual=0.0,
        periodic=True,
    )
    loads = hub_load_harmonics(driven, c)
    expected = np.einsum("tk,kpd->tpd", wave, loads).real
    found = dynamic_hub_loads(driven, response)
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_dynamic_loads_are_the_momentum_of_the_belt():
    """Forces on all pulleys together take the spans' momentum away: d/dt of the integral of
    rho (v w_t + ...) equals minus their sum; here for a drive of fixed centres at standstill, where
    the momentum is that of the transverse motion alone."""
    drive = random_drive(np.random.default_rng(4), 4, arm=False)
    driven = chain(drive, 0.0, n_functions=N)
    rows = hub_load_rows(driven)
    rng = np.random.default_rng(0)
    q_ddot = rng.normal(size=len(driven.M))
    sines = [i for i, x in enumerate(driven.coordinates.labels) if x.startswith("span")]
    q_ddot[[i for i in range(len(q_ddot)) if i not in sines]] = 0.0
    total = (rows.mass @ q_ddot).sum(axis=0)
    expected = np.zeros(2)
    for i, label in enumerate(driven.coordinates.labels):
        if label.startswith("span"):
            span, k = (int(x) for x in label.removeprefix("span").split(".sin"))
            mean = 2.0 / (np.pi * k) if k % 2 else 0.0
            mass = (drive.layout.span_length_m[span - 1] / drive.mean_span_length_m) ** 2
            expected -= mass * mean * q_ddot[i] * drive.layout.normal[span - 1]
    assert total == pytest.approx(expected, abs=1e-12)
    assert np.abs(rows.stiffness.sum(axis=0)).max() < 1e-10 * np.abs(rows.stiffness).max()
