r"""A drive as an engineer gives it: SI quantities whose keys end in their unit.

The fields are the keys of a drive file, one spelling for each quantity. Building a `Drive` checks
everything (types, ranges, keys that exclude each other, the layout) and raises one
`InvalidDriveError` with every mistake found.

Conversions kept here, because they need nothing but the drive: with `l` the mean span length,
`P0` the initial tension and `rho` the mass per length, the time unit is :math:`\sqrt{\rho l^2/P_0}`
and :math:`\Omega = \alpha\,\omega_{crank}\sqrt{\rho l^2/P_0}`, alpha being the firing order.

Depends on: errors, checks; pydantic.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from beltsim.drive.layout import Layout, lay_out
from beltsim.drive.wording import number_words
from beltsim.errors import InvalidDriveError, Mistake, short_name

MAX_PULLEYS = 100
DEFAULT_FIRING_ORDER = 3.0
DEFAULT_SPEED_FLUCTUATION = 0.10

_NAME = r"^[^\s\x00-\x1f\x7f]([^\x00-\x1f\x7f]*[^\s\x00-\x1f\x7f])?$"
_TITLE = r"^[^\x00-\x1f\x7f]*$"


def _number(what: str, unit: str = "", default: Any = ..., **limits: float) -> Any:
    """A finite number within limits; its description says so, in messages and the JSON schema."""
    text = number_words(what, unit, **limits)
    limits_and_more: dict[str, Any] = dict(limits)
    return Field(default, strict=True, allow_inf_nan=False, description=text, **limits_and_more)


def _order(what: str, default: Any = ...) -> Any:
    """An order per crank revolution; that it is a multiple of 1/2 is checked exactly elsewhere."""
    text = f"a multiple of 0.5 from 0.5 to 100 ({what})"
    limits: dict[str, Any] = {"ge": 0.5, "le": 100.0, "json_schema_extra": {"multipleOf": 0.5}}
    return Field(default, strict=True, allow_inf_nan=False, description=text, **limits)


Coordinate = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-10.0, le=10.0)]
SpanLength = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=1e-3, le=20.0)]
Point = tuple[Coordinate, Coordinate]
_POINT = "[x, y], two numbers from -10 to 10"


class Table(BaseModel):
    """A table of a drive file: frozen, no unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", revalidate_instances="always")


class Pulley(Table):
    """One pulley; the list runs counter-clockwise along the belt loop."""

    name: str = Field(
        strict=True,
        min_length=1,
        max_length=60,
        pattern=_NAME,
        description="text of 1 to 60 characters (name of the pulley, different from the others)",
    )
    role: Literal["fixed", "crank", "arm"] = Field(
        description="'fixed', 'crank' (exactly one pulley) or 'arm' (the tensioner pulley)"
    )
    side: Literal["inside", "back"] = Field(
        description="'inside' the loop (the usual ribbed contact), or 'back' of the belt"
    )
    center_m: Point = Field(description=f"{_POINT} (centre in m, x to the right, y up)")
    radius_m: float = _number("pitch radius", "m", ge=1e-3, le=2.0)
    inertia_kg_m2: float = _number("moment of inertia about its axis", "kg m2", gt=0.0, le=100.0)
    accessory_torque_N_m: float = _number(
        "torque of the accessory, positive when absorbed", "N m", 0.0, ge=-1e4, le=1e4
    )


class Belt(Table):
    """The belt; its bending stiffness by exactly one of `EI_N_m2` and `epsilon`."""

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [{"required": ["EI_N_m2"]}, {"required": ["epsilon"]}]}
    )

    EA_N: float = _number("longitudinal stiffness EA", "N", ge=1e3, le=1e9)
    EI_N_m2: float | None = _number("bending stiffness EI", "N m2", None, ge=0.0, le=1e3)
    epsilon: float | None = _number(
        "bending number sqrt(EI/(P0 l^2)), l the mean span length", "", None, ge=0.0, le=1.0
    )
    mass_per_length_kg_m: float = _number("mass per length", "kg/m", ge=1e-4, le=20.0)
    initial_tension_N: float = _number("tension P0 of all spans at rest", "N", ge=1.0, le=1e6)


class Tensioner(Table):
    """Arm, spring and dry friction of the tensioner."""

    pivot_m: Point = Field(description=f"{_POINT} (pivot of the arm in m)")
    arm_inertia_kg_m2: float = _number(
        "moment of inertia of the arm about the pivot, mass of its pulley included",
        "kg m2",
        gt=0.0,
        le=100.0,
    )
    spring_rate_N_m_per_rad: float = _number("rate of the arm's spring", "N m/rad", gt=0.0, le=1e5)
    friction_torque_N_m: float = _number("kinetic friction torque", "N m", ge=0.0, le=1e5)
    static_friction_torque_N_m: float | None = _number(
        "static friction torque, at least the kinetic one", "N m", None, ge=0.0, le=1e5
    )


class Damping(Table):
    """Modal damping."""

    ratio: float = _number("damping ratio of every mode", "", ge=0.0, lt=1.0)


