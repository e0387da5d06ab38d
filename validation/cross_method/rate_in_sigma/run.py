"""Difference between saturated and set-valued orbits over sigma."""

import numpy as np

import beltsim
from validation.cross_method.rate_in_sigma.reference import EXPONENT
from validation.cross_method.slopes import slope
from validation.row import Row

SIGMAS = (1e-4, 1e-5, 1e-6, 1e-7)
NAMES = ("rms of pulley 2", "rms of the arm", "dissipated energy")


def compute() -> list[Row]:
    drive, rows = beltsim.presets.zhu_parker_2008(), []
    for Q_m in (1.0, 3.5):
        problem = beltsim.assemble(drive, 6.3, friction=beltsim.Coulomb(Q_m), n_functions=8)
        exact = _figures(problem)
        bands = [problem.with_friction(beltsim.SaturatedCoulomb(Q_m, sigma)) for sigma in SIGMAS]
        errors = np.array([abs(_figures(band) / exact - 1.0) for band in bands])
        rows += [
            Row(f"{name}, Q_m = {Q_m}", slope(SIGMAS, error), EXPONENT)
            for name, error in zip(NAMES, errors.T, strict=True)
        ]
    return rows


def _figures(problem: beltsim.FrictionProblem) -> np.ndarray:
    orbit = beltsim.event_map.periodic(problem)
    return np.array([*beltsim.event_map.rms(orbit)[[-3, -1]], orbit.dissipated_energy])
