r"""Periodic forcing of a linear system, as a finite Fourier series.

.. math:: f(t) = \sum_{k=0}^{H} c_k \cos k\Omega t + s_k \sin k\Omega t

Row `k` of `cos` and `sin` belongs to harmonic `k`; row 0 is the mean. `H = 0` is an unforced or
constantly loaded system.

Depends on: errors, checks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray, finite_array, not_finite_words, read_only, real_number
from beltsim.errors import InvalidProblemError, Mistake


@dataclass(frozen=True, eq=False)
class HarmonicForcing:
    """Forcing as a Fourier series of fundamental `Omega`.

    Parameters
    ----------
    Omega : float
        Fundamental frequency, rad per unit of the problem's time. Positive.
    cos, sin : array_like of shape (H + 1, n)
        Generalised forces: row `k` multiplies `cos(k Omega t)` and `sin(k Omega t)`.
        Row 0 of `sin` has no meaning and must be zero.

    Raises
    ------
    InvalidProblemError
        On a non-positive `Omega`, wrong shapes or entries that are not finite.

    Examples
    --------
    >>> forcing = HarmonicForcing(2.0, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]])
    >>> float(forcing.at(0.0)[0])
    1.0
    """

    Omega: float
    cos: FloatArray
    sin: FloatArray

    def __post_init__(self) -> None:
        mistakes = []
        Omega = real_number(self.Omega)
        if Omega is None or not Omega > 0.0:
            mistakes.append(Mistake("forcing.Omega", self.Omega, "a finite number > 0"))
        rows: dict[str, FloatArray] = {}
        for name in ("cos", "sin"):
            array = finite_array(getattr(self, name), ndim=2)
            if array is None or array.shape[0] < 1:
                allowed = "a finite array of shape (H + 1, n), one row per harmonic from 0"
                value = not_finite_words(getattr(self, name)) or getattr(self, name)
                mistakes.append(Mistake(f"forcing.{name}", value, allowed))
            else:
                rows[name] = array
        if len(rows) == 2 and rows["cos"].shape != rows["sin"].shape:
            allowed = f"of shape {rows['cos'].shape}, as cos"
            mistakes.append(Mistake("forcing.sin", rows["sin"].shape, allowed))
        if "sin" in rows and np.any(rows["sin"][0]):
            allowed = "zero: sin(0 t) does not exist"
            mistakes.append(Mistake("forcing.sin[0]", rows["sin"][0], allowed))
        if mistakes:
            raise InvalidProblemError(mistakes)
        object.__setattr__(self, "Omega", Omega)
        for name, array in rows.items():
            object.__setattr__(self, name, read_only(array))

    def __repr__(self) -> str:
        used = np.flatnonzero(self.cos.any(axis=1) | self.sin.any(axis=1)).tolist()
        return (
            f"<HarmonicForcing: Omega = {self.Omega:.6g}, {self.cos.shape[1]} coordinates, "
            f"harmonics {', '.join(map(str, used)) or 'none'}>"
        )

    @property
    def period(self) -> float:
        """Period 2 pi / Omega of the fundamental, in the problem's time unit."""
        return 2.0 * np.pi / self.Omega

    @property
    def n_harmonics(self) -> int:
        """Highest harmonic H held (0 for a constant load)."""
        return len(self.cos) - 1

    @property
    def coefficients(self) -> NDArray[np.complex128]:
        """Complex rows `c_k - i s_k`, shape (H + 1, n): f = Re sum_k row_k exp(i k Omega t)."""
        return self.cos - 1j * self.sin

    def at(self, t: Any) -> FloatArray:
        """Forces at the times `t` (shape (...,)): array of shape (..., n)."""
        angle = np.multiply.outer(np.asarray(t, float) * self.Omega, np.arange(len(self.cos)))
        return np.cos(angle) @ self.cos + np.sin(angle) @ self.sin
