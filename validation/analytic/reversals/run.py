"""Steady motion under two harmonics and weak friction, by three solvers."""

import numpy as np

from beltsim import (
    Coulomb,
    FrictionProblem,
    HarmonicForcing,
    event_map,
    harmonic_balance,
    transient,
)
from validation.analytic.reversals.reference import DAMPING, LOADS, ORDERS, STIFFNESS, nu, turns
from validation.row import Row

FRICTION = 2e-2


def compute() -> list[Row]:
    rows = []
    for k in ORDERS:
        cos = np.zeros((k + 1, 1))
        cos[1], cos[k] = LOADS[1], LOADS[0]
        load = HarmonicForcing(1.0, cos, np.zeros_like(cos))
        matrices = [[1.0]], [[DAMPING]], [[0.0]], [[STIFFNESS]]
        mass = FrictionProblem(*matrices, 0, load, Coulomb(FRICTION))
        orbit = event_map.periodic(mass)
        found = {
            "event map": orbit,
            "C core": transient.integrate(mass, 60.0),
            "harmonic balance": harmonic_balance.solve(mass, 41),
        }
        for name, response in found.items():
            rows.append(Row(f"nu, k = {k}, {name}", response.velocity_reversals, nu(k)))
            rows.append(Row(f"stops, k = {k}, {name}", response.stops_per_period, 0.0))
        times = orbit.events.t / mass.period
        label = "time over the forcing period"
        rows.append(Row(f"instants, k = {k}", times, turns(k), turns(k), label, label))
    return rows
