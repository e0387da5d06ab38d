"""The derivative of the map against central differences, at whatever state a search ends."""

from __future__ import annotations

import numpy as np
import pytest
from support.problems import random_problem, random_state

from beltsim import SaturatedCoulomb
from beltsim.event_map.changes import amplitudes
from beltsim.event_map.shooting import shoot
from beltsim.event_map.walk import walk

ANY = 1e9  # a tolerance that every state meets


def derivative_of(problem, found):
    """Derivative of the image in the state's own coordinates."""
    into, out = amplitudes(problem)
    return out @ found.derivative @ into


def differences(problem, found, step):
    columns = []
    length = 0.5 * found.multiple if found.half else float(found.multiple)
    for i in range(2 * problem.n):
        shift = np.zeros(2 * problem.n)
        shift[i] = step
        ends = [walk(problem, found.state + s * shift, length).final_state for s in (1, -1)]
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.array(columns).T * (-1.0 if found.half else 1.0)


@pytest.mark.parametrize("law", ["equal", "static", "saturated"])
def test_derivative_of_the_map(law):
    kinds = set()
    for seed in range(18):
        problem = random_problem(seed + 60, n=1 + seed % 5, share=0.3, static=law == "static")
        x = random_state(seed, problem)
        if law == "saturated":
            speed = np.abs(x[problem.n :]).max()
            problem = problem.with_friction(SaturatedCoulomb(problem.friction.Q_m, 0.1 * speed))
        found = shoot(problem, x, 1 + seed % 3, seed % 2 == 0, ANY, True)
        run = walk(problem, found.state, 0.5 * found.multiple if found.half else found.multiple)
        if found.state[problem.n + problem.joint] == 0.0:
            continue  # at rest: no central difference exists
        kinds |= set(run.integers[:, 1].tolist())
        wanted = differences(problem, found, 1e-6 * np.abs(found.state).max())
        gap = np.abs(derivative_of(problem, found) - wanted).max()
        assert gap <= 3e-6 * np.abs(wanted).max(), seed
    assert kinds == ({0, 2, 3} if law == "saturated" else {0, 1, 2, 3})


def test_rank_is_lost_in_stick():
    """All motions that meet in stick are one dimension fewer."""
    problem = random_problem(60, n=3, share=0.6, static=False)
    found = shoot(problem, random_state(1, problem), 3, False, ANY, True)
    assert 0 in walk(problem, found.state, 3.0).integers[:, 1]
    values = np.linalg.svd(derivative_of(problem, found), compute_uv=False)
    assert values[-1] <= 1e-12 * values[0]
