r"""Geometry of a drive: spans, wraps, tensioner arm and the paper's alignment angles.

Conventions (x to the right, y up): pulleys counter-clockwise along the loop, span `i` from pulley
`i` to the next (0-based), `u_i` along it, `v_i` = `u_i` turned by +90 degrees. The tensioner
pulley T stands at the end of an arm from the pivot `b`: `nu` is the unit vector of `c_T - b`
turned by +90 degrees, and a positive arm angle moves the pulley by `r_t theta_t nu`. The alignment
angles belong to the spans on either side of T, span T-1 ("1") and span T ("2"):

.. math:: \nu\cdot u = -\sin\beta, \qquad \nu\cdot v = \cos\beta

Given span lengths, angles and arm length (a drive's overrides) take the place of the computed
ones; directions still come from the coordinates.

Depends on: checks, tracing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from beltsim.checks import FloatArray, read_only
from beltsim.drive.tracing import trace, turned

if TYPE_CHECKING:
    from beltsim.drive.schema import Drive, Overrides

#: Wraps below this are warned about, rad.
SMALL_WRAP = np.radians(5.0)
#: Overrides further than this from the coordinates are warned about.
OVERRIDE_LENGTH_RATIO = 0.02
OVERRIDE_ANGLE = np.radians(2.0)

Travel = Literal["cw", "ccw"]
_ARRAYS = (
    *("radius_m", "inertia_kg_m2", "side", "accessory_torque_N_m", "center_m"),
    *("span_length_m", "direction", "normal", "wrap_rad", "pivot_m", "arm_normal"),
)


@dataclass(frozen=True, eq=False)
class Layout:
    """Geometry of a drive with `n` pulleys, in SI units. Arrays are read-only.

    Parameters
    ----------
    names : (n,) names of the pulleys.
    radius_m : (n,) pitch radii.
    inertia_kg_m2 : (n,) about the pulley axes.
    side : (n,) +1 inside the loop, -1 on the belt's back.
    accessory_torque_N_m : (n,) positive when absorbed.
    center_m : (n, 2)
    span_length_m : (n,) span `i` runs from pulley `i` to the next.
    direction, normal : (n, 2) unit vectors `u_i` along the spans and `v_i` into the loop.
    wrap_rad : (n,) angle of contact, in [0, 2 pi).
    crank : int
        Index of the crank pulley.
    arm : int or None
        Index of the tensioner pulley; None for fixed centres, and then so are the five below.
    pivot_m : (2,)
    arm_length_m : float
    arm_normal : (2,) unit vector `nu`, direction of motion of the tensioner pulley.
    beta_1, beta_2 : float
        Alignment angles of the spans before and after the tensioner pulley, rad in (-pi, pi].
    travel : "cw" or "ccw"
        Sense of the belt's travel.
    warnings : tuple of str

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> layout = zhu_parker_2008().layout
    >>> layout.span_length_m.tolist()
    [0.1548, 0.3449, 0.5518]
    >>> round(float(np.degrees(layout.wrap_rad[0])), 2)
    221.11
    """

    names: tuple[str, ...]
    radius_m: FloatArray
    inertia_kg_m2: FloatArray
    side: FloatArray
    accessory_torque_N_m: FloatArray
    center_m: FloatArray
    span_length_m: FloatArray
    direction: FloatArray
    normal: FloatArray
    wrap_rad: FloatArray
    crank: int
    travel: Travel
    arm: int | None = None
    pivot_m: FloatArray | None = None
    arm_length_m: float | None = None
    arm_normal: FloatArray | None = None
    beta_1: float | None = None
    beta_2: float | None = None
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in _ARRAYS:
            if getattr(self, name) is not None:
                object.__setattr__(self, name, read_only(getattr(self, name)))

    def __repr__(self) -> str:
        lengths = ", ".join(f"{1e3 * length:.1f}" for length in self.span_length_m[:8])
        more = ", ..." if self.n > 8 else ""
        return f"<Layout: {self.n} pulleys, spans {lengths}{more} mm, travel {self.travel!r}>"

    @property
    def n(self) -> int:
        """Number of pulleys, and of spans."""
        return len(self.names)

    @property
    def span_start_m(self) -> FloatArray:
        """Contact points (n, 2) where the spans begin, from the coordinates."""
        return self.center_m - (self.side * self.radius_m)[:, None] * self.normal

    @property
    def span_end_m(self) -> FloatArray:
        """Contact points (n, 2) where the spans end, from the coordinates."""
        arms = np.roll(self.side * self.radius_m, -1)[:, None] * self.normal
        return np.asarray(np.roll(self.center_m, -1, axis=0) - arms)

    @property
    def belt_length_m(self) -> float:
        """Pitch length of the belt: all spans and all arcs of contact."""
        return float(self.span_length_m.sum() + self.radius_m @ self.wrap_rad)

    def mirrored(self) -> Layout:
        """The same drive seen from behind: y -> -y, list reversed, travel the other way.

        New pulley `k` is old pulley `n-1-k`, new span `k` old span `n-2-k` (mod n). The spans
        of the tensioner change places, with beta -> pi - beta. Given lengths and angles go
        with their spans. Mirroring twice gives the layout back.
        """
        flip = np.array([1.0, -1.0])
        spans = (self.n - 2 - np.arange(self.n)) % self.n
        changes = {
            name: getattr(self, name)[::-1]
            for name in ("names", "radius_m", "inertia_kg_m2", "side", "accessory_torque_N_m")
        }
        changes |= {
            "center_m": self.center_m[::-1] * flip,
            "wrap_rad": self.wrap_rad[::-1],
            "span_length_m": self.span_length_m[spans],
            "direction": -self.direction[spans] * flip,
            "normal": self.normal[spans] * flip,
            "crank": self.n - 1 - self.crank,
            "travel": "ccw" if self.travel == "cw" else "cw",
        }
        if self.arm is not None:
            assert self.pivot_m is not None
            assert self.arm_normal is not None
            assert self.beta_1 is not None
            assert self.beta_2 is not None
            changes |= {
                "arm": self.n - 1 - self.arm,
                "pivot_m": self.pivot_m * flip,
                "arm_normal": -self.arm_normal * flip,
                "beta_1": _principal(np.pi - self.beta_2),
                "beta_2": _principal(np.pi - self.beta_1),
            }
        return replace(self, **changes)


def lay_out(drive: Drive) -> Layout:
    """Geometry of a valid drive; `Drive.layout` keeps it.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    Layout
    """
    pulleys = drive.pulleys
    side = np.array([1.0 if p.side == "inside" else -1.0 for p in pulleys])
    center = np.array([p.center_m for p in pulleys])
    radius = np.array([p.radius_m for p in pulleys])
    names = tuple(p.name for p in pulleys)
    roles = [p.role for p in pulleys]
    path = trace(center, radius, side)
    layout = Layout(
        names=names,
        radius_m=radius,
        inertia_kg_m2=np.array([p.inertia_kg_m2 for p in pulleys]),
        side=side,
        accessory_torque_N_m=np.array([p.accessory_torque_N_m for p in pulleys]),
        center_m=center,
        span_length_m=path.length,
        direction=path.direction,
        normal=path.normal,
        wrap_rad=path.wrap,
        crank=roles.index("crank"),
        travel=drive.crank_rotation,
        warnings=_wrap_warnings(names, path.wrap),
    )
    if drive.tensioner is not None:
        layout = _with_arm(layout, roles.index("arm"), np.array(drive.tensioner.pivot_m))
    return layout if drive.overrides is None else _overridden(layout, drive.overrides)


def _with_arm(layout: Layout, arm: int, pivot: FloatArray) -> Layout:
    reach = layout.center_m[arm] - pivot
    length = float(np.hypot(*reach))
    nu = turned(reach / length)

    def beta(span: int) -> float:
        u, v = layout.direction[span], layout.normal[span]
        return float(np.arctan2(-(nu @ u), nu @ v))

    return replace(
        layout,
        arm=arm,
        pivot_m=pivot,
        arm_length_m=length,
        arm_normal=nu,
        beta_1=beta(arm - 1),
        beta_2=beta(arm),
    )


def _overridden(layout: Layout, given: Overrides) -> Layout:
    """`layout` with the given lengths and angles in place of the computed ones."""
    changes: dict[str, object] = {}
    remarks = []
    if given.span_lengths_m is not None:
        for i, (new, old) in enumerate(
            zip(given.span_lengths_m, layout.span_length_m, strict=True)
        ):
            name = f"overrides.span_lengths_m[{i}]"
            remarks += _length_warning(name, new, float(old))
        changes["span_length_m"] = np.array(given.span_lengths_m)
    if given.arm_length_m is not None and layout.arm_length_m is not None:
        name = "overrides.arm_length_m"
        remarks += _length_warning(name, given.arm_length_m, layout.arm_length_m)
        changes["arm_length_m"] = given.arm_length_m
    for key in ("beta_1", "beta_2"):
        degrees = getattr(given, f"{key}_deg")
        if degrees is not None:
            angle, old = _principal(np.radians(degrees)), getattr(layout, key)
            if abs(_principal(angle - old)) > OVERRIDE_ANGLE:
                remarks.append(
                    f"overrides.{key}_deg = {degrees:g}, but the coordinates give "
                    f"{np.degrees(old):.2f} deg; check the order of the spans"
                )
            changes[key] = angle
    return replace(layout, warnings=(*layout.warnings, *remarks), **changes)  # type: ignore[arg-type]


def _length_warning(name: str, new: float, old: float) -> list[str]:
    if abs(new - old) <= OVERRIDE_LENGTH_RATIO * old:
        return []
    return [
        f"{name} = {new:g} m, but the coordinates give {old:.4f} m; check the order of the spans"
    ]


def _wrap_warnings(names: tuple[str, ...], wrap: FloatArray) -> tuple[str, ...]:
    return tuple(
        f"the belt touches pulley {name} on {np.degrees(angle):.2f} deg only; "
        "check its position, or leave it out"
        for name, angle in zip(names, wrap, strict=True)
        if angle < SMALL_WRAP
    )


def _principal(angle: float) -> float:
    """`angle` (rad) brought into (-pi, pi]; unchanged where it is there already."""
    while angle > np.pi:
        angle -= 2.0 * np.pi
    while angle <= -np.pi:
        angle += 2.0 * np.pi
    return float(angle)
