"""Comparing what beltsim gave with what it should be, and the verdict.

Metrics, for `got` g and `expected` e (numbers, or arrays of one shape for `max` and `rms`):

* ``value``    abs(g - e)
* ``relative`` abs(g - e) / abs(e)
* ``max``      max abs(g - e)
* ``rms``      rms(g - e) / rms(e)
* ``count``    abs(g - e) of whole numbers
* ``at_most``  max(0, g - e)

A row agrees when its error is at most its tolerance. A row that is recorded as explained must
still disagree, and by the recorded number: anything else is flagged and never passes silently.

Depends on: case, row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from validation.case import Case, Explained
from validation.row import Row

#: From best to worst; a case is as good as its worst row.
VERDICTS = ("agrees", "disagrees-explained", "skipped", "disagrees", "failed")


@dataclass(frozen=True)
class Compared:
    """One row with its error and verdict. Arrays show their worst entry in `got`, `expected`."""

    quantity: str
    got: float
    expected: float
    error: float
    tolerance: float
    metric: str
    verdict: str
    flag: str = ""
    entries: int = 1
    curves: dict[str, list[float]] = field(default_factory=dict)
    x_label: str = ""
    y_label: str = ""
    note: str = ""


@dataclass(frozen=True)
class Result:
    """A case that was run: its rows and verdict, or why it failed or was skipped (`failure`)."""

    case: Case
    verdict: str
    rows: tuple[Compared, ...]
    seconds: float
    failure: str = ""
    details: str = ""

    @property
    def flags(self) -> tuple[str, ...]:
        """What a reader must know beside the verdicts."""
        return tuple(f"{row.quantity}: {row.flag}" for row in self.rows if row.flag)

    @property
    def passed(self) -> bool:
        """Whether the case agrees or disagrees exactly as explained, or needs what is not here."""
        return self.verdict in ("agrees", "disagrees-explained", "skipped") and not self.flags


def failed(case: Case, reason: str, seconds: float = 0.0, details: str = "") -> Result:
    """The result of a case that could not be compared."""
    return Result(case, "failed", (), seconds, reason, details)


def skipped(case: Case) -> Result:
    """The result of a case whose peer is not installed."""
    reason = f"{case.needs} is not installed: pip install beltsim[peers]"
    return Result(case, "skipped", (), 0.0, reason)


def compare(case: Case, rows: Sequence[Any], seconds: float = 0.0) -> Result:
    """Compare the rows of `compute()` with their references."""
    try:
        named = [row if isinstance(row, Row) else Row(*row) for row in rows]
        _check_names(case, [row.quantity for row in named])
        compared = tuple(_compare_row(case, row) for row in named)
    except (TypeError, ValueError) as error:
        return failed(case, f"rows cannot be compared: {error}", seconds)
    verdict = max((row.verdict for row in compared), key=VERDICTS.index)
    return Result(case, verdict, compared, seconds)


def _check_names(case: Case, names: Sequence[str]) -> None:
    if not names:
        raise ValueError("compute() returned no rows, so nothing was compared")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"more than one row is named {', '.join(map(repr, twice))}")
    settings = [e.quantity for e in case.explained] + [o.quantity for o in case.overrides]
    for name in settings:
        if name not in names:
            raise ValueError(f"case.toml names {name!r}, but compute() gives no such row")


def _compare_row(case: Case, row: Row) -> Compared:
    override = next((o for o in case.overrides if o.quantity == row.quantity), None)
    metric = override.metric if override else case.metric
    tolerance = override.tolerance if override else case.tolerance
    got, expected = np.asarray(row.got, float), np.asarray(row.expected, float)
    if got.shape != expected.shape:
        raise ValueError(f"{row.quantity!r}: got {got.shape}, expected {expected.shape}")
    if not np.isfinite(expected).all():
        raise ValueError(f"{row.quantity!r}: the reference is not finite ({expected})")
    if got.ndim > 0 and metric not in ("max", "rms"):
        raise ValueError(f"{row.quantity!r}: metric {metric!r} compares single numbers")
    error = _error(metric, got, expected)
    agrees = bool(error <= tolerance)  # NaN is no agreement
    worst = _worst(got, expected)
    one_got, one_expected = float(got.flat[worst]), float(expected.flat[worst])
    known = next((e for e in case.explained if e.quantity == row.quantity), None)
    verdict, flag = _verdict(agrees, one_got, known)
    curves = {}
    if got.ndim:
        curves = {"got": got.ravel().tolist(), "expected": expected.ravel().tolist()}
        if row.x is not None:
            x = np.asarray(row.x, float)
            if x.size != got.size or not np.isfinite(x).all():
                raise ValueError(f"{row.quantity!r}: x must be {got.size} finite numbers")
            curves["x"] = x.ravel().tolist()
    return Compared(
        row.quantity,
        one_got,
        one_expected,
        error,
        tolerance,
        metric,
        verdict,
        flag,
        int(got.size),
        curves,
        row.x_label,
        row.y_label,
        row.note,
    )


def _error(metric: str, got: np.ndarray, expected: np.ndarray) -> float:
    if got.size == 0:
        raise ValueError("an empty array compares nothing")
    gap = got - expected
    if metric == "at_most":
        return float(np.maximum(gap, 0.0))
    if metric == "relative":
        if expected == 0.0:
            raise ValueError("metric 'relative' needs a reference that is not zero")
        return float(abs(gap / expected))
    if metric == "rms":
        size = float(np.sqrt(np.mean(expected**2)))
        if size == 0.0:
            raise ValueError("metric 'rms' needs a reference that is not zero")
        return float(np.sqrt(np.mean(gap**2))) / size
    if metric == "count" and not (float(expected).is_integer() and float(got).is_integer()):
        raise ValueError(f"metric 'count' needs whole numbers, not {got} and {expected}")
    return float(np.abs(gap).max())


def _worst(got: np.ndarray, expected: np.ndarray) -> int:
    gap = np.abs(got - expected)
    return int(np.argmax(np.where(np.isnan(gap), np.inf, gap)))


def _verdict(agrees: bool, got: float, known: Explained | None) -> tuple[str, str]:
    """Verdict of a row, and a flag when a recorded explanation no longer fits."""
    if known is None:
        return ("agrees" if agrees else "disagrees"), ""
    if agrees:
        return "agrees", f"recorded as disagreeing ({known.got:g}), now agrees ({got:g})"
    if not abs(got - known.got) <= known.within:
        flag = f"explained for {known.got:g} +- {known.within:g}, now {got:g}"
        return "disagrees", flag
    return "disagrees-explained", ""
