r"""Where the drive works: belt speed and crank motion at one firing frequency.

.. math:: s = r_c\,\Omega/(\alpha\,l), \qquad
    \theta_c(t) = \sum_k c_k \cos k\Omega_1 t + s_k \sin k\Omega_1 t

The crank turns at Omega/alpha; every order of its motion is a multiple of half a revolution, and
the forcing fundamental Omega_1 is their greatest common divisor times the crank's speed. Belt speed
follows the crank, so the steady state, G and K change with every operating point.

Depends on: model.scaling, checks, errors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from beltsim.checks import FloatArray, real_number
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.model.scaling import DimensionlessDrive


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """A drive at one speed; all values dimensionless.

    Parameters
    ----------
    drive : DimensionlessDrive
    Omega : float
        Firing frequency; 0 at standstill.
    s : float
        Belt speed.
    fundamental : float
        Fundamental frequency of the crank's motion.
    """

    drive: DimensionlessDrive
    Omega: float
    s: float
    fundamental: float

    @property
    def crank_cos(self) -> FloatArray:
        """Cosine rows (H + 1,) of the crank's angle in rad, over the fundamental."""
        return self.drive.crank_cos

    @property
    def crank_sin(self) -> FloatArray:
        """Sine rows (H + 1,) of the crank's angle in rad, over the fundamental."""
        return self.drive.crank_sin

    @property
    def belt_speed_m_s(self) -> float:
        """Belt speed in m/s."""
        return self.s * self.drive.length_m / self.drive.time_s


def operate(drive: DimensionlessDrive, Omega: Any) -> OperatingPoint:
    """The drive at firing frequency `Omega`.

    Parameters
    ----------
    drive : DimensionlessDrive
    Omega : float
        Firing frequency, dimensionless; 0 is standstill.

    Returns
    -------
    OperatingPoint

    Raises
    ------
    InvalidProblemError
        When Omega is negative or not a finite number.

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> from beltsim.model.scaling import scale
    >>> round(operate(scale(zhu_parker_2008()), 4.5).s, 2)
    0.38
    """
    number = real_number(Omega)
    if number is None or number < 0.0:
        raise InvalidProblemError(Mistake("Omega", Omega, "a finite number > 0 (0 at standstill)"))
    crank_speed = number / drive.alpha
    return OperatingPoint(
        drive=drive,
        Omega=number,
        s=float(drive.radius[drive.crank]) * crank_speed,
        fundamental=drive.fundamental_order * crank_speed,
    )
