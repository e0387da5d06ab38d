"""Layout of a drive: pulleys, belt, arm, names and the sense of travel.

Depends on: drive (for its type only), errors; plots.labels, plots.style.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from beltsim.checks import FloatArray
from beltsim.errors import short_name
from beltsim.plots.labels import Room
from beltsim.plots.style import BLUE, GREY, INK, VERMILLION, new_figure, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from beltsim.drive import Drive, Layout

_FACE = {"crank": "#FBE3D3", "arm": "#D6E6F2", "fixed": "#EEF0F2"}
_EDGE = {"crank": VERMILLION, "arm": BLUE, "fixed": GREY}


#: Height of a line of text and width of a letter, in points.
_LINE, _LETTER = 11.0, 6.0


def layout(drive: Drive) -> Figure:
    """Picture of a drive, to scale, x to the right and y up.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    matplotlib.figure.Figure
        Pulleys by role (crank, arm, fixed), the belt with an arrow of travel on each span, span
        numbers and lengths, the arm with its pivot.
    """
    where = drive.layout
    edges = [where.center_m - where.radius_m[:, None], where.center_m + where.radius_m[:, None]]
    if where.pivot_m is not None:
        edges.append(where.pivot_m[None, :])
    low, high = np.vstack(edges).min(axis=0), np.vstack(edges).max(axis=0)
    margin = 0.11 * float((high - low).max())
    low, high = low - margin, high + margin
    per_inch = float(max((high - low) / (7.6, 6.6)))  # metres of the drive on an inch of paper
    width, height = (high - low) / per_inch
    figure = new_figure(width + 0.9, height + 1.15)
    axes = figure.subplots()
    axes.set(aspect="equal", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set(xlabel="x (m)", ylabel="y (m)")
    axes.grid(True, color="#EEEEEE", linewidth=0.6)
    axes.set_axisbelow(True)
    _draw_things(axes, drive, (low, high), per_inch)
    turning = "clockwise" if where.travel == "cw" else "counter-clockwise"
    axes.set_title(plain(f"{drive.name or 'Belt drive'}\nbelt travels {turning}"), fontsize=11)
    return figure


def _draw_things(
    axes: Any, drive: Drive, corners: tuple[FloatArray, FloatArray], per_inch: float
) -> None:
    where, point = drive.layout, per_inch / 72.0
    belt = _belt_line(where)
    axes.plot(*belt.T, color=INK, linewidth=2.4, solid_joinstyle="round", zorder=3)
    lines = [belt, _spread(where.span_start_m, where.span_end_m)]
    if where.arm is not None and where.pivot_m is not None:
        tip = where.center_m[where.arm]
        lines.append(_spread(where.pivot_m[None, :], tip[None, :]))
        _draw_arm(axes, where.pivot_m, tip)
    center, radius = where.center_m, where.radius_m
    if where.pivot_m is not None:
        center, radius = np.vstack([center, where.pivot_m]), np.append(radius, 5.0 * point)
    room = Room(np.vstack(lines), center, radius, *corners)
    for j, pulley in enumerate(drive.pulleys):
        _draw_pulley(axes, where, j, pulley.role, room, point)
    for i in range(where.n):
        _draw_span(axes, where, i, room, point)
    if where.pivot_m is not None:
        spots = _ring(where.pivot_m, 19.0 * point, np.array([0.0, -1.0]))
        spot = room.place(spots, point * np.array([2.5 * _LETTER, 0.5 * _LINE]), 1.5 * point)
        axes.text(*spot, "pivot", ha="center", va="center", fontsize=9, color=BLUE, zorder=7)


def _spread(start: FloatArray, end: FloatArray) -> FloatArray:
    """Points close together on the lines from `start` to `end`, both (m, 2)."""
    share = np.linspace(0.0, 1.0, 60)[:, None, None]
    found: FloatArray = (start + share * (end - start)).reshape(-1, 2)
    return found


def _ring(center: FloatArray, distance: float, first: FloatArray) -> FloatArray:
    """Points (24, 2) around `center`, beginning in the direction `first`."""
    turn = np.arctan2(first[1], first[0]) + np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    order = np.argsort(np.abs(np.angle(np.exp(1j * (turn - turn[0])))), kind="stable")
    ring = center + distance * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.asarray(ring[order])


def _belt_line(where: Layout) -> FloatArray:
    """The belt as one closed line along spans and arcs of contact."""
    points = []
    for j in range(where.n):
        start = where.span_end_m[j - 1] - where.center_m[j]
        turn = np.arctan2(start[1], start[0])
        turn = turn + where.side[j] * np.linspace(0.0, where.wrap_rad[j], 90)
        arc = np.column_stack([np.cos(turn), np.sin(turn)])
        points.append(where.center_m[j] + where.radius_m[j] * arc)
    return np.vstack([*points, points[0][:1]])


def _draw_arm(axes: Any, pivot: FloatArray, tip: FloatArray) -> None:
    line = np.array([pivot, tip]).T
    axes.plot(*line, color=BLUE, linewidth=5.0, alpha=0.55, solid_capstyle="round", zorder=4)
    axes.plot(*pivot, "o", color=BLUE, markersize=9, markerfacecolor="white", zorder=5)


def _draw_pulley(axes: Any, where: Layout, j: int, role: str, room: Room, point: float) -> None:
    """Disc, centre and name: inside where it fits below the centre, else where there is room."""
    from matplotlib.patches import Circle

    centre, radius = where.center_m[j], float(where.radius_m[j])
    face, edge = _FACE[role], _EDGE[role]
    axes.add_patch(Circle(centre, radius, facecolor=face, edgecolor=edge, linewidth=1.2, zorder=2))
    axes.plot(*centre, "+", color=edge, markersize=6, zorder=6)
    name = short_name(where.names[j], 14)
    lines = [name] if role == "fixed" else [name, f"({role})"]
    half = 0.5 * point * np.array([_LETTER * max(map(len, lines)), _LINE * len(lines)])
    spot = centre - np.array([0.0, half[1] + 7.0 * point])
    fits = np.hypot(half[0], 2.0 * half[1] + 7.0 * point) < radius - 4.0 * point
    if role == "arm" or not fits:
        away = where.side[j] * (where.normal[j - 1] + where.normal[j])  # from the belt
        if not away.any():
            away = where.side[j] * where.normal[j]
        reach = float(np.hypot(*half))
        rings = [_ring(centre, radius + gap * reach, away) for gap in (0.8, 1.0, 1.3)]
        spot = room.place(np.vstack(rings), half, 3.0 * point)
    text = plain("\n".join(lines))
    axes.text(*spot, text, ha="center", va="center", fontsize=9.5, color=INK, zorder=7)


def _draw_span(axes: Any, where: Layout, i: int, room: Room, point: float) -> None:
    """Arrow of travel in the middle of span i, its number and length beside it."""
    start, end = where.span_start_m[i], where.span_end_m[i]
    if where.travel == "cw":  # the belt then runs against the order of the list
        start, end = end, start
    middle, along = 0.5 * (start + end), (end - start) / np.linalg.norm(end - start)
    axes.annotate(
        "",
        xy=tuple(middle + 9.0 * point * along),
        xytext=tuple(middle - 9.0 * point * along),
        arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 2.0, "mutation_scale": 17},
        zorder=6,
    )
    lines = [f"span {i + 1}", f"{1e3 * where.span_length_m[i]:.1f} mm"]
    half = 0.5 * point * np.array([0.9 * _LETTER * max(map(len, lines)), 0.95 * _LINE * 2])
    spots = np.array(
        [
            start + share * (end - start) + sign * (reach + 7.0 * point) * where.normal[i]
            for sign in (-1.0, 1.0)
            for share in (0.5, 0.42, 0.58, 0.34, 0.66, 0.25, 0.75)
            for reach in (float(np.abs(where.normal[i]) @ half),)
        ]
    )
    spot = room.place(spots, half, 3.0 * point)
    text = "\n".join(lines)
    axes.text(*spot, text, ha="center", va="center", fontsize=8.5, color="#555555", zorder=5)
