"""The paper's drive at both ends of the friction torque."""

import numpy as np

import beltsim
from beltsim import transient
from validation.analytic.free_and_locked_limits.reference import held, series, steady
from validation.row import Row, gathered
from validation.zhu_parker_2008.paper import problem

SETTINGS = transient.Settings(rtol=1e-10, samples_per_period=64)


def compute() -> list[Row]:
    rows = []
    for Omega in (2.8, 6.3):
        rows += _free(Omega) + _locked(Omega)
    return gathered(rows)


def _free(Omega: float) -> list[Row]:
    at = problem(Omega, Q_m=0.0)
    shape = steady(at, locked=False)
    run = _started(at, shape)
    expected = series(shape, Omega, run.t)
    size = np.abs(expected).max()
    linear = beltsim.linear.response(at)[1]
    return [
        Row("all coordinates, free", run.q / size, expected / size),
        Row("linear.response, free", abs(linear - shape).max() / size, 0.0),
    ]


def _locked(Omega: float) -> list[Row]:
    free = problem(Omega)
    shape = steady(free, locked=True)
    H = held(free, shape)
    above = _started(free.with_friction(beltsim.Coulomb(1.001 * abs(H))), shape)
    below = _started(free.with_friction(beltsim.Coulomb(0.999 * abs(H))), shape)
    expected = series(np.array([H]), Omega, above.t)[:, 0]
    return [
        Row("critical torque", beltsim.linear.critical_torque(free), abs(H)),
        Row("events at 1.001 Q_cr", len(above.events), 0),
        Row("arm moves at 1.001 Q_cr", np.abs(above.q[:, free.joint]).max(), 0.0),
        Row("holding torque over Q_cr", above.friction_torque / abs(H), expected / abs(H)),
        Row("slips (1) at 0.999 Q_cr", int("slip+" in below.events.kind), 1),
    ]


def _started(at: beltsim.FrictionProblem, shape: np.ndarray) -> beltsim.Response:
    """Two periods from the steady state Re shape exp(i Omega t)."""
    start = np.concatenate([shape.real, (1j * at.forcing.Omega * shape).real])
    return transient.integrate(at, 2.0, start, SETTINGS)
