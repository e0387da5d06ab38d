"""Every mistake in the tables of a drive, as far as each can still be told.

Three kinds of checks speak together: the type and range of each value (pydantic's findings,
reworded), keys that depend on each other, and the layout. A check is skipped only when a value it
needs is itself missing or wrong.

Depends on: errors, checks, faults, schema, wording.
"""

from __future__ import annotations

import difflib
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from beltsim.checks import real_number
from beltsim.drive.faults import layout_faults
from beltsim.drive.schema import (
    Belt,
    Damping,
    Drive,
    Excitation,
    ExcitationOrder,
    OperatingPoint,
    Overrides,
    Pulley,
    Tensioner,
)
from beltsim.drive.wording import MISSING, Words, path_words, shown
from beltsim.errors import Mistake

Location = tuple[str | int, ...]

TABLES: dict[tuple[str, ...], type[BaseModel]] = {
    (): Drive,
    ("pulleys",): Pulley,
    ("belt",): Belt,
    ("tensioner",): Tensioner,
    ("damping",): Damping,
    ("operating_point",): OperatingPoint,
    ("excitation",): Excitation,
    ("excitation", "orders"): ExcitationOrder,
    ("overrides",): Overrides,
}

#: Keys of points, two numbers of one unit.
POINTS = ("center_m", "pivot_m")
#: Wrong values and keys that are told one by one; a drive file never has more.
MOST_TOLD = 500

#: How a value given in a customary unit relates to the key's unit: ending, factor, unit.
_CUSTOMARY = (
    ("length_kg_m", 1e-3, "g/m"),
    ("inertia_kg_m2", 1e-4, "kg cm2"),
    ("EI_N_m2", 1e-6, "N mm2"),
    ("torque_N_m", 1e-3, "N mm"),
    ("_m", 1e-3, "mm"),
    ("_N", 1e3, "kN"),
    ("ratio", 1e-2, "%"),
    ("speed_fluctuation", 1e-2, "%"),
)


def mistakes_in(tables: Mapping[str, Any], error: ValidationError | None = None) -> list[Mistake]:
    """Every mistake in `tables`, the arguments of a `Drive`.

    Parameters
    ----------
    tables : mapping
        As given, before validation.
    error : ValidationError, optional
        What pydantic found in them.

    Returns
    -------
    list of Mistake
        In the order: values and keys, keys that depend on each other, layout.
    """
    entries = error.errors(include_url=False, include_context=False) if error else []
    entries = [entry for entry in entries if not _short_of_sound_ones(entry)]
    bad: set[Location] = {tuple(entry["loc"]) for entry in entries}
    given = _Given(tables, bad)
    found = [_reworded(given, entry) for entry in entries[:MOST_TOLD]]
    if len(entries) > MOST_TOLD:
        more = Words(f"{len(entries) - MOST_TOLD} further mistakes")
        found.append(Mistake("drive", more, "a drive file; is this one?"))
    for check in (_belt, _tensioner, _speed, _excitation, _roles, _names, _overrides, _layout):
        found += check(given)
    return list({mistake.field + str(mistake): mistake for mistake in found}.values())


def _short_of_sound_ones(entry: ErrorDetails) -> bool:
    """Whether a list is called too short only because wrong entries were not counted in it."""
    value = entry["input"]
    shortest = {"pulleys": 2, "excitation.orders": 1}.get(path_words(entry["loc"]))
    if entry["type"] != "too_short" or shortest is None:
        return False
    return isinstance(value, Sequence) and len(value) >= shortest


