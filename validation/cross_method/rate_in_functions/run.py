"""Errors of figures over N, with and without residual flexibility."""

import numpy as np

import beltsim
from validation.cross_method.rate_in_functions.reference import EXPONENT, GAIN
from validation.cross_method.slopes import slope
from validation.row import Row

COUNTS, FINE = (24, 32, 40), 96
QUICK = beltsim.event_map.Settings(samples_per_period=1, harmonics=0)
NAMES = ("rms of pulley 2", "rms of the arm", "critical torque")


def compute() -> list[Row]:
    drive = beltsim.presets.zhu_parker_2008(epsilon=0.1)
    rows, first = [], {}
    for residual, title in ((True, "residual flexibility"), (False, "plain truncation")):
        fine = _figures(drive, FINE, residual)
        errors = np.array([abs(_figures(drive, N, residual) / fine - 1.0) for N in COUNTS])
        first[residual] = errors[0]
        rows += [
            Row(f"{title}: {name}", slope(COUNTS, error), EXPONENT)
            for name, error in zip(NAMES, errors.T, strict=True)
        ]
    ratio = float((first[True] / first[False]).max())
    name = "residual flexibility: error at N = 24 over that of plain truncation"
    return [*rows, Row(name, ratio, 1.0 / GAIN)]


def _figures(drive: beltsim.drive.Drive, count: int, residual_flexibility: bool) -> np.ndarray:
    problem = beltsim.assemble(
        drive,
        6.3,
        friction=beltsim.Coulomb(1.0),
        n_functions=count,
        residual_flexibility=residual_flexibility,
    )
    rms = beltsim.event_map.rms(beltsim.event_map.periodic(problem, QUICK))
    return np.array([rms[-3], rms[-1], beltsim.linear.critical_torque(problem)])
