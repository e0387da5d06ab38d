"""Exact transients against two references that share no code with the map."""

from __future__ import annotations

import numpy as np
import pytest
from support.exact import exact_transient
from support.grazing import stored_cases
from support.precise import precise_transient
from support.problems import random_problem, random_state

import beltsim
from beltsim import Coulomb, FrictionProblem, HarmonicForcing, event_map
from beltsim.errors import CoreError, InvalidProblemError, UnsupportedLawError
from beltsim.event_map.flows import flows_of

PERIODS = 6.0


def weighed(problem, state):
    """State with velocities over Omega, so that all entries compare."""
    return state / np.repeat([1.0, problem.forcing.Omega], problem.n)


def same_motion(problem, run, other, tolerance):
    assert run.events.kind.tolist() == list(other.kind)
    size = np.abs(weighed(problem, other.final_state)).max()
    if len(other.t):
        slack = tolerance * problem.period * np.maximum(1.0, 1e-2 / other.margin)
        assert (np.abs(run.events.t - other.t) <= slack).all()
    worst = min(1.0, other.min_margin / 1e-2)
    gap = np.abs(weighed(problem, run.final_state - other.final_state)).max()
    assert gap <= 10.0 * tolerance * size / worst


def test_random_transients_equal_the_reference(full):
    for seed in range(1000 if full else 60):
        problem = random_problem(seed)
        start = random_state(seed, problem) if seed % 2 else None
        exact = exact_transient(problem, PERIODS, start)
        run = event_map.propagate(problem, PERIODS, start)
        same_motion(problem, run, exact, 2e-12)
        assert run.initial_mode == exact.initial_mode
        assert run.energy_balance_residual <= 1e-10


@pytest.mark.parametrize("seed", range(5))
def test_times_and_states_in_forty_digits(seed):
    """Event times to 1e-12 T, states to 1e-10, where events are transversal."""
    problem = random_problem(seed + 500, n=1 + seed % 3, harmonics=1 + seed % 2)
    exact = precise_transient(problem, 2.0)
    run = event_map.propagate(problem, 2.0)
    assert exact.min_margin > 1e-4
    assert run.events.kind.tolist() == exact.kind
    assert len(exact.t) >= 4
    assert max(abs(float(a - b)) for a, b in zip(run.events.t, exact.t, strict=True)) <= (
        1e-12 * problem.period
    )
    wanted = np.array([float(x) for x in exact.final_state])
    size = np.abs(weighed(problem, wanted)).max()
    assert np.abs(weighed(problem, run.final_state - wanted)).max() <= 1e-10 * size


def one_mass(friction, cos, sin=None, k=1.0, c=0.0, Omega=1.0):
    cos = np.array(cos, float)[:, None]
    sin = np.zeros_like(cos) if sin is None else np.array(sin, float)[:, None]
    return FrictionProblem(
        [[1.0]], [[c]], [[0.0]], [[k]], 0, HarmonicForcing(Omega, cos, sin), friction
    )


@pytest.mark.parametrize("start", [0.5, -0.5, 0.3])
@pytest.mark.parametrize("static", [0.5, 0.7])
def test_start_on_the_limit(start, static):
    """|K x| = Q_s at rest: the first derivative of the reaction that is not zero decides."""
    problem = one_mass(Coulomb(0.5, static), [0.0, 0.2], [0.0, 0.1], Omega=0.7)
    place = start / 0.5 * static
    exact = exact_transient(problem, 3.0, [-place, 0.0])
    run = event_map.propagate(problem, 3.0, [-place, 0.0])
    assert run.initial_mode == exact.initial_mode
    same_motion(problem, run, exact, 1e-12)


def test_start_on_the_limit_without_forcing_stays():
    run = event_map.propagate(one_mass(Coulomb(0.5), [0.0]), 3.0, [0.5, 0.0])
    assert run.initial_mode == "stick"
    assert len(run.events) == 0
    assert run.final_state.tolist() == [0.5, 0.0]


@pytest.mark.parametrize("v", [1e-12, -1e-12, 1e-300])
def test_start_with_hardly_any_velocity(v):
    problem = one_mass(Coulomb(0.5), [0.0, 0.9], Omega=0.4, c=0.05)
    exact = exact_transient(problem, 3.0, [0.1, v])
    run = event_map.propagate(problem, 3.0, [0.1, v])
    assert run.initial_mode == ("slip+" if v > 0 else "slip-")
    assert run.events.kind.tolist() == exact.kind
    assert np.abs(run.events.t - exact.t).max() <= 1e-11 * problem.period


def test_nothing_moves_without_cause():
    run = event_map.propagate(one_mass(Coulomb(0.0), [0.0]), 5.0)
    assert len(run.events) == 0
    assert not run.final_state.any()


def test_locked_for_a_very_long_time():
    """No event may be invented over 1e5 periods."""
    problem = random_problem(3, n=4).with_friction(Coulomb(1e4))
    run = event_map.propagate(problem, 1e5)
    assert len(run.events) == 0
    assert run.stick_fraction == 1.0


