r"""Cells of the repetition period in which the friction torque is constant.

The torque :math:`h(\tau)`, :math:`\tau = d\,\Omega t` (d the common divisor of the harmonics), is
`h_j` in cell j between :math:`b_j` and :math:`b_{j+1}`. Its harmonics are exact integrals,

.. math:: h_r = \frac{m}{\pi}\sum_j h_j \int_{b_j}^{b_{j+1}} e^{-ir\tau} d\tau, \qquad
          \bar v_j = \frac{1}{b_{j+1} - b_j}\int_{b_j}^{b_{j+1}} v\,d\tau,

with m = 2 when half a period tells all (the other half has the opposite sign), else 1. A cell that
holds an edge carries the average of both sides, which places the edge inside it; such cells are cut
finer until the edges are located. Sampling replaces averages by values at N instants.

Depends on: checks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of one period (or half of it) and the harmonics in them.

    Parameters
    ----------
    bounds : (N + 1,) angles from 0 to 2 pi / images.
    orders : (nS,) harmonics of tau.
    images : int
    table : (N, 2 nS) cell averages (or samples) of cos r tau, sin r tau, in pairs.
    weight : (N,) with ``table.T @ (weight * h)`` the pairs of cos and sin coefficients of h.
    sampled : bool
    """

    bounds: FloatArray
    orders: NDArray[np.int64]
    images: int
    table: FloatArray
    weight: FloatArray
    sampled: bool

    def coefficients(self, h: FloatArray) -> ComplexArray:
        """Complex harmonics (nS,) of the torque `h` (N,): c - i s."""
        pairs = self.table.T @ (self.weight * h)
        return np.asarray(pairs[0::2] - 1j * pairs[1::2])

    def mean(self, h: FloatArray) -> float:
        """Mean torque."""
        if self.images == 2:
            return 0.0
        return float(np.diff(self.bounds) @ h / (2.0 * np.pi))

    def whole(self, h: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Bounds and torque over the whole period, 0 to 2 pi."""
        if self.images == 1:
            return self.bounds, h
        return np.concatenate([self.bounds, self.bounds[1:] + np.pi]), np.concatenate([h, -h])


@lru_cache(maxsize=32)
def uniform(highest: int, half_wave: bool, count: int, sampled: bool = False) -> Cells:
    """`count` equal cells per period (half as many when half of it tells all)."""
    images = 2 if half_wave else 1
    orders = np.arange(1, highest + 1, images)
    bounds = np.linspace(0.0, 2.0 * np.pi / images, max(count // images, len(orders) + 1) + 1)
    return of_bounds(bounds, orders, images, sampled)


def of_bounds(
    bounds: FloatArray, orders: NDArray[np.int64], images: int, sampled: bool = False
) -> Cells:
    """Cells between `bounds`, with exact averages, or with values at their middles."""
    width = np.diff(bounds)
    table = np.empty((len(width), 2 * len(orders)))
    angle = np.multiply.outer(0.5 * (bounds[1:] + bounds[:-1]), orders)
    half = 0.5 * np.multiply.outer(width, orders)
    share = np.ones_like(half) if sampled else np.sinc(half / np.pi)
    table[:, 0::2] = np.cos(angle) * share
    table[:, 1::2] = np.sin(angle) * share
    return Cells(bounds, orders, images, table, images * width / np.pi, sampled)


def refined(cells: Cells, h: FloatArray, bound: float, pieces: int) -> Cells:
    """Cells with those that hold an edge, and their neighbours, cut into `pieces`.

    An edge lies where the torque is between its bounds, or jumps from one to the other.
    """
    inside = np.abs(h) < bound * (1.0 - 1e-6)
    following = np.roll(h, -1) * np.where(np.arange(len(h)) == len(h) - 1, 3 - 2 * cells.images, 1)
    jumps = ~inside & (h * following < 0.0)
    marked = inside | jumps | np.roll(jumps, 1)
    marked |= np.roll(inside, 1) | np.roll(inside, -1)
    share = np.arange(pieces) / pieces
    new = [
        lower + (upper - lower) * share if cut else np.array([lower])
        for lower, upper, cut in zip(cells.bounds[:-1], cells.bounds[1:], marked, strict=True)
    ]
    bounds = np.concatenate([*new, cells.bounds[-1:]])
    return of_bounds(bounds, cells.orders, cells.images)
