"""Harmonic balance against the exact event map, by the recipe of random problems."""

from __future__ import annotations

import numpy as np
import pytest
from support.damped import damped_problem

from beltsim import event_map, linear
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance import Settings, solve
from beltsim.problem import FrictionProblem

EXACT = event_map.Settings(harmonics=200, samples_per_period=1)
BARE = Settings(estimate=False)
#: A band of this share of the largest velocity costs up to six times as much.
BAND = 1e-3
#: A problem with one harmonic in the forcing whose error is large: 0.58 of the bound at R = 11.
WORST = 10135
INTEGRATED = Settings(projection="exact", start="set_valued", estimate=False)


def exact_series(problem: FrictionProblem) -> np.ndarray:
    """Harmonics from 1 on of the joint's motion on the exact orbit."""
    return np.array(event_map.periodic(problem, EXACT).coefficients)[1:, problem.joint]


def distance(exact: np.ndarray, response) -> float:
    """Rms of the difference in the joint's motion over that of the motion."""
    series = response.coefficients[1:, response.problem.joint]
    wrong = exact.copy()
    wrong[: len(series)] -= series
    return float(np.sqrt(np.sum(np.abs(wrong) ** 2) / np.sum(np.abs(exact) ** 2)))


def compared(seed: int, R: int, settings: Settings) -> tuple[float, float, int, float]:
    """Error, estimate over error, highest harmonic of the forcing, error of a narrow band."""
    problem = damped_problem(seed)
    exact = exact_series(problem)
    found = solve(problem, R, settings)
    error = distance(exact, found)
    size = float(np.sqrt(0.5 * np.sum(np.abs(exact) ** 2)))
    estimate = (found.statistics.get("error_estimate") or 0.0) / size
    law = SaturatedCoulomb(problem.friction.Q_m, BAND * found.statistics["velocity_peak"])
    banded = distance(exact, solve(problem.with_friction(law), R, INTEGRATED))
    return error, estimate / error, len(problem.forcing.cos) - 1, banded


def redriven(problem: FrictionProblem, cos: np.ndarray, sin: np.ndarray, Omega: float):
    """The same system and share of the critical torque under another forcing."""
    share = problem.friction.Q_m / linear.critical_torque(problem)
    push = HarmonicForcing(Omega, cos, sin)
    parts = problem.M, problem.C, problem.G, problem.K, problem.joint
    free = FrictionProblem(*parts, push, Coulomb(0.0))
    return free.with_friction(Coulomb(share * linear.critical_torque(free)))


@pytest.mark.parametrize("seed", range(7000, 7012))
def test_the_estimate_covers_the_error_and_the_error_its_bound(seed: int) -> None:
    for R in (11, 21):
        error, cover, top, banded = compared(seed, R, Settings())
        assert error <= 1.3 * top / R
        assert cover >= 1.0
        assert banded <= 1.3 * top / R + 6.0 * BAND


def test_no_bound_in_R_alone_can_hold_for_every_forcing() -> None:
    """R harmonics of a forcing in its third harmonic alone are R/3 of it: the error stays."""
    problem = damped_problem(WORST)
    push = problem.forcing
    rows = np.zeros((2, 4, problem.n))
    rows[0, 3], rows[1, 3] = push.cos[1], push.sin[1]
    third = redriven(problem, *rows, push.Omega / 3.0)
    error = distance(exact_series(problem), solve(problem, 11, BARE))
    same = distance(exact_series(third), solve(third, 33, BARE))
    assert same == pytest.approx(error, rel=1e-6)
    assert 1.3 / 33 < error <= 1.3 / 11


@pytest.mark.parametrize("seed", range(7020, 7030))
def test_harmonics_that_fall_fast_are_like_one(seed: int) -> None:
    problem = damped_problem(seed)
    push = problem.forcing
    fall = 1.0 / np.maximum(np.arange(len(push.cos)), 1)[:, None]  # amplitudes like 1/k^2
    problem = redriven(problem, push.cos * fall, push.sin * fall, push.Omega)
    exact = exact_series(problem)
    for R in (11, 21, 41):
        assert distance(exact, solve(problem, R, BARE)) <= 1.3 / R


def test_the_recipe_on_fresh_seeds(full) -> None:
    if not full:
        pytest.skip("1200 solutions: --full")
    for R, median, high in ((11, 1e-2, 7e-2), (21, 5e-3, 3e-2), (41, 3e-3, 1.5e-2)):
        rows = np.array([compared(seed, R, Settings()) for seed in range(8000, 8200)])
        assert np.all(rows[:, 0] <= 1.3 * rows[:, 2] / R)
        assert np.all(rows[:, 3] <= 1.3 * rows[:, 2] / R + 6.0 * BAND)
        assert np.mean(rows[:, 0] > 1.3 / R) <= 0.05  # two or three harmonics, falling like 1/k
        assert np.mean(rows[:, 1] >= 1.0) >= 0.95
        single = rows[rows[:, 2] == 1, 0]
        assert np.median(single) <= 1.3 * median  # about 65 problems: their median varies by that
        assert np.percentile(single, 95) <= high
