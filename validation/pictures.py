"""The pictures of a case: ours over the reference, error below, as inline SVG.

Arrays are curves, each with a picture of its own; single numbers share one picture, side by side.
Errors stand on a logarithmic axis with the tolerance as a line; an error of exactly zero is drawn
on the lower edge.

Depends on: compare; matplotlib.
"""

from __future__ import annotations

import io
import math
import textwrap
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from validation.compare import Compared, Result

#: Arrays of fewer entries are shown by their worst one, among the single numbers.
SHORTEST_CURVE = 3
#: Curves drawn for one case: those that come nearest to their tolerances.
MOST_CURVES = 4
#: Curves with more entries than this are embedded as pixels, the rest stays vector graphics.
MOST_VECTORS = 600
#: A range of values beyond this factor is drawn on a logarithmic axis.
WIDE = 300.0
REFERENCE, OURS, LIMIT = "#222222", "#0072B2", "#777777"
VERDICT_COLOURS = {"agrees": OURS, "disagrees-explained": "#E69F00", "disagrees": "#D55E00"}
_LOOK = {
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
}


def of_case(result: Result) -> tuple[list[str], int]:
    """SVG pictures of a case, and how many curves were left out."""
    curves = [row for row in result.rows if row.entries >= SHORTEST_CURVE]
    single = [row for row in result.rows if row.entries < SHORTEST_CURVE]
    shown = sorted(sorted(curves, key=_nearness)[-MOST_CURVES:], key=curves.index)
    name = result.case.name
    drawn = [_svg(lambda row=row: curve(row), f"{name}/{row.quantity}") for row in shown]
    if single:
        drawn.insert(0, _svg(lambda: numbers(single), f"{name}/numbers"))
    return drawn, len(curves) - len(shown)


def curve(row: Compared) -> Figure:
    """One array: values over its abscissa, and the error of each entry."""
    got, expected = (np.array(row.curves[key]) for key in ("got", "expected"))
    x = np.array(row.curves.get("x") or np.arange(1, len(got) + 1), float)
    figure, (top, bottom) = _two_axes(4.6)
    pixels, size = len(got) > MOST_VECTORS, max(2.0, 5.0 - len(got) / 100.0)
    colour = VERDICT_COLOURS[row.verdict]
    line = "-" if row.curves.get("x") and np.all(np.diff(x) > 0.0) else "none"
    common: dict[str, Any] = {"rasterized": pixels, "linestyle": line, "linewidth": 0.8}
    top.plot(x, expected, "o", mfc="none", c=REFERENCE, ms=size + 2.5, label="reference", **common)
    top.plot(x, got, "o", c=colour, ms=size, label="beltsim", **(common | {"linestyle": "none"}))
    top.set_ylabel(_wrapped(row.y_label or "value", 34))
    error = np.abs(got - expected)
    if row.metric == "rms":
        error = error / float(np.sqrt(np.mean(expected**2)))
    _errors(bottom, x, error, np.full(len(x), row.tolerance), [colour] * len(x), pixels)
    bottom.set_xlabel(row.x_label or "entry")
    if "x" not in row.curves:
        bottom.xaxis.set_major_locator(mpl.ticker.MaxNLocator(integer=True))
    bottom.set_ylabel("error" if row.metric != "rms" else "error over rms")
    top.set_title(_wrapped(row.quantity, 60), loc="left", fontsize=9)
    _legend(figure, top, "tolerance (of the rms)" if row.metric == "rms" else "tolerance")
    return figure


def numbers(rows: Sequence[Compared]) -> Figure:
    """Single numbers side by side; names below, the error of each on its own metric."""
    x = np.arange(len(rows), dtype=float)
    names = [_wrapped(row.quantity, 30) for row in rows]
    longest = max(len(line) for name in names for line in name.split("\n"))
    left = 0.3 + 0.055 * longest
    width = left + min(10.0, max(3.8, 0.42 * len(rows)))
    figure, (top, bottom) = _two_axes(width, 3.2, 0.2 + 0.045 * longest, left)
    got, expected = (np.array([getattr(row, key) for row in rows]) for key in ("got", "expected"))
    colours = [VERDICT_COLOURS[row.verdict] for row in rows]
    top.plot(x, expected, "o", mfc="none", c=REFERENCE, ms=8.0, label="reference")
    top.scatter(x, got, c=colours, s=22.0, zorder=3, label="beltsim")
    _widely(top, np.concatenate([got, expected]))
    top.set_ylabel("value")
    tolerances = np.array([row.tolerance for row in rows])
    _errors(bottom, x, np.array([row.error for row in rows]), tolerances, colours)
    bottom.set_ylabel("error")
    bottom.set_xlim(-0.6, len(rows) - 0.4)
    bottom.set_xticks(x, names, rotation=38, ha="right", rotation_mode="anchor", fontsize=7.5)
    _legend(figure, top, "tolerance")
    return figure


