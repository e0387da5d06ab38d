"""Transients of one mass to its steady motion."""

import numpy as np

from beltsim import transient
from validation.analytic.den_hartog.reference import CASES, periods, steady
from validation.analytic.one_mass import one_mass
from validation.row import Row, gathered

RATIO = "forcing frequency over natural frequency"


def compute() -> list[Row]:
    rows = []
    for beta, zeta, f in CASES:
        problem = one_mass(k=1.0, Q=f, c=2.0 * zeta, P=1.0, Omega=beta)
        settings = transient.Settings(rtol=1e-10, keep="events")
        run = transient.integrate(problem, float(periods(beta, zeta)), None, settings)
        amplitude, lag = steady(beta, zeta, f)
        last = run.events.t > run.window[0]
        position, t = run.events.position[last], run.events.t[last]
        top = int(np.argmax(position))
        got_lag = np.angle(np.exp(1j * (beta * t[top] - lag))) + lag
        rows += [
            Row("turns per period", int(np.count_nonzero(last)), 2),
            Row("stops per period", run.stops_per_period, 0.0),
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
                run.dissipated_energy,
                4.0 * f * amplitude,
                x=beta,
                x_label=RATIO,
                y_label="energy over P^2/k",
            ),
        ]
    return gathered(rows)
