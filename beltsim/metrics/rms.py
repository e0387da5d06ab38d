r"""Root mean square of coordinates over one period, mean included.

From samples by the trapezoidal rule, which is spectrally accurate over a whole period of a smooth
motion; from complex harmonics :math:`\sqrt{c_0^2 + \tfrac12\sum |c_k|^2}`.

Depends on: response (its type only), checks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from beltsim.checks import FloatArray

if TYPE_CHECKING:
    from beltsim.response import Response


def rms_of_samples(t: Any, values: Any) -> FloatArray:
    """Root mean square of samples over time.

    Parameters
    ----------
    t : (nt,)
        Increasing times, both ends of the period included; any spacing.
    values : (nt, ...)

    Returns
    -------
    (...)

    Examples
    --------
    >>> t = np.linspace(0.0, 2.0 * np.pi, 100)
    >>> float(rms_of_samples(t, np.sin(t)).round(6))
    0.707107
    """
    t, squares = np.asarray(t, dtype=float), np.asarray(values, dtype=float) ** 2
    steps = np.diff(t).reshape(-1, *[1] * (squares.ndim - 1))
    integral = np.sum(0.5 * steps * (squares[1:] + squares[:-1]), axis=0)
    return np.asarray(np.sqrt(integral / (t[-1] - t[0])))


def rms_of_coefficients(coefficients: Any) -> FloatArray:
    """Root mean square of Re sum_k c_k exp(i k Omega t) over a period.

    Parameters
    ----------
    coefficients : (R + 1, ...) complex
        Row 0 is the mean.

    Returns
    -------
    (...)

    Examples
    --------
    >>> float(rms_of_coefficients([0.0, 1j]).round(6))
    0.707107
    """
    c = np.asarray(coefficients)
    return np.asarray(np.sqrt(c[0].real ** 2 + 0.5 * np.sum(np.abs(c[1:]) ** 2, axis=0)))


def rms(response: Response) -> FloatArray:
    """Root mean square of each coordinate of a response (n,), in the problem's units.

    From its harmonics where it has them, else from its samples.
    """
    if response.coefficients is not None:
        return rms_of_coefficients(response.coefficients)
    return rms_of_samples(response.t, response.q)
