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

from dataclasses import dataclass
from functools import cached_property
from typing import cast

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


@dataclass(frozen=True, eq=False)
class Condensed:
    """The joint's view of a linear system, for a set of harmonics.

    Parameters
    ----------
    Omega : float
        Fundamental of the forcing.
    R : int
        Highest harmonic.
    orders : (nS,) int
        Harmonics that can be present, ascending, without 0.
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
    problem : FrictionProblem
        What was condensed.
    """

    Omega: float
    R: int
    orders: NDArray[np.int64]
    divisor: int
    half_wave: bool
    unit: ComplexArray
    free: ComplexArray
    mobility: ComplexArray
    velocity: ComplexArray
    reaction: ComplexArray
    problem: FrictionProblem

    @property
    def images(self) -> int:
        """2 when half a repetition tells all, else 1."""
        return 2 if self.half_wave else 1

    @cached_property
    def turns(self) -> NDArray[np.int64]:
        """`orders` per repetition: orders/divisor."""
        return self.orders // self.divisor

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

    def coordinates(self, torque: ComplexArray, mean_torque: float) -> ComplexArray:
        """Rows (R + 1, n) of all coordinates under the torque harmonics (nS,) and its mean."""
        found = np.zeros((self.R + 1, self.unit.shape[1]), dtype=complex)
        found[self.orders] = self.free - self.unit * torque[:, None]
        found[0] = self.mean_free
        if mean_torque and self.mean_unit is not None:
            found[0] -= self.mean_unit * mean_torque
        return found


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
    joint, Omega = problem.joint, problem.forcing.Omega
    force = problem.forcing.coefficients
    active = np.flatnonzero(np.any(force[1:] != 0.0, axis=1)) + 1
    orders, divisor, half_wave = _orders(active, R, harmonics)
    load = np.zeros((len(orders), problem.n), dtype=complex)
    load[np.searchsorted(orders, active)] = force[active]
    rate = np.asarray(orders * Omega, dtype=np.float64)
    unit, free = _responses(problem, rate, load, orders)
    answer, at_joint = unit[:, joint], free[:, joint]
    with np.errstate(divide="ignore", invalid="ignore"):
        reaction = at_joint / answer
    reaction[at_joint == 0.0] = 0.0
    if force[0].any():
        _static(problem)  # refuses a mean load on a singular K
    return Condensed(
        Omega=Omega,
        R=R,
        orders=orders,
        divisor=divisor,
        half_wave=half_wave,
        unit=unit,
        free=free,
        mobility=1j * rate * answer,
        velocity=1j * rate * at_joint,
        reaction=reaction,
        problem=problem,
    )


def _orders(
    active: NDArray[np.intp], R: int, harmonics: str
) -> tuple[NDArray[np.int64], int, bool]:
    """Harmonics that the response can have, their common divisor, and half-wave symmetry.

    The velocity of a Coulomb joint is unique, so it has every symmetry of the forcing: it repeats
    with the forcing's own period and, when only odd multiples of that are present, changes sign
    after half of it.
    """
    if len(active) and active[-1] > R:
        allowed = f"at least {active[-1]}, the highest harmonic of the forcing"
        raise InvalidProblemError(Mistake("R", R, allowed))
    divisor = int(np.gcd.reduce(active)) if len(active) and harmonics == "auto" else 1
    odd = bool(np.all((active // divisor) % 2 == 1))
    if harmonics == "odd" and not odd:
        allowed = '"auto" or "all": the forcing has even harmonics'
        raise InvalidProblemError(Mistake("settings.harmonics", "odd", allowed))
    half_wave = odd and harmonics != "all"
    orders = divisor * np.arange(1, R // divisor + 1, 2 if half_wave else 1)
    return orders.astype(np.int64), divisor, half_wave


def _responses(
    problem: FrictionProblem, rate: FloatArray, load: ComplexArray, orders: NDArray[np.int64]
) -> tuple[ComplexArray, ComplexArray]:
    """Responses to a unit torque and to the load, one row per harmonic.

    Refuses an undamped resonance that forcing or friction feed.
    """
    method = _by_lapack if problem.n >= LARGE else _impedances.responses
    joint, B = cast("int", problem.joint), problem.C + problem.G
    unit, free, faulty = method(problem.M, B, problem.K, rate, joint, load, RESONANCE_LIMIT)
    if faulty < 0:
        return unit, free
    allowed = (
        "away from a natural frequency, or damped: nothing limits the response there "
        "(k Omega is the frequency)"
    )
    raise InvalidProblemError(Mistake(f"harmonic {orders[faulty]}", float(rate[faulty]), allowed))


def _by_lapack(
    M: FloatArray,
    B: FloatArray,
    K: FloatArray,
    rate: FloatArray,
    joint: int,
    load: ComplexArray,
    limit: float,
) -> tuple[ComplexArray, ComplexArray, int]:
    """`_impedances.responses` for large matrices."""
    D = np.empty((len(rate), *M.shape), dtype=complex)
    D.real = K - np.multiply.outer(rate**2, M)
    D.imag = np.multiply.outer(rate, B)
    columns = np.zeros((len(rate), len(M), 2), dtype=complex)
    columns[:, joint, 0], columns[:, :, 1] = 1.0, load
    try:
        found = np.asarray(np.linalg.solve(D, columns), dtype=np.complex128)
    except np.linalg.LinAlgError:
        found = np.full_like(columns, np.inf)
        for i in range(len(D)):
            try:
                found[i] = np.linalg.solve(D[i], columns[i])
            except np.linalg.LinAlgError:
                continue
    # in coordinates of unit mass: how far the answer exceeds load over stiffness
    root = np.sqrt(np.diag(M))
    with np.errstate(invalid="ignore", over="ignore"):
        answer = np.abs(found * root[:, None]).max(axis=1)
        given = np.abs(columns / root[:, None]).max(axis=1)
        stiffness = np.abs(D / root[:, None] / root).max(axis=(1, 2))
        sound = (answer * stiffness[:, None] <= limit * given) | (given == 0.0)
    faulty = np.flatnonzero(~sound.all(axis=1))
    return found[:, :, 0], found[:, :, 1], int(faulty[0]) if len(faulty) else -1


def _static(problem: FrictionProblem) -> tuple[FloatArray | None, FloatArray]:
    """Static responses to a unit torque on the joint and to the mean load."""
    columns = np.zeros((problem.n, 2))
    columns[problem.joint, 0] = 1.0
    columns[:, 1] = problem.forcing.cos[0]
    try:
        found = np.asarray(np.linalg.solve(problem.K, columns), dtype=np.float64)
        size = np.abs(problem.K).max() * np.abs(found).max(axis=0)
        if np.all(size <= RESONANCE_LIMIT * np.maximum(np.abs(columns).max(axis=0), 1e-300)):
            return found[:, 0], found[:, 1]
    except np.linalg.LinAlgError:
        pass
    if np.any(columns[:, 1]):
        allowed = "zero in every coordinate, or K regular: the mean position would drift away"
        raise InvalidProblemError(Mistake("forcing.cos[0]", columns[:, 1], allowed))
    return None, np.zeros(problem.n)
