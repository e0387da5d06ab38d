"""Plain aligned text: tables and lists of labelled values.

Depends on: nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence


def say(*lines: str) -> None:
    """Lines on standard output."""
    sys.stdout.write("".join(f"{line}\n" for line in lines))


def complain(text: str) -> None:
    """Each line of `text` on standard error, behind the name of the program."""
    for line in text.splitlines():
        sys.stderr.write(f"beltsim: {line}\n")


def table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    r"""Lines of a table: the first column to the left, the others to the right.

    Examples
    --------
    >>> print(*table(["span", "N"], [["1", "376.7"], ["10", "9.1"]]), sep="\n")
      span      N
      1     376.7
      10      9.1
    """
    cells = [list(titles), *map(list, rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(titles))]
    lines = []
    for row in cells:
        first = row[0].ljust(widths[0])
        rest = (cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))
        lines.append("  " + "  ".join([first, *rest]).rstrip())
    return lines


def listed(pairs: Iterable[tuple[str, str]]) -> list[str]:
    r"""Lines of labels and values, the values below each other.

    Examples
    --------
    >>> print(*listed([("speed", "3089 rpm"), ("stops", "2")]), sep="\n")
      speed  3089 rpm
      stops  2
    """
    found = list(pairs)
    width = max((len(label) for label, _ in found), default=0)
    return [f"  {label.ljust(width)}  {value}" for label, value in found]


def short(value: float, digits: int = 4) -> str:
    """`value` with `digits` significant digits; no exponent between 1e-4 and 1e6.

    Examples
    --------
    >>> short(3088.512), short(0.05), short(14.55), short(2.5e-9)
    ('3089', '0.05', '14.55', '2.5e-09')
    """
    if value and not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits}g}"
    digits_left = len(f"{abs(value):.0f}")
    return f"{value:.0f}" if digits_left >= digits else f"{value:.{digits}g}"
