"""One comparison, as a case returns it.

Depends on: nothing.
"""

from __future__ import annotations

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
