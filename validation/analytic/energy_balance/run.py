"""Energy balance of a running and of a settled period, from the samples alone."""

from beltsim import transient
from validation.analytic.energy_balance.reference import account
from validation.row import Row, gathered
from validation.zhu_parker_2008.paper import problem


def compute() -> list[Row]:
    rows = []
    settings = transient.Settings(rtol=1e-10, samples_per_period=4000)
    for Q_m, periods in ((0.5, 3), (3.5, 3), (3.5, 20), (10.0, 20)):
        at = problem(6.3, Q_m=Q_m)
        run = transient.integrate(at, float(periods), None, settings)
        sums = account(at, run.t, run.q, run.q_dot, run.friction_torque)
        work, friction = sums["work"], sums["friction"]
        rows += [
            Row("losses and gain", (work - sums["rest"]) / work, 1.0),
            Row("friction loss", run.dissipated_energy / work, friction / work),
            Row("residual that beltsim gives", run.energy_balance_residual, 0.0),
        ]
    return gathered(rows)
