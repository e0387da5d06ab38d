r"""Steady state of a running drive: span tensions, bent spans and the arm's rest angle.

Each span obeys :math:`-T w_{xx} + \epsilon_i^2 w_{xxxx} = 0` with the curvature of the pulleys at
both ends, so its shape is known in closed form (delta = sqrt(eps2/T), end curvatures k0, k1):

.. math:: w = \delta^2 [k_0 S(1-x) + k_1 S(x)] + (w(0) - \delta^2 k_0) + g x,
    \quad S(z) = \frac{\sinh(z/\delta)}{\sinh(1/\delta)}, \quad g = u - \delta^2 (k_1 - k_0)

with the chord u = w(1) - w(0). The shear T g is constant along the span. With g eliminated, the
stretch of a bent span splits into its chord and a part that depends on T alone:

.. math:: \tfrac12\int w_x^2 = \tfrac12 u^2 + b(T), \quad 2 b = \delta^2 [(k_0^2 + k_1^2) I_2
    - 2 k_0 k_1 I_{11}] - \delta^4 (k_1 - k_0)^2

with I_2, I_11 the integrals of the two layers' slopes, squared and multiplied. What is left are two
equations for the tension p of the last span and the arm's angle theta_t (p_i = p + o_i, o_i the
sum of the torques up to pulley i):

.. math:: \sum l_i (p_i - 1)/\gamma = \sum arm_i\,\theta_t + \sum l_i (\tfrac12 u_i^2 + b_i)

.. math:: k_s\theta_t + preload + \sum_i e_i T_i + c_i T_i g_i = 0

where e, c are -sin, cos of beta_1 on span T-1 and sin, -cos of beta_2 on span T. The friction
torque is zero by convention: friction makes the rest angle an interval, this is its middle.

Depends on: model.scaling, model.operating_point, checks, errors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from beltsim.checks import FloatArray, read_only
from beltsim.errors import ConvergenceError, SteadyStateError
from beltsim.model.operating_point import OperatingPoint
from beltsim.model.scaling import DimensionlessDrive

#: Limits of the linear geometry; beyond them the result carries a warning.
SLOPE_LIMIT, ARM_ANGLE_LIMIT_RAD, PRELOAD_LIMIT = 0.3, 0.1, 0.1
#: Newton is quadratic here: a last step of this size leaves an error of rounding size.
STEP_TOLERANCE = 1e-10
MAX_ITERATIONS = 60


class _Layer(NamedTuple):
    """One span's boundary layers: width, hyperbolics of 1/delta, b(T) and its derivative."""

    delta: float
    csch: float
    coth: float
    b: float
    b_T: float


