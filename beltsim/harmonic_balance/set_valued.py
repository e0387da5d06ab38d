r"""Harmonic balance for exact Coulomb friction: no sigma, and no failure from a cold start.

Sought is a velocity with harmonics up to R and a torque with

.. math:: V_r = A_r (F_r - h_r), \qquad h \in Q_m\,\mathrm{Sgn}(v), \quad |h| \le Q_m .

A has a non-negative real part and Sgn is monotone, so the velocity exists and is unique, and an
interior-point method reaches it from anywhere. The torque is constant in cells whose Fourier
integrals are exact; cells that hold an edge are cut until the gap

.. math:: 1 - \int h v\,d\tau / (Q_m \int |v|\,d\tau)

on an independent fine grid is below the tolerance, or the cells are as fine as is worth while.

The truncated problem locks before the exact one, from `least_bound` on: :math:`Q_{cr}(R)`, the
smallest bound of a torque whose harmonics 1..R are those of the locked reaction.

Depends on: _kernels, cells, condensation, settings.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import ConvergenceError
from beltsim.harmonic_balance import _kernels
from beltsim.harmonic_balance.cells import Cells, refined, uniform
from beltsim.harmonic_balance.condensation import ComplexArray, Condensed
from beltsim.harmonic_balance.settings import Settings

#: Cells per harmonic before any is cut.
CELLS_PER_HARMONIC = 8
#: Cells per harmonic beyond which none is cut any more.
MOST_CELLS = 60
#: Pieces of a cell that is cut.
PIECES = 6
#: Residual at which the interior-point method stops, and the largest that counts as converged.
STOP, ACCEPTED = 1e-9, 1e-5
#: Largest gap that counts as converged, whatever smaller one was asked for.
ACCEPTED_GAP = 5e-3
#: Share of the frictionless motion below which the joint hardly moves.
STILL = 0.02
#: Points of the grid that judges the result, per harmonic.
JUDGE = 32


@dataclass(frozen=True, eq=False)
class Solved:
    """Torque and velocity of the joint.

    Parameters
    ----------
    torque : (nS,) complex harmonics of the torque, in the order of `Condensed.orders`.
    velocity : (nS,) complex harmonics of the joint's velocity.
    mean_torque : float
    bounds, levels : (N + 1,), (N,)
        The torque over one repetition: constant in cells between angles 0 and 2 pi; empty when it
        is smooth (locked joint, saturated law).
    locked : bool
    gap : float
        Gap between torque and law on the fine grid.
    iterations : int
    residuals : tuple of float
    """

    torque: ComplexArray
    velocity: ComplexArray
    mean_torque: float
    bounds: FloatArray
    levels: FloatArray
    locked: bool
    gap: float
    iterations: int
    residuals: tuple[float, ...] = field(default=())


def critical_bound(condensed: Condensed) -> float:
    """Q_cr(R): least torque that locks the truncated problem, from above, to 1e-6 of itself."""
    key = "_critical_bound"
    if key not in condensed.__dict__:
        object.__setattr__(condensed, key, _critical_bound(condensed))
    return float(condensed.__dict__[key])


def _critical_bound(condensed: Condensed) -> float:
    reaction = condensed.reaction
    if not np.all(np.isfinite(reaction)):
        return np.inf
    if not np.any(reaction):
        return 0.0
    cells = _first_cells(condensed)
    wanted = _pairs(reaction)
    _, high, _ = _kernels.least_bound(cells.table, cells.weight, wanted, 1e-7, 60)
    return float(high)


def solve(condensed: Condensed, Q_m: float, settings: Settings) -> Solved:
    """The truncated problem's solution for the torque `Q_m` >= 0.

    Raises
    ------
    ConvergenceError
        When the residual or the gap stays above its tolerance.
    """
    if Q_m == 0.0:
        zero = np.zeros(len(condensed.orders), dtype=complex)
        return Solved(zero, condensed.velocity, 0.0, *_empty(), False, 0.0, 0)
    if Q_m >= critical_bound(condensed):
        return locked(condensed)
    size = float(np.sqrt(0.5 * np.sum(np.abs(condensed.velocity) ** 2)))
    free = _pairs(condensed.velocity / size)
    mobility = np.ascontiguousarray(condensed.mobility * (Q_m / size))
    cells = _first_cells(condensed, settings)
    history: list[float] = []
    best: Solved | None = None
    worst = np.inf
    for _ in range(settings.max_refinements + 1):
        h, _, residuals = _kernels.interior_point(
            cells.table, cells.weight, mobility, free, STOP, settings.max_iterations
        )
        history += residuals.tolist()
        found = _solved(condensed, cells, h, Q_m, size, history)
        if residuals.min() <= ACCEPTED and (best is None or found.gap < best.gap):
            best, worst = found, float(residuals.min())
        elif residuals.min() > ACCEPTED and best is not None:
            break  # cells finer than rounding can tell apart
        if cells.sampled or found.gap <= settings.tolerance:
            break
        cells = refined(cells, h, 1.0, PIECES)
        if len(cells.weight) * cells.images > MOST_CELLS * (int(cells.orders[-1]) + 1):
            break
    if best is None or not (cells.sampled or best.gap <= ACCEPTED_GAP):
        shown = best or found
        message = (
            f"set-valued harmonic balance stopped at residual {min(worst, *history):.2g}, gap "
            f"{shown.gap:.2g} after {len(history)} iterations at Omega = {condensed.Omega:.6g}, "
            f"Q_m = {Q_m:.6g}; try max_refinements above {settings.max_refinements}, "
            f"max_iterations above {settings.max_iterations}, or another R ({condensed.R} now)"
        )
        raise ConvergenceError(message, shown, history)
    return replace(best, residuals=tuple(history), iterations=len(history))


def _solved(
    condensed: Condensed, cells: Cells, h: FloatArray, Q_m: float, size: float, history: list[float]
) -> Solved:
    torque = Q_m * cells.coefficients(h)
    velocity = condensed.velocity - condensed.mobility * torque
    bounds, levels = cells.whole(h)
    return Solved(
        torque,
        velocity,
        Q_m * cells.mean(h),
        bounds,
        Q_m * levels,
        False,
        _gap(condensed, cells, h, velocity, size),
        len(history),
        tuple(history),
    )


def locked(condensed: Condensed) -> Solved:
    """The joint at rest, in the middle of its rest interval."""
    torque = condensed.reaction.copy()
    low, high = reaction_range(condensed)
    return Solved(torque, np.zeros_like(torque), -0.5 * (low + high), *_empty(), True, 0.0, 0)


def reaction_range(condensed: Condensed) -> tuple[float, float]:
    """Least and largest value of the locked reaction, its mean left out."""
    key = "_reaction_range"
    if key not in condensed.__dict__:
        orders = condensed.orders // condensed.divisor
        ends = (_largest(orders, -condensed.reaction), _largest(orders, condensed.reaction))
        object.__setattr__(condensed, key, (-ends[0], ends[1]))
    return cast("tuple[float, float]", condensed.__dict__[key])


def _largest(orders: NDArray[np.int64], series: ComplexArray) -> float:
    """Largest value of Re sum series exp(i order tau): from a grid, polished by Newton."""
    count = 64 * int(orders.max(initial=1))
    tau = 2.0 * np.pi * np.arange(count) / count
    values = (np.exp(1j * np.multiply.outer(tau, orders)) @ series).real
    around = np.flatnonzero((values >= np.roll(values, 1)) & (values >= np.roll(values, -1)))
    tau = tau[around[np.argsort(values[around])[-8:]]]
    for _ in range(4):
        wave = np.exp(1j * np.multiply.outer(tau, orders)) * series
        slope, bend = (wave @ (1j * orders)).real, (wave @ (-(orders**2))).real
        step = np.where(bend < 0.0, -slope / np.where(bend < 0.0, bend, 1.0), 0.0)
        tau = tau + np.clip(step, -1.0 / count, 1.0 / count)
    return float((np.exp(1j * np.multiply.outer(tau, orders)) @ series).real.max(initial=0.0))


def _first_cells(condensed: Condensed, settings: Settings | None = None) -> Cells:
    highest = condensed.R // condensed.divisor
    if settings is not None and settings.projection == "sampled":
        return uniform(highest, condensed.half_wave, settings.samples_for(highest), True)
    return uniform(highest, condensed.half_wave, CELLS_PER_HARMONIC * (highest + 1))


def _pairs(coefficients: ComplexArray) -> FloatArray:
    pairs = np.empty(2 * len(coefficients))
    pairs[0::2], pairs[1::2] = coefficients.real, -coefficients.imag
    return pairs


def _empty() -> tuple[FloatArray, FloatArray]:
    return np.zeros(0), np.zeros(0)


def _gap(
    condensed: Condensed, cells: Cells, h: FloatArray, velocity: ComplexArray, size: float
) -> float:
    """1 - int h v / int |v| on a grid that knows nothing of the cells' integrals.

    Where hardly anything moves, the motion without friction takes the place of int |v|.
    """
    orders = condensed.orders // condensed.divisor
    count = JUDGE * (int(orders[-1]) + 1)
    tau = (np.arange(count) + 0.5) * (2.0 * np.pi / condensed.images / count)
    v = (np.exp(1j * np.multiply.outer(tau, orders)) @ velocity).real
    moved = float(np.mean(np.abs(v)))
    torque = h[np.searchsorted(cells.bounds, tau, side="right") - 1]
    missing = moved - float(np.mean(torque * v))
    return max(0.0, missing / max(moved, STILL * size))
