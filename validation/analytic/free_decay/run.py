"""Runs of one mass until it stops."""

import numpy as np

from beltsim import transient
from validation.analytic.free_decay.reference import CASES, half_swings
from validation.analytic.one_mass import one_mass
from validation.row import Row, gathered

TIME = "time times natural frequency"


def compute() -> list[Row]:
    rows = []
    settings = transient.Settings(rtol=1e-12)
    for k, Q, x0 in CASES:
        t, x = half_swings(k, Q, x0)
        w, energy = np.sqrt(k), 0.5 * k * x0**2
        run = transient.integrate(one_mass(k, Q), 1.5 * t[-1] / (2.0 * np.pi), [x0, 0.0], settings)
        events, end = run.events, run.final_state
        rows += [
            Row("half swings", len(events), len(t)),
            Row("stopping time", w * events.t[-1], w * t[-1]),
            Row("stopping place", end[0] / x0, x[-1] / x0),
            Row("velocity at the end", end[1], 0.0),
            Row("turning points", events.position / x0, x / x0, w * t, TIME, "place over x0"),
            Row("turning times", w * events.t, w * t, w * t, TIME, TIME),
            Row(
                "lost energy",
                run.total_dissipated_energy / energy,
                1.0 - (x[-1] / x0) ** 2,
            ),
        ]
    return gathered(rows)
