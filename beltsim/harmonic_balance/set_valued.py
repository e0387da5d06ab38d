r"""Harmonic balance for exact Coulomb friction: no sigma, and no failure from a cold start.

Sought is a velocity with harmonics up to R and a torque with

.. math:: V_r = A_r (F_r - h_r), \qquad h \in Q_m\,\mathrm{Sgn}(v), \quad |h| \le Q_m .

A has a non-negative real part and Sgn is monotone, so the velocity exists and is unique. Unless it
is zero it vanishes at single instants only, and the torque switches between its bounds there: the
switching instants are the unknowns (`_switching`), found from a cold start and located to rounding.

Where that does not settle, the interior-point method takes over, which reaches the solution from
anywhere: the torque is constant in cells whose Fourier integrals are exact, and cells that hold an
edge are cut. Its edges start another search for the instants. Either way the result is judged by
the gap

.. math:: 1 - \int h v\,d\tau / (Q_m \int |v|\,d\tau)

on an independent fine grid.

The truncated problem locks before the exact one, from `least_bound` on: :math:`Q_{cr}(R)`, the
smallest bound of a torque whose harmonics 1..R are those of the locked reaction.

Depends on: _kernels, _switching, cells, condensation, phases, settings.
"""

from __future__ import annotations

import cmath
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import ConvergenceError
from beltsim.harmonic_balance import _kernels, _switching
from beltsim.harmonic_balance.cells import Cells, refined, uniform
from beltsim.harmonic_balance.condensation import ComplexArray, Condensed
from beltsim.harmonic_balance.phases import Located
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
ACCEPTED_GAP = 1e-4
#: Relative size below which a static stiffness is the rounding of its terms.
RIGID = 1e-12
#: A torque in a cell closer to its bound than this, relative, is at it.
EDGE = 1e-3
#: Share of the frictionless motion below which the joint hardly moves.
STILL = 0.02
#: Points of the grid that judges the result, per harmonic.
JUDGE = 32
#: Cells in which the search for switching instants starts, per unknown; the second is a retry.
SEARCH_CELLS = (2, 3)
#: Points per harmonic at which its result is checked for instants that it lacks.
SEARCH_GRID = 16
#: Largest velocity at an instant, relative, and most Newton steps on them.
LOCATED, LOCATING = 1e-11, 200


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
        Gap between torque and law on the fine grid; saturated law: `saturated.discrepancy`.
    iterations : int
    residuals : tuple of float
    exact : bool
        `bounds` are the located roots of the velocity.
    located : Located, optional
        The events, where the pattern was given.
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
    exact: bool = False
    located: Located | None = None


def critical_bound(condensed: Condensed) -> float:
    """Q_cr(R): least torque that locks the truncated problem."""
    key = "_critical_bound"
    if key not in condensed.__dict__:
        object.__setattr__(condensed, key, _critical_bound(condensed))
    return float(condensed.__dict__[key])


def _critical_bound(condensed: Condensed) -> float:
    present = _reaction(condensed)
    if not all(map(cmath.isfinite, present.values())):
        return np.inf
    highest = int(condensed.turns[-1])
    if present and not (condensed.half_wave or sprung(condensed)):
        return _least_bound_without_mean(highest, _pairs(condensed.reaction))
    if len(present) == 1:  # a shift in time and a factor tell all single harmonics from each other
        ((k, only),) = present.items()
        return abs(only) * _single_bound(highest, condensed.half_wave, k)
    if not present:
        return 0.0
    return _least_bound(highest, condensed.half_wave, _pairs(condensed.reaction))


def _reaction(condensed: Condensed) -> dict[int, complex]:
    """Harmonics of the locked reaction that are not zero, under their places in `orders`."""
    return {k: value for k, value in enumerate(condensed.reaction.tolist()) if value}


@lru_cache(maxsize=256)
def _single_bound(highest: int, half_wave: bool, k: int) -> float:
    """Least bound of a torque whose k-th harmonic is a cosine and whose others vanish."""
    wanted = np.zeros(2 * len(uniform(highest, half_wave, 1).orders))
    wanted[2 * k] = 1.0
    return _least_bound(highest, half_wave, wanted)


