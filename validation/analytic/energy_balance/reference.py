"""The terms of the energy balance by the trapezoidal rule.

No import from beltsim.
"""

from typing import Any

import numpy as np


def account(
    problem: Any, t: np.ndarray, q: np.ndarray, q_dot: np.ndarray, torque: np.ndarray
) -> dict[str, float]:
    """Work of the forcing, friction loss, and what is left of the balance."""
    angle = np.multiply.outer(t * problem.forcing.Omega, np.arange(len(problem.forcing.cos)))
    force = np.cos(angle) @ problem.forcing.cos + np.sin(angle) @ problem.forcing.sin
    stored = 0.5 * np.sum(q_dot @ problem.M * q_dot + q @ problem.K * q, axis=1)
    work = _integral(np.sum(force * q_dot, axis=1), t)
    viscous = _integral(np.sum(q_dot @ problem.C * q_dot, axis=1), t)
    friction = _integral(torque * q_dot[:, problem.joint], t)
    rest = work - viscous - friction - (stored[-1] - stored[0])
    return {"work": float(work), "friction": float(friction), "rest": float(rest)}


def _integral(values: np.ndarray, t: np.ndarray) -> float:
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(t)))
