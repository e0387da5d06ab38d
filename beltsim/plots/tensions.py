"""Tensions of all spans over the last periods.

Depends on: response, errors; plots.style.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from beltsim.errors import InvalidProblemError
from beltsim.plots.style import (
    CYCLE,
    INK,
    add_crank_angle,
    new_figure,
    plain,
    plain_axes,
    time_axis,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from beltsim.response import Response

_DASHES = ("-", "--", "-.", ":")


def span_tensions(
    response: Response,
    crank_rpm: float | None = None,
    title: str | None = None,
    periods: float = 2.0,
) -> Figure:
    """Every observable of the problem that is a force, over the last `periods` sampled.

    Parameters
    ----------
    response : Response
        With samples.
    crank_rpm : float, optional
        Crank speed; named in the title and used for a second scale in degrees.
    title : str, optional
        Replaces "Span tensions".
    periods : float
        Forcing periods to show; fewer where fewer were sampled.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidProblemError
        When no observable is a force, or the response has no samples.
    """
    forces = [seen for seen in response.problem.observables if seen.unit == "N"]
    if not forces:
        raise InvalidProblemError("nothing to draw: no observable of the problem is a force in N")
    axis = time_axis(response, periods)
    figure = new_figure(8.0, 4.2)
    axes = figure.subplots()
    plain_axes(axes)
    for i, seen in enumerate(forces):
        values = response.observe(seen.name)[axis.chosen] * seen.scale
        axes.plot(
            axis.shown(response.t[axis.chosen]),
            values,
            label=plain(seen.name.removeprefix("tension of ")),
            linewidth=1.5,
            color=CYCLE[i % len(CYCLE)],
            linestyle=_DASHES[i // len(CYCLE) % len(_DASHES)],
        )
    if axes.get_ylim()[0] < 0.0:  # below it the model's belt pushes, a real one is slack
        axes.axhline(0.0, color=INK, linewidth=0.9)
    axes.set_ylabel("span tension (N)")
    axes.set_xlabel(axis.label)
    axes.set_xlim(0.0, float(axis.shown(axis.end)))
    add_crank_angle(axes, axis, crank_rpm)
    speed = f" at {crank_rpm:.0f} rpm" if crank_rpm is not None else ""
    figure.suptitle(plain(title or f"Span tensions{speed}"), fontsize=12)
    figure.legend(loc="outside lower center", ncols=min(len(forces), 7), frameon=False)
    return figure
