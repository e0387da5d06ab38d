"""Runs of one mass until it stops."""

import numpy as np

from beltsim import transient
from validation.analytic.free_decay.reference import CASES, half_swings
from validation.analytic.one_mass import one_mass
from validation.row import Row


def compute() -> list[Row]:
    rows = []
    settings = transient.Settings(rtol=1e-12)
    for k, Q, x0 in CASES:
        t, x = half_swings(k, Q, x0)
        w, energy = np.sqrt(k), 0.5 * k * x0**2
        run = transient.integrate(one_mass(k, Q), 1.5 * t[-1] / (2.0 * np.pi), [x0, 0.0], settings)
        events, end = run.events, run.final_state
        where = f"k = {k}, Q = {Q}, x0 = {x0}"
        rows += [
            Row(f"half swings, {where}", len(events), len(t)),
            Row(f"stopping time, {where}", w * events.t[-1], w * t[-1]),
            Row(f"stopping place, {where}", end[0] / x0, x[-1] / x0),
            Row(f"velocity at the end, {where}", end[1], 0.0),
            Row(f"turning points, {where}", events.position / x0, x / x0, x=t),
            Row(f"turning times, {where}", w * events.t, w * t, x=t),
            Row(
                f"lost energy, {where}",
                run.total_dissipated_energy / energy,
                1.0 - (x[-1] / x0) ** 2,
            ),
        ]
    return rows
