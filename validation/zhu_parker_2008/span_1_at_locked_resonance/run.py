"""Exact rms of span 1 at Omega = 6.8 over the friction torque."""

import numpy as np

import beltsim
from beltsim import study
from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES


def compute() -> list[tuple[str, float, float]]:
    expected, drive, rows = printed(__file__), beltsim.presets.zhu_parker_2008(), []
    for series, options in SERIES.items():
        found = study.sweep(drive, [6.8], [0.0, 0.1, 1.5, 5.0, np.inf], **options)
        rms = found.span_rms.sel(span=1).values[0]
        said = {
            "falls up to Q_m = 5": np.all(np.diff(rms[:-1]) < 0.0),
            "larger with the arm locked": rms[-1] > rms[0],
        }
        rows += [(f"{name}, {series}", float(got), expected[name]) for name, got in said.items()]
    return rows
