"""The exact derivative of the map against central differences."""

from __future__ import annotations

import numpy as np
import pytest
from support.problems import random_problem, random_state

from beltsim import SaturatedCoulomb
from beltsim.event_map.jacobian import jacobian
from beltsim.event_map.walk import walk


def differences(problem, x, periods, step):
    columns = []
    for i in range(len(x)):
        shift = np.zeros(len(x))
        shift[i] = step
        ends = [walk(problem, x + s * shift, periods).final_state for s in (1, -1)]
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.array(columns).T


@pytest.mark.parametrize("law", ["equal", "static", "saturated"])
def test_derivative_of_the_map(law):
    kinds = set()
    for seed in range(12):
        problem = random_problem(seed + 60, n=1 + seed % 5, share=0.3, static=law == "static")
        x = random_state(seed, problem)
        if law == "saturated":
            speed = np.abs(x[problem.n :]).max()
            problem = problem.with_friction(SaturatedCoulomb(problem.friction.Q_m, 0.1 * speed))
        run = walk(problem, x, 1.3)
        kinds |= set(run.integers[:, 1].tolist())
        found = jacobian(problem, run)
        wanted = differences(problem, x, 1.3, 1e-6 * np.abs(x).max())
        assert np.allclose(found, wanted, atol=3e-6 * np.abs(wanted).max()), seed
    assert kinds == ({0, 2, 3} if law == "saturated" else {0, 1, 2, 3})


def test_rank_is_lost_in_stick():
    """All motions that meet in stick are one dimension fewer."""
    problem = random_problem(60, n=3, share=0.6, static=False)
    run = walk(problem, random_state(1, problem), 3.0)
    assert 0 in run.integers[:, 1]
    values = np.linalg.svd(jacobian(problem, run), compute_uv=False)
    assert values[-1] <= 1e-12 * values[0]
