"""What is known before integrating: lines about a survey.

Depends on: friction; metrics and problem for their types only; cli.text.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from beltsim.cli.text import listed, short, table
from beltsim.friction import Coulomb

if TYPE_CHECKING:
    from beltsim.metrics import Survey
    from beltsim.problem import FrictionProblem


def operating_lines(found: Survey, problem: FrictionProblem) -> list[str]:
    """Speed, forcing period, friction and the torque that locks the arm."""
    assert problem.scales is not None
    period_ms = 1e3 * problem.period * problem.scales.time_s
    turn = 6e-3 * found.rpm * period_ms
    pairs = [
        ("crank speed", f"{found.rpm:.1f} rpm (Omega = {short(found.Omega, 5)})"),
        ("belt speed", f"{found.belt_speed_m_s:.2f} m/s"),
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


def _torque(value: float, unit: float, symbol: str) -> str:
    return f"{short(value * unit)} N m ({symbol} = {short(value)})"


def rest_lines(found: Survey) -> list[str]:
    """Rest angle of the arm and torque of its spring there."""
    if found.arm_angle_rad is None or found.spring_torque_N_m is None:
        return ["  fixed centres: no tensioner"]
    angle = f"{np.degrees(found.arm_angle_rad):+.3f} deg from the reference, counter-clockwise"
    return listed(
        [("arm at rest", angle), ("spring torque", f"{short(found.spring_torque_N_m)} N m")]
    )


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
            pulley.name,
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
        row = [str(k + 1), f"{mode.frequency_Hz:.2f}", f"{mode.Omega:.4f}", mode.kind.dominant]
        if found.locked:
            other = found.locked[k] if k < len(found.locked) else None
            row += (
                [f"{other.frequency_Hz:.2f}", f"{other.Omega:.4f}", other.kind.dominant]
                if other
                else [""] * 3
            )
        rows.append(row)
    return table(titles, rows)


def warning_lines(warnings: tuple[str, ...]) -> list[str]:
    """One line per warning, with a heading, or nothing."""
    return ["", "Warnings", *(f"  {text}" for text in warnings)] if warnings else []
