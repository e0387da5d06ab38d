"""The pictures of a run and of a drive, written to files.

Depends on: plots; drive, response and metrics for their types only.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from beltsim import plots

if TYPE_CHECKING:
    from beltsim.drive import Drive
    from beltsim.response import Response


def draw_layout(drive: Drive, stem: Path, suffix: str) -> list[Path]:
    """Picture of the layout; the files written."""
    return [plots.save_figure(plots.layout(drive), _name(stem, "layout", suffix))]


def draw_motion(
    response: Response, stem: Path, suffix: str, rpm: float | None, name: str
) -> list[Path]:
    """Pictures of the arm and of the span tensions, where there are any; the files written."""
    written = []
    speed = f" at {rpm:.0f} rpm" if rpm is not None else ""
    prefix = f"{name}\n" if name else ""
    problem = response.problem
    if problem.joint is not None and problem.friction is not None:
        torque = ""
        if problem.scales is not None:
            torque = f", friction {problem.friction.Q_m * problem.scales.torque_N_m:.4g} N m"
        title = f"{prefix}Tensioner arm{speed}{torque}"
        own = problem.labels is None or problem.labels[problem.joint] != "theta_t"
        figure = plots.arm_motion(response, rpm, None if own else title)
        written.append(plots.save_figure(figure, _name(stem, "arm", suffix)))
    if any(seen.unit == "N" for seen in problem.observables):
        figure = plots.span_tensions(response, rpm, f"{prefix}Span tensions{speed}")
        written.append(plots.save_figure(figure, _name(stem, "tensions", suffix)))
    return written


def _name(stem: Path, what: str, suffix: str) -> Path:
    return stem.with_name(f"{stem.name}-{what}.{suffix}")
