r"""The joint's mobility beyond the last harmonic, and what it does to a torque in phases.

Far above the natural frequencies, with :math:`s = ir\Omega` and :math:`B = C + G`,

.. math:: A_r = \sum_{j \ge 1} \alpha_j s^{-j}, \quad \alpha_j = e_t^T X_j e_t, \qquad
          X_1 = M^{-1}, \; X_j = -M^{-1}(B X_{j-1} + K X_{j-2}) .

The first term is the joint's mass alone. :math:`h_r/(ir)^j` are the harmonics of the j-th integral
of h, so that for a torque known in closed form the tail needs no series.

Depends on: condensation.
"""

from __future__ import annotations

from functools import lru_cache
from typing import cast

import numpy as np
from numpy.polynomial import legendre

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


@lru_cache(maxsize=32)
def integrated(count: int, times: int) -> FloatArray:
    """Legendre coefficients (times + 1, count + times, count) of P_k integrated 0, 1, ... times.

    Each integral starts from 0 at -1.
    """
    found = np.zeros((times + 1, count + times, count))
    for j in range(times + 1):
        found[j, : count + j] = legendre.legint(np.eye(count), m=j, lbnd=-1) if j else np.eye(count)
    found.flags.writeable = False
    return found


def powers(u: FloatArray, highest: int) -> FloatArray:
    """u^m / m! in the last axis, m = 0 ... highest."""
    found = np.ones((*np.shape(u), highest + 1))
    for m in range(1, highest + 1):
        found[..., m] = found[..., m - 1] * u / m
    return found


def starts(lengths: FloatArray, inner: FloatArray, jumps: FloatArray, mirror: int) -> FloatArray:
    r"""Values (p, J + 1, columns) of the j-th integrals where phases start, h itself left out.

    In a phase, :math:`I^j(u) = \sum_m y_{j-m} u^m/m!` and what h adds inside it; y_0 is minus the
    mean of h. Closed by: after all phases the integrals are `mirror` times what they were.

    Parameters
    ----------
    lengths : (p,)
    inner : (p, J + 1, columns)
        What h adds to the integrals over each phase.
    jumps : (p, columns)
        Impulses of h just before each phase.
    mirror : int
        1, or -1 when the phases are half a period after which everything changes sign.
    """
    top = inner.shape[1] - 1
    shift = np.subtract.outer(np.arange(top + 1), np.arange(top + 1))

    def moved(length: FloatArray) -> FloatArray:
        return np.asarray(np.where(shift >= 0, powers(length, top)[..., np.abs(shift)], 0.0))

    steps, now = moved(lengths), np.zeros(inner.shape[1:])
    found = np.empty_like(inner)
    for i in range(len(lengths)):
        now[1] += jumps[i]
        found[i] = now
        now = steps[i] @ now + inner[i]
    closing = moved(lengths.sum()) - mirror * np.eye(top + 1)
    first = np.zeros_like(now)
    if mirror > 0:
        first[:-1] = np.linalg.solve(closing[1:, :-1], -now[1:])
    else:
        first[1:] = np.linalg.solve(closing[1:, 1:], -now[1:])
    return np.asarray(found + moved(np.cumsum(lengths) - lengths) @ first)


def harmonics(orders: FloatArray, begin: FloatArray, end: FloatArray, count: int) -> ComplexArray:
    r"""Harmonics (p, count, nS) of P_k on each phase and zero elsewhere.

    .. math:: \frac1\pi\int P_k e^{-ir\tau}d\tau = \frac{b - a}{\pi}(-i)^k j_k(r(b - a)/2)
              e^{-ir(a + b)/2}
    """
    from scipy.special import spherical_jn  # slow to import, and only patterns need it

    k, length = np.arange(count), end - begin
    argument = 0.5 * np.multiply.outer(length, orders)
    size = spherical_jn(k[:, None], argument[:, None, :]) * (length / np.pi)[:, None, None]
    turned = np.exp(-0.5j * np.multiply.outer(begin + end, orders))
    return np.asarray((-1j) ** k[:, None] * size * turned[:, None, :])
