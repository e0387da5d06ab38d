r"""Condensation of the linear part onto the joint, harmonic by harmonic.

With :math:`D(r) = K + i r\Omega(C + G) - (r\Omega)^2 M` and the blocks `q` (other coordinates) and
`t` (joint), the joint alone obeys, for each harmonic r (the paper's eqs 17 to 21),

.. math:: Z_r \theta_r = F_r - h_r, \quad Z_r = D_{tt} - D_{tq} D_{qq}^{-1} D_{qt}, \quad
          F_r = f_t - D_{tq} D_{qq}^{-1} f_q .

Both follow from one factorisation of D(r): :math:`1/Z_r` is the joint's entry of
:math:`g_r = D^{-1} e_t`, and :math:`F_r = Z_r y_t` with :math:`y_r = D^{-1} f_r`, so that all
coordinates are :math:`q_r = y_r - g_r h_r`. The velocity is
:math:`V_r = A_r(F_r - h_r)` with the mobility :math:`A_r = i r\Omega/Z_r`, whose real part is not
negative when C is positive semidefinite. It has no mean, and the mean load does not enter it.

Complex rows follow :math:`q(t) = \mathrm{Re}\sum_k c_k e^{ik\Omega t}`, row 0 the mean.

Depends on: _impedances, errors, checks, problem.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.harmonic_balance import _impedances
from beltsim.problem import FrictionProblem

ComplexArray = NDArray[np.complex128]

#: A dynamic stiffness that amplifies by more than this is a resonance without damping.
RESONANCE_LIMIT = 1e13
#: Coordinates from which LAPACK's blocks make up for the copies it needs.
LARGE = 40


class System(NamedTuple):
    """What the kernels are told of a problem."""

    M: FloatArray
    C: FloatArray
    G: FloatArray
    K: FloatArray
    joint: int
    Omega: float
    orders: NDArray[np.int64]
    cos: FloatArray
    sin: FloatArray


class Coordinates(NamedTuple):
    """All coordinates under a torque on the joint, the mean left out.

    `series` (nS, n) complex harmonics; `squares` (n,) their mean squares over the period; `power`
    that the torque takes, on average; `residual`: largest unbalanced load of any harmonic,
    relative, from M, C, G, K alone.
    """

    series: ComplexArray
    squares: FloatArray
    power: float
    residual: float


@dataclass(frozen=True, eq=False)
class Condensed:
    """The joint's view of a linear system, for a set of harmonics.

    Parameters
    ----------
    Omega : float
        Fundamental of the forcing.
    R : int
        Highest harmonic.
    orders, turns : (nS,) int
        Harmonics that can be present, ascending, without 0; and per repetition: orders/divisor.
    divisor : int
        All orders are multiples of it: the response repeats `divisor` times per forcing period.
    half_wave : bool
        Whether orders/divisor are all odd: the velocity changes sign after half a repetition.
    unit, free : (nS, n) complex
        `g_r` and `y_r`: response to a unit torque on the joint, and to the forcing.
    mobility, velocity : (nS,) complex
        `A_r`, and the joint's velocity without friction.
    reaction : (nS,) complex
        `F_r`, the torque that holds the joint. Infinite where the joint is a node of the response.
    system : System
    problem : FrictionProblem
        What was condensed.
    """

    Omega: float
    R: int
    orders: NDArray[np.int64]
    turns: NDArray[np.int64]
    divisor: int
    half_wave: bool
    unit: ComplexArray
    free: ComplexArray
    mobility: ComplexArray
    velocity: ComplexArray
    reaction: ComplexArray
    system: System
    problem: FrictionProblem

    @property
    def images(self) -> int:
        """2 when half a repetition tells all, else 1."""
        return 2 if self.half_wave else 1

    @cached_property
    def mean_unit(self) -> FloatArray | None:
        """Static response (n,) to a unit torque on the joint; None where K is singular."""
        return _static(self.problem)[0]

    @cached_property
    def mean_free(self) -> FloatArray:
        """Static response (n,) to the mean load."""
        if not np.any(self.problem.forcing.cos[0]):
            return np.zeros(self.problem.n)
        return _static(self.problem)[1]

    def impedance(self, joint: int) -> ComplexArray:
        """`Z_r` (nS,) of the joint."""
        return np.asarray(1.0 / self.unit[:, joint])

    def coordinates(self, torque: ComplexArray) -> Coordinates:
        """What all coordinates do under the torque harmonics (nS,)."""
        return Coordinates(*_impedances.coordinates(*self.system, self.unit, self.free, torque))

    def mean_position(self, mean_torque: float) -> FloatArray:
        """Mean of all coordinates (n,) under the mean of the torque."""
        if mean_torque and self.mean_unit is not None:
            return self.mean_free - self.mean_unit * mean_torque
        return self.mean_free


def condense(problem: FrictionProblem, R: int, harmonics: str = "auto") -> Condensed:
    """The joint's impedances up to harmonic `R`, kept with the problem's linear part.

    Parameters
    ----------
    problem : FrictionProblem
        With a joint; its friction does not matter.
    R : int
        Highest harmonic, at least that of the forcing.
    harmonics : str
        ``"auto"``: only harmonics that symmetry allows; ``"odd"``; ``"all"``.

    Returns
    -------
    Condensed
        The same object for every friction torque of one linear system.

    Raises
    ------
    InvalidProblemError
        Without a joint; when the forcing has harmonics above R, or even ones with
        ``harmonics="odd"``; at a resonance without damping; for a mean load on a singular K.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(1.0, cos=[[0.0], [3.0]], sin=[[0.0], [0.0]])
    >>> mass = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[4.0]], 0, push, Coulomb(0.2))
    >>> found = condense(mass, 5)
    >>> found.orders, found.reaction[0].real.item(), found.impedance(0)[0].imag.item()
    (array([1, 3, 5]), 3.0, 0.1)
    """
    name = f"harmonic_balance {R} {harmonics}"
    if name not in problem.shared:
        problem.shared[name] = _condense(problem, R, harmonics)
    return cast("Condensed", problem.shared[name])


def _condense(problem: FrictionProblem, R: int, harmonics: str) -> Condensed:
    if problem.joint is None:
        allowed = "an index: without a joint use beltsim.linear.response"
        raise InvalidProblemError(Mistake("joint", None, allowed))
    M, C, G, K, forcing = problem.M, problem.C, problem.G, problem.K, problem.forcing
    active = tuple(_impedances.excited(forcing.cos, forcing.sin).tolist())
    orders, turns, divisor, half_wave = _orders(active, R, harmonics)
    system = System(M, C, G, K, problem.joint, forcing.Omega, orders, forcing.cos, forcing.sin)
    solver = _by_lapack if problem.n >= LARGE else _by_kernel
    unit, free, mobility, velocity, reaction, faulty = solver(system)
    if faulty >= 0:
        allowed = (
            "away from a natural frequency, or damped: nothing limits the response there "
            "(k Omega is the frequency)"
        )
        frequency = float(orders[faulty] * forcing.Omega)
        raise InvalidProblemError(Mistake(f"harmonic {orders[faulty]}", frequency, allowed))
    if active[:1] == (0,):
        _static(problem)  # refuses a mean load on a singular K
    return Condensed(
        Omega=forcing.Omega,
        R=R,
        orders=orders,
        turns=turns,
        divisor=divisor,
        half_wave=half_wave,
        unit=unit,
        free=free,
        mobility=mobility,
        velocity=velocity,
        reaction=reaction,
        system=system,
        problem=problem,
    )


@lru_cache(maxsize=64)
def _orders(
    active: tuple[int, ...], R: int, harmonics: str
) -> tuple[NDArray[np.int64], NDArray[np.int64], int, bool]:
    """Harmonics that the response can have, also per repetition, their divisor, and symmetry.

    `active` are the harmonics of the forcing. The velocity of a Coulomb joint is unique, so it has
    every symmetry of the forcing: it repeats with the forcing's own period and, when only odd
    multiples of that are present, changes sign after half of it.
    """
    moving = [k for k in active if k]
    if moving and moving[-1] > R:
        allowed = f"at least {moving[-1]}, the highest harmonic of the forcing"
        raise InvalidProblemError(Mistake("R", R, allowed))
    divisor = math.gcd(*moving) if moving and harmonics == "auto" else 1
    odd = all((k // divisor) % 2 == 1 for k in moving)
    if harmonics == "odd" and not odd:
        allowed = '"auto" or "all": the forcing has even harmonics'
        raise InvalidProblemError(Mistake("settings.harmonics", "odd", allowed))
    half_wave = odd and harmonics != "all"
    turns = np.arange(1, R // divisor + 1, 2 if half_wave else 1, dtype=np.int64)
    orders = divisor * turns
    turns.flags.writeable = orders.flags.writeable = False
    return orders, turns, divisor, half_wave


def _by_kernel(system: System) -> tuple[Any, ...]:
    return cast("tuple[Any, ...]", _impedances.condensed(*system, RESONANCE_LIMIT))


def _by_lapack(system: System) -> tuple[Any, ...]:
    """`_by_kernel` for large matrices."""
    M, C, G, K, joint, Omega, orders, cos, sin = system
    rate = orders * Omega
    D = np.empty((len(orders), *M.shape), dtype=complex)
    D.real = K - np.multiply.outer(rate**2, M)
    D.imag = np.multiply.outer(rate, C + G)
    columns = np.zeros((len(orders), len(M), 2), dtype=complex)
    columns[:, joint, 0] = 1.0
    loaded = orders < len(cos)
    columns[loaded, :, 1] = cos[orders[loaded]] - 1j * sin[orders[loaded]]
    try:
        found = np.asarray(np.linalg.solve(D, columns), dtype=np.complex128)
    except np.linalg.LinAlgError:
        found = np.full_like(columns, np.inf)
        for i in range(len(D)):
            try:
                found[i] = np.linalg.solve(D[i], columns[i])
            except np.linalg.LinAlgError:
                continue
    faulty = np.flatnonzero(~_sound(found, columns, D, M).all(axis=1))
    unit, free = np.ascontiguousarray(found[:, :, 0]), np.ascontiguousarray(found[:, :, 1])
    joints = _impedances.seen(unit, free, joint, Omega, orders)
    return unit, free, *joints, int(faulty[0]) if len(faulty) else -1


def _sound(found: Any, columns: Any, D: Any, M: FloatArray) -> NDArray[np.bool_]:
    """Whether no answer exceeds load over stiffness by too much, in coordinates of unit mass."""
    root = np.sqrt(np.diag(M))
    with np.errstate(invalid="ignore", over="ignore"):
        answer = np.abs(found * root[:, None]).max(axis=-2)
        given = np.abs(columns / root[:, None]).max(axis=-2)
        stiffness = np.abs(D / root[:, None] / root).max(axis=(-2, -1))
        sound = (answer * stiffness[..., None] <= RESONANCE_LIMIT * given) | (given == 0.0)
    return cast("NDArray[np.bool_]", sound)


def _static(problem: FrictionProblem) -> tuple[FloatArray | None, FloatArray]:
    """Static responses to a unit torque on the joint and to the mean load."""
    columns = np.zeros((problem.n, 2))
    columns[problem.joint, 0] = 1.0
    columns[:, 1] = problem.forcing.cos[0]
    try:
        found = np.asarray(np.linalg.solve(problem.K, columns), dtype=np.float64)
        if np.all(_sound(found, columns, problem.K, problem.M)):
            return found[:, 0], found[:, 1]
    except np.linalg.LinAlgError:
        pass
    if np.any(columns[:, 1]):
        allowed = "zero in every coordinate, or K regular: the mean position would drift away"
        raise InvalidProblemError(Mistake("forcing.cos[0]", columns[:, 1], allowed))
    return None, np.zeros(problem.n)
