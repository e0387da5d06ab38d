"""The critical torque at 6.3, as published and with everything that was tried to reach 18.7."""

from dataclasses import replace
from typing import Any

import numpy as np

import beltsim
from beltsim import linear
from beltsim.model.modal import damping
from validation.reference import printed
from validation.zhu_parker_2008.paper import (
    CONVERGED,
    SERIES,
    SHORT,
    critical_torque,
    first_crossing,
    problem,
)

OMEGA = 6.3
RATIOS = np.linspace(0.0, 0.2, 41)


def compute() -> list[tuple[str, float, float]]:
    expected = printed(__file__)
    as_published = problem(OMEGA)
    tried = {
        "N = (4, 5, 5), as published otherwise": linear.critical_torque(as_published),
        **{f"N = {n}": _with_functions(n) for n in (8, 16, 80, 1)},
        "converged": critical_torque(OMEGA, CONVERGED),
        "damping from the modes of the locked arm": _locked_damping(as_published),
        "damping from the modes at standstill": _damped(as_published, problem(1e-6).C),
        "no damping": critical_torque(OMEGA, zeta=0.0),
        "damping ratio with the largest Q_cr, up to 0.2": max(
            critical_torque(OMEGA, zeta=zeta) for zeta in RATIOS.tolist()
        ),
        "travel reversed": _reversed(),
        "belt speed s = 0.054": _at_speed_of_order(29.5),
        "belt speed s = 0.80": _at_speed_of_order(2.0),
        "peak to peak": 2.0 * linear.critical_torque(as_published),
        "rms": linear.critical_torque(as_published) / np.sqrt(2.0),
        "sum in eq. (26) added instead of subtracted": _sign_slip(as_published),
    }
    rows = [(name, float(got), expected["Q_cr"]) for name, got in tried.items()]
    up = first_crossing(critical_torque, expected["Q_cr"], np.linspace(6.0, 6.8, 17))
    down = first_crossing(
        lambda x: -critical_torque(x), -expected["Q_cr"], np.linspace(6.8, 7.2, 9)
    )
    rows.append(("Omega at which Q_cr rises through 18.7", up, expected["Omega"]))
    rows.append(("Omega at which Q_cr falls through 18.7", down, expected["Omega"]))
    return rows


def _with_functions(n: int) -> float:
    drive = beltsim.presets.zhu_parker_2008()
    at = beltsim.assemble(drive, OMEGA, n_functions=n, residual_flexibility=False)
    return linear.critical_torque(at)


def _damped(at: Any, C: np.ndarray) -> float:
    return linear.critical_torque(replace(at, C=C))


def _locked_damping(at: Any) -> float:
    locked = at.locked()
    C = np.zeros_like(at.C)
    C[np.ix_(at.others, at.others)] = damping(locked.M, locked.K, 0.05)
    return _damped(at, C)


def _reversed() -> float:
    drive = beltsim.presets.zhu_parker_2008().model_copy(update={"crank_rotation": "ccw"})
    return linear.critical_torque(beltsim.assemble(drive, OMEGA, **SERIES[SHORT]))


def _at_speed_of_order(alpha: float) -> float:
    """Belt speed r_1 Omega/(alpha l) of another firing order, with the same motion of the crank."""
    return critical_torque(OMEGA, alpha=alpha, mu=0.10 / 3.0 * alpha)


def _sign_slip(at: Any) -> float:
    force = at.forcing.coefficients[1][at.joint]
    return float(abs(2.0 * force - linear.reaction(at)[1]))
