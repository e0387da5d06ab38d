"""Figures 3 to 11 of Zhu & Parker (2008): one call each, a labelled dataset back.

Every figure holds four computations, along the dimension ``computation``: by the exact event map
and by harmonic balance as in the paper (saturated law, R = 11, sigma = 1e-4, 256 samples), each
for the paper's short series of sines, N = (4, 5, 5), and converged. Points that harmonic balance
does not reach are NaN and named in `failure`. `python -m validation.zhu_parker_2008.figures fig08`
writes dataset and pictures.

Depends on: beltsim.study; validation.zhu_parker_2008.paper.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import beltsim
from beltsim import study
from validation.zhu_parker_2008.paper import SERIES

#: The paper gives no R; 11 gives its numbers of reversals. Its sigma is 1e-5 to 1e-4.
PAPER = {"R": 11, "sigma": 1e-4, "samples": 256}
METHODS: dict[str, study.Method] = {
    "event map": study.EventMap(),
    "harmonic balance": study.HarmonicBalance(**PAPER),
}
SPEED_GRID = np.round(np.arange(0.1, 12.001, 0.05), 2)
TORQUE_GRID = np.round(np.arange(0.0, 12.001, 0.1), 1)
SPEEDS = (2.8, 3.3, 5.7, 6.3, 8.0, 8.7)
LOCKED = np.inf
A_3 = "span1.sin3"
#: Which points failed and why, and how each computation was made.
ABOUT = ("failure", "method", "n_functions", "residual_flexibility")

Progress = Callable[[float], None] | None


def computations(one: Callable[[study.Method, dict[str, Any]], Any]) -> Any:
    """`one` dataset for each method and series, side by side."""
    parts = {
        f"{name}, {series}": one(method, options)
        for name, method in METHODS.items()
        for series, options in SERIES.items()
    }
    return study.combined(parts, "computation")


def compared(
    Omega: Any, Q_m: Any, progress: Progress = None, spectra_of: Sequence[str] = ()
) -> Any:
    """Sweeps of the paper's drive over speed and torque."""
    drive = beltsim.presets.zhu_parker_2008()
    return computations(
        lambda method, options: study.sweep(
            drive, Omega, Q_m, method, progress=progress, spectra_of=spectra_of, **options
        )
    )


def fig03(grid: Any = SPEED_GRID, progress: Progress = None) -> Any:
    """Rms of arm, pulley 2 and pulley 3 over Omega, for five torques; variable `rms`."""
    found = compared(grid, [0.0, 0.1, 1.5, 5.0, LOCKED], progress)
    return found[["rms", *ABOUT]].sel(coordinate=["theta_t", "theta_2", "theta_3"])


def fig04(grid: Any = SPEED_GRID, progress: Progress = None) -> Any:
    """Rms of the transverse motion averaged along each span over Omega; `span_rms`."""
    return compared(grid, [0.0, 0.1, 1.5, 5.0, LOCKED], progress)[["span_rms", *ABOUT]]


def fig05(grid: Any = SPEED_GRID, progress: Progress = None) -> Any:
    """a_3 of span 1: `rms` over Omega for five torques, and the spectra of all of them."""
    found = compared(grid, [0.0, 0.1, 0.5, 1.5, LOCKED], progress, [A_3])
    return found[["rms", "amplitude", *ABOUT]].sel(coordinate=[A_3])


def fig06(grid: Any = TORQUE_GRID, progress: Progress = None) -> Any:
    """Rms of arm, pulley 2 and pulley 3 over Q_m at six speeds."""
    found = compared(SPEEDS, grid, progress)
    return found[["rms", *ABOUT]].sel(coordinate=["theta_t", "theta_2", "theta_3"])


def fig07(grid: Any = SPEED_GRID, progress: Progress = None) -> Any:
    """Dissipated energy over Omega for four torques."""
    return compared(grid, [0.1, 0.5, 3.0, 5.0], progress)[["dissipated_energy", *ABOUT]]


def fig08(grid: Any = TORQUE_GRID, progress: Progress = None) -> Any:
    """Dissipated energy over Q_m at six speeds, and both counts of nu."""
    kept = ["dissipated_energy", "velocity_reversals", "reversals_of_series", *ABOUT]
    return compared(SPEEDS, grid, progress)[kept]


def fig09(grid: Any = (1.0, 3.5, 6.1, 11.0), progress: Progress = None) -> Any:
    """Velocity of the arm and friction torque over a period at Omega = 6.3, for four torques."""
    drive = beltsim.presets.zhu_parker_2008()
    found = computations(
        lambda method, options: study.histories(drive, 6.3, list(grid), method, **options)
    )
    if progress is not None:
        progress(1.0)
    return found


def fig10(grid: Any = SPEED_GRID, progress: Progress = None) -> Any:
    """Critical torque over Omega for four bending stiffnesses, by series; there is one method."""
    parts = {}
    for series, options in SERIES.items():
        bent = {
            epsilon: study.critical_torques(
                beltsim.presets.zhu_parker_2008(epsilon=epsilon), grid, **options
            )
            for epsilon in (0.01, 0.05, 0.1, 0.2)
        }
        parts[series] = study.combined(bent, "epsilon")
        if progress is not None:
            progress(len(parts) / len(SERIES))
    return study.combined(parts, "computation")


def fig11(grid: Any = SPEED_GRID, progress: Progress = None) -> Any:
    """Largest dynamic tension of each span over Omega for four torques."""
    found = compared(grid, [0.0, 0.1, 1.5, 5.0], progress)
    return found[["peak_dynamic_tension", *ABOUT]]


FIGURES: dict[str, Callable[..., Any]] = {
    function.__name__: function
    for function in (fig03, fig04, fig05, fig06, fig07, fig08, fig09, fig10, fig11)
}
