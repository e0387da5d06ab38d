"""Order of convergence from errors at several steps.

Depends on: nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def order(sizes: Sequence[float], errors: Sequence[float]) -> float:
    """Slope of log error over log size, by least squares."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def along_line(sizes: Sequence[float], errors: Sequence[float], slope: float) -> np.ndarray:
    """The line of the given slope through the middle of the errors, at every size."""
    x, y = np.log(np.asarray(sizes, float)), np.log(np.asarray(errors, float))
    return np.asarray(y.mean() + slope * (x - x.mean())) / np.log(10.0)
