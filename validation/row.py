"""One comparison, as a case returns it.

Depends on: nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
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
    """

    quantity: str
    got: Any
    expected: Any
    x: Any = None


def gathered(rows: Iterable[Row]) -> list[Row]:
    """One row per quantity: the values of rows that share a name, one after the other."""
    import numpy as np  # late: this module is imported before any case is

    by_name: dict[str, list[Row]] = {}
    for row in rows:
        by_name.setdefault(row.quantity, []).append(row)
    return [
        Row(
            name,
            np.concatenate([np.ravel(row.got) for row in same]),
            np.concatenate([np.ravel(row.expected) for row in same]),
        )
        for name, same in by_name.items()
    ]
