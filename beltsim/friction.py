r"""Friction laws of the joint: exact Coulomb friction and its saturated substitute.

The friction torque `h_c` acts against the joint's velocity `v`:

* `Coulomb`: :math:`h_c = Q_m\,\mathrm{sgn}(v)` while moving; at `v = 0` whatever keeps the joint
  at rest, as long as :math:`|h_c| \le Q_s`.
* `SaturatedCoulomb`: :math:`h_c = Q_m\,\mathrm{clip}(v/\sigma, -1, 1)` (the paper's eq. 23).

These classes hold numbers only. Each solver writes its own transition rule.

Depends on: errors, checks.
"""

from __future__ import annotations

from dataclasses import dataclass

from beltsim.checks import real_number
from beltsim.errors import InvalidProblemError, Mistake


@dataclass(frozen=True)
class Coulomb:
    """Set-valued Coulomb friction with kinetic level `Q_m` and static level `Q_s`.

    Parameters
    ----------
    Q_m : float
        Kinetic friction torque, in the problem's torque unit (P0 r_t for a drive). >= 0.
    Q_s : float, optional
        Static friction torque, >= Q_m. Default: Q_m.

    Raises
    ------
    InvalidProblemError
        When Q_m < 0, Q_s < Q_m, or either is not a finite number.

    Examples
    --------
    >>> Coulomb(0.5).Q_s
    0.5
    """

    Q_m: float
    Q_s: float | None = None

    def __post_init__(self) -> None:
        Q_m = real_number(self.Q_m)
        Q_s = Q_m if self.Q_s is None else real_number(self.Q_s)
        mistakes = []
        if Q_m is None or Q_m < 0.0:
            mistakes.append(Mistake("friction.Q_m", self.Q_m, "a finite number >= 0"))
        elif Q_s is None or Q_s < Q_m:
            mistakes.append(Mistake("friction.Q_s", self.Q_s, f"a finite number >= Q_m = {Q_m:g}"))
        if mistakes:
            raise InvalidProblemError(mistakes)
        object.__setattr__(self, "Q_m", Q_m)
        object.__setattr__(self, "Q_s", Q_s)


@dataclass(frozen=True)
class SaturatedCoulomb:
    """Coulomb friction replaced by a steep line inside the band `|v| <= sigma`.

    Parameters
    ----------
    Q_m : float
        Friction torque outside the band, in the problem's torque unit. >= 0.
    sigma : float
        Half width of the band, in the joint's velocity unit. > 0.

    Raises
    ------
    InvalidProblemError
        When Q_m < 0 or sigma <= 0, or either is not a finite number.

    Examples
    --------
    >>> SaturatedCoulomb(0.5, sigma=1e-4).sigma
    0.0001
    """

    Q_m: float
    sigma: float

    def __post_init__(self) -> None:
        Q_m, sigma = real_number(self.Q_m), real_number(self.sigma)
        mistakes = []
        if Q_m is None or Q_m < 0.0:
            mistakes.append(Mistake("friction.Q_m", self.Q_m, "a finite number >= 0"))
        if sigma is None or not sigma > 0.0:
            mistakes.append(Mistake("friction.sigma", self.sigma, "a finite number > 0"))
        if mistakes:
            raise InvalidProblemError(mistakes)
        object.__setattr__(self, "Q_m", Q_m)
        object.__setattr__(self, "sigma", sigma)


FrictionLaw = Coulomb | SaturatedCoulomb
