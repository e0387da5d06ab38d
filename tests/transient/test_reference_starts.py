"""Starts and ends that need care: on the limit, almost at rest, locked, events at the very end."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from support.agreement import agreement
from support.exact import exact_transient
from support.problems import random_problem

from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem
from beltsim.transient import Settings, integrate

TIGHT = Settings(rtol=1e-10, keep="all", samples_per_period=50)


def one_mass(cos, sin, friction, k=3.0, c=0.05):
    cos, sin = np.array(cos, float)[:, None], np.array(sin, float)[:, None]
    return FrictionProblem(
        [[1.0]], [[c]], [[0.0]], [[k]], 0, HarmonicForcing(1.0, cos, sin), friction
    )


def assert_exact(problem, periods, start, least_events=0):
    run = exact_transient(problem, periods, start)
    response = integrate(problem, periods, start, TIGHT)
    found = agreement(response, run)
    assert response.initial_mode == run.initial_mode
    assert list(response.events.kind) == run.kind
    assert found.same_sequence
    assert found.state_error <= 1e-8
    assert found.time_errors[found.well_conditioned].max(initial=0.0) <= 1e-9
    assert len(run.kind) >= least_events
    return response


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("Q_s", [0.5, 0.7])
@pytest.mark.parametrize(
    ("shape", "mode"),
    [("rising", "slip"), ("falling", "stick"), ("top", "stick"), ("foot", "slip")],
)
def test_a_start_exactly_on_the_limit(side, Q_s, shape, mode):
    """The reaction of a lone mass at zero is the force: its first derivative at 0 decides.

    Rising and falling have a first derivative; top (a maximum) and foot (a minimum) a second one.
    """
    load = {
        "rising": ([Q_s, 0.0], [0.0, 1.3]),
        "falling": ([Q_s, 0.0], [0.0, -1.3]),
        "top": ([Q_s - 1.0, 1.0], [0.0, 0.0]),
        "foot": ([Q_s + 1.0, -1.0], [0.0, 0.0]),
    }[shape]
    cos, sin = (side * np.array(part) for part in load)
    problem = one_mass(cos, sin, Coulomb(0.5, Q_s))
    assert problem.forcing.at(0.0)[0] == side * Q_s
    response = assert_exact(problem, 2.0, None, least_events=1)
    slip = "slip+" if side > 0.0 else "slip-"
    assert response.initial_mode == (slip if mode == "slip" else "stick")


@pytest.mark.parametrize("v", [1e-12, -1e-12, 1e-9, -1e-300])
def test_a_start_almost_at_rest(v):
    """It slips, and stops at once where the reaction holds it."""
    problem = one_mass([0.1, 0.0], [0.0, 1.0], Coulomb(0.5))
    response = integrate(problem, 1.5, [0.0, v], TIGHT)
    still = exact_transient(problem, 1.5)
    assert response.initial_mode == ("slip+" if v > 0.0 else "slip-")
    assert response.events.kind[0] == "stick"
    assert response.events.t[0] <= 3.0 * abs(v)
    assert list(response.events.kind[1:]) == still.kind
    assert np.abs(response.events.t[1:] - still.t).max() < 1e-8
    assert np.abs(response.final_state - still.final_state).max() < 1e-8


def test_a_start_almost_at_rest_that_nothing_holds():
    problem = one_mass([2.0, 0.0], [0.0, 1.0], Coulomb(0.5))
    backwards = integrate(problem, 1.0, [0.0, -1e-12], TIGHT)
    assert backwards.initial_mode == "slip-"
    assert backwards.events.kind[0] == "reverse"
    run = exact_transient(problem, 1.0)
    assert run.initial_mode == "slip+"
    assert list(backwards.events.kind[1:]) == run.kind
    assert np.abs(backwards.final_state - run.final_state).max() < 1e-8


def test_locked_for_ever():
    """A thousand periods below the limit: no event, and a step that does not shrink."""
    problem = one_mass([0.0, 0.3], [0.0, 0.2], Coulomb(0.5))
    response = integrate(problem, 1000.0, settings=Settings(keep="events"))
    assert len(response.events) == 0
    assert response.stick_fraction == 1.0
    assert not response.final_state.any()
    larger = random_problem(3, 6, share=30.0, static=False)
    short, long = (integrate(larger, periods) for periods in (20.0, 200.0))
    assert len(long.events) == len(exact_transient(larger, 20.0).kind) == 0
    assert long.statistics["steps"] < 12.0 * short.statistics["steps"]


def test_a_very_long_rest_ends_on_time():
    """Released by a force that grows over 1e3 natural periods."""
    k = 1.0
    slow = 1e-3
    problem = FrictionProblem(
        [[1.0]],
        [[0.02]],
        [[0.0]],
        [[k]],
        0,
        HarmonicForcing(slow, [[0.0], [0.0]], [[0.0], [1.0]]),
        Coulomb(0.9),
    )
    response = assert_exact(problem, 0.4, None, least_events=2)
    assert response.events.t[0] == pytest.approx(np.arcsin(0.9) / slow, rel=1e-10)


def test_friction_of_zero_only_reverses():
    problem = random_problem(12, 5).with_friction(Coulomb(0.0))
    start = np.zeros(10)
    start[5 + problem.joint] = 1.0
    response = assert_exact(problem, 4.0, start, least_events=8)
    assert set(response.events.kind) == {"reverse"}
    assert response.dissipated_energy == 0.0
    free = integrate(problem.freed(), 4.0, start, TIGHT)
    assert np.abs(free.final_state - response.final_state).max() < 1e-7


def test_static_friction_alone_can_hold():
    """Q_m = 0, Q_s > 0: it sticks, is let go, and slips without resistance."""
    problem = one_mass([0.0, 0.0], [0.0, 1.0], Coulomb(0.0, 0.4))
    response = assert_exact(problem, 3.0, None, least_events=3)
    assert {"stick", "slip+"} <= set(response.events.kind)


@pytest.mark.parametrize("late", [-1e-7, 0.0, 1e-7])
def test_an_event_at_the_end_of_the_run(late):
    """0 < t <= end: a run that ends just before an event does not list it."""
    problem = random_problem(1, 6, share=0.4)
    run = exact_transient(problem, 3.0)
    k = 8
    periods = run.t[k] / problem.period + late
    response = integrate(problem, periods, settings=TIGHT)
    expected = {-1e-7: k, 1e-7: k + 1}
    if late:
        assert len(response.events) == expected[late]
    else:
        assert len(response.events) in (k, k + 1)
    assert list(response.events.kind) == run.kind[: len(response.events)]
    assert (response.events.t <= response.window[1]).all()
    assert response.window[1] == pytest.approx(run.t[k] + late * problem.period, rel=1e-14)
    assert np.abs(response.final_state[:6] - run.states([response.window[1]])[0, :6]).max() < 1e-7


@pytest.mark.parametrize("tiny", [1e-12, 1e-3])
def test_releases_of_hardly_more_than_the_kinetic_torque(tiny):
    """Q_s a hair above Q_m: the acceleration at a release is almost zero."""
    problem = random_problem(1, 6, share=0.4, static=False)
    Q_m = problem.friction.Q_m
    assert_exact(problem.with_friction(Coulomb(Q_m, Q_m * (1.0 + tiny))), 5.0, None, 10)


def test_a_linear_problem_has_no_events():
    problem = random_problem(9, 6).freed()
    run = exact_transient(problem, 3.0)
    response = integrate(problem, 3.0, settings=TIGHT)
    assert len(response.events) == 0
    assert response.initial_mode is None
    gap = np.abs(response.final_state - run.final_state).max()
    assert gap <= 1e-8 * np.abs(run.final_state).max()


def test_energy_balance_and_loss_of_the_last_period():
    """Closed to the tolerance, and equal to that of the exact motion."""
    problem = random_problem(6, share=0.3)
    response = integrate(problem, 6.0, settings=Settings(rtol=1e-10))
    run = exact_transient(problem, 6.0)
    assert response.energy_balance_residual < 1e-7
    joint = problem.joint
    start, end = response.window
    inside = (run.t > start) & (run.t < end)
    places = run.states([start, *run.t[inside], end])[:, joint]
    loss = problem.friction.Q_m * np.abs(np.diff(places)).sum()
    assert response.dissipated_energy == pytest.approx(loss, rel=1e-8)
    whole = run.states([0.0, *run.t, run.end])[:, joint]
    total = problem.friction.Q_m * np.abs(np.diff(whole)).sum()
    assert response.total_dissipated_energy == pytest.approx(total, rel=1e-8)


def test_the_interface_refuses_what_it_cannot_use():
    problem = random_problem(2, 3)
    for field, arguments in {
        "periods": {"periods": 0.0},
        "initial_state": {"initial_state": [0.0]},
        "settings": {"settings": {"rtol": 1e-3}},
    }.items():
        with pytest.raises(ValueError, match=f"^{field} = "):
            integrate(problem, **arguments)
    with pytest.raises(ValueError, match=r"settings\.rtol = 0\.5: must be between"):
        dataclasses.replace(TIGHT, rtol=0.5)
