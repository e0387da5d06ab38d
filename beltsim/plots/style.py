"""Look of all figures: colours that colour-blind readers can tell apart, plain axes, units.

Depends on: errors, response; io; matplotlib.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from beltsim.checks import FloatArray
from beltsim.errors import InvalidProblemError
from beltsim.io import whole_file

if TYPE_CHECKING:
    from beltsim.response import Response

#: Okabe and Ito's palette.
BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY = (
    *("#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9"),
)
CYCLE = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)
INK, GREY, SHADE = "#222222", "#777777", "#E3E6EA"
DOTS_PER_INCH = 150


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of `width` times `height` inches whose parts make room for each other."""
    return Figure(figsize=(width, height), layout="constrained", facecolor="white")


def plain_axes(axes: Any) -> None:
    """Faint grid, no frame on the right and on top."""
    axes.grid(True, color="#D9D9D9", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def plain(text: str) -> str:
    """`text` as it stands: a dollar sign in a name does not begin a formula."""
    return text.replace("$", r"\$")


def save_figure(figure: Figure, path: str | Path) -> Path:
    """Write `figure` to `path` (format by suffix), whole or not at all.

    A letter that the font lacks is drawn as an empty box, without a warning.

    Raises
    ------
    ResultFileError
        When the file cannot be written.
    """
    target = Path(path)
    with whole_file(target) as temporary, warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        figure.savefig(temporary, dpi=DOTS_PER_INCH)
    return target


class TimeAxis(NamedTuple):
    """The samples to draw and how their times are shown.

    Parameters
    ----------
    chosen : slice of the samples.
    start, end : float
        Problem time of the first and the last of them.
    factor : float
        Shown units per unit of problem time.
    label : str
    """

    chosen: slice
    start: float
    end: float
    factor: float
    label: str

    def shown(self, t: Any) -> FloatArray:
        """Positions on the axis of the problem times `t`."""
        found: FloatArray = (np.asarray(t) - self.start) * self.factor
        return found


def time_axis(response: Response, periods: float) -> TimeAxis:
    """The last `periods` of the samples, or all there are; milliseconds where scales are known.

    Raises
    ------
    InvalidProblemError
        When the response kept fewer than two samples.
    """
    if len(response.t) < 2:
        raise InvalidProblemError(
            f"nothing to draw: the response has {len(response.t)} samples; "
            'run with keep="last_period" or keep="all"'
        )
    period, scales = response.problem.period, response.problem.scales
    end = float(response.t[-1])
    first = int(np.searchsorted(response.t, end - periods * period - 1e-9 * period))
    first = min(first, len(response.t) - 2)
    start = float(response.t[first])
    if scales is None:
        label, factor = "time", 1.0
        since = f" after {start:.6g}" if start > 0.0 else ""
    else:
        label, factor = "time", 1e3 * scales.time_s
        since = f" after {start * scales.time_s:.4f} s" if start > 0.0 else ""
    unit = "ms" if scales is not None else "problem units"
    return TimeAxis(slice(first, None), start, end, factor, f"{label}{since} ({unit})")


def add_crank_angle(axes: Any, axis: TimeAxis, crank_rpm: float | None) -> None:
    """A second scale on top of `axes`: crank angle, counted on from 0 to 360 at the left edge."""
    if crank_rpm is None or axis.label.endswith("(problem units)"):
        return
    rate = 0.006 * crank_rpm  # degrees per millisecond
    first = (rate * axis.factor * axis.start) % 360.0
    top = axes.secondary_xaxis(
        "top", functions=(lambda x: first + rate * x, lambda deg: (deg - first) / rate)
    )
    top.set_xlabel("crank angle (deg)", color=GREY)
    top.tick_params(colors=GREY)
    top.spines["top"].set_color("#BBBBBB")
    step = _degree_step(rate * (axis.end - axis.start) * axis.factor)
    low = np.ceil(first / step - 1e-9) * step
    last = first + rate * (axis.end - axis.start) * axis.factor
    top.set_ticks(np.arange(low, last + 1e-6 * step, step))


def _degree_step(span: float) -> float:
    """Distance of round ticks over `span` degrees: about eight of them."""
    for step in (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0):
        if span / step <= 9.0:
            return step
    return 360.0 * float(np.ceil(span / 360.0 / 8.0))
