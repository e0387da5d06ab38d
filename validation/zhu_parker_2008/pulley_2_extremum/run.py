"""Exact rms of pulley 2 over the friction torque."""

import numpy as np

from beltsim import Coulomb, event_map
from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES, critical_torque, problem


def compute() -> list[tuple[str, float, float]]:
    expected = printed(__file__)["extremum outside"]
    rows = []
    for series in SERIES:
        at = problem(8.0, series)
        torques = np.linspace(0.0, 1.1 * critical_torque(8.0, series), 30)
        problems = [at.with_friction(Coulomb(float(Q))) for Q in torques]
        pulley = at.labels.index("theta_2")
        rms = event_map.survey(problems).rms[:, pulley]
        outside = min(rms) < min(rms[0], rms[-1])
        rows.append((f"extremum outside, {series}", float(outside), expected))
    return rows
