"""Frequencies and critical torque over the number of functions, with and without the residual."""

import numpy as np

import beltsim
from validation.cross_method.orders import along_line, order
from validation.reference import printed
from validation.row import Row

OMEGA = 6.3
COUNTS = (24, 32, 40, 48)
FINE = 96


def compute() -> list[Row]:
    expected = printed(__file__)
    limit = _frequencies(FINE, True, 0.1)
    rows, errors = [], {}
    for residual, name in ((False, "plain"), (True, "residual flexibility")):
        found = [_error(_frequencies(n, residual, 0.1), limit) for n in COUNTS]
        line = along_line(COUNTS, found, expected["order"])
        label = "log10 of the relative error"
        rows += [
            Row(f"order, {name}", order(COUNTS, found), expected["order"]),
            Row(
                f"log10 of the errors, {name}",
                np.log10(found),
                line,
                COUNTS,
                "sine functions per span N",
                label,
            ),
        ]
        errors[name] = found
    factor = errors["plain"][0] / errors["residual flexibility"][0]
    name = f"plain error over that with residual flexibility, N = {COUNTS[0]}"
    return [*rows, Row(name, factor, expected["factor"]), *_thin(expected)]


def _thin(expected: dict[str, float]) -> list[Row]:
    """The paper's belt, whose boundary layers are thin."""
    Q_cr, frequencies = _torque(FINE, True), _frequencies(48, True, 0.01, 10)
    ten = _error(_frequencies(16, True, 0.01, 10), frequencies)
    plain = next(n for n in (8, 16, 32, 48) if abs(_torque(n, False) / Q_cr - 1.0) <= 0.01)
    residual = next(n for n in (4, 8, 16) if abs(_torque(n, True) / Q_cr - 1.0) <= 0.01)
    fewest = "fewest functions for 1 % of Q_cr"
    error = abs(_torque(16, True) / Q_cr - 1.0)
    return [
        Row("error of ten frequencies, default, epsilon = 0.01", ten, expected["error"]),
        Row("error of Q_cr, default, epsilon = 0.01", error, expected["error"]),
        Row(f"{fewest}, plain (of 8, 16, 32, 48)", plain, expected["plain"]),
        Row(f"{fewest}, residual flexibility (of 4, 8, 16)", residual, expected["residual"]),
    ]


def _problem(n: int, residual: bool, epsilon: float) -> beltsim.FrictionProblem:
    drive = beltsim.presets.zhu_parker_2008(epsilon=epsilon)
    return beltsim.assemble(drive, OMEGA, n_functions=n, residual_flexibility=residual)


def _frequencies(n: int, residual: bool, epsilon: float, count: int = 6) -> np.ndarray:
    return beltsim.linear.frequencies(_problem(n, residual, epsilon))[:count]


def _torque(n: int, residual: bool) -> float:
    return beltsim.linear.critical_torque(_problem(n, residual, 0.01))


def _error(found: np.ndarray, limit: np.ndarray) -> float:
    return float(np.abs(found / limit - 1.0).max())
