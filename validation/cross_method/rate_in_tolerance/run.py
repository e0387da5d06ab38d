"""Errors of a transient over its tolerance, against the exact motion."""

import numpy as np

import beltsim
from validation.cross_method.rate_in_tolerance.reference import EXPONENTS, exact_modal
from validation.cross_method.slopes import slope
from validation.row import Row

PERIODS = 10
TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)


def compute() -> list[Row]:
    drive = beltsim.presets.zhu_parker_2008()
    problem = beltsim.assemble(drive, 6.3, friction=beltsim.Coulomb(3.5), n_functions=8)
    exact = exact_modal.run(problem, PERIODS)
    rows, different = [], 0
    for method, expected in EXPONENTS.items():
        errors = []
        for rtol in TOLERANCES:
            settings = beltsim.transient.Settings(rtol=rtol, method=method)
            run = beltsim.transient.integrate(problem, PERIODS, settings=settings)
            different += run.events.kind.tolist() != exact.kind
            state = np.abs(run.final_state - exact.final_state).max()
            errors.append([state, np.abs(run.events.t - exact.t).max()])
        for name, error in zip(("end state", "event times"), np.array(errors).T, strict=True):
            rows.append(Row(f"{name}, {method}", slope(TOLERANCES, error), expected))
    return [*rows, Row("events that differ", different, 0)]
