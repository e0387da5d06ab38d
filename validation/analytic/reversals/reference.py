"""Instants at which a linear mass turns, under two harmonics. No import from beltsim."""

import numpy as np
from scipy.optimize import brentq

#: Mass 1, stiffness 0.5, damping 0.1; load cos t + 20 cos k t, k = 3 and 5.
STIFFNESS, DAMPING, LOADS = 0.5, 0.1, {1: 1.0, 0: 20.0}
ORDERS = (3, 5)


def velocity(t: float, k: int) -> float:
    """Steady velocity at `t`; 2 pi is one period."""
    found = 0.0
    for order, load in ((1, LOADS[1]), (k, LOADS[0])):
        amplitude = load / (STIFFNESS - order**2 + 1j * DAMPING * order)
        found += float((1j * order * amplitude * np.exp(1j * order * t)).real)
    return found


def turns(k: int) -> np.ndarray:
    """Instants of one period at which the velocity changes sign, over the period."""
    grid = np.linspace(0.0, 2.0 * np.pi, 401)
    values = [velocity(t, k) for t in grid]
    found = [
        brentq(velocity, grid[i], grid[i + 1], args=(k,), xtol=1e-14)
        for i in range(400)
        if values[i] * values[i + 1] < 0.0
    ]
    return np.array(found) / (2.0 * np.pi)


def nu(k: int) -> float:
    """max(0, (sign changes per period - 2)/4)."""
    return max(0.0, (len(turns(k)) - 2) / 4.0)
