"""Long transients at five friction torques."""

from beltsim import transient
from validation.cross_method.dissipated_energy.reference import energy
from validation.row import Row, gathered
from validation.zhu_parker_2008.paper import problem

TORQUES = (1.0, 3.5, 5.0, 6.1, 10.0)
PERIODS = 60


def compute() -> list[Row]:
    rows = []
    for Q_m in TORQUES:
        at = problem(6.3, Q_m=Q_m)
        run = transient.integrate(at, float(PERIODS), None, transient.Settings(keep="events"))
        over = {"x": Q_m, "x_label": "friction torque Q_m over P0 r_t"}
        expected, stops = energy(at, PERIODS)
        rows += [
            Row("energy", run.dissipated_energy, expected, **over, y_label="energy over P0 r_t"),
            Row("stops per period", run.stops_per_period, stops, **over),
            Row("reversals nu", run.velocity_reversals, 0.0, **over),
        ]
    return gathered(rows)
