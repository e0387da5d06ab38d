"""Q_s > Q_m from a given pattern: against the exact event map, by rate, and refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.problems import random_problem

import beltsim
from beltsim import Coulomb, FrictionProblem, HarmonicForcing, SaturatedCoulomb, event_map
from beltsim.errors import ConvergenceError, InvalidProblemError, UnsupportedLawError
from beltsim.harmonic_balance import Pattern, Settings, _instants, condense, solve
from beltsim.harmonic_balance._instants import Instants
from beltsim.harmonic_balance._tail import terms

EXACT = event_map.Settings(harmonics=400, samples_per_period=200)
PUSH = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])


def one_mass(ratio: float, Q_m: float = 0.4) -> FrictionProblem:
    return FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, PUSH, Coulomb(Q_m, ratio * Q_m))


def drive() -> FrictionProblem:
    paper = beltsim.presets.zhu_parker_2008()
    return beltsim.assemble(paper, Omega=6.3, n_functions=4).with_friction(Coulomb(7.0, 8.4))


def pattern_of(orbit, shift=0.0) -> Pattern:
    return Pattern(orbit.events.kind, orbit.events.t + shift, orbit.initial_mode)


def settings(pattern: Pattern, estimate: bool = False) -> Settings:
    return Settings(pattern=pattern, estimate=estimate)


def errors(problem: FrictionProblem, orbit, found) -> tuple[float, float]:
    """Relative rms error of the joint's motion, and the largest of an instant over T."""
    exact = np.array(orbit.coefficients)[1:, problem.joint]
    wrong = exact.copy()
    wrong[: len(found.coefficients) - 1] -= found.coefficients[1:, problem.joint]
    instants = np.abs(found.events.t - orbit.events.t).max() / problem.period
    return float(np.linalg.norm(wrong) / np.linalg.norm(exact)), float(instants)


@pytest.mark.parametrize("ratio", [1.2, 1.5])
def test_one_mass_by_rate(ratio: float) -> None:
    """The torque jumps, so theta_r ~ 1/r^3, and the series cut at R misses R^-2.5 of the rms.

    The mobility beyond R is wrong by s^-4: the holding torque, and so its release, by R^-3.
    """
    problem = one_mass(ratio)
    orbit = event_map.periodic(problem, EXACT)
    R = np.array([7, 15, 31, 63])
    rows = np.array(
        [errors(problem, orbit, solve(problem, int(r), settings(pattern_of(orbit)))) for r in R]
    )
    slopes = np.polyfit(np.log(R + 1), np.log(rows), 1)[0]  # only odd harmonics are present
    assert slopes[0] == pytest.approx(-2.5, abs=0.2)
    assert slopes[1] < -2.8
    assert rows[-1, 0] < 2e-5
    assert rows[-1, 1] < 2e-8


CASES = {
    "drive": (drive, 21),
    "one mass": (lambda: one_mass(1.5), 21),
    "3 coordinates, 5 harmonics": (lambda: random_problem(2, 3, share=0.4, static=True), 31),
    "3 coordinates, 3 stops": (lambda: random_problem(3, 3, share=0.4, static=True), 31),
    "3 coordinates, reversals": (lambda: random_problem(6, 3, share=0.4, static=True), 15),
    "10 coordinates": (lambda: random_problem(6, 10, share=0.3, static=True), 41),
}


@pytest.mark.parametrize("name", CASES)
def test_against_the_event_map(name: str) -> None:
    make, R = CASES[name]
    problem = make()
    orbit = event_map.periodic(problem, EXACT)
    found = solve(problem, R, settings(pattern_of(orbit)))
    assert found.events.kind.tolist() == orbit.events.kind.tolist()
    assert found.initial_mode == orbit.initial_mode
    error, instants = errors(problem, orbit, found)
    assert error < 5e-4
    assert instants < 2e-6
    law = problem.friction
    for side in ("torque_before", "torque_after"):
        difference = getattr(found.events, side) - getattr(orbit.events, side)
        assert np.abs(difference).max() < 1e-3 * law.Q_s
    assert np.abs(found.friction_torque).max() <= law.Q_s * (1.0 + 1e-6)
    away = np.abs(found.t[:, None] - found.events.t).min(axis=1) > 1e-5 * problem.period
    difference = (found.friction_torque - orbit.friction_torque)[away]
    assert np.abs(difference).max() < 1e-3 * law.Q_s
    assert found.dissipated_energy == pytest.approx(orbit.dissipated_energy, rel=1e-3)
    assert found.stick_fraction == pytest.approx(orbit.stick_fraction, abs=1e-5)
    assert found.statistics["complementarity_gap"] < 1e-4
    assert found.statistics["balance_residual"] < 1e-9


