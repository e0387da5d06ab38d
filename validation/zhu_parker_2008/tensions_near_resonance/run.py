"""Exact largest dynamic tensions at four resonances of the locked arm, free and with friction."""

from typing import Any

import numpy as np

import beltsim
from beltsim import Coulomb, event_map
from beltsim.metrics.span_tensions import tensions_of
from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES

SPEEDS = [5.5, 5.7, 6.3, 6.8]


def compute() -> list[tuple[str, float, float]]:
    expected, drive, rows = printed(__file__), beltsim.presets.zhu_parker_2008(), []
    for series, options in SERIES.items():
        grid = [beltsim.assemble(drive, Omega, **options) for Omega in SPEEDS]
        problems = [at.with_friction(Coulomb(Q)) for at in grid for Q in (0.0, 5.0)]
        settings = event_map.Settings(samples_per_period=1000, harmonics=0)
        orbits = event_map.solve_many(problems, settings)
        largest = np.array([_largest(orbit) for orbit in orbits]).reshape(len(SPEEDS), 2, 3)
        rises = largest[:, 1] > largest[:, 0]
        turned = np.array([_largest(orbit, -1.0)[0] for orbit in orbits]).reshape(-1, 2)
        falls = turned[:, 1] < turned[:, 0]
        got = {"span 1 falls": ~rises[:, 0], "span 2 rises": rises[:, 1]}
        got |= {"span 3 rises": rises[:, 2]}
        rows += [(f"{name}, {series}", count(holds), expected[name]) for name, holds in got.items()]
        name = f"span 1 falls with the sign of the arm's part turned, {series}"
        rows.append((name, count(falls), expected["span 1 falls"]))
    return rows


def count(holds: np.ndarray) -> float:
    return float(np.count_nonzero(holds))


def _largest(orbit: Any, arm_sign: float = 1.0) -> np.ndarray:
    """Largest |P_d| of each span over the samples; `arm_sign` turns the part of the arm in it."""
    q = orbit.q.copy()
    q[:, orbit.problem.joint] *= arm_sign
    Omega = orbit.problem.forcing.Omega
    tensions = [seen.at(orbit.t, q, Omega) - seen.cos[0] for seen in tensions_of(orbit.problem)]
    return np.abs(tensions).max(axis=1)
