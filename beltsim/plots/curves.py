"""Curves of a study over speed or torque: one panel per quantity, colour and dash by dimension.

Depends on: plots.style, errors; datasets of study as they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from beltsim.errors import InvalidProblemError, Mistake
from beltsim.plots.style import CYCLE, GREY, INK, new_figure, plain, plain_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DASHES: tuple[Any, ...] = ("-", (0, (4, 2)), (0, (1, 1.5)), (0, (6, 2, 1, 2)))
#: A logarithmic axis begins at this share of its largest value: what is less is mostly rounding.
LOG_SHARE = 1e-5
#: Curves of so many points or fewer show each of them.
MARKED = 120
#: Marks of points without a value, and of orbits that need not be the motion one sees.
CROSS: dict[str, Any] = {"linestyle": "", "marker": "x", "markersize": 5.0, "clip_on": False}
RING: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 6.0, "fillstyle": "none"}
#: How axes and legends call a dimension.
NAMES = {
    "Omega": r"excitation frequency $\Omega$",
    "crank_speed": "crank speed (rpm)",
    "Q_m": r"friction torque $Q_m$ ($P_0 r_t$)",
    "share": r"friction torque $Q_m/Q_{cr}$",
    "phase": "time over forcing period",
}
_SHORT = {"Omega": r"$\Omega$", "Q_m": "$Q_m$", "epsilon": r"$\varepsilon$"}


def curves(
    panels: Mapping[str, Any],
    x: str,
    lines: str | None = None,
    styles: str | None = None,
    *,
    title: str | None = None,
    log: bool = False,
    limits: tuple[float, float] | None = None,
    doubtful: Any = None,
) -> Figure:
    """Curves over `x`, one panel for each entry of `panels`.

    Points without a value (NaN) are crosses on the lower edge, unless the whole curve has none.

    Parameters
    ----------
    panels : mapping
        Label of the vertical axis, with its unit, to a data array over `x`, `lines` and `styles`.
    x : str
        Dimension along the horizontal axis: ``"Omega"``, ``"crank_speed"``, ``"Q_m"`` or
        ``"phase"``.
    lines : str, optional
        Dimension told apart by colour.
    styles : str, optional
        Dimension told apart by dash.
    title : str, optional
    log : bool
        Whether the vertical axes are logarithmic.
    limits : (low, high), optional
        Of the horizontal axis.
    doubtful : data array of bool, optional
        Points that get a hollow ring: orbits that are unstable, or not the only one.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidProblemError
        When `panels` is no mapping or empty, or a panel has another dimension.

    Examples
    --------
    >>> import beltsim
    >>> from beltsim import study
    >>> drive = beltsim.presets.zhu_parker_2008()
    >>> found = study.sweep(drive, [2.8, 6.3], [0.5, 3.5], n_functions=4)
    >>> figure = curves({"loss per period": found.dissipated_energy}, "Omega", "Q_m")
    >>> len(figure.axes[0].get_lines())
    2
    """
    if not isinstance(panels, Mapping):
        allowed = "a mapping from the label of each vertical axis to its data: {label: data}"
        raise InvalidProblemError(Mistake("panels", type(panels).__name__, allowed))
    known = {name for name in (x, lines, styles) if name}
    for name, data in panels.items():
        other = sorted(set(map(str, data.dims)) - known)
        if x not in data.dims or other:
            allowed = f"{x} and some of {sorted(known)}"
            if other:
                allowed += f"; tell {' and '.join(other)} apart with lines= or styles="
            raise InvalidProblemError(Mistake(f"panels[{name!r}].dims", data.dims, allowed))
    if not panels:
        raise InvalidProblemError("nothing to draw: no panels")
    figure = new_figure(7.5, 1.2 + 2.5 * len(panels))
    column = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (name, data) in zip(column, panels.items(), strict=True):
        plain_axes(axes)
        _draw(axes, data, doubtful, x, lines, styles)
        axes.set_ylabel(name)
        if log:
            axes.set_yscale("log")
            axes.set_ylim(bottom=LOG_SHARE * float(np.nanmax(np.abs(data.values))))
    first = next(iter(panels.values()))
    column[-1].set_xlabel(NAMES.get(x, x))
    low, high = limits or (float(first[x].min()), _finite_end(first[x].values))
    if low < high:
        column[-1].set_xlim(low, high)
    _second_scale(column[0], first, x)
    if title:
        figure.suptitle(plain(title) if "$" not in title else title, fontsize=12)
    _legend(figure, first, lines, styles, _marks(panels, doubtful))
    return figure


def _finite_end(values: Any) -> float:
    return float(values[np.isfinite(values)].max())


def _draw(
    axes: Any, data: Any, doubtful: Any, x: str, lines: str | None, styles: str | None
) -> None:
    parts = _parts(data, lines)
    colors = _colors(len(parts)) if lines else [INK]
    for i, (one, color) in enumerate(zip(parts, colors, strict=True)):
        for j, each in enumerate(_parts(one, styles)):
            at, values, gap = each[x].values, each.values, np.isnan(each.values)
            axes.plot(
                at,
                values,
                color=color,
                linestyle=_DASHES[j % len(_DASHES)],
                linewidth=1.5 if j == 0 else 1.1,
                marker="o",
                markersize=2.4 if len(values) <= MARKED else 0.0,
            )
            alone = ~gap & np.append(True, gap[:-1]) & np.append(gap[1:], True)
            if alone.any():  # no line leads there
                axes.plot(at[alone], values[alone], "o", color=color, markersize=4.0)
            if gap.any() and not gap.all():
                edge = axes.get_xaxis_transform()
                axes.plot(at[gap], 0.0 * at[gap], transform=edge, color=color, **CROSS)
            if doubtful is not None:
                ring = _parts(_parts(doubtful, lines)[i], styles)[j].values
                axes.plot(at[ring], values[ring], color=color, **RING)


def _parts(data: Any, dimension: str | None) -> list[Any]:
    """`data` at each value of a dimension, or itself where it has none of that name."""
    if dimension is None or dimension not in data.dims:
        return [data]
    return [data.isel({dimension: i}) for i in range(data.sizes[dimension])]


def _colors(count: int) -> list[Any]:
    """A colour of its own for each of `count` curves: from dark to light where the cycle ends."""
    if count <= len(CYCLE):
        return list(CYCLE[:count])
    from matplotlib import colormaps

    return [colormaps["viridis"](share) for share in np.linspace(0.0, 0.93, count).tolist()]


def _second_scale(axes: Any, data: Any, x: str) -> None:
    """The same axis above the panel in its other unit, where the dataset knows it."""
    if x == "Omega" and "crank_speed" in data.coords:
        factor, name = float(data.crank_speed[-1] / data.Omega[-1]), NAMES["crank_speed"]
    elif x == "crank_speed" and "Omega" in data.coords:
        factor, name = float(data.Omega[-1] / data.crank_speed[-1]), NAMES["Omega"]
    elif x == "Q_m" and "si_scale" in data.Q_m.attrs:
        factor, name = float(data.Q_m.attrs["si_scale"]), "friction torque (N m)"
    else:
        return
    top = axes.secondary_xaxis("top", functions=(lambda v: v * factor, lambda v: v / factor))
    top.set_xlabel(name, color=GREY)
    top.tick_params(colors=GREY)
    top.spines["top"].set_color("#BBBBBB")


def _marks(panels: Mapping[str, Any], doubtful: Any) -> dict[str, dict[str, Any]]:
    """What the marks that occur mean."""
    found = {}
    gaps = [np.isnan(data.values) for data in panels.values()]
    if any(gap.any() and not gap.all() for gap in gaps):
        found["no solution"] = CROSS
    if doubtful is not None and doubtful.values.any():
        found["unstable, or not the only orbit"] = RING
    return found


def _legend(
    figure: Figure,
    data: Any,
    lines: str | None,
    styles: str | None,
    marks: dict[str, dict[str, Any]],
) -> None:
    from matplotlib.lines import Line2D

    handles = []
    values = _values(data, lines)
    for value, color in zip(values, _colors(len(values)), strict=True):
        handles.append(Line2D([], [], color=color, label=_said(lines, value)))
    for j, value in enumerate(_values(data, styles)):
        dash = _DASHES[j % len(_DASHES)]
        handles.append(Line2D([], [], color=INK, linestyle=dash, label=_said(styles, value)))
    handles += [Line2D([], [], color=INK, label=text, **mark) for text, mark in marks.items()]
    if len(handles) > 1:
        columns = 3 if max(len(str(handle.get_label())) for handle in handles) > 20 else 5
        figure.legend(
            handles=handles,
            loc="outside lower center",
            ncols=min(columns, len(handles)),
            frameon=False,
        )


def _values(data: Any, dimension: str | None) -> list[Any]:
    if dimension is None or dimension not in data.dims:
        return []
    found: list[Any] = data[dimension].values.tolist()
    return found


def _said(dimension: str | None, value: Any) -> str:
    if isinstance(value, str):
        return plain(value)
    if dimension in ("Q_m", "friction_torque") and np.isinf(value):
        return "locked arm"
    if dimension == "friction_torque":
        return f"{value:.4g} N m"
    return f"{_SHORT.get(dimension or '', dimension)} = {value:g}"