def test_frictionless_joint_reverses():
    problem = random_problem(11, n=3).with_friction(Coulomb(0.0))
    exact = exact_transient(problem, 4.0)
    run = event_map.propagate(problem, 4.0)
    assert set(run.events.kind) == {"reverse"}
    same_motion(problem, run, exact, 2e-12)


def test_figures_of_a_transient_agree_with_its_samples():
    problem = random_problem(21, n=5)
    settings = event_map.Settings(samples_per_period=4000, keep="all")
    run = event_map.propagate(problem, 3.5, settings=settings)
    assert run.t[0] == 0.0
    assert run.t[-1] == pytest.approx(3.5 * problem.period, rel=1e-14)
    assert not run.initial_state.any()
    assert np.abs(np.concatenate([run.q[0], run.q_dot[0]])).max() <= 1e-14 * np.abs(run.q_dot).max()
    v = run.q_dot[:, problem.joint]
    loss = np.trapezoid(run.friction_torque * v, run.t)
    assert run.total_dissipated_energy == pytest.approx(loss, rel=1e-4)
    assert np.abs(run.friction_torque).max() <= problem.friction.Q_s * (1.0 + 1e-12)


def test_run_split_at_random_times_goes_on_the_same():
    """A split run equals the whole one: state carried over, forcing shifted by whole periods."""
    draw = np.random.default_rng(5)
    for seed in range(20):
        problem = random_problem(seed + 40)
        cut = int(draw.integers(1, 4))
        whole = event_map.propagate(problem, 5.0)
        first = event_map.propagate(problem, float(cut))
        rest = event_map.propagate(problem, 5.0 - cut, first.final_state)
        size = np.abs(whole.final_state).max()
        assert np.abs(rest.final_state - whole.final_state).max() <= 1e-9 * size


def test_bad_runs_are_refused():
    problem = random_problem(1, n=2)
    with pytest.raises(InvalidProblemError, match=r"periods.*\n.*initial_state"):
        event_map.propagate(problem, -1.0, [0.0])
    with pytest.raises(UnsupportedLawError):
        event_map.propagate(problem.freed())
    with pytest.raises(InvalidProblemError, match="max_events"):
        event_map.Settings(max_events=0)
    with pytest.raises(CoreError, match="max_events"):
        event_map.propagate(
            problem.with_friction(Coulomb(0.0)), 50.0, settings=event_map.Settings(max_events=3)
        )


def test_long_runs_go_on_in_stretches(monkeypatch):
    """A run is cut into calls so that it can be interrupted; the motion does not notice."""
    problem = random_problem(13, n=2)
    whole = event_map.propagate(problem, 40.3)
    monkeypatch.setattr("beltsim.event_map.walk._STRETCH", 7)
    cut = event_map.propagate(problem, 40.3)
    assert cut.events.kind.tolist() == whole.events.kind.tolist()
    assert np.abs(cut.events.t - whole.events.t).max() <= 1e-11 * problem.period
    size = np.abs(whole.final_state).max()
    assert np.abs(cut.final_state - whole.final_state).max() <= 1e-11 * size


def test_limits_crossed_and_grazing_are_told():
    """Both kinds of result warn as the transient solver does."""
    drive = beltsim.presets.zhu_parker_2008(mu=0.3)
    problem = beltsim.assemble(drive, 6.3, friction=Coulomb(3.5), n_functions=4)
    run = beltsim.transient.integrate(problem, 3.0)
    exact = event_map.propagate(problem, 3.0)
    assert any("falls below 0 N" in text for text in run.warnings)
    assert [text.split(",")[0] for text in exact.warnings] == [
        text.split(",")[0] for text in run.warnings
    ]
    orbit = event_map.periodic(problem)
    assert any("tension of span" in text and "falls below" in text for text in orbit.warnings)
    early = event_map.propagate(problem, 0.01)
    assert early.warnings == problem.warnings


def test_a_touch_in_the_last_period_is_told():
    case = next(case for case in stored_cases(12))
    run = event_map.propagate(case.at(1e-10), PERIODS)
    span = run.window
    times = [*run.near_grazing.t, *run.events.t[run.events.quality != "simple"]]
    last = any(span[0] < t <= span[1] for t in times)
    assert last == any("near grazing" in text for text in run.warnings)


def test_margins_of_stops_are_over_the_largest_reaction_of_the_run():
    """The first stop too, whatever the reaction was until then."""
    found = 0
    for seed in range(20):
        problem = random_problem(seed, n=2, share=0.3, static=False)
        run = event_map.propagate(problem, 3.0, random_state(seed, problem))
        part, events = flows_of(problem).held.part, run.events
        stops = np.isin(events.kind, ("stick", "reverse"))
        if not stops.any():
            continue
        joint, x = problem.joint, np.column_stack([events.q, events.q_dot])
        rest = np.delete(x, [joint, 2 + joint], axis=1)
        reaction = part.signals(events.t, events.position, rest)[0]
        Q_s = problem.friction.Q_s
        peak = max(Q_s, np.abs(reaction).max())
        wanted = np.abs(np.abs(reaction) - Q_s) / peak
        assert np.allclose(events.margin[stops], wanted[stops], atol=1e-12)
        found += 1
    assert found > 10
