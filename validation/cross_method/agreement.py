"""Rows that compare a transient of beltsim with another run of the same problem.

Depends on: beltsim.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from beltsim import transient
from validation.row import Row

#: Events that pass their threshold at least this fast are well-conditioned (see exact_modal.Run).
WELL_CONDITIONED = 0.05
TIME = "time in forcing periods"


def rows(problem: Any, periods: int, others: dict[str, Any], rtol: float) -> list[Row]:
    """Events and end state of `problem` from rest against other runs (t, kind, final_state).

    Times of well-conditioned events are compared in forcing periods. Where the other run knows
    how fast an event passes its threshold, every time error is also turned into the error of
    velocity or reaction that it amounts to, over their largest value. States are in units of
    their largest coordinate and velocity. When the numbers of events differ only that is a row:
    an event more or less is not a matter of tolerance.
    """
    settings = transient.Settings(rtol=rtol, keep="events")
    run = transient.integrate(problem, float(periods), None, settings)
    found = []
    for name, other in others.items():
        where = f"{name}, rtol {rtol:.0e}"
        kinds = [str(kind) for kind in run.events.kind]
        found.append(Row(f"events that differ, {where}", different(kinds, other.kind), 0))
        if len(kinds) == len(other.kind):
            found += _times(run.events.t, other, problem.forcing.Omega, where)
        q, q_dot = np.split(run.final_state, 2)
        other_q, other_q_dot = np.split(other.final_state, 2)
        size = np.abs(other_q).max(), np.abs(other_q_dot).max()
        ends = {"coordinates": (q, other_q), "velocities": (q_dot, other_q_dot)}
        for (what, (ours, theirs)), largest in zip(ends.items(), size, strict=True):
            found.append(
                Row(
                    f"{what} at the end, {where}",
                    ours / largest,
                    theirs / largest,
                    x_label="number of the coordinate",
                    y_label=f"{what} over the largest",
                )
            )
    return found


def _times(t: np.ndarray, other: Any, Omega: float, where: str) -> list[Row]:
    T = 2.0 * np.pi / Omega
    axes = {"x": other.t / T, "x_label": TIME}
    rate = getattr(other, "rate", None)
    if rate is None:
        return [Row(f"event times, {where}", t / T, other.t / T, **axes, y_label=TIME)]
    good = rate >= WELL_CONDITIONED
    amounts = (t - other.t) * Omega * rate
    return [
        Row(
            f"event times, {where}",
            t[good] / T,
            other.t[good] / T,
            x=other.t[good] / T,
            x_label=TIME,
            y_label=TIME,
        ),
        Row(
            f"thresholds at the events, {where}",
            amounts,
            np.zeros(len(t)),
            **axes,
            y_label="velocity or reaction over its largest",
        ),
    ]


def different(ours: Sequence[str], theirs: Sequence[str]) -> int:
    """Events of one sequence that are not in their place in the other."""
    same = sum(a == b for a, b in zip(ours, theirs, strict=False))
    return max(len(ours), len(theirs)) - same
