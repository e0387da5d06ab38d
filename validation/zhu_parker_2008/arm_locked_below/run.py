"""Where the critical torque first reaches a given torque."""

import numpy as np

from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES, critical_torque, first_crossing


def compute() -> list[tuple[str, float, float]]:
    grid = np.arange(0.1, 5.0, 0.1)
    rows = []
    for series in SERIES:
        for Q_m, expected in printed(__file__).items():
            got = first_crossing(lambda x, s=series: critical_torque(x, s), float(Q_m), grid)
            rows.append((f"Q_m = {Q_m}, {series}", got, expected))
    return rows
