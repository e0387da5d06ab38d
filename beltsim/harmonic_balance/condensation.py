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

Depends on: errors, checks, problem.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.problem import FrictionProblem

ComplexArray = NDArray[np.complex128]

#: A dynamic stiffness that amplifies by more than this is a resonance without damping.
RESONANCE_LIMIT = 1e13
#: Relative size below which a mean load does not count as one.
MEAN_TOLERANCE = 1e-12


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
    mean_unit, mean_free : (n,) or None
        Static responses to a unit torque on the joint and to the mean load; None: K is singular,
        and nothing loads it.
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
    mean_unit: FloatArray | None
    mean_free: FloatArray

    @property
    def images(self) -> int:
        """2 when half a repetition tells all, else 1."""
        return 2 if self.half_wave else 1

    def impedance(self, joint: int) -> ComplexArray:
        """`Z_r` (nS,) of the joint."""
        return np.asarray(1.0 / self.unit[:, joint])

    def coordinates(self, torque: ComplexArray, mean_torque: float) -> ComplexArray:
        """Rows (R + 1, n) of all coordinates under the torque harmonics (nS,) and its mean."""
        found = np.zeros((self.R + 1, self.unit.shape[1]), dtype=complex)
        found[self.orders] = self.free - self.unit * torque[:, None]
        found[0] = self.mean_free
        if self.mean_unit is not None:
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
    columns = np.zeros((len(orders), problem.n, 2), dtype=complex)
    columns[:, joint, 0] = 1.0
    forced = np.searchsorted(orders, active)
    columns[forced, :, 1] = force[active]
    rate: FloatArray = np.asarray(orders * Omega, dtype=np.float64)
    D = _dynamic_stiffness(problem, rate)
    found = _solved(problem, D, columns, orders, rate)
    unit, free = found[:, :, 0], found[:, :, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        reaction = free[:, joint] / unit[:, joint]
    reaction[free[:, joint] == 0.0] = 0.0
    mean_unit, mean_free = _mean(problem)
    return Condensed(
        Omega=Omega,
        R=R,
        orders=orders,
        divisor=divisor,
        half_wave=half_wave,
        unit=unit,
        free=free,
        mobility=1j * rate * unit[:, joint],
        velocity=1j * rate * free[:, joint],
        reaction=reaction,
        mean_unit=mean_unit,
        mean_free=mean_free,
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


def _dynamic_stiffness(problem: FrictionProblem, rate: FloatArray) -> ComplexArray:
    """D(r) = K + i r Omega (C + G) - (r Omega)^2 M, shape (nS, n, n)."""
    D = np.empty((len(rate), problem.n, problem.n), dtype=complex)
    D.real = problem.K - np.multiply.outer(rate**2, problem.M)
    D.imag = np.multiply.outer(rate, problem.C + problem.G)
    return D


def _solved(
    problem: FrictionProblem,
    D: ComplexArray,
    columns: ComplexArray,
    orders: NDArray[np.int64],
    rate: FloatArray,
) -> ComplexArray:
    """Solutions of all harmonics; refuses an undamped resonance that forcing or friction feed."""
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
    root = np.sqrt(np.diag(problem.M))
    with np.errstate(invalid="ignore", over="ignore"):
        answer = np.abs(found * root[:, None]).max(axis=1)
        load = np.abs(columns / root[:, None]).max(axis=1)
        stiffness = np.abs(D / root[:, None] / root).max(axis=(1, 2))
        sound = (answer * stiffness[:, None] <= RESONANCE_LIMIT * load) | (load == 0.0)
    if sound.all():
        return found
    k = int(np.flatnonzero(~sound.all(axis=1))[0])
    allowed = (
        "away from a natural frequency, or damped: nothing limits the response there "
        "(k Omega is the frequency)"
    )
    raise InvalidProblemError(Mistake(f"harmonic {orders[k]}", float(rate[k]), allowed))


def _mean(problem: FrictionProblem) -> tuple[FloatArray | None, FloatArray]:
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
