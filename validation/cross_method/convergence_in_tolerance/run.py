"""The end state of one transient for several tolerances, beside the exact one."""

import numpy as np

from beltsim import transient
from validation.cross_method import exact_modal
from validation.cross_method.orders import along_line, order
from validation.reference import printed
from validation.row import Row
from validation.zhu_parker_2008.paper import problem

PERIODS = 10
TOLERANCES = tuple(10.0**-k for k in range(5, 11))


def compute() -> list[Row]:
    expected = printed(__file__)
    at = problem(6.3, Q_m=3.5)
    exact = exact_modal.run(at, PERIODS).final_state
    weight = np.repeat([1.0, 1.0 / at.forcing.Omega], at.n)
    rows = []
    for method in ("adams", "bdf", "taylor"):
        errors = []
        for rtol in TOLERANCES:
            settings = transient.Settings(rtol=rtol, method=method, keep="events")
            end = transient.integrate(at, float(PERIODS), None, settings).final_state
            errors.append(np.abs((end - exact) * weight).max() / np.abs(exact * weight).max())
        largest = max(e / rtol for e, rtol in zip(errors, TOLERANCES, strict=True))
        rows.append(Row(f"error over rtol, largest, {method}", largest, expected["bound"]))
        if method == "taylor":  # at rounding before its order shows
            continue
        rows += [
            Row(f"order, {method}", order(TOLERANCES, errors), expected["order"]),
            Row(
                f"log10 of the errors, {method}",
                np.log10(errors),
                along_line(TOLERANCES, errors, expected["order"]),
                np.log10(TOLERANCES),
                "log10 of rtol",
                "log10 of the relative error",
            ),
        ]
    return rows
