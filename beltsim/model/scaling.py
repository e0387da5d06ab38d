r"""A drive without units, in the canonical frame of the model's equations.

Canonical: pulleys listed counter-clockwise along the belt loop, belt travelling **clockwise**, from
pulley j+1 to pulley j. A drive whose belt travels counter-clockwise is reflected (y -> -y, list
reversed) before it gets here; its `Frame` remembers how pulleys, spans and signs map back.

The one glossary of the model. Indices: span i runs from pulley i to pulley i+1; a tilde marks the
dimensional quantity; `l` is the mean span length, `P0` the initial tension, `rho` the belt's mass
per length. Lengths, radii and inertias keep English names: in the equations they stand with their
dimension, but only their ratios to `l` and to `rho r l^2` matter.

==========  ====================  ===========================================  =====================
symbol      code name             meaning                                      scale
==========  ====================  ===========================================  =====================
l_i         span_length           free length of span i                        l
r_j         radius                pitch radius of pulley j                     l
r_t         arm_length            tensioner arm, pivot to pulley               l
r_t (or l)  lever                 arm of every torque (l without a tensioner)  l
m_j, m_t    m, m_t                inertia, over r_j and over r_t               rho l^2 (r_j, r_t)
k_s         k_s                   spring rate of the arm                       P0 r_t
M_j         accessory_torque      drives pulley j with the travel              P0 r_j
gamma       gamma                 EA, stretching stiffness                     P0
epsilon     epsilon               square root of EI, bending stiffness         sqrt(P0 l^2)
eps2_i      eps2                  epsilon^2 (l/l_i)^2, of span i               1
mu_i        mu                    (l_i/l)^2                                    1
sigma_i     s * span_length       s l_i/l, gyroscopic number of span i         1
s           s                     belt speed                                   sqrt(P0/rho)
Omega       Omega                 firing frequency                             1/time unit
alpha       alpha                 firing order, per crank revolution           1
zeta        zeta                  modal damping ratio                          1
beta_1,2    beta_1, beta_2        angles of the arm to spans T-1 and T         rad
t           t                     time                                         sqrt(rho l^2/P0)
p_i         p                     steady tension of span i                     P0
T_i         T                     p_i - s^2, what holds the span straight      P0
w_i         w                     deflection of span i, into the loop          its own l_i
a_ik        (coordinates)         factor of sin(k pi x) on span i              its own l_i
theta_j     theta_<pulley>        rotation of pulley j with the travel         rad
theta_t     theta_t               rotation of the arm, counter-clockwise       rad
k0, k1      curvatures            curvatures forced on the ends of span i      1/l_i
delta_i     delta                 width of the boundary layer, sqrt(eps2/T)    its own l_i
A0, A1      arm_deflections       end deflections of span i per theta_t        its own l_i
A1 - A0     arm_chord             chord of span i per theta_t                  its own l_i
arm_i       arm_stretch           stretch of span i per theta_t                l
preload     preload               moment of the belt on the arm, at rest       P0 r_t
Q_m, Q_s    Q_m, Q_s              kinetic, static friction torque              P0 r_t
P_di        tension_rows          dynamic tension of span i                    P0
==========  ====================  ===========================================  =====================

Depends on: drive (its type only), checks, errors.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from functools import cached_property
from math import gcd
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray, read_only
from beltsim.errors import short_name

if TYPE_CHECKING:
    from beltsim.drive import Drive
    from beltsim.drive.layout import Layout


@dataclass(frozen=True)
class Frame:
    """How the canonical frame maps back to the user's.

    Parameters
    ----------
    n : int
        Number of pulleys (and spans).
    mirrored : bool
        Whether the drive was reflected to make its belt travel clockwise. Then pulley j is
        canonical pulley n-1-j, x becomes 1-x, theta_t and vertical forces change sign.

    Examples
    --------
    >>> Frame(3, mirrored=True).spans
    array([1, 0, 2])
    """

    n: int
    mirrored: bool

    @cached_property
    def pulleys(self) -> NDArray[np.intp]:
        """Canonical index of each of the user's pulleys, shape (n,); its own inverse."""
        return np.arange(self.n)[::-1] if self.mirrored else np.arange(self.n)

    @cached_property
    def spans(self) -> NDArray[np.intp]:
        """Canonical index of each of the user's spans, shape (n,); its own inverse."""
        index = np.arange(self.n)
        return (self.n - 2 - index) % self.n if self.mirrored else index

    @property
    def sign(self) -> float:
        """-1 for quantities that the reflection turns around (theta_t, vertical forces)."""
        return -1.0 if self.mirrored else 1.0

    def sine_signs(self, k: Any) -> FloatArray:
        """Sign that sin(k pi x) takes when x becomes 1-x, for wave numbers `k`."""
        odd = np.asarray(k) % 2 == 1
        return np.where(odd | (not self.mirrored), 1.0, -1.0)