class _Given:
    """The values as given; those known to be wrong count as absent."""

    def __init__(self, tables: Mapping[str, Any], bad: set[Location]) -> None:
        self._tables = tables
        self._bad = bad
        self._spoilt = {entry[:n] for entry in bad for n in range(len(entry) + 1)}

    def entry(self, *location: str | int) -> Any:
        """What stands at `location`, right or wrong; None when nothing does."""
        here: Any = self._tables
        for part in location:
            if isinstance(part, int):
                sound = isinstance(here, Sequence) and not isinstance(here, str)
                here = here[part] if sound and part < len(here) else None
            elif isinstance(here, BaseModel):
                here = getattr(here, part, None)
            else:
                here = here.get(part) if isinstance(here, Mapping) else None
            if here is None:
                return None
        return here

    def value(self, *location: str | int) -> Any:
        """The value at `location`, or None when it is absent or anything about it is wrong."""
        above = (location[:n] for n in range(len(location)))
        if location in self._spoilt or any(table in self._bad for table in above):
            return None
        return self.entry(*location)

    def present(self, *location: str | int) -> list[str]:
        """Keys of the table at `location` that have a value, right or wrong."""
        table = self.entry(*location)
        if isinstance(table, BaseModel):
            return [key for key in type(table).model_fields if getattr(table, key) is not None]
        if isinstance(table, Mapping):
            return [key for key, value in table.items() if value is not None]
        return []

    def is_table(self, *location: str | int) -> bool:
        return isinstance(self.entry(*location), Mapping | BaseModel)

    def rows(self, *location: str | int) -> int:
        """Length of the list at `location`, 0 when there is none or it is too short or long."""
        entry = self.entry(*location)
        usable = isinstance(entry, Sequence) and not isinstance(entry, str)
        return len(entry) if usable and location not in self._bad else 0

    def column(self, key: str) -> list[Any] | None:
        """`key` of every pulley, or None unless all of them are right."""
        rows = [self.value("pulleys", i, key) for i in range(self.rows("pulleys"))]
        return rows if rows and all(row is not None for row in rows) else None


def _reworded(given: _Given, entry: ErrorDetails) -> Mistake:
    """Finding of pydantic as a mistake with its path, value and what is allowed."""
    location, kind, value = tuple(entry["loc"]), entry["type"], entry["input"]
    names = tuple(part for part in location if isinstance(part, str))
    if not names:  # a key that is no text: pydantic looks no further
        return Mistake("drive", shown(value), "a table whose keys are those of a drive file")
    table = TABLES.get(names[:-1]) if names else None
    field = None if table is None else table.model_fields.get(names[-1])
    if kind == "extra_forbidden" or field is None:
        return Mistake(path_words(location), shown(value), _known_keys(names))
    if names in TABLES and isinstance(location[-1], int):
        allowed = f"a table with the keys {', '.join(TABLES[names].model_fields)}"
        return Mistake(path_words(location), shown(value), allowed)
    if kind == "missing" and isinstance(location[-1], int):
        location = location[:-1]  # too short a list of numbers: speak of the list
    elif kind == "missing":
        value = MISSING
    key = str(names[-1])
    if key in POINTS and isinstance(location[-1], int):  # both numbers are in one unit
        return Mistake(
            path_words(location),
            shown(value),
            f"{field.description}{_in_millimetres(given.entry(*location[:-1]))}",
        )
    allowed = f"{field.description}{_customary(key, value, field)}"
    return Mistake(path_words(location), shown(value), allowed)


def _known_keys(names: tuple[str, ...]) -> str:
    table = TABLES.get(names[:-1])
    if table is None:
        return "a key of a drive file"
    known = list(table.model_fields)
    word = names[-1][:100].lower()
    plain = {key.lower(): key for key in known}
    close = [key for key in plain if word and key.startswith(word)]  # the unit left out
    close += difflib.get_close_matches(word, plain, n=1, cutoff=0.5)
    nearest = f"did you mean {plain[close[0]]}? " if close else ""
    return f"a known key; {nearest}known here: {', '.join(known)}"


