"""How mistakes in a drive are worded: paths, values, and what a key takes.

Depends on: nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


class Words(str):
    """Text that shows without quotes where a mistake shows a value.

    Examples
    --------
    >>> Words("missing")
    missing
    """

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


MISSING = Words("missing")


def path_words(location: Sequence[str | int]) -> str:
    """Path of an entry as a user would write it.

    Examples
    --------
    >>> path_words(["pulleys", 2, "radius_m"])
    'pulleys[2].radius_m'
    """
    words = ""
    for part in location:
        if isinstance(part, int):
            words += f"[{part}]"
        else:
            plain = part.isprintable() and len(part) <= 60
            words += ("." if words else "") + (part if plain else f"{ascii(part)[:60]}")
    return words


def shown(value: Any) -> Any:
    """`value`, or words in its place where its own text cannot or should not be made.

    A hexadecimal integer of a million digits and a table nested ten thousand deep are valid
    input to a parser, but have no printable form.
    """
    if isinstance(value, int) and value.bit_length() > 256:
        return Words(f"an integer of {value.bit_length()} bits")
    try:
        repr(value)
    except (ValueError, RecursionError):
        return Words(f"a {type(value).__name__} too large to show")
    return value


def number_words(
    what: str,
    unit: str = "",
    *,
    gt: float | None = None,
    ge: float | None = None,
    lt: float | None = None,
    le: float | None = None,
) -> str:
    """What a number may be, its meaning and its unit, in words.

    Examples
    --------
    >>> number_words("pitch radius", "m", ge=0.001, le=2.0)
    'a number from 0.001 to 2 (pitch radius in m)'
    """
    low = f"above {gt:g}" if gt is not None else f"from {ge:g}" if ge is not None else ""
    high = f"below {lt:g}" if lt is not None else f"to {le:g}" if le is not None else ""
    if ge is not None and le is None and lt is None:
        low = f"of at least {ge:g}"
    joint = " and " if low.startswith("above") or high.startswith("below") else " "
    high = f"up to {le:g}" if le is not None and gt is not None else high
    limits = joint.join(part for part in (low, high) if part)
    meaning = f"{what} in {unit}" if unit else what
    return f"a number {limits} ({meaning})".replace("  ", " ")
