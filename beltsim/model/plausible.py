r"""Numbers of a drive that can be, but are hardly meant: warnings, never a guess in their place.

* The spring's wind-up :math:`M_0/k`, by which it is turned where it balances the belt. A tensioner
  winds up by 20 to 90 degrees; half a turn and more is a rate in N m/deg, two degrees and less
  one converted twice.
* The mass :math:`J/r^2` that a pulley adds to the belt. A pulley with its accessory weighs some ten
  times as much as the whole belt, seen from the belt; a thousand times is another unit, 1 kg cm2
  being 1e-4 kg m2; less than a two hundredth is no pulley. The crank is left out: its motion is
  prescribed.
* The arm carries its pulley, whose mass lies within its radius and so is at least :math:`J/r^2`.
  Seen from the pivot that is :math:`r_t^2 J/r^2`; an arm of less than half of it is another unit.
* The belt stretches by :math:`P_0/EA` under its initial tension, some 0.1 to 1 %, and weighs about
  20 g per metre and rib.
* The arm has room: its pivot is in no pulley, and its own pulley may turn with it by the 0.1 rad to
  which the model holds before it touches another.

Depends on: model.scaling; drive for its type only.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from beltsim.model.scaling import scale

if TYPE_CHECKING:
    from beltsim.drive import Drive

Point = tuple[float, float]

#: Wind-ups of the spring between which its rate is not doubted, deg.
SMALLEST_WINDUP_DEG, LARGEST_WINDUP_DEG = 2.0, 180.0
#: Mass of a pulley, seen from the belt, over the belt's own, between which it is not doubted.
SMALLEST_MASS_RATIO, LARGEST_MASS_RATIO = 0.005, 1000.0
#: Share of its pulley's least moment below which an arm's moment is doubted.
SMALLEST_ARM_SHARE = 0.5
#: Strains of the belt under its initial tension between which EA is not doubted.
SMALLEST_STRAIN, LARGEST_STRAIN = 1e-5, 0.05
#: Mass of the belt beyond which it is doubted, kg/m; an arm shorter than this is doubted, m.
HEAVIEST_BELT_KG_M, SHORTEST_ARM_M = 2.0, 0.005
#: Rotation of the arm that it must have room for: the model warns beyond it, rad.
ROOM_RAD = 0.1


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
    return (*_spring(drive), *_belt(drive), *_pulleys(drive), *_arm(drive), *_room(drive))


def _spring(drive: Drive) -> list[str]:
    windup, tensioner = windup_deg(drive), drive.tensioner
    if windup is None or tensioner is None:
        return []
    rate = tensioner.spring_rate_N_m_per_rad
    torque = math.radians(windup) * rate
    if windup < SMALLEST_WINDUP_DEG:
        return [
            f"tensioner.spring_rate_N_m_per_rad = {rate:g} needs a wind-up of only {windup:.2g} "
            f"deg to balance the belt's moment of {torque:.4g} N m; tensioners take 20 to 90 deg; "
            f"this rate is {math.radians(rate):.4g} N m/deg"
        ]
    if windup <= LARGEST_WINDUP_DEG:
        return []
    return [
        f"tensioner.spring_rate_N_m_per_rad = {rate:g} is wound up by {windup:.0f} deg to balance "
        f"the belt's moment of {torque:.4g} N m, more than half a turn; if it was meant in N m/deg "
        f"it would be {math.degrees(rate):.4g} N m/rad ({math.radians(windup):.3g} deg)"
    ]


def _belt(drive: Drive) -> list[str]:
    belt, found = drive.belt, []
    strain = belt.initial_tension_N / belt.EA_N
    if not SMALLEST_STRAIN <= strain <= LARGEST_STRAIN:
        found.append(
            f"belt.EA_N = {belt.EA_N:g} under belt.initial_tension_N = {belt.initial_tension_N:g} "
            f"is a stretch of {100.0 * strain:.2g} %; belts stretch by 0.1 to 1 % (EA about 20 000 "
            "N for each PK rib)"
        )
    if belt.mass_per_length_kg_m > HEAVIEST_BELT_KG_M:
        mass = belt.mass_per_length_kg_m
        found.append(
            f"belt.mass_per_length_kg_m = {mass:g} is the mass of {mass / 0.02:.0f} PK ribs; if it "
            f"was meant in g/m it would be {1e-3 * mass:g} kg/m"
        )
    return found


def _pulleys(drive: Drive) -> list[str]:
    belt = drive.belt.mass_per_length_kg_m * drive.layout.belt_length_m
    found = []
    for i, pulley in enumerate(drive.pulleys):
        mass = pulley.inertia_kg_m2 / pulley.radius_m**2
        if pulley.role == "crank":
            continue
        if mass < SMALLEST_MASS_RATIO * belt:
            found.append(
                f"pulleys[{i}].inertia_kg_m2 = {pulley.inertia_kg_m2:g} on a radius of "
                f"{pulley.radius_m:g} m is that of a ring of {1e3 * mass:.2g} g; the belt weighs "
                f"{belt:.3g} kg"
            )
        elif mass > LARGEST_MASS_RATIO * belt:
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


def _room(drive: Drive) -> list[str]:
    """Pulleys in which the pivot lies, or which the arm's pulley meets when the arm turns."""
    tensioner, where = drive.tensioner, drive.layout
    if tensioner is None or where.arm is None or where.arm_length_m is None:
        return []
    found, pivot, length = [], tensioner.pivot_m, where.arm_length_m
    own = drive.pulleys[where.arm]
    if length < SHORTEST_ARM_M:
        found.append(
            f"tensioner.pivot_m = ({pivot[0]:g}, {pivot[1]:g}) is {1e3 * length:.2g} mm from the "
            "centre of the arm's pulley: that is the arm's length"
        )
    for i, other in enumerate(drive.pulleys):
        if i == where.arm:
            continue
        apart = math.dist(other.center_m, pivot)
        if apart < other.radius_m:
            found.append(
                f"tensioner.pivot_m = ({pivot[0]:g}, {pivot[1]:g}) lies inside pulleys[{i}] "
                f"({other.name}), {apart:.3g} m from its centre"
            )
            continue
        turn = _turn_to_touch(length, apart, own.radius_m + other.radius_m)
        now = _angle(own.center_m, pivot, other.center_m)
        if turn is not None and now - turn < ROOM_RAD:
            found.append(
                f"the arm's pulley touches pulleys[{i}] ({other.name}) once the arm turns by "
                f"{math.degrees(max(0.0, now - turn)):.2g} deg towards it"
            )
    return found


def _turn_to_touch(arm: float, apart: float, radii: float) -> float | None:
    """Angle at the pivot, between arm and the other centre, at which two pulleys touch."""
    cosine = (arm**2 + apart**2 - radii**2) / (2.0 * arm * apart)
    return None if cosine >= 1.0 else math.acos(max(-1.0, cosine))


def _angle(end: Point, pivot: Point, other: Point) -> float:
    """Angle at the pivot between the arm and the line to another centre, 0 to pi."""
    a, b = (math.atan2(one[1] - pivot[1], one[0] - pivot[0]) for one in (end, other))
    return abs(math.remainder(a - b, math.tau))