def _customary(key: str, value: Any, field: FieldInfo) -> str:
    """The value in the key's unit, if a customary unit would explain it."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    if (isinstance(value, int) and value.bit_length() > 256) or not math.isfinite(value):
        return ""
    limits = [
        (bound, getattr(rule, bound))
        for rule in field.metadata
        for bound in ("gt", "ge", "lt", "le")
        if getattr(rule, bound, None) is not None
    ]
    if key == "span_lengths_m":
        limits = [("ge", 1e-3), ("le", 20.0)]
    tests = {"gt": float.__gt__, "ge": float.__ge__, "lt": float.__lt__, "le": float.__le__}
    for ending, factor, unit in _CUSTOMARY:
        if key.endswith(ending) or (ending == "_m" and key == "span_lengths_m"):
            number = float(value) * factor
            fits = limits and all(tests[bound](number, float(limit)) for bound, limit in limits)
            return f"; {value:g} {unit} would be {number:g}" if fits else ""
    return ""


def _in_millimetres(point: Any) -> str:
    """A point in metres, if it makes sense in millimetres."""
    numbers = [real_number(value) for value in point] if isinstance(point, Sequence) else []
    if len(numbers) != 2 or not all(n is not None and abs(n) <= 1e4 for n in numbers):
        return ""
    x, y = (float(n or 0.0) for n in numbers)
    if all(number == 0.0 or abs(number) >= 1.0 for number in (x, y)):
        return f"; [{x:g}, {y:g}] mm would be [{1e-3 * x:g}, {1e-3 * y:g}]"
    large = max(x, y, key=abs)
    return f"; {large:g} mm would be {1e-3 * large:g}"


def _one_of(given: _Given, location: Location, keys: tuple[str, str]) -> list[Mistake]:
    """A mistake unless exactly one of two keys is given."""
    if not given.is_table(*location):
        return []
    there = [key for key in keys if key in given.present(*location)]
    if len(there) == 1:
        return []
    value = Words(f"both {keys[0]} and {keys[1]}" if there else f"neither {keys[0]} nor {keys[1]}")
    return [Mistake(path_words(location), value, f"given by exactly one of {keys[0]}, {keys[1]}")]


def _belt(given: _Given) -> Iterator[Mistake]:
    yield from _one_of(given, ("belt",), ("EI_N_m2", "epsilon"))
    EA, P0 = given.value("belt", "EA_N"), given.value("belt", "initial_tension_N")
    if EA is not None and P0 is not None and not EA > P0:
        allowed = f"above belt.initial_tension_N = {P0:g}; check the unit of both (N)"
        yield Mistake("belt.EA_N", EA, allowed)


def _tensioner(given: _Given) -> Iterator[Mistake]:
    kinetic = given.value("tensioner", "friction_torque_N_m")
    static = given.value("tensioner", "static_friction_torque_N_m")
    if kinetic is not None and static is not None and static < kinetic:
        allowed = f"at least tensioner.friction_torque_N_m = {kinetic:g}, or left out"
        yield Mistake("tensioner.static_friction_torque_N_m", static, allowed)


def _speed(given: _Given) -> list[Mistake]:
    return _one_of(given, ("operating_point",), ("rpm", "Omega"))


def _excitation(given: _Given) -> Iterator[Mistake]:
    if given.entry("excitation", "orders") is not None:
        value = given.entry("excitation", "speed_fluctuation")
        if value is not None:
            allowed = "left out where excitation.orders is given: say it there, order by order"
            yield Mistake("excitation.speed_fluctuation", shown(value), allowed)
    yield from _half_order(given, "excitation", "firing_order")
    seen: dict[float, int] = {}
    for i in range(given.rows("excitation", "orders")):
        here: Location = ("excitation", "orders", i)
        yield from _one_of(given, here, ("speed_fluctuation", "angle_amplitude_deg"))
        yield from _half_order(given, *here, "order")
        order = given.value(*here, "order")
        if order is not None and seen.setdefault(float(order), i) != i:
            allowed = f"given once; excitation.orders[{seen[float(order)]}] has it already"
            yield Mistake(path_words((*here, "order")), order, allowed)


def _half_order(given: _Given, *location: str | int) -> Iterator[Mistake]:
    order = given.value(*location)
    if order is not None and (2.0 * order) % 1.0 != 0.0:
        yield Mistake(path_words(location), order, "a multiple of 0.5 (an order per revolution)")


def _roles(given: _Given) -> Iterator[Mistake]:
    roles = [given.value("pulleys", i, "role") for i in range(given.rows("pulleys"))]
    if not roles:
        return
    complete = None not in roles
    cranks = [i for i, role in enumerate(roles) if role == "crank"]
    arms = [i for i, role in enumerate(roles) if role == "arm"]
    if len(cranks) > 1 or (complete and not cranks):
        value = Words(f"{_counted(cranks)} of role 'crank'")
        yield Mistake("pulleys", value, "a list with exactly one pulley of role 'crank'")
    if len(arms) > 1:
        value = Words(f"{_counted(arms)} of role 'arm'")
        yield Mistake("pulleys", value, "a list with at most one pulley of role 'arm'")
    tensioner = given.entry("tensioner") is not None
    if complete and tensioner and not arms:
        value = Words("no pulley of role 'arm'")
        yield Mistake("pulleys", value, "a list with one of role 'arm', since there is a tensioner")
    if arms and not tensioner:
        allowed = f"a table [tensioner], since pulleys[{arms[0]}] has the role 'arm'"
        yield Mistake("tensioner", MISSING, allowed)
    for i in cranks:
        torque = given.value("pulleys", i, "accessory_torque_N_m")
        if torque is not None and torque != 0.0:
            field = f"pulleys[{i}].accessory_torque_N_m"
            yield Mistake(field, torque, "0 on the crank: its torque follows from the others")
    if len(arms) == 1:
        yield from _arm_length(given, arms[0])


def _arm_length(given: _Given, arm: int) -> Iterator[Mistake]:
    center, pivot = given.value("pulleys", arm, "center_m"), given.value("tensioner", "pivot_m")
    if center is None or pivot is None:
        return
    length = math.dist(center, pivot)
    if length < 1e-3:
        value = Words(f"{tuple(pivot)}, {length:.3g} m from the centre of pulleys[{arm}]")
        yield Mistake("tensioner.pivot_m", value, "at least 0.001 m from it: the arm's length")
    elif length > 5.0:
        value = Words(f"{tuple(pivot)}, {length:.3g} m from the centre of pulleys[{arm}]")
        yield Mistake("tensioner.pivot_m", value, "at most 5 m from it: the arm's length")


def _counted(rows: list[int]) -> str:
    named = ", ".join(f"pulleys[{i}]" for i in rows)
    return f"{len(rows)} ({named})" if rows else "none"


def _names(given: _Given) -> Iterator[Mistake]:
    names = [given.value("pulleys", i, "name") for i in range(given.rows("pulleys"))]
    counts = Counter(name for name in names if name is not None)
    for i, name in enumerate(names):
        if counts.get(name, 0) > 1 and names.index(name) != i:
            allowed = f"a name of its own; pulleys[{names.index(name)}] has this one"
            yield Mistake(f"pulleys[{i}].name", name, allowed)


def _overrides(given: _Given) -> Iterator[Mistake]:
    lengths, n = given.value("overrides", "span_lengths_m"), given.rows("pulleys")
    if lengths is not None and n and len(lengths) != n:
        value = Words(f"{len(lengths)} lengths")
        yield Mistake("overrides.span_lengths_m", value, f"a list of {n}, one per span")
    if given.entry("tensioner") is None:
        for key in ("beta_1_deg", "beta_2_deg", "arm_length_m"):
            value = given.entry("overrides", key)
            if value is not None:
                yield Mistake(f"overrides.{key}", shown(value), "left out without a tensioner")


def _layout(given: _Given) -> list[Mistake]:
    center, radius, side = (given.column(key) for key in ("center_m", "radius_m", "side"))
    if center is None or radius is None or side is None:
        return []
    names = [_label(given.value("pulleys", i, "name"), i) for i in range(len(radius))]
    sides = np.array([1.0 if entry == "inside" else -1.0 for entry in side])
    return layout_faults(names, np.array(center, float), np.array(radius, float), sides)


def _label(name: str | None, i: int) -> str:
    return name if name is not None else f"pulley {i + 1}"
