"""Exact dissipated energy over the friction torque at Omega = 6.3."""

import numpy as np
from scipy.optimize import brentq

from beltsim import Coulomb, event_map
from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES, critical_torque, problem

SHARE = 0.01


def compute() -> list[tuple[str, float, float]]:
    expected = printed(__file__)["10.4"]
    rows = []
    for series in SERIES:
        at, Q_cr = problem(6.3, series), critical_torque(6.3, series)

        def losses(torques: np.ndarray, at: object = at) -> np.ndarray:
            friction = [Coulomb(float(Q)) for Q in torques]
            return event_map.survey([at.with_friction(law) for law in friction]).dissipated_energy

        grid = np.linspace(0.0, Q_cr, 30)
        found = losses(grid)
        limit = SHARE * found.max()
        last = grid[found > limit].max()
        edge = brentq(lambda Q, of: losses(np.array([Q]))[0] - of, last, Q_cr, limit, xtol=1e-6)
        rows.append((f"Q_m of {SHARE * 100:.0f} %, {series}", float(edge), expected))
    return rows
