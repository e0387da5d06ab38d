"""Pictures: one function per figure, each returns a matplotlib `Figure`.

No display and no global state of matplotlib is used; `save_figure` writes a file whole or not at
all. SI units wherever the problem knows its scales.

Depends on: drive, response, problem, io; matplotlib.
"""

from __future__ import annotations

from beltsim.plots.arm import arm_motion
from beltsim.plots.event_phases import event_phases
from beltsim.plots.geometry import layout
from beltsim.plots.style import save_figure
from beltsim.plots.tensions import span_tensions

__all__ = ["arm_motion", "event_phases", "layout", "save_figure", "span_tensions"]
