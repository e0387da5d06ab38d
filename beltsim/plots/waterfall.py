"""Spectra over speed, one behind the other.

Depends on: plots.style, errors; datasets of study as they are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from beltsim.errors import InvalidProblemError, Mistake
from beltsim.plots.curves import NAMES
from beltsim.plots.style import BLUE, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def waterfall(panels: dict[str, Any], label: str, title: str | None = None) -> Figure:
    """Amplitudes over (Omega, harmonic) as stems in space, one panel for each entry of `panels`.

    The horizontal axis is the frequency of the harmonic, k Omega, so that a natural frequency shows
    as a wall along the speeds.

    Parameters
    ----------
    panels : dict
        Title of a panel to a data array over ``Omega`` and ``harmonic``.
    label : str
        Of the vertical axis.
    title : str, optional

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidProblemError
        When a panel has other dimensions.
    """
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    figure = new_figure(1.0 + 5.5 * len(panels), 5.4)
    for place, (name, data) in enumerate(panels.items()):
        if set(data.dims) != {"Omega", "harmonic"}:
            raise InvalidProblemError(Mistake("dims", data.dims, "Omega and harmonic"))
        axes = figure.add_subplot(1, len(panels), place + 1, projection="3d")
        values = data.transpose("Omega", "harmonic").values
        speeds, orders = data.Omega.values, data.harmonic.values
        stems, strength = [], []
        top = float(np.nanmax(values))
        for i, speed in enumerate(speeds.tolist()):
            for k, order in enumerate(orders.tolist()):
                if values[i, k] > 1e-4 * top:
                    at = order * speed
                    stems.append([(at, speed, 0.0), (at, speed, float(values[i, k]))])
                    strength.append(order)
        collection = Line3DCollection(stems, colors=BLUE, linewidths=0.8)
        axes.add_collection3d(collection)
        axes.set_xlim(0.0, float(speeds.max() * orders.max()))
        if len(speeds) > 1:
            axes.set_ylim(float(speeds.min()), float(speeds.max()))
        axes.set_zlim(0.0, top)
        axes.set_xlabel(r"frequency of the harmonic, $k\Omega$")
        axes.set_ylabel(NAMES["Omega"])
        axes.set_zlabel(label)
        axes.set_title(name, loc="left", fontsize=10)
        axes.view_init(elev=28.0, azim=-62.0)
    if title:
        figure.suptitle(title, fontsize=12)
    return figure
