"""Steady state of the linear system, free or with the arm held, by one dense complex solution.

No import from beltsim.
"""

from typing import Any

import numpy as np


def _stiffness(problem: Any) -> np.ndarray:
    rate = 1j * problem.forcing.Omega
    stiffness: np.ndarray = problem.K + rate * (problem.C + problem.G) + rate**2 * problem.M
    return stiffness


def _force(problem: Any) -> np.ndarray:
    force: np.ndarray = problem.forcing.cos[1] - 1j * problem.forcing.sin[1]
    return force


def steady(problem: Any, locked: bool) -> np.ndarray:
    """Complex amplitudes (n,) of the first harmonic."""
    stiffness, force = _stiffness(problem), _force(problem)
    if locked:  # the arm's equation is replaced by its being at zero
        stiffness[problem.joint] = 0.0
        stiffness[problem.joint, problem.joint] = 1.0
        force = force.copy()
        force[problem.joint] = 0.0
    return np.linalg.solve(stiffness, force)


def held(problem: Any, shape: np.ndarray) -> complex:
    """Complex amplitude of the torque that holds the arm."""
    residual = _force(problem) - _stiffness(problem) @ shape
    return complex(residual[problem.joint])


def series(shape: np.ndarray, Omega: float, t: np.ndarray) -> np.ndarray:
    """Re shape exp(i Omega t), one row per time."""
    return np.real(np.multiply.outer(np.exp(1j * Omega * t), shape))
