"""Exact spectra of a_3 of span 1 about the two superharmonics, short series and converged."""

import numpy as np

import beltsim
from beltsim import study
from beltsim.linear import frequencies
from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES

RANGES = {"5th": (5, np.arange(4.05, 4.275, 0.01)), "3rd": (3, np.arange(4.4, 4.585, 0.01))}


def compute() -> list[tuple[str, float, float]]:
    expected, drive, rows = printed(__file__), beltsim.presets.zhu_parker_2008(), []
    for series, options in SERIES.items():
        for name, (order, grid) in RANGES.items():
            method = study.EventMap(harmonics=order)
            found = study.sweep(
                drive, grid, [0.5], method, spectra_of=["span1.sin3"], harmonics=order, **options
            )
            top = int(np.argmax(found.amplitude.values[:, 0, 0, order]))
            Omega = float(grid[top]) if 0 < top < len(grid) - 1 else np.nan  # no peak inside
            modes = frequencies(beltsim.assemble(drive, float(grid[top]), **options))
            mode = 1 + int(np.argmin(np.abs(modes - order * grid[top])))
            for what, got in ((f"{name} harmonic", Omega), (f"mode of the {name} harmonic", mode)):
                rows.append((f"{what}, {series}", got, expected[what]))
    return rows
