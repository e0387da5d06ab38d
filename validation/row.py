"""One comparison, as a case returns it.

Depends on: nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Row:
    """One comparison, as `compute()` of a case returns it (a plain tuple will do).

    Parameters
    ----------
    quantity : str
        What is compared; unique within the case.
    got, expected : float or array_like
        Ours and the reference.
    x : array_like, optional
        Abscissa of arrays, for pictures.
    x_label, y_label : str, optional
        What the axes of that picture show, with units. Default: the number of the entry, and
        "value".
    note : str, optional
        Anything a reader may want beside the numbers, such as times taken. It is not compared.
    """

    quantity: str
    got: Any
    expected: Any
    x: Any = None
    x_label: str = ""
    y_label: str = ""
    note: str = ""


def gathered(rows: Iterable[Row]) -> list[Row]:
    """One row per quantity: the values of rows that share a name, one after the other.

    Labels are those of the first; abscissae must be given by all of them or by none.
    """
    import numpy as np  # late: this module is imported before any case is

    by_name: dict[str, list[Row]] = {}
    for row in rows:
        by_name.setdefault(row.quantity, []).append(row)

    def joined(same: list[Row], field: str) -> Any:
        parts = [getattr(row, field) for row in same]
        return None if parts[0] is None else np.concatenate([np.ravel(part) for part in parts])

    return [
        replace(same[0], **{key: joined(same, key) for key in ("got", "expected", "x")})
        for same in by_name.values()
    ]
