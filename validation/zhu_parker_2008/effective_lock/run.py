"""Critical torque at the exact resonance of span 1, and what is still dissipated from 10.4 on."""

import numpy as np

from beltsim import Coulomb, event_map
from validation.reference import printed
from validation.zhu_parker_2008.paper import SERIES, SHORT, by_kind, critical_torque, problem

TORQUES = np.arange(0.5, 12.1, 0.5)


def compute() -> list[tuple[str, float, float]]:
    expected = printed(__file__)
    rows = []
    for series in SERIES:
        Omega = by_kind(series, 6.0, 6.5)["span 1"][0].Omega
        got = critical_torque(Omega, series)
        rows.append((f"Q_cr at the resonance of span 1, {series}", got, expected["10.4"]))
    resonance = by_kind(SHORT, 6.0, 6.5)["span 1"][0].Omega
    points = {f"{SHORT}, resonance": (resonance, SHORT)}
    points |= {f"{series}, 6.3": (6.3, series) for series in SERIES}
    for name, point in points.items():
        share = _share(*point, expected["10.4"])
        rows.append((f"energy at 10.4 over its maximum, {name}", share, expected["share"]))
    return rows


def _share(Omega: float, series: str, Q_m: float) -> float:
    """Dissipated energy at `Q_m` over the largest of all torques, exact."""
    at = problem(Omega, series)
    settings = event_map.Settings(samples_per_period=1, harmonics=0)
    laws = [Coulomb(Q) for Q in (*TORQUES.tolist(), Q_m)]
    orbits = event_map.solve_many([at.with_friction(law) for law in laws], settings)
    energies = [orbit.dissipated_energy for orbit in orbits]
    return energies[-1] / max(energies)
