"""Multipliers by differences of the exact motion. No import from beltsim."""

from typing import Any

import numpy as np

from validation.cross_method import exact_modal

STEP = 1e-6


def moduli(problem: Any, state: np.ndarray) -> np.ndarray:
    """Moduli of the eigenvalues of the derivative of one period's map at `state`, sorted."""
    columns = []
    for i in range(len(state)):
        step = np.zeros(len(state))
        step[i] = STEP * max(1.0, abs(state[i]))
        ends = [exact_modal.run(problem, 1, state + sign * step).final_state for sign in (1, -1)]
        columns.append((ends[0] - ends[1]) / (2.0 * step[i]))
    return np.sort(np.abs(np.linalg.eigvals(np.array(columns).T)))
