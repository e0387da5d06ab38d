"""Pictures: one function per figure, each returns a matplotlib `Figure`.

No display and no global state of matplotlib is used; `save_figure` writes a file whole or not at
all. SI units wherever the problem knows its scales.

Depends on: drive, response, problem, io; matplotlib.
"""

from __future__ import annotations

from beltsim.plots.arm import arm_motion
from beltsim.plots.curves import curves
from beltsim.plots.event_phases import event_phases
from beltsim.plots.geometry import layout
from beltsim.plots.grid_map import grid_map
from beltsim.plots.histories import arm_histories
from beltsim.plots.style import save_figure
from beltsim.plots.tensions import span_tensions
from beltsim.plots.waterfall import waterfall

__all__ = [
    "arm_histories",
    "arm_motion",
    "curves",
    "event_phases",
    "grid_map",
    "layout",
    "save_figure",
    "span_tensions",
    "waterfall",
]
