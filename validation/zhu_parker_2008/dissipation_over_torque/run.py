"""Exact dissipation per cycle at four torques over a grid of Omega."""

import numpy as np

from beltsim import Coulomb, event_map
from validation.reference import printed
from validation.zhu_parker_2008.paper import problem

TORQUES = (0.1, 0.5, 3.0, 5.0)
GRID = np.arange(5.0, 9.0001, 0.05)


def compute() -> list[tuple[str, float, float]]:
    grid = [problem(float(Omega)) for Omega in GRID]
    problems = [each.with_friction(Coulomb(Q)) for each in grid for Q in TORQUES]
    energy = event_map.survey(problems).dissipated_energy.reshape(len(GRID), 4)
    more = np.flatnonzero(energy[:, 2:].min(axis=1) > energy[:, :2].max(axis=1))
    expected = printed(__file__)
    return [
        ("lower end", float(GRID[more[0]]), expected["lower end"]),
        ("upper end", float(GRID[more[-1]]), expected["upper end"]),
        ("gaps in between", float(np.count_nonzero(np.diff(more) != 1)), 0.0),
    ]