class OperatingPoint(Table):
    """Crank speed, by exactly one of `rpm` and `Omega`."""

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [{"required": ["rpm"]}, {"required": ["Omega"]}]}
    )

    rpm: float | None = _number("crank speed", "revolutions per minute", None, gt=0.0, le=1e5)
    Omega: float | None = _number(
        "dimensionless firing frequency, firing order x crank speed x time unit", "", None,
        gt=0.0, le=1e4,
    )  # fmt: skip


class ExcitationOrder(Table):
    """One order of the crank's motion; its size by exactly one of two keys."""

    model_config = ConfigDict(
        json_schema_extra={
            "oneOf": [{"required": ["speed_fluctuation"]}, {"required": ["angle_amplitude_deg"]}]
        }
    )

    order: float = _order("periods per crank revolution")
    speed_fluctuation: float | None = _number(
        "amplitude of the crank speed over the mean speed, 0.10 is 10 %", "", None, ge=0.0, lt=1.0
    )
    angle_amplitude_deg: float | None = _number(
        "amplitude of the crank angle", "deg", None, ge=0.0, le=60.0
    )
    phase_deg: float = _number(
        "phase of the angle, amplitude sin(order x crank angle + phase)", "deg", 0.0,
        ge=-360.0, le=360.0,
    )  # fmt: skip


