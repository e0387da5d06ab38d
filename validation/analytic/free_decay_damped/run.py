"""Runs of one damped mass until it stops."""

import numpy as np

from beltsim import transient
from validation.analytic.free_decay_damped.reference import CASES, half_swings
from validation.analytic.one_mass import one_mass
from validation.row import Row


def compute() -> list[Row]:
    rows = []
    settings = transient.Settings(rtol=1e-12)
    for zeta, k, Q, x0 in CASES:
        t, x = half_swings(zeta, k, Q, x0)
        w = np.sqrt(k)
        periods = 1.5 * t[-1] / (2.0 * np.pi)
        run = transient.integrate(one_mass(k, Q, 2.0 * zeta * w), periods, [x0, 0.0], settings)
        where = f"zeta = {zeta}, k = {k}, Q = {Q}, x0 = {x0}"
        rows += [
            Row(f"half swings, {where}", len(run.events), len(t)),
            Row(f"turning points, {where}", run.events.position / x0, x / x0, x=t),
            Row(f"turning times, {where}", w * run.events.t, w * t, x=t),
            Row(f"ends in stick (1), {where}", run.events.kind[-1] == "stick", 1),
        ]
    return rows
