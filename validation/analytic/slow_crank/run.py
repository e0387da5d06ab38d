"""Response of the paper's drive to a crank that turns slowly."""

import numpy as np

import beltsim
from validation.analytic.slow_crank.reference import crank, radii
from validation.row import Row
from validation.zhu_parker_2008.paper import SERIES, problem

OMEGA = 1e-3


def compute() -> list[Row]:
    rows = []
    for series in SERIES:
        at = problem(OMEGA, series, zeta=0.0)
        response = beltsim.linear.response(at)[1] / crank()
        for j in (2, 3):
            got = response[at.labels.index(f"theta_{j}")] * radii()[j - 1] / radii()[0]
            rows.append(Row(f"pulley {j}, {series}", [got.real, got.imag], [1.0, 0.0]))
        rows.append(Row(f"arm, {series}", abs(response[at.joint]), 0.0))
        tensions = [_dynamic(seen, response) for seen in at.observables if seen.unit == "N"]
        rows.append(Row(f"tensions, {series}", tensions, np.zeros(3)))
    return rows


def _dynamic(seen: beltsim.Observable, response: np.ndarray) -> float:
    """Amplitude of a span's dynamic tension over gamma = EA/P0 = 400 and the crank's angle."""
    direct = (seen.cos[1] - 1j * seen.sin[1]) / crank()
    return float(abs(seen.row @ response + direct)) / 400.0