@dataclass(frozen=True, eq=False)
class DimensionlessDrive:
    """A drive in the canonical frame and without units; see the module's glossary.

    Arrays have one entry per canonical pulley or span. Without a tensioner `arm`
    is None and what belongs to it is 0. `crank_cos` and `crank_sin` (H + 1,) are the Fourier rows
    of the crank's angle in rad, over the fundamental `fundamental_order` per crank revolution.
    `length_m`, `tension_N` and `time_s` are the scales l, P0 and sqrt(rho l^2/P0), `lever_m` is
    r_t, or l without a tensioner.
    """

    names: tuple[str, ...]
    span_length: FloatArray
    radius: FloatArray
    side: FloatArray
    m: FloatArray
    accessory_torque: FloatArray
    direction: FloatArray
    normal: FloatArray
    crank: int
    arm: int | None
    arm_length: float
    arm_normal: FloatArray
    beta_1: float
    beta_2: float
    m_t: float
    k_s: float
    gamma: float
    epsilon: float
    zeta: float
    alpha: float
    fundamental_order: float
    crank_cos: FloatArray
    crank_sin: FloatArray
    frame: Frame
    length_m: float
    tension_N: float
    time_s: float
    lever_m: float

    def __post_init__(self) -> None:
        for name, value in self.__dict__.copy().items():
            if isinstance(value, np.ndarray):
                object.__setattr__(self, name, read_only(value))

    @property
    def n(self) -> int:
        """Number of pulleys and of spans."""
        return len(self.radius)

    @property
    def lever(self) -> float:
        """What torques are divided by: the arm's length, or l without a tensioner."""
        return 1.0 if self.arm is None else self.arm_length

    @property
    def torque_N_m(self) -> float:
        """SI value of one unit of torque, P0 r_t."""
        return self.tension_N * self.lever_m

    @cached_property
    def mu(self) -> FloatArray:
        """(l_i/l)^2."""
        return self.span_length**2

    @cached_property
    def eps2(self) -> FloatArray:
        """Bending number epsilon^2 (l/l_i)^2 of each span."""
        return self.epsilon**2 / self.span_length**2

    @cached_property
    def curvatures(self) -> tuple[FloatArray, FloatArray]:
        """Curvatures that the pulleys force on both ends of each span; zero for a string."""
        if self.epsilon == 0.0:
            return np.zeros(self.n), np.zeros(self.n)
        k = self.side / self.radius
        return self.span_length * k, self.span_length * np.roll(k, -1)

    @cached_property
    def arm_stretch(self) -> FloatArray:
        """arm_i: stretch l_i strain_i of each span per theta_t."""
        found = np.zeros(self.n)
        if self.arm is not None:
            found[self.arm - 1] -= self.arm_length * np.sin(self.beta_1)
            found[self.arm] += self.arm_length * np.sin(self.beta_2)
        return found

    @cached_property
    def arm_deflections(self) -> tuple[FloatArray, FloatArray]:
        """A0, A1: deflections of the ends x = 0 and x = 1 of each span per theta_t."""
        A0, A1 = np.zeros(self.n), np.zeros(self.n)
        if self.arm is not None:
            A1[self.arm - 1] = (
                self.arm_length * np.cos(self.beta_1) / self.span_length[self.arm - 1]
            )
            A0[self.arm] = self.arm_length * np.cos(self.beta_2) / self.span_length[self.arm]
        return A0, A1

    @cached_property
    def arm_chord(self) -> FloatArray:
        """A1 - A0: chord of each span per theta_t."""
        A0, A1 = self.arm_deflections
        return A1 - A0

    @property
    def preload(self) -> float:
        """Moment of the belt on the arm in the reference state, in P0 r_t; 0 without an arm."""
        return 0.0 if self.arm is None else float(np.sin(self.beta_1) - np.sin(self.beta_2))

    def span_name(self, span: int) -> str:
        """Name of canonical span `span`, numbered and directed as the user listed it."""
        number = int(self.frame.spans[span])
        ends = self.frame.pulleys[[number, (number + 1) % self.n]]
        one, other = (short_name(self.names[j]) for j in ends)
        return f"span {number + 1} ({one} - {other})"


