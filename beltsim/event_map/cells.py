r"""A linear flow without eigenvectors, on short cells.

Where the modes are defective or nearly so, where K is singular or an undamped mode is in resonance,
the closed form in modes loses its digits. There the state is extended by the constant, the load and
the oscillators, :math:`y = (x, 1, c, \cos h\Omega t, \sin h\Omega t)`, so that

.. math:: \dot y = A y, \qquad y(t + ud) = \sum_k \frac{(ud)^k}{k!} A^k y(t), \quad |A| d \le 1,

exact to rounding. `x` is scaled to energy coordinates (Cholesky factors of K and M), in which the
free motion of a passive system does not grow.

Depends on: linear_part, binding, checks.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map import binding
from beltsim.event_map.linear_part import ComplexArray, LinearPart

#: Terms of a Taylor series, as in beltsim_map.h, and those that matter on a cell.
TERMS = 32
_ENOUGH = 24
#: What the C map calls a flow in cells.
CELLS = -1


@dataclass(frozen=True, eq=False)
class CellFlow:
    """One linear flow of N reals in cells; the counterpart of `flows.Flow`.

    `exponents` are for judging stability only.
    """

    part: LinearPart
    exponents: ComplexArray
    condition: float
    scale: tuple[FloatArray, FloatArray]
    m: int = CELLS
    _powers: list[FloatArray] = field(default_factory=list)

    @property
    def N(self) -> int:
        """Reals in the state."""
        return len(self.part.row)

    @property
    def size(self) -> int:
        """Reals in the extended state."""
        return self.N + 2 * len(self.part.D)

    @property
    def Omega(self) -> float:
        """Fundamental of the forcing."""
        return self.part.Omega

    @property
    def X_c(self) -> FloatArray:
        """No static part is taken out of the state."""
        return np.zeros(self.N)

    @property
    def fastest(self) -> float:
        """Largest modulus of an exponent."""
        return float(np.abs(self.exponents).max(initial=0.0))

    @cached_property
    def generator(self) -> FloatArray:
        """A (Na, Na) of the extended state."""
        N, part, (into, out) = self.N, self.part, self.scale
        H = len(part.D) - 1
        A = np.zeros((self.size, self.size))
        A[:N, :N] = into @ part.A @ out
        A[:N, N] = into @ part.force[0].real
        A[:N, N + 1] = into @ part.load
        for h in range(1, H + 1):
            cos, sin = N + 1 + h, N + 1 + H + h
            A[:N, cos], A[:N, sin] = into @ part.force[h].real, -into @ part.force[h].imag
            A[cos, sin], A[sin, cos] = -h * self.Omega, h * self.Omega
        return A

    @cached_property
    def d(self) -> float:
        """Length of a cell."""
        norm = np.linalg.norm(self.generator[: self.N, : self.N], 2) if self.N else 0.0
        return 1.0 / max(float(norm), len(self.part.D) * self.Omega)

    @cached_property
    def step(self) -> FloatArray:
        """exp(A d)."""
        total = np.eye(self.size)
        for k in range(_ENOUGH, 0, -1):
            total = np.eye(self.size) + self.generator @ total * (self.d / k)
        return total

    @cached_property
    def packed(self) -> FloatArray:
        """All arrays in the order in which the C map reads them."""
        part, scaled = self.part, self.generator * self.d
        row = np.zeros(self.size)
        H = len(part.D) - 1
        row[: self.N] = part.row @ self.scale[1]
        row[self.N], row[self.N + 1] = part.D[0].real, part.d_c
        row[self.N + 2 : self.N + 2 + H], row[self.N + 2 + H :] = part.D[1:].real, -part.D[1:].imag
        rows = [row]
        for k in range(1, TERMS):
            rows.append(rows[-1] @ scaled / k)
        parts = [self.scale[0].T, self.scale[1].T, scaled.T, self.step.T, np.array(rows)]
        parts += [part.row, part.D.real, part.D.imag, np.array([part.d_c, self.d])]
        found = np.concatenate([each.ravel() for each in parts])
        assert len(found) == binding.flow_reals(self.N, CELLS, H)[0]
        return found

    def extended(self, t: float, c: float, x: FloatArray) -> FloatArray:
        """The extended state (Na,) of state `x` at time `t` under load `c`."""
        angle = self.Omega * t * np.arange(1, len(self.part.D))
        return np.concatenate([self.scale[0] @ x, [1.0, c], np.cos(angle), np.sin(angle)])

    def advanced(self, y: FloatArray, tau: float) -> FloatArray:
        """Extended states `y` (..., Na) a time `tau` later."""
        cells = int(tau / self.d)
        rest, bit = tau / self.d - cells, 0
        if not self._powers:
            self._powers.append(self.step.T)
        while cells:
            while bit >= len(self._powers):
                self._powers.append(self._powers[-1] @ self._powers[-1])
            if cells & 1:
                y = y @ self._powers[bit]
            cells, bit = cells >> 1, bit + 1
        term = total = y
        for k in range(1, _ENOUGH):
            term = term @ self.generator.T * (rest * self.d / k)
            total = total + term
        return total

    def states(self, y: FloatArray, tau: FloatArray) -> FloatArray:
        """States (nt, N) at ascending times `tau` (nt,) after the extended state `y`."""
        found = np.empty((len(tau), self.N))
        cell = np.floor(tau / self.d).astype(int)
        at, done = y, 0
        for i, first in zip(*np.unique(cell, return_index=True), strict=True):
            last = int(np.searchsorted(cell, i, side="right"))
            at = self.advanced(at, (i - done) * self.d * (1.0 + 1e-15))
            done = int(i)
            u = tau[first:last] / self.d - i
            terms = [at]
            for k in range(1, _ENOUGH):
                terms.append(self.generator @ terms[-1] * (self.d / k))
            found[first:last] = (
                np.vander(u, _ENOUGH, increasing=True) @ np.array(terms)[:, : self.N]
            )
        scaled: FloatArray = found @ self.scale[1].T
        return scaled
