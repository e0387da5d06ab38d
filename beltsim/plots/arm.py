r"""Arm velocity and friction torque over the last periods (as Fig. 9 of Zhu & Parker 2008).

Sticking phases are shaded, located events marked, the levels :math:`\pm Q_m` (and
:math:`\pm Q_s`, where it is larger) drawn. The curves pass through the events themselves, not
only through the samples, so that jumps of the torque stand upright.

Depends on: response, friction, errors; plots.style.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from beltsim.checks import FloatArray
from beltsim.errors import InvalidProblemError
from beltsim.friction import Coulomb
from beltsim.plots.style import (
    BLUE,
    GREY,
    INK,
    SHADE,
    VERMILLION,
    TimeAxis,
    add_crank_angle,
    new_figure,
    plain,
    plain_axes,
    time_axis,
)
from beltsim.response import phases

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from beltsim.response import Response

#: Marker and name in the legend of each kind of event.
MARKERS = {
    "stick": ("o", "stops and sticks"),
    "reverse": ("D", "reverses"),
    "slip+": ("^", "slips, +"),
    "slip-": ("v", "slips, \N{MINUS SIGN}"),
}


class _Curves(NamedTuple):
    """Velocity and torque of the joint with the events put in, in the units shown."""

    t: FloatArray
    velocity: FloatArray
    torque: FloatArray
    torque_scale: float
    velocity_unit: str
    torque_unit: str


def _series(response: Response) -> str:
    """For the title: a truncated series ripples where the joint rests."""
    if response.statistics.get("solver") != "harmonic_balance":
        return ""
    return f" (harmonic balance, R = {response.statistics['R']})"


def arm_motion(
    response: Response,
    crank_rpm: float | None = None,
    title: str | None = None,
    periods: float = 2.0,
) -> Figure:
    """Velocity of the joint and its friction torque over the last `periods` sampled.

    Parameters
    ----------
    response : Response
        With a joint and with samples.
    crank_rpm : float, optional
        Crank speed; named in the title and used for a second scale in degrees.
    title : str, optional
        Replaces "Tensioner arm", or the joint's label where the problem is no belt drive.
    periods : float
        Forcing periods to show; fewer where fewer were sampled.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidProblemError
        When the problem has no joint or the response no samples.
    """
    joint, law = response.problem.joint, response.problem.friction
    if joint is None or law is None or response.initial_mode is None:
        raise InvalidProblemError("nothing to draw: the problem has no friction joint")
    axis = time_axis(response, periods)
    curves = _curves(response, axis, joint)
    figure = new_figure(8.0, 5.6)
    upper, lower = figure.subplots(2, 1, sharex=True)
    for axes in (upper, lower):
        plain_axes(axes)
        _shade_sticking(axes, response, axis, joint)
        axes.axhline(0.0, color=INK, linewidth=0.7)
    upper.plot(curves.t, curves.velocity, color=BLUE, linewidth=1.7)
    label = (response.problem.labels or ())[joint]
    arm = label == "theta_t"  # as an assembled drive calls it
    velocity = "arm velocity" if arm else f"velocity of {label}"
    upper.set_ylabel(plain(f"{velocity} ({curves.velocity_unit})"), color=BLUE)
    lower.plot(curves.t, curves.torque, color=VERMILLION, linewidth=1.7)
    lower.set_ylabel(f"friction {'torque ' if arm else ''}({curves.torque_unit})", color=VERMILLION)
    static = law.Q_s if isinstance(law, Coulomb) and law.Q_s is not None else law.Q_m
    two = static > law.Q_m
    _draw_levels(lower, law.Q_m * curves.torque_scale, "Q_m", "--", -1.0 if two else 0.0)
    if two:
        _draw_levels(lower, static * curves.torque_scale, "Q_s", ":", 1.0)
    _mark_events(upper, lower, response, axis, curves.torque_scale)
    lower.set_xlabel(axis.label)
    lower.set_xlim(0.0, float(axis.shown(axis.end)))
    add_crank_angle(upper, axis, crank_rpm)
    speed = f" at {crank_rpm:.0f} rpm" if crank_rpm is not None else ""
    figure.suptitle(
        plain(title or f"{'Tensioner arm' if arm else f'Joint {label}'}{speed}{_series(response)}"),
        fontsize=12,
    )
    _add_legend(figure, upper)
    return figure


def _curves(response: Response, axis: TimeAxis, joint: int) -> _Curves:
    """The samples of the joint with every event of the stretch put among them."""
    events, scales = response.events, response.problem.scales
    t = response.t[axis.chosen]
    velocity, torque = response.q_dot[axis.chosen, joint], response.friction_torque[axis.chosen]
    if isinstance(response.problem.friction, Coulomb):  # v = 0 at every event of this law
        inside = np.flatnonzero((events.t > axis.start) & (events.t < axis.end))
        place = np.repeat(np.searchsorted(t, events.t[inside]), 2)
        both = np.column_stack([events.torque_before, events.torque_after])[inside].ravel()
        t = np.insert(t, place, np.repeat(events.t[inside], 2))
        velocity, torque = np.insert(velocity, place, 0.0), np.insert(torque, place, both)
    if scales is None:
        return _Curves(axis.shown(t), velocity, torque, 1.0, "problem units", "problem units")
    rate = scales.coordinates[joint] / scales.time_s
    unit = f"{scales.units[joint]}/s"
    torque_scale = scales.torque_N_m
    return _Curves(axis.shown(t), velocity * rate, torque * torque_scale, torque_scale, unit, "N m")


def _shade_sticking(axes: Any, response: Response, axis: TimeAxis, joint: int) -> None:
    ends = (float(response.q[axis.chosen][0, joint]), float(response.q[-1, joint]))
    assert response.initial_mode is not None
    found = phases(response.events, response.initial_mode, axis.start, axis.end, ends)
    for phase in found:
        if phase.mode == "stick":
            axes.axvspan(*axis.shown([phase.start, phase.end]), color=SHADE, linewidth=0.0)


def _draw_levels(axes: Any, level: float, name: str, linestyle: str, outward: float) -> None:
    """Lines at +-level; `outward` (1, 0 or -1) moves their names apart from their neighbours."""
    for sign, word in ((1.0, "+"), (-1.0, "\N{MINUS SIGN}")):
        axes.axhline(sign * level, color=GREY, linewidth=0.9, linestyle=linestyle)
        axes.annotate(
            f"{word}${name}$",
            (1.0, sign * level),
            xycoords=("axes fraction", "data"),
            xytext=(5, 6.5 * sign * outward),
            textcoords="offset points",
            va="center",
            color=INK,
        )


def _mark_events(upper: Any, lower: Any, response: Response, axis: TimeAxis, scale: float) -> None:
    """Markers on zero velocity, and on the torque with which the motion goes on."""
    events = response.events
    inside = (events.t >= axis.start) & (events.t <= axis.end)
    for kind, (marker, name) in MARKERS.items():
        chosen = inside & (events.kind == kind)
        if not chosen.any():
            continue
        style = {"linestyle": "", "marker": marker, "color": INK, "zorder": 4, "markersize": 5.5}
        style |= {"markerfacecolor": "white", "clip_on": False}
        t = axis.shown(events.t[chosen])
        upper.plot(t, np.zeros(len(t)), label=name, **style)
        lower.plot(t, events.torque_after[chosen] * scale, **style)


def _add_legend(figure: Figure, axes: Any) -> None:
    from matplotlib.patches import Patch

    handles, names = axes.get_legend_handles_labels()
    if axes.patches:  # the shaded stretches
        handles.append(Patch(color=SHADE))
        names.append("sticking")
    if names:
        figure.legend(handles, names, loc="outside lower center", ncols=len(names), frameon=False)
