"""Set-valued harmonic balance over R, beside the exact orbit."""

import numpy as np

from beltsim import event_map, harmonic_balance
from validation.cross_method.slopes import slope
from validation.reference import printed
from validation.row import Row
from validation.zhu_parker_2008.paper import problem

HARMONICS = tuple(range(9, 63, 4))
POINTS = {"no stops": (6.3, 1.0), "with stops": (6.3, 3.5)}


def compute() -> list[Row]:
    expected = printed(__file__)
    rows = []
    for name, (Omega, Q_m) in POINTS.items():
        at = problem(Omega, Q_m=Q_m)
        exact = event_map.periodic(at, event_map.Settings(harmonics=2000)).coefficients[
            1:, at.joint
        ]
        lean = harmonic_balance.Settings(estimate=False)
        errors = [_error(harmonic_balance.solve(at, R, lean), exact) for R in HARMONICS]
        largest = max(error * R for error, R in zip(errors, HARMONICS, strict=True))
        found = harmonic_balance.solve(at, 15)
        size = float(np.sqrt(0.5)) * np.linalg.norm(exact)
        share = _error(found, exact) * size / found.statistics["error_estimate"]
        rows += [
            Row(f"order, {name}", slope(HARMONICS, errors), expected["order"]),
            Row(f"error times R, largest, {name}", largest, expected["bound"]),
            Row(f"error over its estimate, R = 15, {name}", share, expected["covered"]),
        ]
    return rows


def _error(found: object, exact: np.ndarray) -> float:
    """Rms of the difference over the rms, by Parseval."""
    series = found.coefficients[1:, found.problem.joint]
    gap = exact.copy()
    gap[: len(series)] -= series
    return float(np.linalg.norm(gap) / np.linalg.norm(exact))
