"""Figures derived from event logs made by hand, and the same for every solver."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from support.exact import exact_transient
from support.problems import problems
from support.responses import stick_slip

from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.problem import FrictionProblem
from beltsim.response import (
    EventLog,
    NearGrazing,
    Phase,
    Window,
    figures,
    friction_travel,
    phases,
    sign_changes,
)

Q_M = 0.5
PROBLEM = FrictionProblem(  # period 1
    [[2.0]],
    [[0.1]],
    [[0.0]],
    [[8.0]],
    0,
    HarmonicForcing(2.0 * np.pi, [[0.0], [1.0]], [[0.0], [0.0]]),
    Coulomb(Q_M),
)
REST = np.zeros(2)


def log(*events):
    """Events (t, kind) or (t, kind, position)."""
    t = [event[0] for event in events]
    kind = [event[1] for event in events]
    position = [event[2] if len(event) > 2 else 0.0 for event in events]
    none = np.zeros((len(t), 0))
    zeros = np.zeros(len(t))
    return EventLog(t, kind, none, none, position, zeros, zeros, ["simple"] * len(t), zeros)


def window(start=0.0, end=1.0, start_state=REST, end_state=REST, work=0.0, viscous=0.0, loss=None):
    return Window(start, end, np.asarray(start_state), np.asarray(end_state), work, viscous, loss)


def test_modes_after_each_event():
    events = log((1, "reverse"), (2, "stick"), (3, "slip-"), (4, "reverse"), (5, "reverse"))
    assert events.modes_after("slip+") == ["slip-", "stick", "slip-", "slip+", "slip-"]
    assert len(events) == 5
    assert len(EventLog.empty(3)) == 0
    assert EventLog.empty(3).q.shape == (0, 3)


@pytest.mark.parametrize(
    ("first", "events", "changes"),
    [
        ("slip+", [(0.3, "stick"), (0.5, "slip-")], 1),
        ("slip+", [(0.3, "stick"), (0.5, "slip+")], 0),
        ("slip+", [(0.3, "reverse")], 1),
        ("slip-", [(0.3, "reverse"), (0.5, "stick"), (0.7, "slip-")], 2),
        ("slip-", [(0.3, "stick"), (0.5, "slip-"), (0.6, "stick"), (0.7, "slip+")], 1),
        ("stick", [(0.3, "slip-"), (0.5, "stick")], 0),
        ("stick", [], 0),
    ],
)
def test_sign_changes_between_successive_slip_phases(first, events, changes):
    assert sign_changes(log(*events), first, 0.0, 1.0) == changes


def test_a_closed_orbit_that_starts_in_stick_counts_the_change_across_its_start():
    orbit = log((0.1, "slip-"), (0.4, "stick"), (0.6, "slip+"), (0.9, "stick"))
    assert sign_changes(orbit, "stick", 0.0, 1.0) == 1
    assert sign_changes(orbit, "stick", 0.0, 1.0, cyclic=True) == 2
    assert sign_changes(log((0.3, "slip+"), (0.5, "stick")), "stick", 0.0, 1.0, cyclic=True) == 0


def test_reversals_beyond_two_per_period_over_four():
    """Six changes in the period: nu = (6 - 2)/4."""
    events = log(*[(0.1 * i, "reverse") for i in range(1, 7)])
    assert figures(PROBLEM, events, "slip+", window()).velocity_reversals == 1.0
    usual = log((0.2, "reverse"), (0.7, "reverse"))
    assert figures(PROBLEM, usual, "slip+", window()).velocity_reversals == 0.0
    one = log((0.2, "reverse"))
    assert figures(PROBLEM, one, "slip+", window()).velocity_reversals == 0.0


def test_the_direction_before_the_window_counts():
    """Slip- ends before the window; the slip+ inside is a change against it."""
    events = log((0.4, "stick"), (1.5, "slip+"), (1.8, "stick"))
    assert sign_changes(events, "slip-", 1.0, 2.0) == 1
    assert sign_changes(events, "slip+", 1.0, 2.0) == 0


def test_an_event_on_a_boundary_belongs_to_the_window_that_it_ends():
    events = log((1.0, "stick"), (1.25, "slip-"), (2.0, "stick"))
    found = figures(PROBLEM, events, "slip+", window(1.0, 2.0))
    assert found.stops_per_period == 1.0
    assert found.stick_fraction == 0.25
    assert sign_changes(log((1.0, "reverse"), (2.0, "reverse")), "slip+", 1.0, 2.0) == 1


def test_phases_are_cut_at_both_ends():
    events = log((0.5, "stick", 0.3), (1.25, "slip-", 0.3), (1.75, "reverse", -0.2))
    found = list(phases(events, "slip+", 1.0, 2.0, (0.3, 0.1)))
    assert found == [
        Phase("stick", 1.0, 1.25, 0.3, 0.3),
        Phase("slip-", 1.25, 1.75, 0.3, -0.2),
        Phase("slip+", 1.75, 2.0, -0.2, 0.1),
    ]


def test_phases_without_events():
    assert list(phases(log(), "slip-", 0.0, 1.0, (0.2, -0.1))) == [
        Phase("slip-", 0.0, 1.0, 0.2, -0.1)
    ]


def test_stick_fraction_is_cut_at_the_window():
    events = log((0.75, "stick"), (1.25, "slip+"), (1.5, "stick"), (2.5, "slip-"))
    assert figures(PROBLEM, events, "slip+", window(1.0, 2.0)).stick_fraction == 0.75
    assert figures(PROBLEM, log(), "stick", window()).stick_fraction == 1.0
    assert figures(PROBLEM, log(), "slip+", window()).stick_fraction == 0.0


def test_dissipated_energy_is_torque_times_travel():
    """0.1 to 0.4, back to -0.2, rest, then -0.2 to -0.5: a travel of 0.3 + 0.6 + 0.3."""
    events = log(
        (0.3, "reverse", 0.4), (0.6, "stick", -0.2), (0.8, "slip-", -0.2), (1.7, "stick", -9.0)
    )
    found = figures(PROBLEM, events, "slip+", window(0, 1, [0.1, 1.0], [-0.5, -1.0]))
    assert found.dissipated_energy == pytest.approx(Q_M * 1.2, rel=1e-15)
    assert friction_travel(events, "slip+", 0.0, 1.0, (0.1, -0.5)) == pytest.approx(1.2)


def test_a_law_whose_loss_does_not_follow_from_positions_brings_its_own():
    problem = PROBLEM.with_friction(SaturatedCoulomb(Q_M, 0.1))
    events = log((0.3, "stick", 0.4))
    found = figures(problem, events, "slip+", window(loss=0.123))
    assert found.dissipated_energy == 0.123


def test_counts_of_a_run_shorter_than_a_period_are_per_period():
    events = log((0.1, "reverse"), (0.2, "stick"), (0.225, "slip+"))
    found = figures(PROBLEM, events, "slip+", window(0.0, 0.25))
    assert found.stops_per_period == 4.0
    assert found.velocity_reversals == (2 * 4.0 - 2.0) / 4.0
    assert found.stick_fraction == pytest.approx(0.1)
    assert found.period_residual is None


def test_a_run_of_no_length_has_no_figures():
    found = figures(PROBLEM, log(), "stick", window(0.0, 0.0))
    assert found == (0.0, 0.0, 0.0, 0.0, 0.0, None)


def test_no_joint_no_friction_figures():
    found = figures(PROBLEM.freed(), log(), None, window(0, 1, [0.0, 1.0], [1.0, 0.0], work=3.0))
    assert found[:4] == (0.0, 0.0, 0.0, 0.0)


def test_period_residual_divides_velocities_by_Omega():
    w = 2.0 * np.pi
    found = figures(PROBLEM, log(), "slip+", window(0, 1, [1.0, 0.0], [2.0, 3.0 * w]))
    assert found.period_residual == pytest.approx(3.0 / 3.0)
    same = figures(PROBLEM, log(), "slip+", window(0, 1, [2.0, 1.0], [2.0, 1.0]))
    assert same.period_residual == 0.0
    nothing = figures(PROBLEM, log(), "stick", window())
    assert nothing.period_residual == 0.0


def test_energy_balance():
    """Gain 8/2 (1 - 0) + 2/2 (0 - 1) = 3, friction 0.5, viscous 0.25, work 3.75: closed."""
    ends = ([0.0, 1.0], [1.0, 0.0])
    closed = figures(PROBLEM, log(), "slip+", window(0, 1, *ends, work=3.75, viscous=0.25))
    assert closed.dissipated_energy == 0.5
    assert closed.energy_balance_residual == pytest.approx(0.0, abs=1e-15)
    open_ = figures(PROBLEM, log(), "slip+", window(0, 1, *ends, work=5.0, viscous=0.25))
    assert open_.energy_balance_residual == pytest.approx(1.25 / 5.0)
    still = figures(PROBLEM, log(), "stick", window())
    assert still.energy_balance_residual == 0.0


@given(problem=problems(max_n=8))
@settings(derandomize=True, deadline=None, max_examples=12)
def test_figures_agree_with_the_sampled_motion(problem):
    """The figures of an exact run against its velocity, sampled over the last period."""
    run = exact_transient(problem, 3.0)
    joint, T = problem.joint, problem.period
    zeros = np.zeros(len(run.t))
    events = EventLog(
        *(run.t, run.kind, run.q, run.q_dot, run.q[:, joint], run.torque_before),
        *(run.torque_after, ["simple"] * len(run.t), zeros),
    )
    t = np.linspace(run.end - T, run.end, 1001)
    states = run.states(t)
    v = states[:, problem.n + joint]
    last = Window(t[0], run.end, states[0], run.final_state, 0.0, 0.0)
    found = figures(problem, events, run.initial_mode, last)
    speed = np.abs(v)
    loss = problem.friction.Q_m * 0.5 * np.sum((speed[1:] + speed[:-1]) * np.diff(t))
    scale = problem.friction.Q_m * np.abs(v).max() * T
    assert found.dissipated_energy == pytest.approx(loss, rel=0, abs=1e-3 * scale)
    assert found.stick_fraction == pytest.approx(np.mean(v == 0.0), abs=0.002 * (len(events) + 1))
    if run.min_margin > 0.01:
        changes = np.count_nonzero(np.diff(np.sign(v[v != 0.0])))
        counted = sign_changes(events, run.initial_mode, t[0], run.end)
        assert counted - changes in (0, 1)  # one more when the window opens with a rest
        starts = np.count_nonzero((v[1:] == 0.0) & (v[:-1] != 0.0))
        assert found.stops_per_period == pytest.approx(starts)


def test_logs_are_frozen():
    events = log((1.0, "stick"))
    for name in ("t", "kind", "position", "margin", "quality"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(events, name)[0] = getattr(events, name)[0]
    with pytest.raises(dataclasses.FrozenInstanceError):
        events.t = np.zeros(1)
    touches = NearGrazing([1.0], [1e-9], ["velocity"])
    with pytest.raises(ValueError, match="read-only"):
        touches.margin[0] = 1.0
    assert len(touches) == 1
    assert len(NearGrazing.empty()) == 0


def test_responses_are_frozen():
    response = dataclasses.replace(stick_slip(), coefficients=np.ones((2, 2)))
    for name in ("t", "q", "q_dot", "friction_torque", "final_state", "coefficients"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(response, name)[0] = 0.0
    assert response.coefficients.dtype == np.complex128
    with pytest.raises(dataclasses.FrozenInstanceError):
        response.periodic = False


def test_observing_by_name():
    response = stick_slip()
    tension = response.observe("tension of span 1")
    assert tension.shape == response.t.shape
    seen = response.problem.observables[0]
    assert tension[0] == pytest.approx(response.q[0] @ seen.row + seen.cos.sum())
    with pytest.raises(KeyError, match="no observable or coordinate 'tension'; observables: "):
        response.observe("tension")


def test_texts_are_short():
    response = stick_slip(periods=3)
    assert f"n = {response.problem.n}, Coulomb(Q_m=" in repr(response)
    assert f"{len(response.events)} events" in repr(response)
    assert "periodic" in repr(response)
    assert "stick" in repr(response.events)
    assert repr(EventLog.empty()).startswith("<EventLog: 0 events")
    assert repr(NearGrazing.empty()) == "<NearGrazing: 0 touches>"
    assert max(len(repr(part)) for part in (response, response.events)) < 400


def test_coordinates_are_observed_by_their_labels():
    response = stick_slip(periods=3)
    for i, label in enumerate(response.problem.labels):
        assert np.array_equal(response.observe(label), response.q[:, i])
    with pytest.raises(KeyError, match=r"observables: .*; coordinates: span1.sin1, theta_t"):
        response.observe("q99")
