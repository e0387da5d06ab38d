r"""The paper's method: saturated friction, alternating frequency and time, Newton-Raphson.

Unknown are the joint's velocity harmonics x (pairs cos, sin). With the inverse mobility B and
`table` T of N samples the residual and its Jacobian are (eqs 21 to 23)

.. math:: E = B x + \tfrac 2N T^T h(T x) - F, \qquad
          J = B + \tfrac 2N T^T \mathrm{diag}(Q_m/\sigma\ \text{where}\ |v| < \sigma) T .

``projection="exact"`` puts the integrals over a period in the place of the sums (`_bands`).

Where Newton diverges, Broyden's method goes on from the best iterate with its Jacobian. A ladder
comes down to sigma in rungs that are halved where one fails. The balance is monotone and its
solution unique, so an interior-point method finds it for any sigma (``start="set_valued"``): the
saturated law is the set-valued one with a compliance, :math:`v - \sigma h/Q_m` in place of v.

Depends on: _bands, _kernels, cells, condensation, set_valued, settings, friction.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import ConvergenceError, InvalidProblemError, Mistake
from beltsim.friction import SaturatedCoulomb
from beltsim.harmonic_balance import _bands, _kernels, set_valued
from beltsim.harmonic_balance.cells import uniform
from beltsim.harmonic_balance.condensation import Condensed
from beltsim.harmonic_balance.set_valued import Solved
from beltsim.harmonic_balance.settings import Settings

#: Newton counts as diverged after so many steps without a new least residual.
PATIENCE = 12
#: Each rung of the ladder narrows the band to this share; where one fails, to its root, until
#: that is above the last.
RUNG, LAST_RUNG = 0.3, 0.95
#: Samples per shortest wave that judge the closed form, and the largest discrepancy, over Q_m, that
#: is due to the samples: at most 0.02 was seen at R = 5, less with more harmonics.
FINE, DISCREPANT = 64, 0.05
#: Most iterations of a rung, and of the interior-point method.
RUNG_STEPS, INTERIOR_STEPS = 40, 100


class Projected(NamedTuple):
    """Torque over Q_m: its harmonics (m,) in pairs, their derivative (m, m), and its mean."""

    pairs: FloatArray
    slope: FloatArray
    mean: float


#: From pairs of velocity harmonics and a band to the harmonics of clip(v/sigma, -1, 1).
Projection = Callable[[FloatArray, float], Projected]


def _sampled(table: FloatArray, x: FloatArray, sigma: float) -> Projected:
    """The paper's projection: `table` (N, m) samples cos and sin at equal steps of a period."""
    level = table @ x / sigma
    h, rows = np.clip(level, -1.0, 1.0), table[np.abs(level) < 1.0]
    weight = 2.0 / len(h)
    return Projected(weight * (table.T @ h), weight / sigma * (rows.T @ rows), float(h.mean()))


def _exact(orders: NDArray[np.int64], images: int, x: FloatArray, sigma: float) -> Projected:
    """The closed form, see `_bands`."""
    return Projected(*_bands.projected(x, orders, images, sigma))


