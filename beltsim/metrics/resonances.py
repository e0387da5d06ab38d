r"""Resonances along the operating line: speeds that meet one of their own natural frequencies.

Belt speed follows the crank, so every natural frequency of the undamped drive depends on Omega. A
resonance is a root of :math:`\omega_k(\Omega) = \Omega` at fixed k, frequencies sorted.

Depends on: model, linear, metrics.mode_kind; drive for its type only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from beltsim.errors import InvalidProblemError, Mistake
from beltsim.linear import frequencies, modes
from beltsim.metrics.mode_kind import ModeKind, mode_kind
from beltsim.model.assemble import assemble
from beltsim.problem import FrictionProblem

if TYPE_CHECKING:
    from beltsim.drive import Drive

#: Coarsest step in Omega of the search for crossings.
STEP = 0.1


@dataclass(frozen=True)
class Resonance:
    """A speed at which the firing frequency is a natural frequency.

    Parameters
    ----------
    Omega : float
        Firing frequency, dimensionless.
    rpm : float
        Crank speed.
    number : int
        Which natural frequency, counted from 1.
    kind : ModeKind
        What moves.
    """

    Omega: float
    rpm: float
    number: int
    kind: ModeKind


def resonances(
    drive: Drive,
    low: float,
    high: float,
    *,
    locked: bool = False,
    n_functions: int | Sequence[int] = 16,
    residual_flexibility: bool = True,
) -> tuple[Resonance, ...]:
    """Resonances of the undamped drive for Omega between `low` and `high`.

    Parameters
    ----------
    drive : Drive
    low, high : float
        Range of Omega, 0 < low < high.
    locked : bool
        Whether the arm is held.
    n_functions, residual_flexibility
        As for `beltsim.assemble`.

    Returns
    -------
    tuple of Resonance
        By rising Omega.

    Raises
    ------
    SteadyStateError
        When the range reaches a slack span or a supercritical belt.

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> found = resonances(zhu_parker_2008(), 6.0, 6.5, n_functions=8)
    >>> [(round(item.Omega, 2), item.kind.dominant) for item in found]
    [(6.25, 'span 1')]
    """
    from scipy.optimize import brentq  # only when resonances are asked for

    if not 0.0 < low < high:
        raise InvalidProblemError(Mistake("low, high", (low, high), "0 < low < high"))

    def problem(Omega: float) -> FrictionProblem:
        return assemble(
            drive,
            Omega,
            n_functions=n_functions,
            residual_flexibility=residual_flexibility,
        )

    def gaps(Omega: float) -> np.ndarray:
        return frequencies(problem(Omega), locked) - Omega

    grid = np.linspace(low, high, ceil((high - low) / STEP) + 1)
    found = []
    before = gaps(grid[0])
    for left, right in zip(grid[:-1].tolist(), grid[1:].tolist(), strict=True):
        after = gaps(right)
        for k in np.flatnonzero((before >= 0.0) != (after >= 0.0)):
            Omega = float(brentq(lambda x, k=k: gaps(x)[k], left, right, xtol=1e-11))
            at = problem(Omega)
            kind = mode_kind(at, modes(at, locked).shapes[k])
            found.append(Resonance(Omega, drive.rpm(Omega), int(k) + 1, kind))
        before = after
    return tuple(sorted(found, key=lambda item: item.Omega))
