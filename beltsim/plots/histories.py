"""Velocity of the arm and friction torque over one period, as several methods find them.

Depends on: plots.style; datasets of `study.histories` as they are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from beltsim.plots.curves import NAMES
from beltsim.plots.style import CYCLE, GREY, INK, new_figure, plain_axes

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def arm_histories(data: Any, title: str | None = None, torque_of: int = 0) -> Figure:
    """One panel for each torque of `data`: velocity by each method, and one friction torque.

    Parameters
    ----------
    data : xarray.Dataset
        Of `study.histories`, or several of them `combined` along ``"solver"``.
    title : str, optional
    torque_of : int
        Which method's friction torque is drawn.

    Returns
    -------
    matplotlib.figure.Figure
    """
    several = "solver" in data.dims
    names = data.solver.values.tolist() if several else [""]
    count = data.sizes["Q_m"]
    figure = new_figure(7.8, 1.0 + 2.1 * count)
    column = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for i, axes in enumerate(column):
        plain_axes(axes)
        right = axes.twinx()
        right.spines["top"].set_visible(False)
        row = data.isel(Q_m=i)
        chosen = row.isel(solver=torque_of) if several else row
        right.plot(data.phase, chosen.friction_torque, color=GREY, linewidth=1.0)
        right.set_ylabel("friction torque\n($P_0 r_t$)", color=GREY)
        for j, name in enumerate(names):
            one = row.isel(solver=j) if several else row
            if not np.isnan(one.velocity.values).all():
                axes.plot(data.phase, one.velocity, color=CYCLE[j % len(CYCLE)], label=name)
        axes.axhline(0.0, color=INK, linewidth=0.6)
        axes.set_ylabel("arm velocity\n(dimensionless)")
        axes.set_title(f"$Q_m$ = {float(data.Q_m[i]):g}", loc="left", fontsize=10)
        _same_zero(axes, right)
    column[-1].set_xlabel(NAMES["phase"])
    column[-1].set_xlim(0.0, 1.0)
    if title:
        figure.suptitle(title, fontsize=12)
    if several:
        from matplotlib.lines import Line2D

        handles = [Line2D([], [], color=CYCLE[j % len(CYCLE)]) for j in range(len(names))]
        words = [*names, f"friction torque, {names[torque_of]}"]
        handles.append(Line2D([], [], color=GREY))
        figure.legend(handles, words, loc="outside lower center", ncols=2, frameon=False)
    return figure


def _same_zero(left: Any, right: Any) -> None:
    """Symmetric limits, so that both zeros lie on one line."""
    for axes in (left, right):
        top = max(abs(limit) for limit in axes.get_ylim())
        axes.set_ylim(-top, top)