#: Scaled drives by the id of their drive, with a weak reference that proves the id still holds.
_SCALED: dict[int, tuple[weakref.ref[Any], DimensionlessDrive]] = {}


def scale(drive: Drive) -> DimensionlessDrive:
    """The drive in the canonical frame, without units.

    Parameters
    ----------
    drive : Drive
        SI description. Drives are immutable, so the result is kept as long as the drive lives.

    Returns
    -------
    DimensionlessDrive

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> scaled = scale(zhu_parker_2008())
    >>> round(scaled.gamma), round(scaled.preload, 3)
    (400, 0.675)
    """
    key = id(drive)
    kept = _SCALED.get(key)
    if kept is not None and kept[0]() is drive:
        return kept[1]
    scaled = _scaled(drive)
    _SCALED[key] = (weakref.ref(drive, lambda _: _SCALED.pop(key, None)), scaled)
    return scaled


def _scaled(drive: Drive) -> DimensionlessDrive:
    mirrored = drive.layout.travel == "ccw"
    layout = drive.layout.mirrored() if mirrored else drive.layout
    length = float(np.mean(layout.span_length_m))
    P0, rho = drive.belt.initial_tension_N, drive.belt.mass_per_length_kg_m
    fundamental, crank_cos, crank_sin = _crank_series(drive)
    inertia_unit = rho * length**2
    return DimensionlessDrive(
        names=tuple(layout.names),
        span_length=layout.span_length_m / length,
        radius=layout.radius_m / length,
        side=np.asarray(layout.side, dtype=float),
        m=layout.inertia_kg_m2 / (inertia_unit * layout.radius_m),
        accessory_torque=_driving_torques(layout, P0),
        direction=layout.direction,
        normal=layout.normal,
        crank=int(layout.crank),
        **_scaled_arm(drive, layout, length),
        gamma=drive.belt.EA_N / P0,
        epsilon=float(np.sqrt(drive.bending_stiffness_N_m2 / P0)) / length,
        zeta=drive.damping.ratio,
        alpha=drive.excitation.firing_order,
        fundamental_order=fundamental,
        crank_cos=crank_cos,
        crank_sin=crank_sin,
        frame=Frame(len(layout.names), mirrored),
        length_m=length,
        tension_N=P0,
        time_s=float(np.sqrt(inertia_unit / P0)),
    )


def _scaled_arm(drive: Drive, layout: Layout, length: float) -> dict[str, Any]:
    """What belongs to the tensioner; zeros without one."""
    tensioner = drive.tensioner
    if tensioner is None or layout.arm_length_m is None:
        zeros = dict.fromkeys(("arm_length", "beta_1", "beta_2", "m_t", "k_s"), 0.0)
        return {"arm": None, "arm_normal": np.zeros(2), "lever_m": length, **zeros}
    P0, rho = drive.belt.initial_tension_N, drive.belt.mass_per_length_kg_m
    arm_m = layout.arm_length_m
    return {
        "arm": layout.arm,
        "arm_normal": layout.arm_normal,
        "arm_length": arm_m / length,
        "lever_m": arm_m,
        "beta_1": layout.beta_1,
        "beta_2": layout.beta_2,
        "m_t": tensioner.arm_inertia_kg_m2 / (rho * arm_m * length**2),
        "k_s": tensioner.spring_rate_N_m_per_rad / (P0 * arm_m),
    }


def _driving_torques(layout: Layout, P0: float) -> FloatArray:
    """M_j: an accessory takes power, so it drives its pulley backwards; the crank closes it."""
    torque = -np.asarray(layout.accessory_torque_N_m) / (P0 * layout.radius_m)
    torque[layout.crank] = 0.0
    torque[layout.crank] = -np.sum(torque)
    return torque


def _crank_series(drive: Drive) -> tuple[float, FloatArray, FloatArray]:
    """Fundamental order per crank revolution, and Fourier rows of the crank's angle in rad.

    Orders are multiples of 1/2, so twice the orders are integers with a common divisor. Without
    any order the fundamental is the firing order and the crank does not oscillate.
    """
    halves = [round(2 * item.order) for item in drive.orders]
    common = gcd(*halves) if halves else 0
    if common == 0:
        return float(drive.excitation.firing_order), np.zeros(1), np.zeros(1)
    cos, sin = np.zeros((2, max(halves) // common + 1))
    for half, item in zip(halves, drive.orders, strict=True):
        cos[half // common] += item.angle_amplitude_rad * np.sin(item.phase_rad)
        sin[half // common] += item.angle_amplitude_rad * np.cos(item.phase_rad)
    return common / 2, cos, sin
