"""When the arm slips, sticks and reverses over one period, as its friction torque rises.

One column per torque: the period runs upwards, the colour is the mode, a dot is a reversal without
a stop.

Depends on: response, friction, checks; plots.style.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from beltsim.checks import FloatArray
from beltsim.friction import Coulomb
from beltsim.plots.style import BLUE, INK, ORANGE, SHADE, new_figure, plain, plain_axes
from beltsim.response import phases

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from beltsim.response import Response

_COLOURS = {
    "slip+": (ORANGE, "slips, +"),
    "slip-": (BLUE, "slips, \N{MINUS SIGN}"),
    "stick": (SHADE, "sticks"),
}


def event_phases(
    orbits: Sequence[Response], Q_m_cr: float | None = None, title: str | None = None
) -> Figure:
    """Phase diagram of periodic `orbits` over their friction torque.

    Parameters
    ----------
    orbits : sequence of Response
        One period each, torques rising.
    Q_m_cr : float, optional
        Critical torque, in the problems' unit; drawn as a line.
    title : str, optional

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = new_figure(7.5, 4.5)
    axes = figure.add_subplot()
    plain_axes(axes)
    axes.grid(False)
    scales = orbits[0].problem.scales if orbits else None
    unit, factor = ("N m", scales.torque_N_m) if scales is not None else ("problem units", 1.0)
    torques = np.array([orbit.problem.friction.Q_m for orbit in orbits if orbit.problem.friction])
    torques = torques * factor
    for orbit, torque, width in zip(orbits, torques, _widths(torques), strict=True):
        _column(axes, orbit, float(torque), float(width))
    if Q_m_cr is not None:
        laws = [orbit.problem.friction for orbit in orbits]
        static = any(isinstance(law, Coulomb) and (law.Q_s or 0.0) > law.Q_m for law in laws)
        said = "can stay locked from" if static else "locked from"
        axes.axvline(Q_m_cr * factor, color=INK, linestyle="--", linewidth=1.0, label=said)
    axes.set_xlabel(f"kinetic friction torque ({unit})")
    axes.set_ylabel("time over period of the motion")
    axes.set_ylim(0.0, 1.0)
    for colour, name in _COLOURS.values():
        axes.fill_between([], [], color=colour, label=name)
    if any((orbit.events.kind == "reverse").any() for orbit in orbits):
        axes.plot([], [], ".", color=INK, label="reverses")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=3, frameon=False)
    axes.set_title(plain(title or "Phases of the arm"), loc="left")
    return figure


def _widths(torques: FloatArray) -> FloatArray:
    """Column widths that leave no gap between evenly spaced torques."""
    if len(torques) < 2:
        return np.ones(len(torques))
    return np.gradient(torques)


def _column(axes: Any, orbit: Response, torque: float, width: float) -> None:
    start, end = orbit.window
    joint = orbit.problem.joint or 0
    ends = (float(orbit.initial_state[joint]), float(orbit.final_state[joint]))
    for phase in phases(orbit.events, orbit.initial_mode or "stick", start, end, ends):
        low, high = phase.start / (end - start), phase.end / (end - start)
        axes.bar(torque, high - low, width, bottom=low, color=_COLOURS[phase.mode][0], linewidth=0)
    turns = orbit.events.t[orbit.events.kind == "reverse"] / (end - start)
    axes.plot(np.full(len(turns), torque), turns, ".", color=INK, markersize=3)
