r"""A linear system in first order, with the signal that is watched.

.. math:: \dot x = A x + \mathrm{Re}\sum_h f_h e^{ih\Omega t} + l\,c, \qquad
   s = \mathrm{row}\cdot x + \mathrm{Re}\sum_h D_h e^{ih\Omega t} + d_c c

Depends on: errors, checks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import NotPeriodicError

ComplexArray = NDArray[np.complex128]
#: A stiffness this near singular, relatively, cannot answer a harmonic.
_SINGULAR = 1e-12
#: Share of a force that counts as answered when no more than this is left.
_LEFT = 1e-9


@dataclass(frozen=True, eq=False)
class LinearPart:
    """Second-order matrices and the same in first order; see the module for the symbols.

    `M`, `damping`, `K` (k, k), `F` (H + 1, k) and `push` (k,) make `A` (N, N), `force` (H + 1, N)
    and `load` (N,), N = 2k.
    """

    M: FloatArray
    damping: FloatArray
    K: FloatArray
    F: ComplexArray
    push: FloatArray
    Omega: float
    row: FloatArray
    D: ComplexArray
    d_c: float

    @cached_property
    def _inverse(self) -> FloatArray:
        return np.asarray(np.linalg.inv(self.M), dtype=float)

    @cached_property
    def A(self) -> FloatArray:
        """Matrix of the free motion."""
        k = len(self.M)
        found = np.zeros((2 * k, 2 * k))
        found[:k, k:] = np.eye(k)
        found[k:, :k] = -self._inverse @ self.K
        found[k:, k:] = -self._inverse @ self.damping
        return found

    @cached_property
    def force(self) -> ComplexArray:
        """Harmonics of the forcing in the state's rates."""
        return np.concatenate([0.0 * self.F, self.F @ self._inverse.T], axis=1)

    @cached_property
    def load(self) -> FloatArray:
        """A unit of the constant load in the state's rates."""
        return np.concatenate([0.0 * self.push, self._inverse @ self.push])

    def signals(self, t: FloatArray, c: FloatArray, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The signal and its rate (nt,) at times `t`, loads `c` (nt,) and states `x` (nt, N)."""
        spin = 1j * self.Omega * np.arange(len(self.D))
        turns = np.exp(np.multiply.outer(t, spin))
        value = x @ self.row + (turns @ self.D).real + self.d_c * c
        rate = x @ (self.row @ self.A) + (self.row @ self.load) * c
        rate += (turns @ (self.force @ self.row + spin * self.D)).real
        return value, rate

    def steady(self, name: str, bound: float = 0.0, joint: int = 0) -> ComplexArray:
        """Harmonics (H + 1, k) of the steady response, where there is one.

        `bound`: largest friction torque at coordinate `joint`. Its mean is at most that, and its
        harmonics 4/pi times that (a square wave), which may hold an undamped mode.

        Raises
        ------
        NotPeriodicError
            When a harmonic of the forcing meets a mode without damping.
        """
        found = np.zeros_like(self.F)
        for h, force in enumerate(self.F):
            w = h * self.Omega
            Z = self.K + 1j * w * self.damping - w**2 * self.M
            if not force.any():
                continue
            answer, left = _least_squares(Z, force)
            if left > _LEFT and bound > 0.0:
                size = float(np.linalg.norm(Z)) or 1.0
                unit = np.eye(len(force))[:, [joint]]
                answer, left = _least_squares(np.hstack([Z, unit * size]), force)
                needed = float(np.abs(answer[-1])) * size
                most = bound * (4.0 / np.pi if h else 1.0)
                if left <= _LEFT and needed > most * (1.0 + _LEFT):
                    why = f"friction holds at most {most:.6g} of the {needed:.6g} there"
                    raise self._resonance(h, name, why)
            if left > _LEFT:
                raise self._resonance(h, name, "friction does not reach it")
            found[h] = answer[: len(force)]
        return found

    def _resonance(self, h: int, name: str, why: str) -> NotPeriodicError:
        what = "a mean load" if h == 0 else f"harmonic {h} of the forcing"
        text = (
            f"{what} meets an undamped mode of frequency {h * self.Omega:.6g} of the system with "
            f"its joint {name}, and {why}: the motion grows, no periodic orbit is sought. Add "
            "damping or stiffness, or look at a transient"
        )
        return NotPeriodicError(text)


def _least_squares(columns: Any, force: ComplexArray) -> tuple[ComplexArray, float]:
    """Solution, and what is left of `force`, relatively."""
    answer = np.asarray(np.linalg.lstsq(columns, force, rcond=_SINGULAR)[0], dtype=complex)
    left = float(np.linalg.norm(columns @ answer - force)) / float(np.linalg.norm(force))
    return answer, left
