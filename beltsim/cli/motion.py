"""What a run showed: lines about its last period.

Depends on: response and metrics for their types only; cli.text.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from beltsim.cli.text import listed, short, table

if TYPE_CHECKING:
    from beltsim.metrics import Survey
    from beltsim.problem import Scales
    from beltsim.response import Response

#: Events listed at most; the result file has them all.
MOST_EVENTS = 40
#: Share of the period residual below which what is left of the slowest mode cannot explain it.
SETTLED = 1e-3


def event_lines(response: Response, rpm: float) -> list[str]:
    """Table of the events of the window: when, what, where and the torque on both sides."""
    scales, events = _scales(response), response.events
    start, end = response.window
    chosen = np.flatnonzero((events.t > start) & (events.t <= end))
    if response.problem.joint is None:
        return []
    head = f"Events of the last {_window_words(response)}"
    if len(chosen) == 0:
        state = "sticks" if response.stick_fraction > 0.5 else "slips"
        return ["", head, f"  none: the arm {state} all the time"]
    in_ms, in_N_m = 1e3 * scales.time_s, scales.torque_N_m
    in_deg = float(np.degrees(scales.coordinates[response.problem.joint]))
    turn = 6e-3 * rpm * in_ms * response.problem.period  # the crank's, in a forcing period
    rows = [
        [
            str(events.kind[i]),
            f"{events.t[i] * in_ms:.4f}",
            f"{round(events.t[i] * in_ms * 6e-3 * rpm % turn, 2) % turn:.2f}",
            f"{events.position[i] * in_deg:+.4f}",
            f"{events.torque_before[i] * in_N_m:+.3f}",
            f"{events.torque_after[i] * in_N_m:+.3f}",
            f"{events.margin[i]:.1e}",
            str(events.quality[i]).replace("_", " "),
        ]
        for i in chosen[:MOST_EVENTS]
    ]
    titles = [
        "event",
        "time ms",
        "crank deg",
        "arm deg",
        "N m before",
        "after",
        "margin",
        "quality",
    ]
    remark = f"arm angle from its rest position, crank angle within {turn:.4g} deg"
    lines = ["", f"{head} ({remark})", *table(titles, rows)]
    if len(chosen) > MOST_EVENTS:
        lines.append(f"  ... and {len(chosen) - MOST_EVENTS} more, in the result file")
    return lines


def reversal_words(response: Response) -> str:
    """nu, and what it counts where several orders make several turns plain to and fro."""
    forcing, nu = response.problem.forcing, f"nu = {short(response.velocity_reversals)}"
    orders = np.flatnonzero(np.any(forcing.coefficients[1:] != 0.0, axis=1)) + 1
    if orders.tolist() in ([], [1]):
        return nu
    return (
        f"{nu} (turns beyond one to and fro per forcing period; orders up to {orders[-1]} times it)"
    )


def figure_lines(response: Response, found: Survey, periods: float) -> list[str]:
    """Stops, reversals, sticking, losses, balance, and how periodic the motion is."""
    pairs = []
    if response.problem.joint is not None:
        pairs = [
            ("stops", f"{short(response.stops_per_period)} per period"),
            ("velocity reversals", reversal_words(response)),
            ("sticking", f"{100.0 * response.stick_fraction:.2f} % of the time"),
            ("friction loss", loss_words(response)),
        ]
    pairs.append(("energy balance", f"closed to {response.energy_balance_residual:.1e}"))
    pairs.append(("period residual", _residual_words(response, found, periods)))
    pairs.append(("slowest mode", _decay_words(found, periods)))
    return ["", f"Last {_window_words(response)}", *listed(pairs)]


def range_lines(response: Response) -> list[str]:
    """Lowest and highest value of every observable over the window; the arm's, from its rest."""
    start = response.window[0]
    inside = response.t >= start * (1.0 - 1e-12)
    if not inside.any():
        return []
    rows = []
    for seen in response.problem.observables:
        name, rest, (scale, unit) = seen.name, 0.0, seen.shown
        if seen.unit == "rad":  # with the zero of the table of events
            name, rest = f"{name} from rest", float(seen.cos[0])
        values = (response.observe(seen.name)[inside] - rest) * scale
        low, high = float(values.min()), float(values.max())
        digits = 3 if seen.unit == "rad" else 1
        row = [name, *(f"{value:.{digits}f}" for value in (low, high, high - low)), unit.strip()]
        rows.append(row)
    return ["", *table(["over it", "lowest", "highest", "range", ""], rows)] if rows else []


def _scales(response: Response) -> Scales:
    assert response.problem.scales is not None  # drives have them
    return response.problem.scales


def _window_words(response: Response) -> str:
    """The window in words: "period", or how much of one there was."""
    start, end = response.window
    share = (end - start) / response.problem.period
    return "period" if abs(share - 1.0) < 1e-9 else f"{short(share)} periods"


def loss_words(response: Response) -> str:
    """Friction loss of the window as energy and as mean power."""
    scales, joint = _scales(response), response.problem.joint
    assert joint is not None
    joule = response.dissipated_energy * scales.torque_N_m * float(scales.coordinates[joint])
    seconds = (response.window[1] - response.window[0]) * scales.time_s
    return f"{short(joule)} J = {short(joule / seconds if seconds else 0.0)} W"


def _residual_words(response: Response, found: Survey, periods: float) -> str:
    if response.period_residual is None:
        return "not known: the run is shorter than a period"
    verdict = "periodic"
    if not response.periodic:
        decay = min(found.decay_free, found.decay_locked or math.inf)
        verdict = "not yet periodic: run longer (--periods)"
        if math.exp(-decay * periods) < SETTLED * response.period_residual:
            verdict = "does not settle: another period, or irregular motion"
    return f"{response.period_residual:.1e} of the state ({verdict})"


def _decay_words(found: Survey, periods: float) -> str:
    """What is left of the slowest mode, exp(-decay x) after x periods."""
    decays = [("arm free", found.decay_free)]
    if found.decay_locked is not None:
        decays.append(("arm locked", found.decay_locked))
    parts = [
        f"{short(100.0 * float(np.exp(-decay * periods)), 2)} % ({name})" for name, decay in decays
    ]
    return f"{', '.join(parts)} left after {short(periods)} periods"
