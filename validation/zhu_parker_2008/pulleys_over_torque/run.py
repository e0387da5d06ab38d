"""Exact rms of pulleys and arm at the six speeds of Fig. 6."""

import numpy as np

import beltsim
from beltsim import study
from validation.reference import printed
from validation.row import Row
from validation.zhu_parker_2008.paper import SERIES

TORQUES = [*np.arange(0.0, 12.1, 1.0), np.inf]


def compute() -> list[Row]:
    expected, drive, rows = printed(__file__), beltsim.presets.zhu_parker_2008(), []
    rise = expected.pop("rise")
    speeds = [float(name) for name in expected]
    for series, options in SERIES.items():
        method = study.EventMap(harmonics=0)
        rms = study.sweep(drive, speeds, TORQUES, method, **options).rms
        for number in (2, 3):
            pulley = rms.sel(coordinate=f"theta_{number}")
            less = (pulley.sel(Q_m=np.inf) < pulley.sel(Q_m=0.0)).values.astype(float)
            name = f"pulley {number} suppressed, {series}"
            rows.append(Row(name, less, list(expected.values()), speeds))
        steps = rms.sel(coordinate="theta_t").diff("Q_m")
        rows.append(
            Row(f"rise of the arm's rms with the torque, {series}", float(steps.max()), rise)
        )
    return rows
