"""The grid of the study of Fig. 8 by every solver, compared with each other."""

import numpy as np

import beltsim
from beltsim import study
from validation.reference import printed
from validation.zhu_parker_2008.fig08_lobes.data import (
    SPEEDS,
    TIME_BANDS,
    series_method,
    time_method,
)
from validation.zhu_parker_2008.paper import SERIES, SHORT

#: Of the critical torque; at the torque itself runs in time converge too slowly to compare.
SHARES = np.array([0.1, 0.3, 0.5, 0.7, 0.9, 0.95])
ORDERS = (51, 101, 201, 401)


def compute() -> list[tuple[str, float, float]]:
    expected = printed(__file__)
    difference, rows = expected["difference"], []
    exact = sweep(SHARES, time_method("event map", 0.0))
    fine = sweep(np.arange(0.02, 1.0, 0.02), time_method("event map", 0.0))
    top = fine.dissipated_energy.max("share")
    steps = np.sign(fine.dissipated_energy.diff("share").values)
    humps = (np.diff(steps, axis=1) < 0).sum(axis=1).max()
    rows.append(("nu, fine grid, event map", worst(fine.velocity_reversals), expected["nu"]))
    rows.append(("most humps of the energy at one speed", float(humps), expected["humps"]))
    for sigma in (0.0, *TIME_BANDS):
        name = f"{sigma:.0e}" if sigma else "exact"
        ours, other = (sweep(SHARES, time_method(which, sigma)) for which in ("event map", "CVODE"))
        for which, found in (("event map", ours), ("CVODE", other)):
            row = (f"nu, {which}, {name}", worst(found.velocity_reversals), expected["nu"])
            rows.append(row)
        gap = worst(np.abs(ours.dissipated_energy - other.dissipated_energy) / top)
        rows.append((f"energy, event map against CVODE, {name}", gap, difference))
        if sigma:
            gap = worst(np.abs(ours.dissipated_energy - exact.dissipated_energy) / top)
            rows.append((f"energy, saturated against exact law, {name}", gap, difference))
    for R in ORDERS:
        found = sweep(SHARES, series_method(R, 0.0))
        gap = worst(np.abs(found.dissipated_energy - exact.dissipated_energy) / top)
        rows.append((f"energy, set-valued series against exact, R = {R}", gap, difference))
    return rows


def sweep(shares: np.ndarray, method: study.Method) -> object:
    drive = beltsim.presets.zhu_parker_2008()
    return study.sweep(drive, SPEEDS, shares, method, relative=True, **SERIES[SHORT])


def worst(values: object) -> float:
    """The largest value; NaN, which no tolerance covers, when any is missing."""
    return float(np.max(values.values))
