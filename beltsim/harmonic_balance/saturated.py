r"""The paper's method: saturated friction, alternating frequency and time, Newton-Raphson.

Unknown are the joint's velocity harmonics x (pairs cos, sin). With the inverse mobility B and
`table` T of N samples the residual and its Jacobian are (eqs 21 to 23)

.. math:: E = B x + \tfrac 2N T^T h(T x) - F, \qquad
          J = B + \tfrac 2N T^T \mathrm{diag}(Q_m/\sigma\ \text{where}\ |v| < \sigma) T .

Where Newton diverges, Broyden's method goes on from the best iterate with its Jacobian. A ladder
comes down to sigma in rungs that are halved where one fails. The balance is monotone and its
solution unique, so an interior-point method finds it for any sigma (``start="set_valued"``): the
saturated law is the set-valued one with a compliance, :math:`v - \sigma h/Q_m` in place of v.

Depends on: _kernels, cells, condensation, set_valued, settings, friction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from beltsim.checks import FloatArray
from beltsim.errors import ConvergenceError, InvalidProblemError, Mistake
from beltsim.friction import SaturatedCoulomb
from beltsim.harmonic_balance import _kernels, set_valued
from beltsim.harmonic_balance.cells import uniform
from beltsim.harmonic_balance.condensation import Condensed
from beltsim.harmonic_balance.set_valued import Solved
from beltsim.harmonic_balance.settings import Settings

#: Newton counts as diverged after so many steps without a new least residual.
PATIENCE = 12
#: Each rung of the ladder narrows the band to this share; where one fails, to its root, until
#: that is above the last.
RUNG, LAST_RUNG = 0.3, 0.95
#: Most iterations of a rung, and of the interior-point method.
RUNG_STEPS, INTERIOR_STEPS = 40, 100


@dataclass(frozen=True, eq=False)
class Balance:
    """Residual of the balance and its Jacobian, for pairs x of velocity harmonics.

    Parameters
    ----------
    stiffness : (m, m) inverse mobility, block by block.
    table : (N, m) samples of cos and sin.
    load : (m,) pairs of the locked reaction.
    Q_m, sigma : float
    """

    stiffness: FloatArray
    table: FloatArray
    load: FloatArray
    Q_m: float
    sigma: float

    def torque(self, x: FloatArray) -> FloatArray:
        """Pairs of torque harmonics."""
        h = self.Q_m * np.clip(self.table @ x / self.sigma, -1.0, 1.0)
        return np.asarray(2.0 / len(h) * (self.table.T @ h))

    def residual(self, x: FloatArray) -> FloatArray:
        """E (m,), torque units."""
        return np.asarray(self.stiffness @ x + self.torque(x) - self.load)

    def jacobian(self, x: FloatArray) -> FloatArray:
        """dE/dx (m, m)."""
        rows = self.table[np.abs(self.table @ x) < self.sigma]
        slope = 2.0 / len(self.table) * self.Q_m / self.sigma
        return np.asarray(self.stiffness + slope * (rows.T @ rows))


def balance_of(condensed: Condensed, law: SaturatedCoulomb, samples: int) -> Balance:
    """The balance of one law, with `samples` instants per repetition."""
    highest = condensed.R // condensed.divisor
    cells = uniform(highest, False, samples, True)
    step = 2 if condensed.half_wave else 1
    keep = np.repeat(np.arange(highest) % step == 0, 2)
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
    return Balance(stiffness, cells.table[:, keep], load, law.Q_m, law.sigma)


def solve(condensed: Condensed, law: SaturatedCoulomb, settings: Settings) -> Solved:
    """The balanced velocity and torque.

    Raises
    ------
    ConvergenceError
        With the best iterate and the residual history.
    """
    highest = condensed.R // condensed.divisor
    samples = settings.samples_for(highest)
    x = set_valued._pairs(condensed.velocity)
    history: list[float] = []
    if settings.start == "set_valued" and law.Q_m > 0.0:
        x = velocity_of(condensed, law, samples)
        balance = balance_of(condensed, law, samples)
        x, good = _balanced(balance, x, settings, history)
    else:
        x, good = _down_the_ladder(condensed, law, samples, x, settings, history)
        balance = balance_of(condensed, law, samples)
    found = _solved(balance, x, history)
    if not good:
        advice = "start='set_valued'" if settings.sigma_ladder else "sigma_ladder=True"
        message = (
            f"harmonic balance stopped at residual {history[-1]:.2g} after {len(history)} "
            f"iterations at Omega = {condensed.Omega:.6g}, Q_m = {law.Q_m:.6g}, sigma = "
            f"{law.sigma:.3g}, R = {condensed.R}; try {advice}, or the law Coulomb(Q_m)"
        )
        raise ConvergenceError(message, found, history)
    return found


def _down_the_ladder(
    condensed: Condensed,
    law: SaturatedCoulomb,
    samples: int,
    x: FloatArray,
    settings: Settings,
    history: list[float],
) -> tuple[FloatArray, bool]:
    """Balance at sigma, through wider bands when a ladder is asked for."""
    widest = float(np.abs(condensed.velocity).sum())
    sigma, share, good = law.sigma, RUNG, True
    if settings.sigma_ladder and widest > law.sigma:
        sigma = widest
    balance = balance_of(condensed, SaturatedCoulomb(law.Q_m, sigma), samples)
    x, good = _balanced(balance, x, settings, history)
    while good and sigma > law.sigma:
        following = max(law.sigma, share * sigma)
        if following < law.sigma / share:  # no rung that is hardly one
            following = law.sigma
        rung = replace(balance, sigma=following)
        next_x, found = _balanced(rung, x, settings, history, RUNG_STEPS)
        if found:
            x, sigma, share = next_x, following, max(RUNG, share * share)
        elif share < LAST_RUNG:
            share = float(np.sqrt(share))
        else:
            return x, False
    return x, good


def velocity_of(condensed: Condensed, law: SaturatedCoulomb, samples: int) -> FloatArray:
    """The velocity (pairs) by the interior-point method."""
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
    residual, change = balance.residual(x), np.inf
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
            x, residual = best_x, balance.residual(best_x)
            inverse, waited = np.asarray(np.linalg.inv(balance.jacobian(x)), dtype=np.float64), 0
        if inverse is None:
            step = np.linalg.solve(balance.jacobian(x), -residual)
        else:
            step = -inverse @ residual
        size_x = max(float(np.linalg.norm(x)), 1e-300)
        change = float(np.linalg.norm(step)) / size_x
        following = balance.residual(x + step)
        if inverse is not None:  # Broyden's update of the inverse
            moved = inverse @ (following - residual)
            scalar = float(step @ moved)
            if scalar != 0.0:
                inverse = inverse + np.outer(step - moved, step @ inverse) / scalar
        x, residual = x + step, following
    return best_x, best <= tolerance


def _solved(balance: Balance, x: FloatArray, history: list[float]) -> Solved:
    pairs = balance.torque(x)
    h = balance.Q_m * np.clip(balance.table @ x / balance.sigma, -1.0, 1.0)
    empty = np.zeros(0)
    return Solved(
        pairs[0::2] - 1j * pairs[1::2],
        x[0::2] - 1j * x[1::2],
        float(h.mean()),
        empty,
        empty,
        False,
        0.0,
        len(history),
        tuple(history),
    )
