"""What is known before integrating: lines about a survey.

Depends on: friction, errors; metrics and problem for their types only; cli.text.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from beltsim.cli.text import listed, short, table
from beltsim.errors import short_name
from beltsim.friction import Coulomb

if TYPE_CHECKING:
    from beltsim.metrics import Survey
    from beltsim.metrics.survey import SurveyedMode
    from beltsim.problem import FrictionProblem


#: Orders of the excitation that are printed, and how close to a frequency one is marked.
MOST_ORDERS, CLOSE = 6, 0.05


def operating_lines(found: Survey, problem: FrictionProblem) -> list[str]:
    """Speed, forcing period, friction and the torque that locks the arm."""
    assert problem.scales is not None
    period_ms = 1e3 * problem.period * problem.scales.time_s
    turn = 6e-3 * found.rpm * period_ms
    pairs = [
        ("crank speed", f"{found.rpm:.1f} rpm (firing frequency Omega = {short(found.Omega, 5)})"),
        ("belt speed", f"{found.belt_speed_m_s:.2f} m/s"),
        *zip(["excitation", *[""] * len(found.orders)], _excitation(found), strict=False),
        ("forcing period", f"{period_ms:.3f} ms ({turn:.4g} deg of crank)"),
    ]
    law, unit = problem.friction, problem.scales.torque_N_m
    if law is not None and found.Q_cr is not None:
        pairs.append(("arm friction", f"{_torque(law.Q_m, unit, 'Q_m')}"))
        static = law.Q_s if isinstance(law, Coulomb) else None
        if static is not None and static > law.Q_m:
            pairs.append(("static", _torque(static, unit, "Q_s")))
        pairs.append(("arm locks from", _torque(found.Q_cr, unit, "Q_cr")))
    return listed(pairs)


def _excitation(found: Survey) -> list[str]:
    """Orders of the crank's motion with the amplitude of its speed, of its angle, and the phase."""
    words = [
        f"order {order.order:g}: {100.0 * order.order * order.angle_amplitude_rad:.3g} % of speed "
        f"({np.degrees(order.angle_amplitude_rad):.3g} deg)"
        + (f" at {np.degrees(order.phase_rad):.4g} deg" if order.phase_rad else "")
        for order in found.orders[:MOST_ORDERS]
    ]
    if len(found.orders) > MOST_ORDERS:
        words.append(f"and {len(found.orders) - MOST_ORDERS} more")
    words[-1] += " (default: the file gives none)" * found.default_excitation
    return words


def _torque(value: float, unit: float, symbol: str) -> str:
    return f"{short(value * unit)} N m ({symbol} = {short(value)})"


def rest_lines(found: Survey) -> list[str]:
    """Rest angle of the arm and torque of its spring there."""
    if found.arm_angle_rad is None or found.spring_torque_N_m is None:
        return ["  fixed centres: no tensioner"]
    angle = f"{np.degrees(found.arm_angle_rad):+.3f} deg from the reference, counter-clockwise"
    torque = f"{short(found.spring_torque_N_m)} N m"
    if found.spring_windup_deg is not None:
        torque += f" (wound up by {found.spring_windup_deg:.1f} deg in the reference state)"
    return listed([("arm at rest", angle), ("spring torque", torque)])


def span_lines(found: Survey) -> list[str]:
    """Steady tensions; without rho c^2 is what holds the span straight and loads the hubs."""
    rows = [
        [
            span.name,
            f"{1e3 * span.length_m:.1f}",
            f"{span.tension_N:.1f}",
            f"{span.tension_without_centrifugal_N:.1f}",
        ]
        for span in found.spans
    ]
    return table(["span", "length mm", "tension N", "less rho c^2"], rows)


def pulley_lines(found: Survey) -> list[str]:
    """Angles of contact and steady hub loads."""
    rows = [
        [
            short_name(pulley.name),
            f"{pulley.wrap_deg:.1f}",
            f"{pulley.hub_load_N:.1f}",
            f"{pulley.hub_load_x_N:.1f}",
            f"{pulley.hub_load_y_N:.1f}",
        ]
        for pulley in found.pulleys
    ]
    return table(["pulley", "wrap deg", "hub load N", "x", "y"], rows)


def frequency_lines(found: Survey, count: int) -> list[str]:
    """Natural frequencies with the arm free and locked, side by side, with what moves most."""
    titles = ["mode", "free Hz", "Omega", "moves"]
    if found.locked:
        titles += ["locked Hz", "Omega", "moves"]
    rows = []
    for k, mode in enumerate(found.free[:count]):
        row = [str(k + 1), f"{mode.frequency_Hz:.2f}", f"{mode.Omega:.4f}", _moves(mode)]
        if found.locked:
            other = found.locked[k] if k < len(found.locked) else None
            row += (
                [f"{other.frequency_Hz:.2f}", f"{other.Omega:.4f}", _moves(other)]
                if other
                else [""] * 3
            )
        rows.append(row)
    return table(titles, rows)


def _moves(mode: SurveyedMode) -> str:
    kind, _, name = mode.kind.dominant.partition(" ")
    return f"{kind} {short_name(name, 12)}" if name else kind


def meeting_lines(found: Survey) -> list[str]:
    """Orders of the excitation that lie close to a listed frequency at this speed, or nothing."""
    rows = []
    for order in found.orders:
        hertz = order.order * found.rpm / 60.0
        for words, modes in (("free", found.free), ("locked", found.locked)):
            rows += [
                [
                    f"order {order.order:g}",
                    *(f"{hertz:.2f}", f"{k} {words}", f"{mode.frequency_Hz:.2f}"),
                    *(f"{100.0 * (mode.frequency_Hz / hertz - 1.0):+.1f} %", _moves(mode)),
                ]
                for k, mode in enumerate(modes, start=1)
                if order.angle_amplitude_rad and abs(mode.frequency_Hz - hertz) <= CLOSE * hertz
            ]
    if not rows:
        return []
    head = f"Near resonance: orders within {CLOSE:.0%} of a frequency at this speed"
    return ["", head, *table(["excited", "at Hz", "mode", "at Hz", "off by", "moves"], rows)]


def warning_lines(warnings: tuple[str, ...]) -> list[str]:
    """One line per warning, with a heading, or nothing."""
    return ["", "Warnings", *(f"  {text}" for text in warnings)] if warnings else []
