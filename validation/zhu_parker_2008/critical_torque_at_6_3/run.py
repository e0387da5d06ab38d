"""The critical torque at 6.3, as published and with everything that was tried to reach 18.7."""

from dataclasses import replace
from typing import Any

import numpy as np

import beltsim
from beltsim import linear
from beltsim.model import chain
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
        "damping from the modes with the crank free": _with_crank_free(as_published),
        "damping from the complex modes of the locked arm": _complex_damping(as_published),
        "no damping": critical_torque(OMEGA, zeta=0.0),
        "damping ratio with the largest Q_cr, up to 0.2": max(
            critical_torque(OMEGA, zeta=zeta) for zeta in RATIOS.tolist()
        ),
        "travel reversed": _reversed(),
        "belt speed s = 0.054": _at_speed_of_order(29.5),
        "belt speed s = 0.80": _at_speed_of_order(2.0),
        "stiffness without the belt's centrifugal tension": _at_standstill(as_published),
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
    swing = expected["mu"] * expected["Q_cr"] / tried["N = (4, 5, 5), as published otherwise"]
    rows.append(("amplitude mu of the crank at which Q_cr is 18.7", swing, expected["mu"]))
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


def _with_crank_free(at: Any) -> float:
    """Damping of the modes of the whole system, without the crank's row and column."""
    driven = chain(beltsim.presets.zhu_parker_2008(), OMEGA, **SERIES[SHORT])
    system, found = driven.system, driven.coordinates
    K = system.K + 1e-9 * system.M  # as a whole it turns freely
    return _damped(at, found.turned(damping(system.M, K, 0.05)))


def _complex_damping(at: Any) -> float:
    """Ratio 0.05 for the complex modes of the gyroscopic system, arm locked."""
    held = replace(at.locked(), C=np.zeros((at.n - 1, at.n - 1)))
    n, W = held.n, OMEGA
    A = np.zeros((2 * n, 2 * n))
    A[:n, n:] = np.eye(n)
    A[n:, :n], A[n:, n:] = -np.linalg.solve(held.M, held.K), -np.linalg.solve(held.M, held.G)
    rates, shapes = np.linalg.eig(A)
    size = np.abs(rates)
    damped = -0.05 * size + 1j * np.sign(rates.imag) * size * np.sqrt(1.0 - 0.05**2)
    load = np.concatenate([np.zeros(n), np.linalg.solve(held.M, held.forcing.coefficients[1])])
    q = (shapes @ (np.linalg.solve(shapes, load) / (1j * W - damped)))[:n]
    row = {name: getattr(at, name)[at.joint, at.others] for name in "MGK"}
    reaction = (row["K"] + 1j * W * row["G"] - W**2 * row["M"]) @ q
    return float(abs(at.forcing.coefficients[1][at.joint] - reaction))


def _at_standstill(at: Any) -> float:
    """Stiffness, and with it the crank's push, of the belt at rest; all else as it runs."""
    still = problem(1e-6)
    forcing = beltsim.HarmonicForcing(OMEGA, still.forcing.cos, still.forcing.sin)
    return linear.critical_torque(replace(at, K=still.K, forcing=forcing))


def _reversed() -> float:
    drive = beltsim.presets.zhu_parker_2008().model_copy(update={"crank_rotation": "ccw"})
    return linear.critical_torque(beltsim.assemble(drive, OMEGA, **SERIES[SHORT]))


def _at_speed_of_order(alpha: float) -> float:
    """Belt speed r_1 Omega/(alpha l) of another firing order, with the same motion of the crank."""
    return critical_torque(OMEGA, alpha=alpha, mu=0.10 / 3.0 * alpha)


def _sign_slip(at: Any) -> float:
    force = at.forcing.coefficients[1][at.joint]
    return float(abs(2.0 * force - linear.reaction(at)[1]))
