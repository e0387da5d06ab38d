"""Runs of one damped mass until it stops."""

import numpy as np

from beltsim import transient
from validation.analytic.free_decay_damped.reference import CASES, half_swings
from validation.analytic.one_mass import one_mass
from validation.row import Row, gathered

TIME = "time times natural frequency"


def compute() -> list[Row]:
    rows = []
    settings = transient.Settings(rtol=1e-12)
    for zeta, k, Q, x0 in CASES:
        t, x = half_swings(zeta, k, Q, x0)
        w = np.sqrt(k)
        periods = 1.5 * t[-1] / (2.0 * np.pi)
        run = transient.integrate(one_mass(k, Q, 2.0 * zeta * w), periods, [x0, 0.0], settings)
        rows += [
            Row("half swings", len(run.events), len(t)),
            Row("turning points", run.events.position / x0, x / x0, w * t, TIME, "place over x0"),
            Row("turning times", w * run.events.t, w * t, w * t, TIME, TIME),
            Row("ends in stick (1)", run.events.kind[-1] == "stick", 1),
        ]
    return gathered(rows)