@dataclass(frozen=True, eq=False)
class SteadyState:
    """Steady state in the canonical frame, dimensionless; arrays have one entry per span.

    Parameters
    ----------
    point : OperatingPoint
    p : (n,)
        Belt tension.
    T : (n,)
        p - s^2, the tension that holds the span straight.
    theta_t : float
        Rest angle of the arm; 0 without one.
    delta : (n,)
        Width of the boundary layers; 0 for a string.
    w_0, w_1 : (n,)
        Deflection at x = 0 and x = 1.
    g : (n,)
        Slope far from the layers; the shear is T g.
    flexibility : (n,)
        -d(1/2 int w_x^2)/dT with the ends held: how much a bent span gives.
    warnings : tuple of str
    iterations : int
    """

    point: OperatingPoint
    p: FloatArray
    T: FloatArray
    theta_t: float
    delta: FloatArray
    w_0: FloatArray
    w_1: FloatArray
    g: FloatArray
    flexibility: FloatArray
    warnings: tuple[str, ...]
    iterations: int

    def __post_init__(self) -> None:
        for name in ("p", "T", "delta", "w_0", "w_1", "g", "flexibility"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def drive(self) -> DimensionlessDrive:
        """The drive this is a state of."""
        return self.point.drive

    def deflection(self, x: Any) -> FloatArray:
        """Deflections w*(x) of the spans at `x` (nx,) in [0, 1]: array (n, nx)."""
        x = np.asarray(x, dtype=float)
        line: FloatArray = self.w_0[:, None] + np.multiply.outer(self.g, x)
        if self.drive.epsilon == 0.0:
            return line
        k0, k1 = (k[:, None] for k in self.drive.curvatures)
        d = self.delta[:, None]
        # sinh(z/d)/sinh(1/d) through exponentials that decay away from its end
        rise = np.exp((x - 1.0) / d) * np.expm1(-2.0 * x / d) / np.expm1(-2.0 / d)
        fall = np.exp(-x / d) * np.expm1(-2.0 * (1.0 - x) / d) / np.expm1(-2.0 / d)
        found: FloatArray = line + d**2 * (k0 * (fall - 1.0) + k1 * rise)
        return found


def solve(point: OperatingPoint) -> SteadyState:
    """Steady state at an operating point.

    Parameters
    ----------
    point : OperatingPoint

    Returns
    -------
    SteadyState

    Raises
    ------
    SteadyStateError
        When the string limit has a slack span, or a belt faster than its critical speed. It is
        refused there because with bending the equations keep a root at a tiny tension.
    ConvergenceError
        When Newton does not converge.

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> from beltsim.model import operating_point, scaling
    >>> drive = scaling.scale(zhu_parker_2008())
    >>> state = solve(operating_point.operate(drive, 6.3))
    >>> state.p.round(2)
    array([1.26, 1.26, 1.26])
    """
    drive = point.drive
    offset = np.cumsum(drive.accessory_torque)
    arm = _ArmRow.of(drive)
    p, theta_t = _string_limit(point, offset, arm)
    p, theta_t, iterations = _newton(point, offset, arm, p, theta_t)
    tensions = p + offset
    T = tensions - point.s**2
    layers = _layers(drive, T)
    delta = np.array([layer.delta for layer in layers])
    A0, A1 = drive.arm_deflections
    k0, k1 = drive.curvatures
    g = drive.arm_chord * theta_t - delta**2 * (k1 - k0)
    return SteadyState(
        point=point,
        p=tensions,
        T=T,
        theta_t=theta_t,
        delta=delta,
        w_0=A0 * theta_t,
        w_1=A1 * theta_t,
        g=g,
        flexibility=np.array([-layer.b_T for layer in layers]),
        warnings=_warnings(drive, theta_t, layers, g),
        iterations=iterations,
    )


class _ArmRow(NamedTuple):
    """Factors of T_i and of T_i g_i in the arm's balance."""

    e: FloatArray
    c: FloatArray

    @classmethod
    def of(cls, drive: DimensionlessDrive) -> _ArmRow:
        return cls(
            drive.arm_stretch / drive.lever, drive.arm_chord * drive.span_length / drive.lever
        )


def _string_limit(point: OperatingPoint, offset: FloatArray, arm: _ArmRow) -> tuple[float, float]:
    """Tension of the last span and arm angle of the straight belt, or the reason why not."""
    drive, length = point.drive, point.drive.span_length
    total = float(length.sum())
    mean = float(length @ offset) / total
    theta_t = 0.0
    if drive.arm is not None:
        a = drive.gamma * float(drive.arm_stretch.sum()) / total
        pull = drive.preload * (-mean - point.s**2) - float(arm.e @ offset)
        theta_t = pull / (drive.k_s - drive.preload * a)
        p = 1.0 - mean + a * theta_t
    else:
        p = 1.0 - mean
    T = p + offset - point.s**2
    if T.min() <= 0.0:
        raise SteadyStateError(_refusal(point, p + offset, int(np.argmin(T))))
    return p, theta_t


def _refusal(point: OperatingPoint, p: FloatArray, span: int) -> str:
    drive = point.drive
    tension = float(p[span]) * drive.tension_N
    centrifugal = point.s**2 * drive.tension_N
    where = f"{drive.span_name(span)} at Omega = {point.Omega:g}"
    speed = f"the belt runs at {point.belt_speed_m_s:.4g} m/s"
    if tension <= 0.0:
        return (
            f"{where} is slack: its steady tension would be {tension:.4g} N ({speed}); "
            "raise belt.initial_tension_N or lower the accessory torques"
        )
    return (
        f"{where} runs faster than its critical speed: {speed}, which takes {centrifugal:.4g} N of "
        f"its steady tension of {tension:.4g} N; lower the speed, raise belt.initial_tension_N or "
        "lower the accessory torques"
    )


def _newton(
    point: OperatingPoint, offset: FloatArray, arm: _ArmRow, p: float, theta_t: float
) -> tuple[float, float, int]:
    """Damped Newton for (p, theta_t); the stretch equation is scaled by gamma/n."""
    drive, length = point.drive, point.drive.span_length
    k0, k1 = drive.curvatures
    chord = drive.arm_chord
    held = offset - point.s**2
    free = drive.arm is not None
    scale = drive.gamma / drive.n
    total, stretch = float(length.sum()), float(drive.arm_stretch.sum())
    chord_2, pull = float(length @ chord**2), float(arm.e.sum())
    turn = arm.c * chord
    turn_sum, turn_held = float(turn.sum()), float(turn @ held)
    bend = drive.preload + float(arm.e @ held) - float(arm.c @ (drive.eps2 * (k1 - k0)))
    strains = float(length @ (offset - 1.0)) / drive.gamma
    lowest, lengths = float(held.min()), length.tolist()
    history = []
    for iteration in range(1, MAX_ITERATIONS + 1):
        layers = _layers(drive, p + held)
        bends = sum(l * layer.b for l, layer in zip(lengths, layers, strict=True))
        bends_T = sum(l * layer.b_T for l, layer in zip(lengths, layers, strict=True))
        along = total / drive.gamma * p + strains
        r1 = scale * (along - stretch * theta_t - 0.5 * chord_2 * theta_t**2 - bends)
        r2 = (drive.k_s + turn_sum * p + turn_held) * theta_t + pull * p + bend if free else 0.0
        history.append(max(abs(r1), abs(r2)))
        j11 = scale * (total / drive.gamma - bends_T)
        j12 = scale * (-stretch - chord_2 * theta_t)
        j21, j22 = pull + turn_sum * theta_t, drive.k_s + turn_sum * p + turn_held
        if not free:
            j12, j21, j22 = 0.0, 0.0, 1.0
        determinant = j11 * j22 - j12 * j21
        if determinant == 0.0:
            break
        step_p = (j12 * r2 - j22 * r1) / determinant
        step_t = (j21 * r1 - j11 * r2) / determinant
        while p + lowest + step_p <= 0.0:
            step_p, step_t = 0.5 * step_p, 0.5 * step_t
        p, theta_t = p + step_p, theta_t + step_t
        if abs(step_p) <= STEP_TOLERANCE * (p + lowest) and abs(step_t) <= STEP_TOLERANCE:
            return p, theta_t, iteration
    message = (
        f"steady state at Omega = {point.Omega:g}: Newton stopped at residual {history[-1]:.3g} "
        f"after {len(history)} iterations; the belt is probably too stiff in bending for its "
        f"tension (epsilon = {drive.epsilon:g}): lower belt.EI_N_m2 or raise "
        "belt.initial_tension_N"
    )
    raise ConvergenceError(message, partial=(p, theta_t), residual_history=history)


def _layers(drive: DimensionlessDrive, T: FloatArray) -> list[_Layer]:
    """Boundary layers of all spans; plain floats are faster than arrays for a few spans."""
    if drive.epsilon == 0.0:
        return [_Layer(0.0, 0.0, 1.0, 0.0, 0.0)] * drive.n
    k0, k1 = drive.curvatures
    columns = (k0.tolist(), k1.tolist(), drive.eps2.tolist(), T.tolist())
    return [_layer(*span) for span in zip(*columns, strict=True)]


def _layer(k0: float, k1: float, eps2: float, T: float) -> _Layer:
    """Boundary layers of one span, through exponentials that decay."""
    d2 = eps2 / T
    d = math.sqrt(d2)
    csch = -2.0 * math.exp(-1.0 / d) / math.expm1(-2.0 / d)
    csch_2 = csch * csch
    coth = math.sqrt(1.0 + csch_2)
    # I2 = int C0^2 = int C1^2, I11 = int C0 C1; _d: derivative by delta
    I2 = 0.5 * (d * coth + csch_2)
    I11 = 0.5 * csch * (coth + d)
    I2_d = 0.5 * coth + csch_2 * (0.5 / d + coth / d2)
    I11_d = 0.5 * csch * ((csch_2 + coth * coth) / d2 + coth / d + 1.0)
    same, cross, jump = k0 * k0 + k1 * k1, 2.0 * k0 * k1, (k1 - k0) ** 2
    inner = same * I2 - cross * I11
    b = 0.5 * d2 * (inner - d2 * jump)
    b_d = d * inner + 0.5 * d2 * (same * I2_d - cross * I11_d) - 2.0 * d2 * d * jump
    return _Layer(d, csch, coth, b, -0.5 * b_d * d / T)


def _steepest(drive: DimensionlessDrive, layers: list[_Layer], g: FloatArray) -> tuple[float, int]:
    """Largest slope |w_x| of all spans, and the span it is in."""
    k0, k1 = drive.curvatures
    slopes = [
        _steepest_of(*span)
        for span in zip(layers, k0.tolist(), k1.tolist(), g.tolist(), strict=True)
    ]
    steepest = max(slopes)
    return steepest, slopes.index(steepest)


def _steepest_of(layer: _Layer, k0: float, k1: float, g: float) -> float:
    """Largest slope of one span: at an end, or at its point of inflection."""
    d, csch, coth = layer.delta, layer.csch, layer.coth
    slopes = [g + d * (k1 * csch - k0 * coth), g + d * (k1 * coth - k0 * csch)]
    if k0 * k1 < 0.0:  # both layers bend to one side: k0 C0 - k1 C1 has an extremum between
        squared = k0 * k0 + k1 * k1 - 2.0 * k0 * k1 * coth / max(csch, 1e-100)
        slopes.append(g - math.copysign(d * csch * math.sqrt(squared), k0))
    return max(abs(slope) for slope in slopes)


def _warnings(
    drive: DimensionlessDrive, theta_t: float, layers: list[_Layer], g: FloatArray
) -> tuple[str, ...]:
    """What leaves the range of the linear geometry, with its numbers."""
    found = []
    slope, span = _steepest(drive, layers, g)
    if slope > SLOPE_LIMIT:
        found.append(
            f"steady slope of {drive.span_name(span)} reaches {slope:.3g} (above {SLOPE_LIMIT:g}): "
            "the model is linear in slopes"
        )
    if abs(theta_t) > ARM_ANGLE_LIMIT_RAD:
        found.append(
            f"steady arm angle {math.degrees(drive.frame.sign * theta_t):.3g} deg (beyond "
            f"{math.degrees(ARM_ANGLE_LIMIT_RAD):.2g} deg): the model is linear in the arm's "
            "rotation"
        )
    if drive.arm is not None and abs(drive.preload) < PRELOAD_LIMIT:
        found.append(
            "the arm is nearly in line with the belt's pull, whose moment about the pivot is only "
            f"{drive.preload * drive.torque_N_m:.3g} N m, {abs(drive.preload):.2g} of P0 r_t (less "
            f"than {PRELOAD_LIMIT:g}): it hardly tightens the belt; move tensioner.pivot_m so that "
            "the arm stands across the pull"
        )
    return tuple(found)