def test_a_rough_pattern_leads_to_the_same_motion() -> None:
    problem = one_mass(1.5)
    orbit = event_map.periodic(problem, EXACT)
    near = solve(problem, 15, settings(pattern_of(orbit)))
    far = solve(problem, 15, settings(pattern_of(orbit, 0.02 * problem.period)))
    assert np.abs(near.coefficients - far.coefficients).max() < 1e-9
    assert np.abs(near.events.t - far.events.t).max() < 1e-8 * problem.period


def test_equal_torques_agree_with_the_set_valued_method() -> None:
    """Its error of about 1/R is what they differ by; the pattern's own is R^-2.5."""
    problem = one_mass(1.0)
    orbit = event_map.periodic(problem, EXACT)
    differences = []
    for R in (21, 41, 81):
        by_pattern = solve(problem, R, settings(pattern_of(orbit)))
        set_valued = solve(problem, R)
        difference = by_pattern.coefficients[1:, 0] - set_valued.coefficients[1:, 0]
        differences.append(np.sqrt(0.5) * np.linalg.norm(difference))
        assert differences[-1] <= set_valued.statistics["error_estimate"]
        assert errors(problem, orbit, by_pattern)[0] < 0.2 * errors(problem, orbit, set_valued)[0]
    assert differences[2] < 0.5 * differences[0]


def test_static_friction_that_shrinks_to_the_kinetic() -> None:
    equal = event_map.periodic(one_mass(1.0), EXACT)
    limit = solve(one_mass(1.0), 21, settings(pattern_of(equal)))
    close = solve(one_mass(1.0 + 1e-7), 21, settings(pattern_of(equal)))
    assert np.abs(limit.coefficients - close.coefficients).max() < 1e-6


def test_the_estimate_covers_the_error() -> None:
    for problem in (one_mass(1.2), random_problem(3, 3, share=0.4, static=True)):
        orbit = event_map.periodic(problem, EXACT)
        found = solve(problem, 15, settings(pattern_of(orbit), estimate=True))
        size = np.sqrt(0.5) * np.linalg.norm(np.array(orbit.coefficients)[1:, problem.joint])
        assert errors(problem, orbit, found)[0] * size <= found.statistics["error_estimate"]


def test_the_mobility_beyond_the_last_harmonic() -> None:
    problem = random_problem(5, 6)
    condensed = condense(problem, 400, "all")
    alpha = terms(condensed)
    assert len(alpha) == 3
    mass = np.linalg.inv(problem.M)[problem.joint, problem.joint]
    assert alpha[0] == pytest.approx(mass / condensed.Omega)
    r = condensed.orders[99:]
    left = condensed.mobility[99:] - ((1j * r[:, None]) ** -np.arange(1.0, 4.0)) @ alpha
    slope = np.polyfit(np.log(r), np.log(np.abs(left)), 1)[0]
    assert slope == pytest.approx(-4.0, abs=0.3)


def test_the_velocity_is_that_of_its_series() -> None:
    """The closed form against 40 000 harmonics of the same torque."""
    problem = one_mass(1.2)
    pattern = ASYMMETRIC
    condensed = condense(problem, 9, "all")
    equations = Instants(condensed, problem.friction, pattern)
    motion = equations.motion(pattern.angles(condensed.Omega))
    many = condense(problem, 40_000, "all")
    full = Instants(many, problem.friction, pattern)
    powers = (1j * full.orders[:, None]) ** -np.arange(1.0, 4.0)
    mobility = powers @ equations.alpha
    mobility[:9] = condensed.mobility
    full.count = equations.count
    ends = equations.ends(motion.angles)
    held = np.concatenate([[1.0], *(motion.parts[i] for i in (0, 3))])
    series = -mobility * (held @ full._waves(ends, len(held) - 1)[: len(held)])
    series[:9] += condensed.velocity
    s = np.array([-0.9, -0.2, 0.5])
    tau = ends[:-1, None] + 0.5 * (s + 1.0) * np.diff(ends)[:, None]
    wanted = (np.exp(1j * np.multiply.outer(tau, full.orders)) @ series).real
    assert np.abs(equations.velocity(motion, s) - wanted).max() < 1e-8
    slope = equations.velocity(motion, s + 1e-6) - equations.velocity(motion, s - 1e-6)
    derivative = slope / (1e-6 * np.diff(ends)[:, None])
    assert np.abs(equations.velocity(motion, s, 1) - derivative).max() < 1e-7


ASYMMETRIC = Pattern(["stick", "slip-", "reverse", "stick", "slip+"], [1, 3, 6, 8, 11], "slip+")


