"""A quantity over two dimensions of a study as coloured cells; holes stay white and are crossed.

Depends on: plots.style, plots.curves (its names of dimensions); datasets of study as they are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from beltsim.plots.curves import NAMES
from beltsim.plots.style import new_figure, plain_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Colours of whole numbers from 0 on; the last stands for all that are larger.
_STEPS = ("#F2F4F7", "#56B4E9", "#009E73", "#E69F00", "#D55E00", "#CC79A7", "#5B3A8C", "#222222")


def grid_map(
    panels: dict[str, Any],
    x: str,
    y: str,
    label: str,
    *,
    columns: int = 3,
    first: int = 0,
    title: str | None = None,
    y_label: str | None = None,
) -> Figure:
    """Whole numbers over `x` and `y`, one panel for each entry of `panels`.

    Parameters
    ----------
    panels : dict
        Title of a panel to a data array over `x` and `y`; NaN is a hole.
    x, y : str
        Dimensions of the axes. A dimension of more than two values that grow by factors (such as
        numbers of harmonics) is drawn evenly spaced.
    label : str
        Of the colour bar.
    columns : int
        Panels side by side; more of them go below.
    first : int
        The number of the first colour; smaller ones share it, as larger ones share the last.
    title, y_label : str, optional

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> import beltsim
    >>> from beltsim import study
    >>> drive = beltsim.presets.zhu_parker_2008()
    >>> found = study.sweep(drive, [2.8, 6.3], [0.5, 3.5], n_functions=4)
    >>> figure = grid_map({"": found.phases_per_period}, "Omega", "Q_m", "phases per period")
    >>> figure.axes[0].get_xlabel()[:10]
    'excitation'
    """
    from matplotlib.colors import BoundaryNorm, ListedColormap

    edges = np.arange(first - 0.5, first + len(_STEPS) + 0.5)
    norm, colours = BoundaryNorm(edges, len(_STEPS)), ListedColormap(list(_STEPS))
    across_count = min(columns, len(panels))
    down = -(-len(panels) // across_count)
    figure = new_figure(1.6 + 4.0 * across_count, 0.9 + 3.3 * down)
    table = figure.subplots(down, across_count, sharex=True, sharey=True, squeeze=False)
    row = table.ravel()
    for axes, (name, data) in zip(row, panels.items(), strict=False):
        plain_axes(axes)
        axes.grid(False)
        values = data.transpose(y, x).values.astype(float)
        across, up = _edges(data[x].values), _edges(data[y].values)
        shown = np.clip(values, first, first + len(_STEPS) - 1)
        drawn = axes.pcolormesh(across, up, np.ma.masked_invalid(shown), cmap=colours, norm=norm)
        holes = np.argwhere(np.isnan(values))
        if len(holes):
            middle_x, middle_y = 0.5 * (across[1:] + across[:-1]), 0.5 * (up[1:] + up[:-1])
            axes.plot(
                middle_x[holes[:, 1]], middle_y[holes[:, 0]], "x", color="#999999", markersize=3
            )
        _even_ticks(axes.set_xticks, data[x].values)
        _even_ticks(axes.set_yticks, data[y].values)
        axes.set_ylim(up[0], up[-1])
        axes.set_title(name, loc="left", fontsize=10)
    for axes in table[:, 0]:
        axes.set_ylabel(y_label or NAMES.get(y, y))
    for axes in table[-1]:
        axes.set_xlabel(NAMES.get(x, x))
    for axes in row[len(panels) :]:
        axes.set_visible(False)
    bar = figure.colorbar(drawn, ax=list(row), label=label, shrink=0.9)
    numbers = np.arange(first, first + len(_STEPS))
    words = [*(str(k) for k in numbers[:-1]), f"{numbers[-1]} or more"]
    bar.set_ticks(numbers.tolist(), labels=words)
    if title:
        figure.suptitle(title, fontsize=12)
    return figure


def _uneven(values: Any) -> bool:
    """Whether steps grow so much that equal cells are easier to read."""
    steps = np.diff(values)
    return len(values) > 2 and float(steps.max()) > 8.0 * float(steps.min())


def _edges(values: Any) -> Any:
    """Borders of cells about `values`; cells of one size where these are uneven."""
    if _uneven(values):
        return np.arange(len(values) + 1) - 0.5
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def _even_ticks(setter: Any, values: Any) -> None:
    if _uneven(values):
        setter(range(len(values)), labels=[f"{value:g}" for value in values])
