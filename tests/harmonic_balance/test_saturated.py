"""The paper's method: its table of reversals, its Jacobian, its failures."""

from __future__ import annotations

import numpy as np
import pytest
from support.problems import random_problem

import beltsim
from beltsim.errors import ConvergenceError
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance import Settings, condense, reversals_of_series, solve
from beltsim.harmonic_balance.saturated import balance_of

LADDER = Settings(samples=256, sigma_ladder=True, estimate=False)


@pytest.fixture(scope="module")
def drive_problem():
    drive = beltsim.presets.zhu_parker_2008()
    return beltsim.assemble(drive, Omega=6.3, n_functions=(4, 5, 5), residual_flexibility=False)


@pytest.mark.parametrize(
    ("R", "expected"),
    [(5, [0, 0, 1, 2]), (9, [0, 1, 1, 3]), (11, [0, 1, 2, 3]), (13, [0, 1, 2, 3])],
)
def test_reversals_move_with_the_number_of_harmonics(drive_problem, R, expected) -> None:
    counts = []
    for Q_m in (1.0, 3.5, 6.1, 8.5):
        found = solve(drive_problem.with_friction(SaturatedCoulomb(Q_m, 1e-4)), R, LADDER)
        velocity = 1j * np.arange(R + 1) * found.coefficients[:, drive_problem.joint]
        counts.append(reversals_of_series(velocity))
    assert counts == expected


@pytest.mark.parametrize("seed", range(5))
def test_jacobian_is_the_derivative_of_the_residual(seed: int) -> None:
    problem = random_problem(seed, 4, static=False, share=0.3)
    condensed = condense(problem, 9)
    sigma = 0.3 * np.abs(condensed.velocity).max()
    balance = balance_of(
        condensed, SaturatedCoulomb(problem.friction.Q_m, sigma), Settings(samples=333)
    )
    x = np.random.default_rng(seed).standard_normal(2 * len(condensed.orders)) * sigma
    step = 1e-7 * sigma
    columns = [
        (balance.residual(x + step * e) - balance.residual(x - step * e)) / (2.0 * step)
        for e in np.eye(len(x))
    ]
    expected = np.array(columns).T
    assert np.abs(balance.jacobian(x) - expected).max() < 1e-6 * np.abs(expected).max()


@pytest.mark.parametrize("seed", range(5))
def test_it_approaches_exact_friction_as_the_band_narrows(seed: int) -> None:
    problem = random_problem(seed, 3, static=False, share=0.2)
    exact = solve(problem, 9, Settings(estimate=False))
    peak = exact.statistics["velocity_peak"]
    size = np.abs(exact.coefficients[1:]).max()
    settings = Settings(samples=4096, sigma_ladder=True, estimate=False)
    gaps = []
    for share in (0.3, 0.003):
        law = SaturatedCoulomb(problem.friction.Q_m, share * peak)
        found = solve(problem.with_friction(law), 9, settings)
        gaps.append(np.abs(found.coefficients - exact.coefficients)[1:].max() / size)
        assert found.energy_balance_residual < 1e-6
    assert gaps[1] < 0.01
    assert gaps[1] < 0.2 * gaps[0]


def test_a_failure_carries_the_best_iterate(drive_problem) -> None:
    problem = drive_problem.with_friction(SaturatedCoulomb(8.5, 1e-4))
    with pytest.raises(ConvergenceError, match="sigma_ladder") as caught:
        solve(problem, 9, Settings(samples=256, max_iterations=8, estimate=False))
    assert len(caught.value.residual_history) == 8
    assert caught.value.partial.coefficients.shape == (10, problem.n)
    assert not caught.value.partial.statistics["converged"]


def test_a_wide_band_warns(drive_problem) -> None:
    found = solve(drive_problem.with_friction(SaturatedCoulomb(1.0, 10.0)), 5, LADDER)
    assert any("viscous rather than dry" in text for text in found.warnings)


def test_the_set_valued_solution_is_a_good_start(drive_problem) -> None:
    problem = drive_problem.with_friction(SaturatedCoulomb(8.5, 1e-4))
    near = Settings(samples=256, start="set_valued", estimate=False)
    one, other = solve(problem, 9, near), solve(problem, 9, LADDER)
    assert np.abs(one.coefficients - other.coefficients).max() < 1e-6
    assert one.statistics["iterations"] < other.statistics["iterations"]


def test_no_friction_is_the_linear_response(drive_problem) -> None:
    expected = beltsim.linear.response(drive_problem)
    law = SaturatedCoulomb(0.0, 1e-4)
    found = solve(drive_problem.with_friction(law), 5, Settings(estimate=False))
    size = np.abs(expected).max()
    assert np.abs(found.coefficients[: len(expected)] - expected).max() < 1e-10 * size
    exact = solve(drive_problem.with_friction(Coulomb(0.0)), 5, Settings(estimate=False))
    assert np.abs(found.coefficients - exact.coefficients).max() < 1e-10 * size


@pytest.mark.parametrize("sigma", [1e-2, 1e-4, 1e-7])
@pytest.mark.parametrize(("R", "samples"), [(5, 64), (9, 257), (25, 256)])
def test_the_interior_start_converges_for_any_band(drive_problem, sigma, R, samples) -> None:
    settings = Settings(samples=samples, start="set_valued", estimate=False)
    for Q_m in (0.5, 3.5, 8.5, 20.0):
        found = solve(drive_problem.with_friction(SaturatedCoulomb(Q_m, sigma)), R, settings)
        assert found.statistics["converged"]


def test_a_ladder_that_cannot_come_down_says_so(drive_problem) -> None:
    problem = drive_problem.with_friction(SaturatedCoulomb(10.0, 1e-9))
    with pytest.raises(ConvergenceError, match="start='set_valued'"):
        solve(problem, 13, Settings(samples=256, sigma_ladder=True, estimate=False))