@pytest.mark.parametrize("name", ["whole period", "half a period"])
def test_the_derivative_by_the_instants(name: str) -> None:
    """Impulses at the events against differences of the conditions, reversals included."""
    problem = one_mass(1.2)
    if name == "whole period":
        pattern = ASYMMETRIC
    else:
        t = np.array([1.0, 3.0, 4.5])
        times = np.concatenate([t, t + 0.5 * problem.period])
        pattern = Pattern(
            [*("stick", "slip+", "reverse"), *("stick", "slip-", "reverse")], times, "slip+"
        )
    equations = Instants(condense(problem, 15, "all"), problem.friction, pattern)
    assert equations.half_wave == (name == "half a period")
    angles = equations.given
    exact = equations.motion(angles).derivative
    for i, unit in enumerate(np.eye(len(angles))):
        after, before = (equations.motion(angles + e * unit).residual for e in (1e-5, -1e-5))
        assert (after - before) / 2e-5 == pytest.approx(exact[:, i], abs=1e-6 * np.abs(exact).max())


def test_half_a_period_tells_all_where_forcing_and_pattern_are_symmetric() -> None:
    """And only there: the same motion from the whole period, and no symmetry where none is."""
    problem = one_mass(1.5)
    pattern = pattern_of(event_map.periodic(problem, EXACT))
    condensed, law = condense(problem, 21, "all"), problem.friction
    uneven = Pattern(pattern.kind, pattern.t + 1e-6 * np.eye(4)[2], pattern.initial_mode)
    halves = [Instants(condensed, law, given).half_wave for given in (pattern, uneven)]
    assert halves == [True, False]
    by_half, by_whole = (_instants.solve(condensed, law, given) for given in (pattern, uneven))
    assert np.abs(by_half.torque - by_whole.torque).max() < 1e-10 * law.Q_m
    assert np.abs(by_half.located.found.angles - by_whole.located.found.angles).max() < 1e-10
    pushed = HarmonicForcing(0.5, [[0.0], [1.0], [0.01]], [[0.0], [0.0], [0.0]])
    even = condense(replace(problem, forcing=pushed), 21, "all")
    assert not Instants(even, law, pattern).half_wave


WRONG = {
    "too few stops": (["reverse", "reverse"], [3.0, 9.0], "slip+"),
    "one stop": (["stick", "slip-", "reverse"], [3.0, 4.0, 9.0], "slip+"),
    "mirrored": (["stick", "slip+", "stick", "slip-"], [1.0, 3.0, 7.0, 9.0], "slip-"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_pattern_of_no_response_is_refused(name: str) -> None:
    with pytest.raises(ConvergenceError, match=r"pattern.*try|settle") as caught:
        solve(one_mass(1.5), 15, settings(Pattern(*WRONG[name])))
    assert len(caught.value.residual_history) > 0


@pytest.mark.parametrize(
    ("kind", "t", "mode", "named"),
    [
        (["stick"], [1.0], "slip+", "pattern.t"),
        (["stick", "slip-"], [1.0], "slip+", "pattern.t"),
        (["stick", "slip+"], [2.0, 1.0], "slip+", "pattern.t"),
        (["stick", "slip+"], [-1.0, 1.0], "slip+", "pattern.t"),
        (["stick", "slip+"], [1.0, np.nan], "slip+", "pattern.t"),
        (["stick", "slip-"], [1.0, 2.0], "slip+", "pattern.kind"),
        (["slip-", "slip+"], [1.0, 2.0], "slip+", "pattern.kind"),
        (["stick", "jump"], [1.0, 2.0], "slip+", "pattern.kind"),
        (["stick", "slip+"], [1.0, 2.0], "moving", "pattern.initial_mode"),
    ],
)
def test_impossible_patterns(kind, t, mode, named) -> None:
    with pytest.raises(InvalidProblemError, match=named):
        Pattern(kind, t, mode)


def test_patterns_that_do_not_belong_to_the_problem() -> None:
    pattern = Pattern(["stick", "slip-", "stick", "slip+"], [1.0, 3.0, 7.0, 13.0], "slip+")
    with pytest.raises(InvalidProblemError, match="below one forcing period"):
        solve(one_mass(1.5), 9, settings(pattern))
    with pytest.raises(InvalidProblemError, match=r"settings\.pattern"):
        solve(one_mass(1.0).with_friction(SaturatedCoulomb(0.4, 1e-3)), 9, settings(pattern))
    with pytest.raises(InvalidProblemError, match="None without friction"):
        solve(one_mass(1.0).with_friction(Coulomb(0.0)), 9, settings(pattern))
    still = HarmonicForcing(0.5, [[1.0], [0.0]], [[0.0], [0.0]])
    rest = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[1.0]], 0, still, Coulomb(0.2, 0.3))
    with pytest.raises(InvalidProblemError, match="None without forcing"):
        solve(rest, 9, settings(pattern))
    with pytest.raises(InvalidProblemError, match=r"settings\.pattern"):
        Settings(pattern=["stick"])
    with pytest.raises(InvalidProblemError, match=r"settings\.harmonics"):
        Settings(pattern=pattern, harmonics="odd")


def test_without_a_pattern_the_error_says_how_to_give_one() -> None:
    with pytest.raises(UnsupportedLawError, match=r"Settings\(pattern=Pattern\("):
        solve(one_mass(1.5), 9)
