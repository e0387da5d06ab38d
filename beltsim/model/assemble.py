"""The whole chain at one operating point: from a drive to the friction problem.

scale -> operate -> solve -> discretise -> prescribe -> damping, then the friction law, scales and
observables that every solver and report needs.

Depends on: model.*, problem, forcing, friction, checks, errors; drive for its type only.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from beltsim.checks import FloatArray, real_number
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, FrictionLaw, SaturatedCoulomb
from beltsim.model import crank, galerkin, modal, operating_point, scaling, steady_state
from beltsim.model.crank import DrivenSystem
from beltsim.model.plausible import plausibility_warnings
from beltsim.problem import FrictionProblem, Observable, Scales

if TYPE_CHECKING:
    from beltsim.drive import Drive


def assemble(
    drive: Drive,
    Omega: float | None = None,
    *,
    rpm: float | None = None,
    friction: FrictionLaw | None = None,
    n_functions: int | Sequence[int] = 16,
    residual_flexibility: bool = True,
) -> FrictionProblem:
    """The friction problem of a drive at one operating point.

    Parameters
    ----------
    drive : Drive
        The drive, in SI.
    Omega : float, optional
        Firing frequency of the operating point, dimensionless, > 0. Default: the drive's own.
    rpm : float, optional
        Crank speed in revolutions per minute, instead of `Omega`.
    friction : Coulomb or SaturatedCoulomb, optional
        Friction law of the arm in units of P0 r_t. Default: the drive's own law.
    n_functions : int or sequence of int
        Sine functions per span: one number, or one per span.
    residual_flexibility : bool
        Whether the sines left out act statically; without it the series converges slowly.

    Returns
    -------
    FrictionProblem
        Crank prescribed and removed; the arm is the last coordinate and the joint. Without a
        tensioner `joint` is None. Observables: the tension of each span and the arm's angle.

    Raises
    ------
    InvalidProblemError
        On an Omega, rpm or n_functions that cannot be.
    SteadyStateError
        On a slack span or a belt faster than its critical speed.

    .. warning::
        theta_j > 0 turns a pulley with the belt's travel; theta_t > 0 turns the arm
        counter-clockwise as the user sees it; deflections point into the loop.

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> problem = assemble(zhu_parker_2008(), Omega=6.3, friction=Coulomb(3.5))
    >>> problem.n, problem.labels[-2:]
    (51, ('theta_3', 'theta_t'))
    """
    driven = chain(
        drive,
        Omega,
        rpm=rpm,
        n_functions=n_functions,
        residual_flexibility=residual_flexibility,
    )
    return assemble_driven(drive, driven, friction)


def assemble_driven(
    drive: Drive, driven: DrivenSystem, friction: FrictionLaw | None = None
) -> FrictionProblem:
    """The friction problem of a driven system: damping, friction, scales and observables added.

    Parameters
    ----------
    drive : Drive
        The drive that `driven` comes from.
    driven : DrivenSystem
        From `chain`.
    friction : Coulomb or SaturatedCoulomb, optional
        Default: the drive's own law.

    Raises
    ------
    InvalidProblemError
        At standstill (Omega = 0), where there is no forcing period.
    """
    scaled, point = driven.drive, driven.system.state.point
    if point.Omega == 0.0:
        raise InvalidProblemError(Mistake("Omega", point.Omega, "a finite number > 0"))
    law = friction if friction is not None else friction_of(drive)
    coordinates = driven.coordinates
    return FrictionProblem(
        M=driven.M,
        C=modal.damping(driven.M, driven.K, scaled.zeta, coordinates.mass_factor),
        G=driven.G,
        K=driven.K,
        joint=None if scaled.arm is None else len(coordinates.index) - 1,
        forcing=HarmonicForcing(point.fundamental, driven.cos, driven.sin),
        friction=law,
        labels=coordinates.labels,
        scales=Scales(scaled.time_s, scaled.torque_N_m, coordinates.scale, coordinates.units),
        observables=_observables(driven),
        warnings=(
            *plausibility_warnings(drive),
            *driven.system.state.warnings,
            *_friction_warning(law, scaled.preload, scaled.torque_N_m),
        ),
    )


def chain(
    drive: Drive,
    Omega: float | None = None,
    *,
    rpm: float | None = None,
    n_functions: int | Sequence[int] = 16,
    residual_flexibility: bool = True,
) -> DrivenSystem:
    """The chain up to the driven system, whose nouns metrics read; Omega = 0 is allowed.

    Parameters are those of `assemble`. The intermediate nouns hang on the result: `.system`
    (LinearSystem), `.system.state` (SteadyState), `.system.state.point`, `.drive`.
    """
    _require_drive(drive)
    point = operating_point.operate(scaling.scale(drive), _firing_frequency(drive, Omega, rpm))
    system = galerkin.discretise(steady_state.solve(point), n_functions, residual_flexibility)
    return crank.prescribe(system)


def friction_of(drive: Drive) -> Coulomb | None:
    """The drive's own friction law, divided by P0 r_t; None without a tensioner."""
    tensioner = drive.tensioner
    if tensioner is None:
        return None
    unit = scaling.scale(drive).torque_N_m
    static = tensioner.static_friction_torque_N_m
    kinetic = tensioner.friction_torque_N_m
    return Coulomb(kinetic / unit, None if static is None else static / unit)


def _require_drive(drive: Any) -> None:
    from beltsim.drive import Drive  # loads pydantic, as whoever has a drive did before

    if not isinstance(drive, Drive):
        name = repr(str(drive)) if isinstance(drive, str | PathLike) else "path"
        raise InvalidProblemError(Mistake("drive", drive, f"a Drive: beltsim.load_drive({name})"))


def _firing_frequency(drive: Drive, Omega: float | None, rpm: float | None) -> float:
    if Omega is not None and rpm is not None:
        raise InvalidProblemError(Mistake("rpm", rpm, "left out when Omega is given"))
    if rpm is None:
        return float(drive.Omega) if Omega is None else Omega
    speed = real_number(rpm)
    if speed is None or speed <= 0.0:
        raise InvalidProblemError(Mistake("rpm", rpm, "a finite number > 0"))
    return float(drive.omega(speed))


def _observables(driven: DrivenSystem) -> tuple[Observable, ...]:
    """Tension of each span, and the arm's angle from the reference state."""
    scaled, state = driven.drive, driven.system.state
    found = []
    cos = driven.tension_cos.copy()
    cos[:, 0] += state.p[scaled.frame.spans]
    for i in range(scaled.n):
        name = f"tension of span {i + 1}"
        parts = (driven.tension_rows[i], cos[i], driven.tension_sin[i])
        found.append(Observable(name, *parts, lower=0.0, scale=scaled.tension_N, unit="N"))
    if scaled.arm is not None:
        row = np.zeros(len(driven.M))
        row[-1] = 1.0
        rest: FloatArray = np.array([scaled.frame.sign * state.theta_t])
        limit = steady_state.ARM_ANGLE_LIMIT_RAD
        found.append(
            Observable("arm angle", row, rest, np.zeros(1), -limit, limit, unit="rad"),
        )
    return tuple(found)


def _friction_warning(law: FrictionLaw | None, preload: float, unit: float) -> tuple[str, ...]:
    if not isinstance(law, Coulomb | SaturatedCoulomb) or law.Q_m <= abs(preload):
        return ()
    return (
        f"friction torque {law.Q_m * unit:.4g} N m (Q_m = {law.Q_m:.4g}) exceeds the spring torque "
        f"{abs(preload) * unit:.4g} N m ({abs(preload):.4g}): the arm cannot return by itself",
    )