def _least_bound(highest: int, half_wave: bool, wanted: FloatArray) -> float:
    """Least bound of a torque with the harmonics `wanted`, from above.

    A linear program in cells tells where the torque switches; Newton's method moves these instants,
    and the bound, until the harmonics are those wanted.
    """
    cells = uniform(highest, half_wave, CELLS_PER_HARMONIC * (highest + 1))
    _, high, guess, _ = _kernels.least_bound(cells.table, cells.weight, wanted, 1e-7, 60)
    if not np.any(guess):
        return float(high)
    orders, images, period = cells.orders, cells.images, 2.0 * np.pi / cells.images
    grid = uniform(highest, half_wave, SEARCH_GRID * (highest + 1), True).table
    edges = np.empty(len(grid))
    count, sign = _switching.crossings(guess, orders, images, grid @ guess, edges)
    edges = edges[:count]
    table, pairs = np.zeros((count, len(wanted))), np.zeros(len(wanted))
    jacobian = np.empty((len(wanted), count + 1))
    bound = high
    for _ in range(40):
        _switching.torque_of(edges, count, sign, orders, images, table, pairs)
        missing = wanted - bound * pairs
        if np.abs(missing).max() <= 1e-12 * np.abs(wanted).max():
            return float(min(bound, high))
        jump = 2.0 * sign * (1.0 - 2.0 * (np.arange(count) % 2))
        jacobian[:, :count] = images / np.pi * bound * (jump[:, None] * table).T
        jacobian[:, count] = pairs
        step = _newton_step(jacobian, missing)
        room = np.diff(np.append(edges, edges[:1] + period))
        closing = -np.diff(np.append(step[:count], step[:1]))
        nearing = closing > 0.0
        share = float((0.7 * room[nearing] / closing[nearing]).min(initial=1.0))
        edges = edges + share * step[:count]
        bound += share * step[count]
    return float(high)


def _newton_step(jacobian: FloatArray, missing: FloatArray) -> FloatArray:
    """The shortest step, which there is one of only where no instant is missing or idle."""
    if jacobian.shape[0] == jacobian.shape[1]:
        try:
            return np.asarray(np.linalg.solve(jacobian, missing), dtype=np.float64)
        except np.linalg.LinAlgError:
            pass
    return np.asarray(np.linalg.lstsq(jacobian, missing, rcond=None)[0], dtype=np.float64)


def solve(condensed: Condensed, Q_m: float, settings: Settings, moves: bool = False) -> Solved:
    """The truncated problem's solution for the torque `Q_m` >= 0.

    `moves`: it is known to move, as it does with fewer harmonics: Q_cr(R) never falls as R grows.

    Raises
    ------
    ConvergenceError
        When the residual or the gap stays above its tolerance.
    """
    if Q_m == 0.0:
        zero = np.zeros(len(condensed.orders), dtype=complex)
        return Solved(zero, condensed.velocity, 0.0, *_empty(), False, 0.0, 0)
    if not moves and Q_m >= critical_bound(condensed):
        return locked(condensed)
    if not settings.samples_torque(saturated=False):
        tried = []
        for cells_per_unknown in SEARCH_CELLS:
            tried.append(_searched(condensed, Q_m, cells_per_unknown))
            if tried[-1].exact and tried[-1].gap <= settings.tolerance:
                return tried[-1]
        best = min(tried, key=lambda found: found.gap)
        if best.gap <= settings.tolerance:
            return best
    return _in_cells(condensed, Q_m, settings)


def _searched(condensed: Condensed, Q_m: float, cells_per_unknown: int) -> Solved:
    """Switching instants from a cold start; the gap tells whether they are right."""
    images = condensed.images
    count = cells_per_unknown * 2 * len(condensed.turns) * images + (2 - images)
    cells = uniform(int(condensed.turns[-1]), condensed.half_wave, count)
    return _of_instants(_switching.searched(cells.table, cells.weight, *_search(condensed, Q_m)))


def _search(condensed: Condensed, Q_m: float) -> tuple[object, ...]:
    """What both ways to the instants are told."""
    images, grid = condensed.images, _grid(condensed, SEARCH_GRID)
    joint = condensed.turns, images, condensed.mobility, condensed.velocity, Q_m
    return *joint, grid, _grid(condensed, JUDGE * images), LOCATED, LOCATING, STILL


def _of_instants(found: tuple[Any, ...]) -> Solved:
    torque, velocity, mean, bounds, levels, gap, worst, steps = found
    exact = steps < LOCATING
    return Solved(torque, velocity, mean, bounds, levels, False, gap, steps, (worst,), exact)


def _in_cells(condensed: Condensed, Q_m: float, settings: Settings) -> Solved:
    """The interior-point method, cells cut until edges are located; its edges polished."""
    size, mobility, free = _switching.scaled(condensed.mobility, condensed.velocity, Q_m)
    cells = _first_cells(condensed, settings)
    history: list[float] = []
    best: Solved | None = None
    worst = np.inf
    for _ in range(settings.max_refinements + 1):
        h, _, residuals = _kernels.interior_point(
            cells.table, cells.weight, mobility, free, 0.0, STOP, settings.max_iterations
        )
        history += residuals.tolist()
        found = _solved(condensed, cells, h, Q_m, size, history)
        if residuals.min() <= ACCEPTED and (best is None or found.gap < best.gap):
            best, worst = found, float(residuals.min())
        elif residuals.min() > ACCEPTED and best is not None:
            break  # cells finer than rounding can tell apart
        if cells.sampled or found.gap <= settings.tolerance:
            break
        edged = _edged(condensed, cells, h, Q_m)
        if edged.gap < found.gap and (best is None or edged.gap < best.gap):
            best, worst = edged, edged.residuals[0]
            if best.gap <= settings.tolerance:
                break
        cells = refined(cells, h, 1.0, PIECES)
        if len(cells.weight) * cells.images > MOST_CELLS * (int(cells.orders[-1]) + 1):
            break
    accepted = max(ACCEPTED_GAP, settings.tolerance)
    if best is None or not (cells.sampled or best.gap <= accepted):
        shown = best or found
        message = (
            f"set-valued harmonic balance stopped at residual {min(worst, *history):.2g}, gap "
            f"{shown.gap:.2g} after {len(history)} iterations at Omega = {condensed.Omega:.6g}, "
            f"Q_m = {Q_m:.6g}; try max_refinements above {settings.max_refinements}, "
            f"max_iterations above {settings.max_iterations}, or another R ({condensed.R} now)"
        )
        raise ConvergenceError(message, shown, history)
    return replace(best, residuals=tuple(history), iterations=len(history))


