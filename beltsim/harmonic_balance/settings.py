"""Settings of a harmonic-balance solution.

Depends on: errors, checks, pattern.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from beltsim.checks import real_number
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.harmonic_balance.pattern import Pattern

HARMONICS = ("auto", "odd", "all")
PROJECTIONS = ("auto", "exact", "sampled")
STARTS = ("linear", "set_valued")


@dataclass(frozen=True)
class Settings:
    """How to solve, and what to return.

    Parameters
    ----------
    harmonics : str
        ``"auto"``: the harmonics that the forcing's symmetry allows (multiples of their common
        divisor, odd ones only when half-wave symmetry holds); ``"odd"``; ``"all"``.
    projection : str
        How the torque's harmonics are found: ``"exact"``, Fourier integrals in closed form between
        located edges; ``"sampled"`` at `samples` instants, as the paper does for the saturated
        law; ``"auto"``: exact for Coulomb, sampled for the saturated law.
    samples : int, optional
        Instants per repetition of the response, at least 2R + 1. Default: 256 or 8(R + 1),
        whichever is more.
    tolerance : float
        Exact projection: largest gap left between the torque and its law, see
        `statistics["complementarity_gap"]`; cells are cut until it is reached.
    max_refinements : int
        How often cells may be cut.
    newton_tolerance : float
        Saturated law: largest residual over the largest torque, and change of a step over the size
        of the velocity.
    max_iterations : int
    sigma_ladder : bool
        Saturated law: come down to sigma in steps from a wide band.
    start : str
        Saturated law: ``"linear"`` (the response without friction) or ``"set_valued"`` (an
        interior-point solution of the same balance, which exists and is found for any sigma).
    estimate : bool
        Whether to estimate the error from a second solution, with 2R + 5 harmonics, which costs
        several times the solution itself; above R = 100 with half of R.
    samples_per_period : int
        Samples of the response per forcing period; both ends are included.

    pattern : Pattern, optional
        Coulomb: events of the response that is meant, which Q_s > Q_m needs; all harmonics are
        then kept.

    Raises
    ------
    InvalidProblemError
        With every setting that cannot be used.

    Examples
    --------
    >>> Settings(projection="sampled", samples=512).samples
    512
    """

    harmonics: str = "auto"
    projection: str = "auto"
    samples: int | None = None
    tolerance: float = 1e-5
    max_refinements: int = 6
    newton_tolerance: float = 1e-9
    max_iterations: int = 200
    sigma_ladder: bool = False
    start: str = "linear"
    estimate: bool = True
    samples_per_period: int = 200
    pattern: Pattern | None = None

    def __post_init__(self) -> None:
        mistakes = []
        known = {"harmonics": HARMONICS, "projection": PROJECTIONS, "start": STARTS}
        for name, words in known.items():
            if getattr(self, name) not in words:
                allowed = "one of " + ", ".join(words)
                mistakes.append(Mistake(f"settings.{name}", getattr(self, name), allowed))
        least = {"max_iterations": 1, "max_refinements": 0, "samples_per_period": 1}
        if self.samples is not None:
            least["samples"] = 3
        for name, low in least.items():
            if not is_integer(getattr(self, name), low):
                allowed = f"an integer >= {low}"
                mistakes.append(Mistake(f"settings.{name}", getattr(self, name), allowed))
        for name, top in (("tolerance", 0.1), ("newton_tolerance", 1e-2)):
            number = real_number(getattr(self, name))
            if number is None or not 1e-14 <= number <= top:
                allowed = f"between 1e-14 and {top:g}"
                mistakes.append(Mistake(f"settings.{name}", getattr(self, name), allowed))
        for name in ("sigma_ladder", "estimate"):
            if not isinstance(getattr(self, name), bool | np.bool_):
                mistakes.append(Mistake(f"settings.{name}", getattr(self, name), "True or False"))
        if self.projection == "exact" and self.samples is not None:
            allowed = 'None: with projection = "exact" nothing is sampled'
            mistakes.append(Mistake("settings.samples", self.samples, allowed))
        if self.pattern is not None:
            mistakes += self._pattern_mistakes()
        if mistakes:
            raise InvalidProblemError(mistakes)

    def _pattern_mistakes(self) -> list[Mistake]:
        if not isinstance(self.pattern, Pattern):
            return [Mistake("settings.pattern", self.pattern, "a harmonic_balance.Pattern")]
        if self.harmonics == "odd":
            return [Mistake("settings.harmonics", "odd", '"auto" or "all" beside a pattern')]
        return []

    def samples_torque(self, saturated: bool) -> bool:
        """Whether the torque of a law, saturated or not, is sampled."""
        return self.projection == "sampled" or (saturated and self.projection == "auto")

    def samples_for(self, R: int) -> int:
        """Samples per repetition for R harmonics; refuses fewer than the series needs."""
        if self.samples is None:
            return max(256, 8 * (R + 1))
        if self.samples < 2 * R + 1:
            allowed = f"at least 2R + 1 = {2 * R + 1}, or None"
            raise InvalidProblemError(Mistake("settings.samples", self.samples, allowed))
        return int(self.samples)


def is_integer(value: Any, least: float = -math.inf) -> bool:
    """Whether `value` is an integer, not a bool, and at least `least`."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    return whole and value >= least


def require_common(R: Any, settings: Any) -> None:
    """Refuse what all problems of a grid share and none could use."""
    mistakes = []
    if not is_integer(R, 1):
        mistakes.append(Mistake("R", R, "an integer >= 1"))
    if settings is not None and not isinstance(settings, Settings):
        mistakes.append(Mistake("settings", settings, "a harmonic_balance.Settings or None"))
    if mistakes:
        raise InvalidProblemError(mistakes)
