"""The largest critical torque of the operating range."""

import numpy as np

from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES, critical_torque, peak


def compute() -> list[tuple[str, float, float]]:
    grid = np.arange(0.1, 12.05, 0.1)
    expected = printed(__file__)["peak"]
    rows = []
    for series in SERIES:
        place, _ = peak(lambda x, s=series: critical_torque(x, s), grid)
        rows.append((f"Omega of the peak, {series}", place, expected))
    return rows
