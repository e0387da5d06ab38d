"""Reading numbers and arrays that a user gave, without guessing.

Depends on: nothing.
"""

from __future__ import annotations

from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def real_number(value: Any) -> float | None:
    """`value` as a finite float, or None when it is not one.

    A bool, a text, a complex number and an array with entries are not numbers here.

    Examples
    --------
    >>> real_number(3), real_number(True), real_number("3"), real_number(float("nan"))
    (3.0, None, None, None)
    """
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real):
        return None
    try:
        number = float(value)
    except OverflowError:
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


def not_finite_words(value: Any) -> str | None:
    """The first entry of the array `value` that is not finite, in words; None when all are.

    Examples
    --------
    >>> not_finite_words([[1.0, 2.0], [float("nan"), 0.0]])
    'nan at [1, 0]'
    """
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, OverflowError):
        return None
    if array.dtype.kind != "f":
        return None
    bad = np.argwhere(~np.isfinite(array))
    if len(bad) == 0:
        return None
    more = f" and {len(bad) - 1} more" if len(bad) > 1 else ""
    return f"{array[tuple(bad[0])]:g} at {bad[0].tolist()}{more}"


def read_only(array: Any) -> FloatArray:
    """A C-contiguous float copy of `array` that nobody can write to."""
    copy = np.array(array, dtype=np.float64, order="C", copy=True)
    copy.flags.writeable = False
    return copy
