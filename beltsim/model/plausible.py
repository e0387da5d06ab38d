r"""Numbers of a drive that can be, but are hardly meant: warnings, never a guess in their place.

* The spring's wind-up :math:`M_0/k`, by which it is turned where it balances the belt. A tensioner
  winds up by 20 to 90 degrees; half a turn and more is a rate in N m/deg.
* The mass :math:`J/r^2` that a pulley adds to the belt. A pulley with its accessory weighs some ten
  times as much as the whole belt, seen from the belt; a thousand times is another unit, 1 kg cm2
  being 1e-4 kg m2. The crank is left out: its motion is prescribed.
* The arm carries its pulley, whose mass lies within its radius and so is at least :math:`J/r^2`.
  Seen from the pivot that is :math:`r_t^2 J/r^2`; an arm of less than half of it is another unit.

Depends on: model.scaling; drive for its type only.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from beltsim.model.scaling import scale

if TYPE_CHECKING:
    from beltsim.drive import Drive

#: Wind-up of the spring beyond which its rate is doubted, deg.
LARGEST_WINDUP_DEG = 180.0
#: Mass of a pulley, seen from the belt, over the belt's own, beyond which it is doubted.
LARGEST_MASS_RATIO = 1000.0
#: Share of its pulley's least moment below which an arm's moment is doubted.
SMALLEST_ARM_SHARE = 0.5


def windup_deg(drive: Drive) -> float | None:
    """Angle by which the arm's spring is wound up in the reference state; None without an arm.

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> round(windup_deg(zhu_parker_2008()), 1)
    39.9
    """
    if drive.tensioner is None:
        return None
    scaled = scale(drive)
    torque = abs(scaled.preload) * scaled.torque_N_m
    return math.degrees(torque / drive.tensioner.spring_rate_N_m_per_rad)


def plausibility_warnings(drive: Drive) -> tuple[str, ...]:
    """What of `drive` looks like a number in another unit, with both numbers.

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> plausibility_warnings(zhu_parker_2008())
    ()
    """
    return (*_spring(drive), *_pulleys(drive), *_arm(drive))


def _spring(drive: Drive) -> list[str]:
    windup, tensioner = windup_deg(drive), drive.tensioner
    if windup is None or tensioner is None or windup <= LARGEST_WINDUP_DEG:
        return []
    rate = tensioner.spring_rate_N_m_per_rad
    torque = math.radians(windup) * rate
    return [
        f"tensioner.spring_rate_N_m_per_rad = {rate:g} is wound up by {windup:.0f} deg to balance "
        f"the belt's moment of {torque:.4g} N m, more than half a turn; if it was meant in N m/deg "
        f"it would be {math.degrees(rate):.4g} N m/rad ({math.radians(windup):.3g} deg)"
    ]


def _pulleys(drive: Drive) -> list[str]:
    belt = drive.belt.mass_per_length_kg_m * drive.layout.belt_length_m
    found = []
    for i, pulley in enumerate(drive.pulleys):
        mass = pulley.inertia_kg_m2 / pulley.radius_m**2
        if pulley.role != "crank" and mass > LARGEST_MASS_RATIO * belt:
            found.append(
                f"pulleys[{i}].inertia_kg_m2 = {pulley.inertia_kg_m2:g} on a radius of "
                f"{pulley.radius_m:g} m moves like {mass:.4g} kg on the belt, which weighs "
                f"{belt:.3g} kg itself; if it was meant in kg cm2 it would be "
                f"{1e-4 * pulley.inertia_kg_m2:g} kg m2"
            )
    return found


def _arm(drive: Drive) -> list[str]:
    tensioner, where = drive.tensioner, drive.layout
    if tensioner is None or where.arm is None or where.arm_length_m is None:
        return []
    pulley = drive.pulleys[where.arm]
    least = pulley.inertia_kg_m2 * (where.arm_length_m / pulley.radius_m) ** 2
    if tensioner.arm_inertia_kg_m2 >= SMALLEST_ARM_SHARE * least:
        return []
    return [
        f"tensioner.arm_inertia_kg_m2 = {tensioner.arm_inertia_kg_m2:g} is less than its pulley "
        f"alone must have about the pivot: a mass of at least J/r2 = "
        f"{pulley.inertia_kg_m2 / pulley.radius_m**2:.3g} kg at {where.arm_length_m:.3g} m gives "
        f"{least:.3g} kg m2"
    ]