@dataclass(frozen=True, eq=False)
class Balance:
    """Residual of the balance and its Jacobian, for pairs x of velocity harmonics.

    Parameters
    ----------
    stiffness : (m, m) inverse mobility, block by block.
    projection : callable
        Harmonics of the torque over Q_m, from samples or in closed form.
    load : (m,) pairs of the locked reaction.
    Q_m, sigma : float
    """

    stiffness: FloatArray
    projection: Projection
    load: FloatArray
    Q_m: float
    sigma: float

    def at(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """E (m,), torque units, and dE/dx (m, m)."""
        found = self.projection(x, self.sigma)
        residual = self.stiffness @ x + self.Q_m * found.pairs - self.load
        return residual, self.stiffness + self.Q_m * found.slope

    def residual(self, x: FloatArray) -> FloatArray:
        """E (m,), torque units."""
        return self.at(x)[0]

    def jacobian(self, x: FloatArray) -> FloatArray:
        """dE/dx (m, m)."""
        return self.at(x)[1]


def balance_of(condensed: Condensed, law: SaturatedCoulomb, settings: Settings) -> Balance:
    """The balance of one law, with the projection of `settings`."""
    m = 2 * len(condensed.orders)
    stiffness = np.zeros((m, m))
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / condensed.mobility
    if not np.all(np.isfinite(inverse)):
        k = int(condensed.orders[np.flatnonzero(~np.isfinite(inverse))[0]])
        allowed = "moved by a torque on it: this harmonic cannot be balanced"
        raise InvalidProblemError(Mistake("joint", f"at rest in harmonic {k}", allowed))
    even = np.arange(0, m, 2)
    stiffness[even, even] = stiffness[even + 1, even + 1] = inverse.real
    stiffness[even, even + 1], stiffness[even + 1, even] = inverse.imag, -inverse.imag
    load = set_valued._pairs(condensed.reaction)
    projection = _projection(condensed, settings)
    return Balance(stiffness, projection, load, law.Q_m, law.sigma)


def _projection(condensed: Condensed, settings: Settings) -> Projection:
    if not settings.samples_torque(saturated=True):
        return partial(_exact, condensed.turns, condensed.images)
    highest = condensed.R // condensed.divisor
    table = uniform(highest, False, settings.samples_for(highest), True).table
    keep = np.repeat(np.arange(highest) % condensed.images == 0, 2)
    return partial(_sampled, table[:, keep])


def discrepancy(condensed: Condensed, balance: Balance, x: FloatArray, settings: Settings) -> float:
    """Largest difference of a torque's harmonics to those by the other projection, over Q_m.

    Samples are judged by the closed form, the closed form by many samples.
    """
    exact = partial(_exact, condensed.turns, condensed.images)
    fine = replace(settings, projection="sampled", samples=FINE * int(condensed.turns[-1]))
    sampled = settings.samples_torque(saturated=True)
    other = exact if sampled else _projection(condensed, fine)
    pairs = balance.projection(x, balance.sigma).pairs
    return float(np.abs(pairs - other(x, balance.sigma).pairs).max(initial=0.0))


def solve(condensed: Condensed, law: SaturatedCoulomb, settings: Settings) -> Solved:
    """The balanced velocity and torque.

    Raises
    ------
    ConvergenceError
        With the best iterate and the residual history.
    """
    balance = balance_of(condensed, law, settings)
    history: list[float] = []
    if settings.start == "set_valued" and law.Q_m > 0.0:
        x, good = _balanced(balance, velocity_of(condensed, law, settings), settings, history)
        if not good and not settings.samples_torque(saturated=True):  # samples are only near it
            x, good = _down_the_ladder(condensed, balance, True, settings, history)
    else:
        x, good = _down_the_ladder(condensed, balance, settings.sigma_ladder, settings, history)
    found = _solved(balance, x, history, discrepancy(condensed, balance, x, settings))
    if not good:
        advice = "start='set_valued'" if settings.sigma_ladder else "sigma_ladder=True"
        message = (
            f"harmonic balance stopped at residual {history[-1]:.2g} after {len(history)} "
            f"iterations at Omega = {condensed.Omega:.6g}, Q_m = {law.Q_m:.6g}, sigma = "
            f"{law.sigma:.3g}, R = {condensed.R}; try {advice}, or the law Coulomb(Q_m)"
        )
        raise ConvergenceError(message, found, history)
    if not settings.samples_torque(saturated=True) and found.gap > DISCREPANT:
        message = (
            f"the torque integrated in closed form differs by {found.gap:.2g} Q_m from its samples "
            f"at Omega = {condensed.Omega:.6g}, Q_m = {law.Q_m:.6g}, sigma = {law.sigma:.3g}, "
            f"R = {condensed.R}: an edge of the band was missed; try projection='sampled'"
        )
        raise ConvergenceError(message, found, history)
    return found


def _down_the_ladder(
    condensed: Condensed,
    balance: Balance,
    laddered: bool,
    settings: Settings,
    history: list[float],
) -> tuple[FloatArray, bool]:
    """Balance at sigma from the motion without friction, through wider bands when `laddered`."""
    last, share = balance.sigma, RUNG
    widest = float(np.abs(condensed.velocity).sum())
    sigma = widest if laddered and widest > last else last
    first = replace(balance, sigma=sigma)
    x, good = _balanced(first, set_valued._pairs(condensed.velocity), settings, history)
    while good and sigma > last:
        following = max(last, share * sigma)
        if following < last / share:  # no rung that is hardly one
            following = last
        rung = replace(balance, sigma=following)
        next_x, found = _balanced(rung, x, settings, history, RUNG_STEPS)
        if found:
            x, sigma, share = next_x, following, max(RUNG, share * share)
        elif share < LAST_RUNG:
            share = float(np.sqrt(share))
        else:
            return x, False
    return x, good


def velocity_of(condensed: Condensed, law: SaturatedCoulomb, settings: Settings) -> FloatArray:
    """The velocity (pairs) by the interior-point method, at samples; a start for any projection."""
    samples = settings.samples_for(condensed.R // condensed.divisor)
    size = float(np.sqrt(0.5 * np.sum(np.abs(condensed.velocity) ** 2)))
    half_wave = condensed.half_wave and samples % 2 == 0
    cells = uniform(int(condensed.turns[-1]), half_wave, samples, True)
    table = cells.table
    if condensed.half_wave and not half_wave:
        table = np.ascontiguousarray(
            table[:, np.repeat(np.arange(table.shape[1] // 2) % 2 == 0, 2)]
        )
    free, mobility = (
        set_valued._pairs(condensed.velocity / size),
        condensed.mobility * law.Q_m / size,
    )
    h, _, _ = _kernels.interior_point(
        table, cells.weight, mobility, free, law.sigma / size, set_valued.STOP, INTERIOR_STEPS
    )
    torque = set_valued._series(table.T @ (cells.weight * h)) * law.Q_m
    return set_valued._pairs(condensed.velocity - condensed.mobility * torque)


def _balanced(
    balance: Balance,
    x: FloatArray,
    settings: Settings,
    history: list[float],
    most: int | None = None,
) -> tuple[FloatArray, bool]:
    """Newton, then Broyden where that diverges; the best iterate and whether it converged."""
    scale = max(float(np.abs(balance.load).max(initial=0.0)), balance.Q_m, 1e-300)
    best_x, best, waited = x, np.inf, 0
    inverse: FloatArray | None = None
    tolerance = settings.newton_tolerance
    (residual, jacobian), change = balance.at(x), np.inf
    for _ in range(min(settings.max_iterations, most or settings.max_iterations)):
        size = float(np.abs(residual).max(initial=0.0)) / scale
        history.append(size)
        if not np.isfinite(size):
            break
        if size < best:
            best_x, best, waited = x, size, 0
        waited += 1
        if size <= tolerance and change <= max(tolerance, 1e-6):
            return x, True
        if inverse is None and waited > PATIENCE:  # Newton diverges: Broyden from its best
            x = best_x
            residual, jacobian = balance.at(x)
            inverse, waited = np.asarray(np.linalg.inv(jacobian), dtype=np.float64), 0
        step = np.linalg.solve(jacobian, -residual) if inverse is None else -inverse @ residual
        size_x = max(float(np.linalg.norm(x)), 1e-300)
        change = float(np.linalg.norm(step)) / size_x
        following, jacobian = balance.at(x + step)
        if inverse is not None:  # Broyden's update of the inverse
            moved = inverse @ (following - residual)
            scalar = float(step @ moved)
            if scalar != 0.0:
                inverse = inverse + np.outer(step - moved, step @ inverse) / scalar
        x, residual = x + step, following
    return best_x, best <= tolerance


def _solved(balance: Balance, x: FloatArray, history: list[float], gap: float) -> Solved:
    torque = balance.projection(x, balance.sigma)
    empty = np.zeros(0)
    return Solved(
        balance.Q_m * set_valued._series(torque.pairs),
        set_valued._series(x),
        balance.Q_m * torque.mean,
        empty,
        empty,
        False,
        gap,
        len(history),
        tuple(history),
    )