class Excitation(Table):
    """Motion of the crank about its mean speed: one order, or a list of them."""

    firing_order: float = _order(
        "firings per crank revolution, alpha; 2 for a four-stroke engine of 4 cylinders",
        DEFAULT_FIRING_ORDER,
    )
    speed_fluctuation: float | None = _number(
        "amplitude of the crank speed over the mean speed in the firing order, 0.10 is 10 %; "
        f"{DEFAULT_SPEED_FLUCTUATION:g} unless orders are given",
        "",
        None,
        ge=0.0,
        lt=1.0,
    )
    orders: tuple[ExcitationOrder, ...] | None = Field(
        None,
        min_length=1,
        max_length=100,
        description="a list of 1 to 100 tables (orders of the crank's motion, in place of "
        "speed_fluctuation)",
    )

    @model_validator(mode="before")
    @classmethod
    def _default_fluctuation(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and all(
            data.get(key) is None for key in ("speed_fluctuation", "orders")
        ):
            return {**data, "speed_fluctuation": DEFAULT_SPEED_FLUCTUATION}
        return data


class Overrides(Table):
    """Lengths and angles that take the place of those from the coordinates."""

    span_lengths_m: tuple[SpanLength, ...] | None = Field(
        None,
        description="numbers from 0.001 to 20, one per span (lengths in m; span 1 runs from the "
        "first pulley to the second)",
    )
    beta_1_deg: float | None = _number(
        "alignment angle of the span before the tensioner pulley", "deg", None, ge=-360.0, le=360.0
    )
    beta_2_deg: float | None = _number(
        "alignment angle of the span after the tensioner pulley", "deg", None, ge=-360.0, le=360.0
    )
    arm_length_m: float | None = _number("length of the arm", "m", None, ge=1e-3, le=5.0)


class CrankOrder(NamedTuple):
    """One resolved order: theta_c has `angle_amplitude_rad sin(order w t + phase_rad)` in it."""

    order: float
    angle_amplitude_rad: float
    phase_rad: float


def _resolved(given: ExcitationOrder) -> CrankOrder:
    if given.speed_fluctuation is not None:
        amplitude = given.speed_fluctuation / given.order
    else:
        assert given.angle_amplitude_deg is not None
        amplitude = float(np.radians(given.angle_amplitude_deg))
    return CrankOrder(given.order, amplitude, float(np.radians(given.phase_deg)))


class Drive(Table):
    """A belt drive: the content of one drive file.

    Takes the tables of a drive file as keyword arguments (dicts, or the models of this module).

    Raises
    ------
    InvalidDriveError
        With every mistake found: wrong or missing values, unknown keys, keys that exclude each
        other, and layouts that cannot be.

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> drive = zhu_parker_2008()
    >>> round(drive.time_unit_s * 1e3, 4), round(drive.rpm(12.0))
    (6.4914, 5884)
    """

    name: str = Field(
        "",
        strict=True,
        max_length=200,
        pattern=_TITLE,
        description="text of at most 200 characters on one line (name of the drive)",
    )
    crank_rotation: Literal["cw", "ccw"] = Field(
        description="'cw' or 'ccw' (sense of crank and belt, seen with x to the right and y up)"
    )
    pulleys: tuple[Pulley, ...] = Field(
        min_length=2,
        max_length=MAX_PULLEYS,
        description=f"a list of 2 to {MAX_PULLEYS} tables (pulleys, counter-clockwise along the "
        "belt loop)",
    )
    belt: Belt = Field(description="a table (the belt)")
    tensioner: Tensioner | None = Field(
        None, description="a table (the tensioner), together with a pulley of role 'arm'"
    )
    damping: Damping = Field(description="a table (modal damping)")
    operating_point: OperatingPoint = Field(description="a table (crank speed)")
    excitation: Excitation = Field(
        default_factory=lambda: Excitation.model_validate({}),
        description="a table (motion of the crank about its mean)",
    )
    overrides: Overrides | None = Field(
        None, description="a table (lengths and angles in place of those from the coordinates)"
    )

    def __init__(self, /, **tables: Any) -> None:
        from beltsim.drive.soundness import mistakes_in  # it needs the models above

        found: list[Mistake] = []
        try:
            super().__init__(**tables)
        except ValidationError as error:
            found = mistakes_in(tables, error)
        else:
            found = mistakes_in(tables)
        if found:
            raise InvalidDriveError(found)

    def __repr__(self) -> str:
        point = self.operating_point
        speed = f"{point.rpm:g} rpm" if point.rpm is not None else f"Omega = {point.Omega:g}"
        names = ", ".join(short_name(pulley.name) for pulley in self.pulleys[:8])
        more = ", ..." if len(self.pulleys) > 8 else ""
        arm = "with" if self.tensioner is not None else "without"
        return (
            f"<Drive {self.name!r}: {len(self.pulleys)} pulleys ({names}{more}), {arm} tensioner, "
            f"{speed}>"
        )

    __str__ = __repr__

    @classmethod
    def model_validate(cls, obj: Any, **_: Any) -> Self:
        """A drive from a mapping of tables, with the errors of `Drive` itself."""
        if isinstance(obj, cls):
            return obj
        if not isinstance(obj, Mapping) or not all(isinstance(key, str) for key in obj):
            raise InvalidDriveError(Mistake("drive", obj, "a table with the keys of a drive file"))
        return cls(**obj)

    def model_copy(
        self,
        *,
        update: Mapping[str, Any] | None = None,
        deep: bool = False,  # noqa: ARG002 - nothing in a drive can be changed
    ) -> Self:
        """A copy with whole tables replaced, checked like a new drive."""
        tables = {name: getattr(self, name) for name in self.model_fields_set}
        return type(self)(**tables | dict(update or {}))

    def changed(self, /, **tables: Any) -> Self:
        """A copy with some keys changed, checked like a new drive.

        Parameters
        ----------
        **tables : mapping or value
            For a table, the keys to change in it; None removes a key. Anything else replaces.

        Examples
        --------
        >>> from beltsim.drive.presets import zhu_parker_2008
        >>> drive = zhu_parker_2008().changed(operating_point={"rpm": 1500.0, "Omega": None})
        >>> drive.operating_point.rpm
        1500.0
        """
        data = self.model_dump(exclude_none=True)
        for key, value in tables.items():
            merged = value
            if isinstance(value, Mapping) and isinstance(data.get(key), dict):
                both = data[key] | dict(value)
                merged = {name: entry for name, entry in both.items() if entry is not None}
            data[key] = merged
        return type(self)(**data)

    @cached_property
    def layout(self) -> Layout:
        """Geometry: spans, wraps, arm."""
        return lay_out(self)

    @property
    def mean_span_length_m(self) -> float:
        """Mean length `l` of the spans, the scale of lengths, m."""
        return float(self.layout.span_length_m.mean())

    @property
    def time_unit_s(self) -> float:
        """Time unit sqrt(rho l^2 / P0), s."""
        belt = self.belt
        inertia = belt.mass_per_length_kg_m * self.mean_span_length_m**2
        return float(np.sqrt(inertia / belt.initial_tension_N))

    @property
    def bending_stiffness_N_m2(self) -> float:
        """Bending stiffness EI, given or from epsilon^2 P0 l^2, N m2."""
        if self.belt.EI_N_m2 is not None:
            return self.belt.EI_N_m2
        assert self.belt.epsilon is not None
        return self.belt.epsilon**2 * self.belt.initial_tension_N * self.mean_span_length_m**2

    def omega(self, rpm: float) -> float:
        """Dimensionless firing frequency Omega at a crank speed in rpm."""
        return self.excitation.firing_order * rpm * (2.0 * np.pi / 60.0) * self.time_unit_s

    def rpm(self, Omega: float) -> float:
        """Crank speed in rpm at a dimensionless firing frequency Omega."""
        return Omega / (self.excitation.firing_order * (2.0 * np.pi / 60.0) * self.time_unit_s)

    @property
    def Omega(self) -> float:
        """The drive's operating point as dimensionless firing frequency."""
        if self.operating_point.Omega is not None:
            return self.operating_point.Omega
        assert self.operating_point.rpm is not None
        return self.omega(self.operating_point.rpm)

    @property
    def orders(self) -> tuple[CrankOrder, ...]:
        """Orders of the crank's motion, theta_c(t) = sum amplitude sin(order w t + phase).

        A speed fluctuation mu_o means that theta_c' has the amplitude mu_o w, w being the mean
        crank speed, so that the amplitude of the angle is mu_o/order rad.
        """
        given = self.excitation.orders
        if given is None:
            alpha, mu = self.excitation.firing_order, self.excitation.speed_fluctuation
            assert mu is not None
            return (CrankOrder(alpha, mu / alpha, 0.0),)
        return tuple(_resolved(entry) for entry in given)

    def to_toml(self) -> str:
        """The drive as the text of a drive file; loading it gives an equal drive."""
        from beltsim.drive.writing import to_toml

        return to_toml(self)
