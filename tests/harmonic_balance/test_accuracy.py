"""Harmonic balance against the exact event map, by the recipe of random problems."""

from __future__ import annotations

import numpy as np
import pytest
from support.damped import damped_problem

from beltsim import event_map
from beltsim.harmonic_balance import Settings, solve

EXACT = event_map.Settings(harmonics=200, samples_per_period=1)


def compared(seed: int, R: int, settings: Settings) -> tuple[float, float, int]:
    """Relative error of the joint's motion, estimate over true error, and the forcing's top."""
    problem = damped_problem(seed)
    joint = problem.joint
    exact = np.array(event_map.periodic(problem, EXACT).coefficients)[1:, joint]
    found = solve(problem, R, settings)
    wrong = exact.copy()
    wrong[:R] -= found.coefficients[1:, joint]
    size = float(np.sqrt(0.5 * np.sum(np.abs(exact) ** 2)))
    error = float(np.sqrt(0.5 * np.sum(np.abs(wrong) ** 2)))
    estimate = found.statistics.get("error_estimate")
    return error / size, (estimate or 0.0) / error, len(problem.forcing.cos) - 1


@pytest.mark.parametrize("seed", range(7000, 7012))
def test_the_estimate_covers_the_error_and_the_error_its_bound(seed: int) -> None:
    for R in (11, 21):
        error, cover, top = compared(seed, R, Settings())
        assert error <= 1.3 * top / R
        assert cover >= 1.0


def test_the_recipe_on_fresh_seeds(full) -> None:
    if not full:
        pytest.skip("600 solutions: --full")
    for R, median, high in ((11, 1e-2, 7e-2), (21, 5e-3, 3e-2), (41, 3e-3, 1.5e-2)):
        rows = np.array([compared(seed, R, Settings()) for seed in range(8000, 8200)])
        assert np.all(rows[:, 0] <= 1.3 * rows[:, 2] / R)
        assert np.mean(rows[:, 1] >= 1.0) >= 0.95
        single = rows[rows[:, 2] == 1, 0]
        assert np.median(single) <= 1.3 * median  # about 65 problems: their median varies by that
        assert np.percentile(single, 95) <= high
