"""The paper's method beside exact orbits of the same law, with and without stops."""

import numpy as np

from beltsim import SaturatedCoulomb, event_map, harmonic_balance
from validation.reference import printed
from validation.row import Row
from validation.zhu_parker_2008.paper import problem

R, SIGMA = 25, 0.01
PROJECTIONS = {"sampled": 601, "exact": None}


def compute() -> list[Row]:
    expected, rows = printed(__file__), []
    for Q_m in (1.0, 3.5):
        at = problem(6.3, Q_m=Q_m).with_friction(SaturatedCoulomb(Q_m, SIGMA))
        orbit = event_map.periodic(at, event_map.Settings(harmonics=2000))
        for projection, samples in PROJECTIONS.items():
            settings = harmonic_balance.Settings(
                projection=projection, samples=samples, start="set_valued", estimate=False
            )
            found = harmonic_balance.solve(at, R, settings)
            exact = orbit.coefficients[1:, at.joint]
            series = np.pad(found.coefficients[1:, at.joint], (0, len(exact) - R))
            error = float(np.linalg.norm(exact - series) / np.linalg.norm(exact))
            loss = found.dissipated_energy / orbit.dissipated_energy
            name = f"Q_m = {Q_m}, {projection}"
            rows += [
                Row(f"motion, {name}", error, expected["bound"] / R),
                Row(f"dissipated energy, {name}", loss, expected["ratio"]),
            ]
    return rows