def _edged(condensed: Condensed, cells: Cells, h: FloatArray, Q_m: float) -> Solved:
    """Switching instants, started from the torque in cells."""
    rounded = np.where(np.abs(h) > 1.0 - EDGE, np.sign(h), h)
    return _of_instants(_switching.from_cells(rounded, cells.weight, *_search(condensed, Q_m)))


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
        _gap(condensed, cells.bounds, h, velocity, size),
        len(history),
        tuple(history),
    )


def _least_bound_without_mean(highest: int, wanted: FloatArray) -> float:
    """The same for a torque of zero mean, in cells alone: above it by less than 1e-3."""
    cells = uniform(highest, False, 4 * CELLS_PER_HARMONIC * (highest + 1))
    table = np.column_stack([cells.table, np.ones(len(cells.table))])
    wanted = np.append(wanted, 0.0)
    return float(_kernels.least_bound(table, cells.weight, wanted, 1e-7, 60)[1])


def critical_torque(condensed: Condensed) -> float:
    """Q_cr: half the peak-to-peak of the locked reaction, whose mean the rest position takes.

    Where no position changes the reaction, friction carries its mean too: the largest modulus.
    """
    low, high = reaction_range(condensed)
    centred = condensed.half_wave or sprung(condensed)
    return 0.5 * (high - low) if centred else max(-low, high)


def sprung(condensed: Condensed) -> bool:
    """Whether a static displacement of the joint, the others following, changes its reaction."""
    if condensed.mean_unit is not None:
        return True
    problem, joint = condensed.problem, cast("int", condensed.problem.joint)
    row = problem.K[joint, problem.others]
    inner = problem.K[np.ix_(problem.others, problem.others)]
    following = np.linalg.lstsq(inner, row, rcond=RIGID)[0]
    stiffness, size = problem.K[joint, joint], abs(problem.K[joint, joint])
    return bool(abs(stiffness - row @ following) > RIGID * (size + np.abs(row) @ np.abs(following)))


def locked(condensed: Condensed) -> Solved:
    """The joint at rest, in the middle of its rest interval."""
    torque = condensed.reaction.copy()
    low, high = reaction_range(condensed)
    mean = 0.0 if condensed.half_wave or not sprung(condensed) else -0.5 * (low + high)
    return Solved(torque, np.zeros_like(torque), mean, *_empty(), True, 0.0, 0)


def reaction_range(condensed: Condensed) -> tuple[float, float]:
    """Least and largest value of the locked reaction, its mean left out."""
    key = "_reaction_range"
    if key not in condensed.__dict__:
        present = _reaction(condensed)
        if len(present) == 1:
            high = abs(*present.values())
            ends = (-high, high)
        else:
            orders, series = condensed.turns[[*present]], np.array([*present.values()], complex)
            ends = (-_largest(orders, -series), _largest(orders, series))
        object.__setattr__(condensed, key, ends)
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
    if settings is not None and settings.samples_torque(saturated=False):
        return uniform(highest, condensed.half_wave, settings.samples_for(highest), True)
    return uniform(highest, condensed.half_wave, CELLS_PER_HARMONIC * (highest + 1))


def _pairs(coefficients: ComplexArray) -> FloatArray:
    """Pairs c, s (2 nS,) of harmonics c - i s."""
    return np.asarray(np.conj(coefficients).view(np.float64))


def _series(pairs: FloatArray) -> ComplexArray:
    """Harmonics c - i s (nS,) of pairs."""
    return np.asarray(np.conj(pairs.view(np.complex128)))


def _empty() -> tuple[FloatArray, FloatArray]:
    return np.zeros(0), np.zeros(0)


def _grid(condensed: Condensed, points: int) -> FloatArray:
    """Values of the harmonics at the middles of equal steps, so many per harmonic and period."""
    highest = int(condensed.turns[-1])
    return uniform(highest, condensed.half_wave, points * (highest + 1), True).table


def _gap(
    condensed: Condensed, bounds: FloatArray, h: FloatArray, velocity: ComplexArray, size: float
) -> float:
    """The gap on a grid that knows nothing of the torque's integrals.

    Where hardly anything moves, the motion without friction takes the place of int |v|.
    """
    grid = _grid(condensed, JUDGE * condensed.images)
    return float(_kernels.relative_gap(grid, _pairs(velocity), bounds, h, STILL * size))
