"""The set-valued method: never fails, agrees with exact motions, knows when it locks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from support.damped import damped_problem
from support.exact import exact_transient
from support.problems import critical_torque, random_problem

from beltsim import event_map, linear
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb
from beltsim.harmonic_balance import Settings, condense, set_valued, sign_change_angles, solve
from beltsim.harmonic_balance.set_valued import critical_bound
from beltsim.harmonic_balance.solve import _gap_warnings, _second
from beltsim.problem import FrictionProblem

BARE = Settings(estimate=False)
SHARES = (0.0, 1e-6, 1e-3, 0.02, 0.3, 0.7, 0.9, 0.97, 0.999, 1.0, 1.5, 20.0)


def one_mass(Q_m: float, Omega: float = 0.5, damping: float = 0.02) -> FrictionProblem:
    push = HarmonicForcing(Omega, [[0.0], [1.0]], [[0.0], [0.0]])
    return FrictionProblem([[1.0]], [[damping]], [[0.0]], [[1.0]], 0, push, Coulomb(Q_m))


def complementarity(found) -> float:
    """Q_m int |v| - int h v over the work that the same torque could do, on 4000 points."""
    problem = found.problem
    k = np.arange(len(found.coefficients))
    velocity = 1j * k * found.coefficients[:, problem.joint]
    tau = np.linspace(0.0, 2.0 * np.pi, 4000, endpoint=False)
    moved = np.mean(np.abs((np.exp(1j * np.outer(tau, k)) @ velocity).real))
    work = 0.5 * np.sum(found.torque_coefficients * np.conj(velocity)).real
    return float(1.0 - work / (problem.friction.Q_m * moved))


@pytest.mark.parametrize("R", [1, 9, 25])
@pytest.mark.parametrize("seed", range(8))
def test_every_torque_converges_from_a_cold_start(seed: int, R: int) -> None:
    problem = random_problem(seed, static=False, harmonics=1 if R == 1 else None)
    Q_cr = critical_torque(problem)
    for share in SHARES:
        found = solve(problem.with_friction(Coulomb(share * Q_cr)), R, BARE)
        assert found.statistics["balance_residual"] < 1e-10
        assert found.energy_balance_residual < 1e-9
        assert np.abs(found.friction_torque).max() <= max(share, 1.0) * Q_cr * (1.0 + 1e-6)


@pytest.mark.parametrize(("R", "seed", "many"), [(51, 20, None), (101, 3, None), (201, 6, 1)])
def test_many_harmonics(R: int, seed: int, many: int | None) -> None:
    problem = random_problem(seed, 4, static=False, share=0.6, harmonics=many)
    found = solve(problem, R, BARE)
    assert found.statistics["complementarity_gap"] < 1e-5
    assert found.statistics["balance_residual"] < 1e-10


@pytest.mark.parametrize("seed", [3, 6, 7])
def test_the_search_settles_with_many_harmonics(seed: int) -> None:
    problem = random_problem(seed, 4, static=False, share=0.6)
    condensed = condense(problem, 51)
    found = set_valued._searched(condensed, problem.friction.Q_m, set_valued.SEARCH_CELLS[0])
    assert not condensed.half_wave
    assert found.gap < 1e-9


def test_no_torque_fails_with_up_to_201_harmonics(full) -> None:
    if not full:
        pytest.skip("many solutions: --full")
    # half-wave symmetry (one harmonic in the forcing) makes 201 harmonics bearable
    for R, seeds, many in (
        (11, 2000, None),
        (25, 500, None),
        (51, 100, None),
        (101, 20, None),
        (201, 2, None),
        (201, 30, 1),
    ):
        for seed in range(60_000, 60_000 + seeds):
            problem = random_problem(seed, static=False, harmonics=many)
            condensed, Q_cr = condense(problem, R), linear.critical_torque(problem)
            shares = np.random.default_rng(seed).uniform((0.0, 0.3, 0.9), (0.3, 0.9, 1.0))
            for share in (1e-6, *shares, 0.999, 1.3):
                found = set_valued.solve(condensed, share * Q_cr, BARE)
                assert found.gap <= 1e-4


@pytest.mark.parametrize(
    ("seed", "share"), [(50_131, 0.92527), (50_423, 0.93352), (51_265, 0.70843), (51_978, 0.32198)]
)
def test_hard_searches_settle_and_the_cells_lead_to_the_same_instants(seed, share) -> None:
    problem = random_problem(seed, static=False)
    condensed = condense(problem, 11)
    Q_m = share * linear.critical_torque(problem)
    found = set_valued.solve(condensed, Q_m, BARE)
    other = set_valued._in_cells(condensed, Q_m, BARE)
    assert max(found.gap, other.gap) < 1e-9
    assert np.abs(found.velocity - other.velocity).max() < 1e-5 * np.abs(found.velocity).max()


@pytest.mark.parametrize("seed", range(6))
def test_without_friction_it_is_the_linear_response(seed: int) -> None:
    problem = random_problem(seed, static=False).with_friction(Coulomb(0.0))
    found = solve(problem, 9, BARE)
    expected = linear.response(problem)
    shown = found.coefficients[: len(expected)]
    assert np.abs(shown - expected).max() <= 1e-10 * np.abs(expected).max()
    assert set(found.events.kind.tolist()) <= {"reverse"}


@pytest.mark.parametrize("seed", range(6))
def test_above_the_critical_torque_the_joint_is_locked(seed: int) -> None:
    problem = random_problem(seed, static=False)
    Q_cr = critical_torque(problem)
    found = solve(problem.with_friction(Coulomb(1.01 * Q_cr)), 9, BARE)
    expected = linear.response(problem, locked=True)
    size = np.abs(expected).max()
    assert found.statistics["locked"]
    assert np.all(found.coefficients[1:, problem.joint] == 0.0)
    assert np.abs(found.coefficients[1 : len(expected)] - expected[1:]).max() <= 1e-10 * size
    assert found.statistics["Q_cr"] == pytest.approx(linear.critical_torque(problem), rel=1e-9)
    low, high = found.rest_interval
    position = found.q[0, problem.joint]
    assert position == pytest.approx(0.5 * (low + high), rel=1e-9)
    assert found.events.t.size == 0
    assert found.stick_fraction == 1.0


def test_between_both_critical_torques_it_warns() -> None:
    found = solve(one_mass(0.98), 9, BARE)
    Q_cr_R, Q_cr = found.statistics["Q_cr_R"], found.statistics["Q_cr"]
    assert Q_cr_R < 0.98 < Q_cr
    assert found.statistics["locked"]
    assert found.rest_interval is None
    assert any("use more harmonics" in text for text in found.warnings)
    below = solve(one_mass(0.96), 9, BARE)
    assert not any("use more harmonics" in text for text in below.warnings)


def test_a_gap_above_the_tolerance_is_accepted_but_said() -> None:
    problem, settings = one_mass(0.4), Settings(estimate=False, tolerance=1e-6)
    solved = replace(set_valued.solve(condense(problem, 9), 0.4, settings), gap=2e-3)
    (text,) = _gap_warnings(solved, settings, problem.friction)
    assert "gap of 0.002, above the tolerance 1e-06" in text
    assert _gap_warnings(replace(solved, gap=1e-7), settings, problem.friction) == ()


@pytest.mark.parametrize("seed", range(12))
def test_instants_are_the_roots_of_the_velocity(seed: int) -> None:
    problem = random_problem(seed, static=False)
    R = (5, 9, 15)[seed % 3]
    for share in (0.05, 0.3, 0.6, 0.9):
        law = Coulomb(share * critical_bound(condense(problem, R)))
        condensed = condense(problem, R)
        solved = set_valued.solve(condensed, law.Q_m, BARE)
        if not solved.exact:
            continue
        velocity = np.zeros(R + 1, dtype=complex)
        velocity[condensed.orders] = solved.velocity
        inner = solved.bounds[1:-1]
        inner = inner[np.diff(solved.levels) != 0.0]
        d = condensed.divisor
        turned = np.concatenate([inner + 2.0 * np.pi * i for i in range(d)]) / d
        found = sign_change_angles(velocity)
        if len(found) == len(turned) + d:  # a switch on the border of the repetition itself
            found = np.sort(found)[: len(turned)]
        assert len(found) == len(turned)
        assert np.abs(found - np.sort(turned)).max() < 1e-6


@pytest.mark.parametrize("seed", range(3))
def test_both_searches_find_the_same(seed: int) -> None:
    problem = random_problem(seed, 4, static=False, share=0.5)
    condensed, fine = condense(problem, 9), Settings(tolerance=1e-8)
    Q_m = problem.friction.Q_m
    one = set_valued.solve(condensed, Q_m, fine)
    other = set_valued._in_cells(condensed, Q_m, fine)
    assert np.abs(one.velocity - other.velocity).max() < 1e-5 * np.abs(one.velocity).max()


def test_one_harmonic_has_its_critical_torque_in_closed_form() -> None:
    # the least bound of a torque whose first harmonic is cos t is that of a square wave: pi/4
    assert critical_bound(condense(one_mass(0.1), 1)) == pytest.approx(np.pi / 4.0, rel=1e-12)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_critical_torque_of_a_series_is_that_of_a_linear_program(seed: int) -> None:
    problem = random_problem(seed, 3, static=False, harmonics=2)
    condensed = condense(problem, 7, "all")
    N = 600
    tau = (np.arange(N) + 0.5) * 2.0 * np.pi / N
    angle = np.outer(condensed.orders, tau)
    rows = 2.0 / N * np.concatenate([np.cos(angle), np.sin(angle)])
    wanted = np.concatenate([condensed.reaction.real, -condensed.reaction.imag])
    equal = np.hstack([rows, np.zeros((len(rows), 1))])
    bounds = np.hstack([np.eye(N), -np.ones((N, 1))])
    bounds = np.vstack([bounds, np.hstack([-np.eye(N), -np.ones((N, 1))])])
    cost = np.zeros(N + 1)
    cost[-1] = 1.0
    free = [(None, None)] * N + [(0.0, None)]
    least = linprog(cost, bounds, np.zeros(2 * N), equal, wanted, free).fun
    # the program switches only between its 600 samples
    assert critical_bound(condensed) == pytest.approx(least, rel=1e-4)


@pytest.mark.parametrize("seed", range(12))
def test_the_error_stays_below_its_bound(seed: int) -> None:
    problem = damped_problem(seed)
    joint, Omega, period = problem.joint, problem.forcing.Omega, problem.period
    found = {R: solve(problem, R, BARE) for R in (11, 21)}
    rest = found[21]
    run = exact_transient(problem, 200.0, rest.initial_state)
    t = np.linspace(199.0 * period, 200.0 * period, 257)[:-1]
    exact = run.states(t)[:, joint]
    exact -= exact.mean()
    for R, response in found.items():
        series = response.coefficients[1:, joint]
        theta = (np.exp(1j * np.outer(t * Omega, np.arange(1, R + 1))) @ series).real
        error = np.sqrt(np.mean((theta - exact) ** 2) / np.mean(exact**2))
        assert error <= 1.3 / R


def test_the_error_falls_with_the_number_of_harmonics() -> None:
    problem = one_mass(0.15, Omega=2.0)  # slips all the time
    run = exact_transient(problem, 600.0)
    t = np.linspace(599.0 * problem.period, 600.0 * problem.period, 513)[:-1]
    exact = run.states(t)[:, 0]
    errors = []
    fine = Settings(estimate=False, tolerance=1e-12, max_refinements=12)
    for R in (11, 21, 41, 81):
        k = np.arange(R + 1)
        theta = (np.exp(2j * np.outer(t, k)) @ solve(problem, R, fine).coefficients[:, 0]).real
        errors.append(np.sqrt(np.mean((theta - exact) ** 2)))
    slope = np.polyfit(np.log([11, 21, 41, 81]), np.log(errors), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.05)


@settings(derandomize=True, deadline=None, max_examples=20)
@given(seed=st.integers(0, 2**31))
def test_the_torque_is_the_sign_of_the_velocity(seed: int) -> None:
    problem = random_problem(seed, 3, static=False, share=0.4)
    found = solve(problem, 9, BARE)
    assert abs(complementarity(found)) < 1e-4


def test_sampling_agrees_with_closed_form_as_its_samples_grow() -> None:
    problem = random_problem(11, 5, static=False, share=0.4)
    exact = solve(problem, 9, Settings(estimate=False, tolerance=1e-9, max_refinements=10))
    gaps = []
    for samples in (64, 1024):
        rough = solve(problem, 9, Settings(estimate=False, projection="sampled", samples=samples))
        gaps.append(np.abs(rough.coefficients - exact.coefficients).max())
    assert gaps[1] < 0.2 * gaps[0]
    assert gaps[1] < 2e-3 * np.abs(exact.coefficients).max()


@pytest.mark.parametrize("seed", range(4))
def test_symmetry_is_used_only_when_it_holds(seed: int) -> None:
    problem = random_problem(seed, 4, static=False, harmonics=1, share=0.5)
    odd, every = solve(problem, 9, BARE), solve(problem, 9, Settings("all", estimate=False))
    assert odd.statistics["half_wave"]
    assert not every.statistics["half_wave"]
    size = np.abs(every.coefficients).max()
    assert np.abs(odd.coefficients - every.coefficients)[1:].max() < 5e-3 * size
    mixed = random_problem(seed, 4, static=False, harmonics=2, share=0.5)
    assert not solve(mixed, 9, BARE).statistics["half_wave"]


def test_a_common_divisor_repeats_the_response() -> None:
    push = HarmonicForcing(0.25, np.zeros((3, 1)), [[0.0], [0.0], [1.0]])  # second harmonic alone
    double = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4))
    once = HarmonicForcing(0.5, np.zeros((2, 1)), [[0.0], [1.0]])
    single = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, once, Coulomb(0.4))
    two, one = solve(double, 18, BARE), solve(single, 9, BARE)
    assert two.coefficients[::2, 0] == pytest.approx(one.coefficients[:, 0], abs=1e-9)
    assert not two.coefficients[1::2].any()
    assert two.dissipated_energy == pytest.approx(2.0 * one.dissipated_energy, rel=1e-9)
    assert two.stops_per_period == 2.0 * one.stops_per_period


def test_a_mean_load_moves_the_joint_and_nothing_else() -> None:
    problem = random_problem(3, 3, static=False, harmonics=2, share=0.3)
    cos = problem.forcing.cos.copy()
    cos[0] += [1.0, -2.0, 0.5]
    loaded = FrictionProblem(
        problem.M,
        problem.C,
        problem.G,
        problem.K,
        problem.joint,
        HarmonicForcing(problem.forcing.Omega, cos, problem.forcing.sin),
        problem.friction,
    )
    plain, moved = solve(problem, 9, BARE), solve(loaded, 9, BARE)
    assert np.array_equal(plain.coefficients[1:], moved.coefficients[1:])
    shift = np.linalg.solve(problem.K, [1.0, -2.0, 0.5])
    assert moved.coefficients[0].real - plain.coefficients[0].real == pytest.approx(shift)


def test_torques_of_one_system_share_its_impedances() -> None:
    problem = random_problem(5, 6, static=False)
    assert condense(problem, 9) is condense(problem.with_friction(Coulomb(0.1)), 9)


def test_events_are_those_of_the_exact_motion() -> None:
    problem = one_mass(0.4)
    found = solve(problem, 81, BARE)
    run = exact_transient(problem, 120.0, found.initial_state)
    last = run.t > 119.0 * problem.period
    kinds = [kind for kind, keep in zip(run.kind, last, strict=True) if keep]
    assert sorted(found.events.kind.tolist()) == sorted(kinds)
    times = np.sort(np.mod(run.t[last], problem.period))
    assert np.abs(found.events.t - times).max() < problem.period / 81


def test_one_harmonic_of_a_moving_joint_is_no_stick():
    push = HarmonicForcing(0.5, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]])
    mass = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[1.0]], 0, push, Coulomb(0.6))
    found = solve(mass, 1)
    assert found.dissipated_energy > 0.1
    assert found.stick_fraction == 0.0
    assert found.events.kind.tolist() == ["reverse", "reverse"]


@pytest.mark.parametrize("seed", [2, 5])
def test_many_harmonics_and_their_estimate(seed: int) -> None:
    """Instants by the hundred; the estimate, from a solution with fewer harmonics, covers."""
    problem = random_problem(seed, 3, share=0.4, static=False)
    found = solve(problem, 121, Settings("all"))
    assert found.statistics["complementarity_gap"] <= 1e-5
    assert complementarity(found) < 1e-5
    orbit = event_map.periodic(problem, event_map.Settings(harmonics=800))
    wrong = np.array(orbit.coefficients)[1:, problem.joint]
    wrong[:121] -= found.coefficients[1:, problem.joint]
    assert np.sqrt(0.5) * np.linalg.norm(wrong) <= found.statistics["error_estimate"]


def test_a_solution_is_compared_with_one_that_can_tell_more() -> None:
    """With more harmonics up to R = 100, for a locked joint, or where the forcing asks for it."""
    problem = one_mass(0.4)
    assert _second(problem, 15, False) == (35, 4.0)
    assert _second(problem, 101, False) == (49, 2.0)
    assert _second(problem, 101, True) == (207, 4.0)
    push = HarmonicForcing(0.5, np.eye(60)[:, 1:2] + np.eye(60)[:, 59:], np.zeros((60, 1)))
    assert _second(replace(problem, forcing=push), 101, False) == (207, 4.0)
