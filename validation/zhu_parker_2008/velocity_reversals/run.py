"""Velocity reversals by located events and by the sign changes of truncated series."""

import numpy as np

from beltsim import SaturatedCoulomb, event_map, harmonic_balance, transient
from validation.reference import printed
from validation.row import Row
from validation.zhu_parker_2008.paper import CONVERGED, SHORT, problem

OMEGA = 6.3
HARMONICS = (5, 9, 11, 13, 25)
SETTINGS = harmonic_balance.Settings(samples=256, start="set_valued", estimate=False)


def compute() -> list[Row]:
    rows = []
    for name, expected in printed(__file__).items():
        Q_m = float(name.removeprefix("Q_m = "))
        short, converged = (problem(OMEGA, series, Q_m=Q_m) for series in (SHORT, CONVERGED))
        run = transient.integrate(short, 100.0, None, transient.Settings(keep="events"))
        found = {
            f"exact, {SHORT}": event_map.periodic(short).velocity_reversals,
            f"exact, {CONVERGED}": event_map.periodic(converged).velocity_reversals,
            f"C core, {SHORT}": run.velocity_reversals,
        }
        saturated = short.with_friction(SaturatedCoulomb(Q_m, 1e-4))
        for R in HARMONICS:
            series = harmonic_balance.solve(saturated, R, SETTINGS).coefficients[:, short.joint]
            velocity = 1j * OMEGA * np.arange(len(series)) * series
            count = harmonic_balance.reversals_of_series(velocity)
            found[f"series of {R} harmonics"] = count
        rows += [Row(f"{name}, {how}", nu, expected) for how, nu in found.items()]
    return rows
