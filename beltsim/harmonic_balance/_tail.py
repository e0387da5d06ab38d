r"""The joint's mobility beyond the last harmonic, and what it does to a torque in phases.

Far above the natural frequencies, with :math:`s = ir\Omega` and :math:`B = C + G`,

.. math:: A_r = \sum_{j \ge 1} \alpha_j s^{-j}, \quad \alpha_j = e_t^T X_j e_t, \qquad
          X_1 = M^{-1}, \; X_j = -M^{-1}(B X_{j-1} + K X_{j-2}) .

The first term is the joint's mass alone. :math:`h_r/(ir)^j` are the harmonics of the j-th integral
of h, so that for a torque known in closed form the tail needs no series.

Depends on: condensation.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.polynomial import legendre
from scipy.special import spherical_jn

from beltsim.checks import FloatArray
from beltsim.harmonic_balance.condensation import ComplexArray, Condensed

#: Most terms of the expansion.
MOST_TERMS = 3


def terms(condensed: Condensed) -> FloatArray:
    r""":math:`\alpha_j/\Omega^j`: as many terms as fit the mobility of the last harmonic best."""
    problem = condensed.problem
    M, B, K = problem.M, problem.C + problem.G, problem.K
    unit = np.zeros(problem.n)
    unit[problem.joint] = 1.0
    before = np.zeros(problem.n)
    now: FloatArray = np.asarray(np.linalg.solve(M, unit), dtype=np.float64)
    alpha = []
    for j in range(1, MOST_TERMS + 1):
        alpha.append(float(now[cast("int", problem.joint)]) / condensed.Omega**j)
        before, now = now, np.asarray(-np.linalg.solve(M, B @ now + K @ before), dtype=np.float64)
    last = 1j * condensed.orders[-1]
    sums = np.cumsum([alpha[j] / last ** (j + 1) for j in range(MOST_TERMS)])
    best = int(np.argmin(np.abs(condensed.mobility[-1] - sums)))
    return np.array(alpha[: best + 1])


class Phases:
    r"""Periodic functions that are polynomials on each phase.

    Parameters
    ----------
    ends : (p + 1,) ascending angles, the last one turn after the first.
    parts : p arrays (degree + 1, columns)
        Legendre coefficients on each phase, one function per column.
    """

    def __init__(self, ends: FloatArray, parts: list[FloatArray]) -> None:
        self.ends, self.lengths = ends, np.diff(ends)
        mean = self._mean(parts)
        #: The functions without their mean, then their integrals without mean.
        self.integrals = [_shifted(parts, [-mean] * len(parts))]

    def _mean(self, parts: list[FloatArray]) -> FloatArray:
        pairs = zip(self.lengths, parts, strict=True)
        return cast("FloatArray", sum(length * part[0] for length, part in pairs)) / (2.0 * np.pi)

    def integral(self, times: int) -> list[FloatArray]:
        """The periodic integral, so many times, of the functions without their mean."""
        while len(self.integrals) <= times:
            found, starts = [], []
            area = np.zeros(self.integrals[0][0].shape[1:])
            for length, part in zip(self.lengths, self.integrals[-1], strict=True):
                found.append(legendre.legint(part, lbnd=-1, scl=0.5 * length))
                starts.append(area)
                area = area + length * part[0]
            found = _shifted(found, starts)
            self.integrals.append(_shifted(found, [-self._mean(found)] * len(found)))
        return self.integrals[times]

    def weighted(self, weights: FloatArray, first: int, phase: int, s: FloatArray) -> FloatArray:
        """Values (len(s), columns) of sum_j weights_j I^(first + j) at local s in a phase."""
        self.integral(first + len(weights) - 1)
        parts = [self.integrals[first + j][phase] for j in range(len(weights))]
        total = np.zeros_like(parts[-1])
        for weight, part in zip(weights, parts, strict=True):
            total[: len(part)] += weight * part
        return np.asarray(legendre.legvander(s, len(total) - 1) @ total)


def harmonics(orders: FloatArray, start: float, end: float, count: int) -> ComplexArray:
    r"""Harmonics (count, nS) of P_k over a phase and zero elsewhere.

    .. math:: \frac1\pi\int P_k e^{-ir\tau}d\tau = \frac{b - a}{\pi}(-i)^k j_k(r(b - a)/2)
              e^{-ir(a + b)/2}
    """
    k = np.arange(count)
    argument = 0.5 * orders * (end - start)
    size = spherical_jn(k[:, None], argument[None, :]) * (end - start) / np.pi
    turned = np.exp(-0.5j * orders * (start + end))
    return np.asarray((-1j) ** k[:, None] * size * turned)


def _shifted(parts: list[FloatArray], by: list[FloatArray]) -> list[FloatArray]:
    moved = [part.copy() for part in parts]
    for part, value in zip(moved, by, strict=True):
        part[0] += value
    return moved
