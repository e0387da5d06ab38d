r"""Sign changes of a trigonometric polynomial, located as roots of its companion matrix.

With :math:`z = e^{i\tau}` a real series :math:`v = \mathrm{Re}\sum_k V_k z^k` is, times a power of
z, a polynomial. Every real zero of v is the angle of one of its roots, so between two neighbouring
angles (of all roots, on the circle or not) v keeps its sign: the signs halfway between them count
the changes without sampling.

Depends on: errors, checks.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import InvalidProblemError, Mistake


def sign_change_angles(coefficients: Any) -> FloatArray:
    r"""Angles in [0, 2 pi) where Re sum_k c_k exp(i k tau) changes sign, ascending.

    Parameters
    ----------
    coefficients : array_like of shape (R + 1,), complex
        Row 0 is the mean.

    Raises
    ------
    InvalidProblemError
        When the coefficients are not one row of finite numbers.

    Examples
    --------
    >>> sign_change_angles([0.0, 1.0]) / np.pi
    array([0.5, 1.5])
    """
    c = np.asarray(coefficients)
    if c.dtype.kind not in "iufc" or c.ndim != 1 or not len(c) or not np.isfinite(c).all():
        allowed = "one row of finite complex numbers, from the mean on"
        raise InvalidProblemError(Mistake("coefficients", coefficients, allowed))
    c = c.astype(complex)
    c[0] = c[0].real
    size = float(np.abs(c).max())
    if size == 0.0:
        return np.zeros(0)
    c = np.where(np.abs(c) > 1e-15 * size, c / size, 0.0)
    active = np.flatnonzero(c)
    top = int(active[-1])
    if top == 0:
        return np.zeros(0)
    powers = np.concatenate([-active[::-1], active])
    step = int(np.gcd.reduce(np.diff(powers)[np.diff(powers) > 0]))
    polynomial = np.zeros(2 * top + 1, dtype=complex)
    polynomial[top - active] += 0.5 * c[active]
    polynomial[top + active] += 0.5 * np.conj(c[active])
    roots = np.angle(np.roots(polynomial[::step])) / step
    splits = (roots[:, None] + 2.0 * np.pi * np.arange(step) / step).ravel()
    splits = np.sort(np.mod(splits, 2.0 * np.pi))
    between = 0.5 * (
        splits
        + np.roll(splits, -1)
        + np.where(np.arange(len(splits)) < len(splits) - 1, 0.0, 2.0 * np.pi)
    )
    values = _values(c, active, between)
    before = np.roll(values, 1)
    changes = np.flatnonzero(before * values < 0.0)
    low, high = np.roll(between, 1)[changes], between[changes]
    low = np.where(low > high, low - 2.0 * np.pi, low)
    for _ in range(60):  # bisection: sure, and cheap beside the roots
        middle = 0.5 * (low + high)
        same = _values(c, active, middle) * before[changes] > 0.0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.sort(np.mod(0.5 * (low + high), 2.0 * np.pi))


def reversals_of_series(coefficients: Any) -> float:
    """Velocity reversals nu of a truncated velocity series, by located sign changes.

    nu = max(0, (sign changes per period - 2)/4). Inside a sticking phase a truncated series ripples
    about zero, so this counts ripples too; `Response.velocity_reversals` does not.

    Parameters
    ----------
    coefficients : array_like of shape (R + 1,), complex
        Harmonics of the velocity, row 0 the mean.

    Examples
    --------
    >>> reversals_of_series([0.0, 1.0]), reversals_of_series([0.0, 1.0, 0.0, 1.5])
    (0.0, 1.0)
    """
    return max(0.0, (len(sign_change_angles(coefficients)) - 2.0) / 4.0)


def _values(c: NDArray[np.complex128], active: NDArray[np.intp], tau: FloatArray) -> FloatArray:
    found: FloatArray = (np.exp(1j * np.multiply.outer(tau, active)) @ c[active]).real
    return found
