"""What an engineer wants first from a drive at one speed, without integrating anything.

Steady tensions, wraps, hub loads, natural frequencies with the arm free and locked, the friction
torque that locks the arm, and how fast a start dies away. In SI where the name carries a unit.

Depends on: model, linear, metrics.hub_loads, metrics.mode_kind; drive for its type only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from beltsim import linear
from beltsim.metrics.hub_loads import newtons, steady_hub_loads
from beltsim.metrics.mode_kind import ModeKind, mode_kind
from beltsim.model.assemble import assemble_driven, chain
from beltsim.model.plausible import windup_deg
from beltsim.problem import FrictionProblem

if TYPE_CHECKING:
    from beltsim.drive import Drive
    from beltsim.drive.schema import CrankOrder
    from beltsim.friction import FrictionLaw
    from beltsim.model.crank import DrivenSystem


@dataclass(frozen=True)
class SurveyedSpan:
    """A span: its ends, length, steady tension, and what is left of it without rho c^2."""

    name: str
    length_m: float
    tension_N: float
    tension_without_centrifugal_N: float


@dataclass(frozen=True)
class SurveyedPulley:
    """A pulley: angle of contact and steady force of the belt on its hub."""

    name: str
    wrap_deg: float
    hub_load_x_N: float
    hub_load_y_N: float

    @property
    def hub_load_N(self) -> float:
        """Size of the hub load."""
        return float(np.hypot(self.hub_load_x_N, self.hub_load_y_N))


@dataclass(frozen=True)
class SurveyedMode:
    """A natural frequency (undamped, gyroscopic) and what moves in it."""

    frequency_Hz: float
    Omega: float
    kind: ModeKind


@dataclass(frozen=True)
class Survey:
    """A drive at one speed.

    Parameters
    ----------
    name : str
    rpm, Omega : float
        Crank speed and dimensionless firing frequency.
    belt_speed_m_s : float
    spans : tuple of SurveyedSpan
    pulleys : tuple of SurveyedPulley
    arm_angle_rad : float or None
        Rest angle of the arm from the reference state, counter-clockwise; None without a tensioner.
    spring_torque_N_m : float or None
        Size of the torque of the arm's spring at that angle.
    spring_windup_deg : float or None
        Angle by which the spring is wound up in the reference state.
    friction_torque_N_m : float or None
        Kinetic friction torque of the arm.
    free, locked : tuple of SurveyedMode
        Modes with the arm free and locked; `locked` is empty without a tensioner.
    Q_cr : float or None
        Friction torque that keeps the arm locked, in P0 r_t.
    critical_torque_N_m : float or None
        The same in N m.
    decay_free, decay_locked : float or None
        Decay of the slowest mode per forcing period: exp(-decay x) is left after x periods.
    orders : tuple of CrankOrder
        The crank's motion about its mean speed, order by order.
    default_excitation : bool
        Whether the drive gives no excitation, so that the orders are the default.
    warnings : tuple of str
    """

    name: str
    rpm: float
    Omega: float
    belt_speed_m_s: float
    spans: tuple[SurveyedSpan, ...]
    pulleys: tuple[SurveyedPulley, ...]
    arm_angle_rad: float | None
    spring_torque_N_m: float | None
    spring_windup_deg: float | None
    friction_torque_N_m: float | None
    free: tuple[SurveyedMode, ...]
    locked: tuple[SurveyedMode, ...]
    Q_cr: float | None
    critical_torque_N_m: float | None
    decay_free: float
    decay_locked: float | None
    orders: tuple[CrankOrder, ...]
    default_excitation: bool
    warnings: tuple[str, ...]


def survey(
    drive: Drive,
    Omega: float | None = None,
    *,
    rpm: float | None = None,
    friction: FrictionLaw | None = None,
    n_functions: int | Sequence[int] = 16,
    residual_flexibility: bool = True,
    n_modes: int = 12,
) -> Survey:
    """Survey of a drive at one operating point.

    Parameters
    ----------
    drive, Omega, rpm, friction, n_functions, residual_flexibility
        As for `beltsim.assemble`.
    n_modes : int
        How many modes to list.

    Returns
    -------
    Survey

    Raises
    ------
    InvalidProblemError, SteadyStateError
        As `beltsim.assemble`.

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> found = survey(zhu_parker_2008())
    >>> [round(span.tension_N, 1) for span in found.spans]
    [376.7, 376.7, 376.7]
    """
    driven = chain(
        drive, Omega, rpm=rpm, n_functions=n_functions, residual_flexibility=residual_flexibility
    )
    problem = assemble_driven(drive, driven, friction)
    scaled, state = driven.drive, driven.system.state
    jointed = problem.joint is not None
    Q_cr = linear.critical_torque(problem) if jointed else None
    unit, spring = scaled.torque_N_m, scaled.preload + scaled.k_s * state.theta_t
    law = problem.friction
    return Survey(
        name=drive.name,
        rpm=float(drive.rpm(state.point.Omega)),
        Omega=state.point.Omega,
        belt_speed_m_s=state.point.belt_speed_m_s,
        spans=_spans(driven),
        pulleys=_pulleys(drive, driven),
        arm_angle_rad=scaled.frame.sign * state.theta_t if jointed else None,
        spring_torque_N_m=abs(spring) * unit if jointed else None,
        spring_windup_deg=windup_deg(drive),
        friction_torque_N_m=unit * law.Q_m if law is not None else None,
        free=_modes(problem, False, n_modes),
        locked=_modes(problem, True, n_modes) if jointed else (),
        Q_cr=Q_cr,
        critical_torque_N_m=None if Q_cr is None else Q_cr * unit,
        decay_free=linear.decay(problem),
        decay_locked=linear.decay(problem, locked=True) if jointed else None,
        orders=drive.orders,
        default_excitation="excitation" not in drive.model_fields_set,
        warnings=(*drive.layout.warnings, *problem.warnings),
    )


def _spans(driven: DrivenSystem) -> tuple[SurveyedSpan, ...]:
    scaled, state = driven.drive, driven.system.state
    P0 = scaled.tension_N
    return tuple(
        SurveyedSpan(
            scaled.span_name(i),
            float(scaled.span_length[i]) * scaled.length_m,
            float(state.p[i]) * P0,
            float(state.T[i]) * P0,
        )
        for i in scaled.frame.spans.tolist()
    )


def _pulleys(drive: Drive, driven: DrivenSystem) -> tuple[SurveyedPulley, ...]:
    state = driven.system.state
    loads = newtons(state, steady_hub_loads(state)).tolist()
    wraps = np.degrees(drive.layout.wrap_rad).tolist()
    return tuple(
        SurveyedPulley(name, wrap, *load)
        for name, wrap, load in zip(drive.layout.names, wraps, loads, strict=True)
    )


def _modes(problem: FrictionProblem, locked: bool, n_modes: int) -> tuple[SurveyedMode, ...]:
    found = linear.modes(problem, locked)
    in_Hz = linear.hertz(problem, found.frequencies).tolist()
    listed = zip(in_Hz, found.frequencies.tolist(), found.shapes, strict=True)
    return tuple(
        SurveyedMode(hz, omega, mode_kind(problem, shape))
        for hz, omega, shape in list(listed)[:n_modes]
    )