def _errors(
    axes: Any,
    x: np.ndarray,
    error: np.ndarray,
    tolerance: np.ndarray,
    colours: Sequence[str],
    pixels: bool = False,
) -> None:
    """Errors and tolerances; logarithmic as soon as there is anything that is not zero."""
    shown = np.where(np.isfinite(error), error, np.nan)
    sizes = np.concatenate([shown[shown > 0.0], tolerance[tolerance > 0.0]])
    if len(sizes):
        low, high = 10.0 ** (math.floor(math.log10(sizes.min())) - 1), 3.0 * sizes.max()
        axes.set_yscale("log")
        axes.set_ylim(low, high)
        axes.yaxis.set_major_locator(mpl.ticker.LogLocator(numticks=5))
        axes.yaxis.set_major_formatter(mpl.ticker.FuncFormatter(lambda y, _: f"{y:.0e}"))
        axes.yaxis.set_minor_locator(mpl.ticker.NullLocator())
        shown = np.where(shown == 0.0, low, shown)
    axes.scatter(x, shown, c=colours, s=14.0, zorder=3, clip_on=False, rasterized=pixels)
    half = 0.4 if len(x) == 1 else 0.4 * float(np.diff(np.sort(x)).mean())
    if len(set(tolerance)) == 1:
        axes.axhline(tolerance[0], color=LIMIT, linestyle="--", linewidth=1.0)
    else:
        axes.hlines(tolerance, x - half, x + half, color=LIMIT, linestyle="--", linewidth=1.0)


def _widely(axes: Any, values: np.ndarray) -> None:
    """A logarithmic axis where single numbers differ by orders of magnitude."""
    sizes = np.abs(values[np.isfinite(values) & (values != 0.0)])
    if len(sizes) and sizes.max() > WIDE * sizes.min():
        axes.set_yscale("symlog", linthresh=float(sizes.min()))
        axes.yaxis.set_major_locator(
            mpl.ticker.SymmetricalLogLocator(base=10, linthresh=sizes.min())
        )


def _legend(figure: Figure, top: Any, limit: str) -> None:
    handles, labels = top.get_legend_handles_labels()
    handles.append(mpl.lines.Line2D([], [], color=LIMIT, linestyle="--", linewidth=1.0))
    figure.legend(
        handles, [*labels, limit], loc="upper right", ncols=3, frameon=False, fontsize=7.5
    )


def _two_axes(
    width: float, height: float = 3.6, below: float = 0.45, left: float = 0.75
) -> tuple[Figure, Any]:
    """Values over errors, `below` and `left` inches from the edges.

    Margins are given, not found: a layout engine takes longer than all the rest.
    """
    tall = height - 0.45 + below
    figure = Figure(figsize=(width, tall))
    margins = {"left": left / width, "right": 1.0 - 0.12 / width}
    margins |= {"top": 1.0 - 0.5 / tall, "bottom": below / tall, "hspace": 0.12}
    return figure, figure.subplots(2, 1, sharex=True, height_ratios=(3, 2), gridspec_kw=margins)


def _nearness(row: Compared) -> float:
    """How near a row comes to its tolerance; what is no number comes first of all."""
    if not math.isfinite(row.error):
        return math.inf
    return row.error / row.tolerance if row.tolerance > 0.0 else row.error


def _wrapped(text: str, width: int) -> str:
    return "\n".join(textwrap.wrap(text.replace("$", r"\$"), width))


def _svg(draw: Any, salt: str) -> str:
    """The picture as an SVG element: same input, same bytes; `salt` keeps its names its own."""
    with mpl.rc_context(_LOOK | {"svg.hashsalt": salt}):
        text = io.StringIO()
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        draw().savefig(text, format="svg", metadata=nothing)
    svg = text.getvalue()
    return svg[svg.index("<svg") :]
