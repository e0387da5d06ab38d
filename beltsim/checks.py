"""Reading numbers and arrays that a user gave, without guessing.

Depends on: nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def real_number(value: Any) -> float | None:
    """`value` as a finite float, or None when it is not one (a bool is not a number here)."""
    if isinstance(value, bool | np.bool_ | str | bytes):
        return None
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        return None
    return number if np.isfinite(number) else None


def finite_array(value: Any, ndim: int) -> FloatArray | None:
    """`value` as a float array of `ndim` dimensions with finite entries, or None."""
    try:
        raw = np.asarray(value)
        if raw.dtype.kind not in "iuf" or raw.ndim != ndim:
            return None
        array = raw.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        return None
    return array if np.isfinite(array).all() else None


def read_only(array: Any) -> FloatArray:
    """A C-contiguous float copy of `array` that nobody can write to."""
    copy = np.array(array, dtype=np.float64, order="C", copy=True)
    copy.flags.writeable = False
    return copy
