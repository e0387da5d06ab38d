"""Periodic orbits of one mass by the event map."""

import numpy as np

from beltsim import event_map
from validation.analytic.den_hartog_orbit.reference import CASES, steady
from validation.analytic.one_mass import one_mass
from validation.row import Row, gathered

RATIO = "forcing frequency over natural frequency"


def compute() -> list[Row]:
    rows = []
    for beta, zeta, f in CASES:
        problem = one_mass(k=1.0, Q=f, c=2.0 * zeta, P=1.0, Omega=beta)
        orbit = event_map.periodic(problem)
        amplitude, lag = steady(beta, zeta, f)
        position, t = orbit.events.position, orbit.events.t
        top = int(np.argmax(position))
        got_lag = np.angle(np.exp(1j * (beta * t[top] - lag))) + lag
        rows += [
            Row("turns per period", len(orbit.events), 2),
            Row(
                "upper amplitude",
                position[top],
                amplitude,
                x=beta,
                x_label=RATIO,
                y_label="amplitude over P/k",
            ),
            Row(
                "lower amplitude",
                -position.min(),
                amplitude,
                x=beta,
                x_label=RATIO,
                y_label="amplitude over P/k",
            ),
            Row("phase", got_lag, lag, x=beta, x_label=RATIO, y_label="phase, rad"),
            Row(
                "dissipated energy",
                orbit.dissipated_energy,
                4.0 * f * amplitude,
                x=beta,
                x_label=RATIO,
                y_label="energy over P^2/k",
            ),
        ]
    return gathered(rows)
