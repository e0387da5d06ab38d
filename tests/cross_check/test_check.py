"""Solvers against each other: they agree, and whoever is made to be wrong is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beltsim import Coulomb, FrictionProblem, HarmonicForcing, SaturatedCoulomb, event_map
from beltsim.cross_check import Candidate, check, compare, motion_of, residuals
from beltsim.cross_check.check import EXACT_RESIDUAL, _latest, _merged
from beltsim.errors import InvalidProblemError

PUSH = HarmonicForcing(0.5, [[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 0.3]])
TWO = FrictionProblem(
    M=[[1.0, 0.2], [0.2, 2.0]],
    C=[[0.05, 0.0], [0.0, 0.04]],
    G=[[0.0, 0.3], [-0.3, 0.0]],
    K=[[1.0, -0.2], [-0.2, 9.0]],
    joint=0,
    forcing=PUSH,
    friction=Coulomb(0.4),
)
SETTINGS = event_map.Settings(samples_per_period=2000)


def orbit(problem=TWO):
    return event_map.periodic(problem, SETTINGS)


def as_candidate(response, name="other", accuracy=1e-9, problem=TWO):
    motion = motion_of(replace(response, problem=problem))
    return Candidate(name, motion, "made up", accuracy)


@pytest.mark.parametrize("Q_m", [0.05, 0.4, 0.8, 3.0])
def test_all_solvers_agree(Q_m):
    found = check(TWO.with_friction(Coulomb(Q_m)), tolerance=0.03)
    assert found.faults == ()
    assert len(found.residuals) == (3 if Q_m == 3.0 else 4)  # a locked joint has no band
    for one in found.candidates[:2]:
        assert found.residuals[one.name].worst < 1e-6


def test_the_figures_are_those_of_the_response():
    response = orbit()
    motion = motion_of(response)
    assert motion.stick_fraction == pytest.approx(response.stick_fraction, abs=1e-12)
    assert motion.velocity_reversals == response.velocity_reversals
    assert motion.dissipated_energy == pytest.approx(response.dissipated_energy, rel=1e-9)
    assert motion.rms == pytest.approx(event_map.rms(response), rel=1e-9)


def test_residuals_fall_with_the_fourth_power_of_the_step():
    worst = []
    for samples in (250, 500):
        settings = event_map.Settings(samples_per_period=samples)
        worst.append(residuals(motion_of(event_map.periodic(TWO, settings))).equation)
    assert np.log2(worst[0] / worst[1]) == pytest.approx(4.0, abs=0.5)


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"K": np.array(TWO.K) * 1.001}, "equation"),
        ({"C": np.array(TWO.C) * 1.05}, "equation"),
        ({"G": -np.array(TWO.G)}, "equation"),
        ({"friction": Coulomb(0.41)}, "torque"),
        ({"friction": Coulomb(0.39)}, "sliding"),
    ],
)
def test_a_motion_of_another_system_is_found_wrong(change, name):
    wrong = as_candidate(orbit(replace(TWO, **change)))
    found = compare([as_candidate(orbit(), "right"), wrong])
    assert not found.agrees
    assert getattr(found.residuals["other"], name) > 1e-4
    assert found.residuals["right"].worst < 1e-7
    assert any(fault.startswith("other is wrong") for fault in found.faults)
    assert not any("right is wrong" in fault for fault in found.faults)


def test_the_reference_is_not_always_right():
    wrong = as_candidate(orbit(replace(TWO, C=np.array(TWO.C) * 1.05)), "first")
    found = compare([wrong, as_candidate(orbit(), "second")])
    text = " ".join(found.faults)
    assert "second differs from first" in text
    assert "first is wrong" in text
    assert "second is wrong" not in text


def barely_moving(stiffness=25.0):
    """`TWO` with a third coordinate that moves a millionth as much."""
    M, C, G, K = (np.zeros((3, 3)) for _ in range(4))
    for whole, part in ((M, TWO.M), (C, TWO.C), (G, TWO.G), (K, TWO.K)):
        whole[:2, :2] = part
    M[2, 2], C[2, 2], K[2, 2], K[0, 2], K[2, 0] = 1.0, 0.05, stiffness, 1e-5, 1e-5
    forcing = HarmonicForcing(0.5, np.pad(PUSH.cos, ((0, 0), (0, 1))), np.zeros((2, 3)))
    return FrictionProblem(M, C, G, K, 0, forcing, Coulomb(0.4))


def test_a_row_that_barely_moves_is_as_exact_as_an_integrator_can_make_it():
    problem = barely_moving()
    response = orbit(problem)
    noisy = response.q_dot.copy()
    noisy[:, 2] += 1e-10 * np.abs(noisy).max() * np.sin(7.0 * response.t)
    noise = replace(response, q_dot=noisy)
    found = residuals(as_candidate(noise, problem=problem).motion)
    assert np.abs(noisy[:, 2]).max() < 3e-6 * np.abs(noisy).max()  # 1e-4 of what it does itself
    assert 1e-7 < found.equation < EXACT_RESIDUAL


def test_a_row_that_barely_moves_is_found_wrong_all_the_same():
    response = orbit(barely_moving(stiffness=25.5))
    found = residuals(as_candidate(response, problem=barely_moving()).motion)
    assert found.equation > 3.0 * EXACT_RESIDUAL


def test_torque_fed_in_and_a_broken_period_are_found():
    response = orbit()
    turned = replace(response, friction_torque=-response.friction_torque)
    assert residuals(as_candidate(turned).motion).direction > 0.5
    moved = response.q.copy()
    moved[-1] += 1e-3
    assert residuals(as_candidate(replace(response, q=moved)).motion).period > 1e-4


def test_energy_that_comes_from_nowhere_is_found():
    response = orbit()
    faster = replace(response, q_dot=1.01 * response.q_dot)
    assert residuals(as_candidate(faster).motion).energy > 1e-4


@pytest.mark.parametrize(
    ("law", "note"),
    [
        (Coulomb(0.05, 0.06), "pattern of events of the event map"),
        (Coulomb(0.4, 0.5), "pattern of events of the event map"),
        (Coulomb(0.4, 3.0), "a joint at rest"),
    ],
)
def test_static_friction_above_kinetic_takes_the_pattern_of_the_event_map(law, note):
    found = check(TWO.with_friction(law), tolerance=0.03)
    notes = {one.name: one.note for one in found.candidates}
    assert note in notes["set-valued balance"]
    assert len(found.residuals) == (4 if law.Q_m == 0.05 else 3)  # no band holds a static level
    assert found.faults == ()


def test_the_saturated_law_itself():
    found = check(TWO.with_friction(SaturatedCoulomb(0.4, 0.05)))
    assert [one.motion is None for one in found.candidates] == [False, False, True, False]
    assert found.faults == ()


def test_no_two_results_are_no_agreement():
    found = compare([as_candidate(orbit()), Candidate("none", None, "failed")])
    assert not found.agrees
    assert "nothing to compare" in found.faults[0]


def test_input_that_cannot_be_used():
    with pytest.raises(InvalidProblemError, match="joint"):
        check(TWO.freed())
    with pytest.raises(InvalidProblemError, match="tolerance"):
        check(TWO, tolerance=0.0)
    with pytest.raises(InvalidProblemError, match="at least 2 periods"):
        motion_of(orbit(), 2)


def test_event_times_are_compared_around_the_circle():
    first = (np.array([0.001, 0.5]), ["stick", "slip-"])
    assert _latest(first, (np.array([0.501, 0.999]), ["slip-", "stick"]), 1) == pytest.approx(0.002)
    assert _latest(first, (np.array([0.5]), ["slip-"]), 1) == np.inf


def test_short_sticks_are_reversals_for_who_cannot_see_them():
    motion = motion_of(orbit())
    assert _merged(motion, 0.0)[1] == list(motion.kinds)
    angles, kinds = _merged(motion, 0.9)
    assert kinds == ["reverse", "reverse"]
    assert np.diff(angles) == pytest.approx(0.5, abs=1e-9)


def test_an_event_at_the_start_of_the_period_is_one_at_its_end():
    """Without damping at half the natural frequency the joint turns at t = 0, a tie of rounding."""
    push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    mass = FrictionProblem([[1.0]], [[0.0]], [[0.0]], [[1.0]], 0, push, Coulomb(0.05))
    turning = event_map.periodic(mass, SETTINGS)
    assert turning.events.t[0] < 1e-12 * mass.period
    motion = motion_of(turning)
    assert motion.pieces[0].torque[0] == turning.events.torque_after[0]
    assert motion.pieces[-1].torque[-1] == turning.events.torque_before[0]
    assert residuals(motion).worst <= EXACT_RESIDUAL


def test_a_solver_that_denies_the_motion_of_the_others_is_a_fault():
    push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    falling = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[-1.0]], 0, push, Coulomb(0.4))
    found = check(falling, tolerance=0.05)
    assert not found.agrees
    assert "event map denies" in found.faults[0]
    assert "unstable" in found.faults[0]
    assert "event map denies" in repr(found)
    assert len(repr(found)) < 1000


def test_a_check_shows_itself_in_a_line():
    found = compare([as_candidate(orbit(), "first"), as_candidate(orbit(), "second")])
    assert repr(found) == "<Check: 2 of 2 solvers gave a motion; they agree>"
