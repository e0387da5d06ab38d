r"""What a friction problem does when its joint is free or locked: linear algebra only.

Undamped gyroscopic modes of :math:`M\ddot q + G\dot q + K q = 0`, the steady response to the
forcing with damping, the torque that keeps the joint locked (eq. 26 of Zhu & Parker, for any
number of harmonics) and the rate at which a start dies away.

Complex rows follow :math:`q(t) = \mathrm{Re} \sum_k c_k e^{i k \Omega t}`, row 0 the mean.

Depends on: problem, errors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray, read_only
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.problem import FrictionProblem

ComplexArray = NDArray[np.complex128]

#: Stiffness below this, relative to the largest, counts as a free (rigid) mode.
RIGID_TOLERANCE = 1e-11
#: A dynamic stiffness worse conditioned than this is a resonance without damping.
RESONANCE_CONDITION = 1e13


@dataclass(frozen=True, eq=False)
class Modes:
    """Undamped gyroscopic modes, sorted by frequency.

    Parameters
    ----------
    frequencies : (m,)
        Natural frequencies, rad per unit of the problem's time; 0 for a rigid mode.
    shapes : (m, n) complex
        Row k moves as Re(shape exp(i omega_k t)). The entry of largest modulus is 1. A locked
        joint has its column, zero.

    """

    frequencies: FloatArray
    shapes: ComplexArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "frequencies", read_only(self.frequencies))
        self.shapes.flags.writeable = False


def modes(problem: FrictionProblem, locked: bool = False) -> Modes:
    r"""Natural frequencies and shapes of the undamped system, friction left out.

    With K = F F' and M = L L' the system is first order in (L' q', F' q) with a skew matrix, whose
    eigenvalues are those of a Hermitian one: frequencies come out real and to rounding.

    Parameters
    ----------
    problem : FrictionProblem
    locked : bool
        Whether the joint is held.

    Returns
    -------
    Modes
        m = n modes, or n - 1 with the joint locked.

    Raises
    ------
    InvalidProblemError
        When K has a negative eigenvalue (the equilibrium is not a minimum of energy, and
        frequencies may not be real), or when a joint is to be locked and there is none.

    Examples
    --------
    >>> from beltsim import FrictionProblem, HarmonicForcing
    >>> rest = HarmonicForcing(1.0, [[0.0]], [[0.0]])
    >>> modes(FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[4.0]], None, rest, None)).frequencies
    array([2.])
    """
    moving = _moving(problem, locked)
    n = len(moving)
    if n == 0:
        return Modes(np.zeros(0), np.zeros((0, problem.n), dtype=complex))
    hermitian, L_inverse = _hermitian_form(problem, moving)
    omega, z = np.linalg.eigh(hermitian)
    velocities = (L_inverse.T @ z[:n, n:]).T
    return Modes(np.maximum(omega[n:], 0.0), _normalised(velocities, moving, problem.n))


def frequencies(problem: FrictionProblem, locked: bool = False) -> FloatArray:
    """Natural frequencies of `modes` alone, for scans: array (m,), sorted.

    Parameters, errors and unit are those of `modes`.
    """
    moving = _moving(problem, locked)
    n = len(moving)
    if n == 0:
        return np.zeros(0)
    omega = np.linalg.eigvalsh(_hermitian_form(problem, moving)[0])
    return np.asarray(np.maximum(omega[n:], 0.0))


def response(problem: FrictionProblem, locked: bool = False) -> ComplexArray:
    """Steady response to the forcing with damping, friction left out.

    Parameters
    ----------
    problem : FrictionProblem
    locked : bool
        Whether the joint is held at zero.

    Returns
    -------
    (H + 1, n) complex
        Row k is harmonic k, row 0 the mean; the column of a locked joint is zero.

    Raises
    ------
    InvalidProblemError
        When a harmonic of the forcing meets a resonance without damping; it is named.
    """
    moving = _moving(problem, locked)
    grid = np.ix_(moving, moving)
    M, K = problem.M[grid], problem.K[grid]
    CG = 1j * (problem.C[grid] + problem.G[grid])
    force = problem.forcing.coefficients[:, moving]
    found = np.zeros((len(force), problem.n), dtype=complex)
    for k, row in enumerate(force):
        if row.any():
            rate = k * problem.forcing.Omega
            found[k, moving] = _solved(K - rate**2 * M + rate * CG, row, M, k, rate)
    return found


def reaction(problem: FrictionProblem) -> ComplexArray:
    r"""Torque that holds the joint at zero in the locked steady state.

    .. math:: H_R = f_t - (M_{tq}\ddot q + (C_{tq} + G_{tq})\dot q + K_{tq} q)

    Returns
    -------
    (H + 1,) complex
        Harmonics of the reaction.

    Raises
    ------
    InvalidProblemError
        Without a joint, or at a resonance without damping.
    """
    q = response(problem, locked=True)
    t = cast("int", problem.joint)
    rate = np.arange(len(q)) * problem.forcing.Omega
    stiffness = (
        problem.K[t]
        + np.multiply.outer(1j * rate, problem.C[t] + problem.G[t])
        - np.multiply.outer(rate**2, problem.M[t])
    )
    held: ComplexArray = problem.forcing.coefficients[:, t] - np.sum(stiffness * q, axis=1)
    return held


def critical_torque(problem: FrictionProblem) -> float:
    """Smallest static friction that keeps the joint locked, Q_cr.

    Half the peak-to-peak of the locked reaction, since the rest position adapts to its mean. For
    one harmonic this is the amplitude of eq. 26. Its extrema are located, not sampled. Where no
    position changes the reaction (nothing but friction holds the joint), friction has to carry the
    mean too, and it is the largest modulus.

    Raises
    ------
    InvalidProblemError
        Without a joint, or at a resonance without damping.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(1.0, [[0.0], [3.0]], [[0.0], [4.0]])
    >>> mass = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[4.0]], 0, push, Coulomb(1.0))
    >>> critical_torque(mass)
    5.0
    """
    low, high = extremes(reaction(problem))
    return 0.5 * (high - low) if _sprung(problem) else max(abs(low), abs(high))


def _sprung(problem: FrictionProblem) -> bool:
    """Whether a static displacement of the joint, the others following, changes its reaction."""
    t, q = cast("int", problem.joint), problem.others
    K_tq = problem.K[t, q]
    following = np.linalg.lstsq(problem.K[np.ix_(q, q)], K_tq, rcond=RIGID_TOLERANCE)[0]
    size = abs(problem.K[t, t]) + np.abs(K_tq) @ np.abs(following)
    return bool(abs(problem.K[t, t] - K_tq @ following) > RIGID_TOLERANCE * size)


def extremes(coefficients: ComplexArray) -> tuple[float, float]:
    """Smallest and largest value of Re sum_k c_k exp(i k tau), for coefficients (H + 1,).

    Zeros of the derivative are roots of a polynomial in exp(i tau). The value at any angle is a
    value of the series, so roots off the unit circle do no harm.
    """
    c = np.asarray(coefficients, dtype=complex)
    k = np.arange(len(c))
    slope = 1j * k * c
    size = np.abs(slope)
    if not size.any():
        return float(c[0].real), float(c[0].real)
    # harmonics of rounding size would spoil the roots, and move no extremum
    slope = slope[: np.flatnonzero(size > 1e-16 * size.max())[-1] + 1]
    tau = np.angle(np.roots(np.concatenate([slope[:0:-1], [0.0], np.conj(slope[1:])])))
    values = (np.exp(1j * np.multiply.outer(tau, k)) @ c).real
    return float(values.min()), float(values.max())


def decay(problem: FrictionProblem, locked: bool = False) -> float:
    """Decay per forcing period of the slowest mode, damping included and friction left out.

    After `x` periods the slowest mode still has ``exp(-decay * x)`` of its start. Zero without
    damping, negative for a system that diverges.

    Parameters
    ----------
    problem : FrictionProblem
    locked : bool
        Whether the joint is held.

    Examples
    --------
    >>> from beltsim import FrictionProblem, HarmonicForcing
    >>> rest = HarmonicForcing(1.0, [[0.0]], [[0.0]])
    >>> mass = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[4.0]], None, rest, None)
    >>> round(decay(mass), 6)
    0.314159
    """
    moving = _moving(problem, locked)
    n = len(moving)
    if n == 0:
        return float("inf")
    grid = np.ix_(moving, moving)
    right = np.hstack([problem.K[grid], problem.C[grid] + problem.G[grid]])
    first_order = np.zeros((2 * n, 2 * n))
    first_order[:n, n:] = np.eye(n)
    first_order[n:] = -np.linalg.solve(problem.M[grid], right)
    slowest = float(np.linalg.eigvals(first_order).real.max())
    return -slowest * problem.period


def hertz(problem: FrictionProblem, frequencies: FloatArray | float) -> FloatArray:
    """Frequencies in Hz, from rad per unit of the problem's time.

    Raises
    ------
    InvalidProblemError
        When the problem carries no scales.
    """
    if problem.scales is None:
        raise InvalidProblemError(Mistake("scales", None, "given, to convert to Hz"))
    return np.asarray(frequencies) / (2.0 * np.pi * problem.scales.time_s)


def _moving(problem: FrictionProblem, locked: bool) -> NDArray[np.intp]:
    """Indices of the coordinates that move."""
    if not locked:
        return np.arange(problem.n)
    if problem.joint is None:
        raise InvalidProblemError(Mistake("joint", None, "an index, to lock it"))
    return problem.others


def _hermitian_form(
    problem: FrictionProblem, moving: NDArray[np.intp]
) -> tuple[ComplexArray, FloatArray]:
    """Hermitian matrix whose eigenvalues are +-omega, and the inverse Cholesky factor of M."""
    grid, n = np.ix_(moving, moving), len(moving)
    L_inverse: FloatArray = np.linalg.inv(np.linalg.cholesky(problem.M[grid]))
    turning = L_inverse @ problem.G[grid] @ L_inverse.T
    form = np.zeros((2 * n, 2 * n))
    form[:n, :n] = 0.5 * (turning - turning.T)
    form[:n, n:] = L_inverse @ _stiffness_factor(problem.K[grid])
    form[n:, :n] = -form[:n, n:].T
    return np.asarray(1j * form, dtype=np.complex128), L_inverse


def _stiffness_factor(K: FloatArray) -> FloatArray:
    """F with K = F F': Cholesky, or through eigenvalues where a rigid mode makes K singular."""
    try:
        return np.asarray(np.linalg.cholesky(K), dtype=np.float64)
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(K)
    limit = RIGID_TOLERANCE * float(np.abs(values).max())
    if values[0] < -limit:
        allowed = (
            f"at least {-limit:.3g}: an indefinite K has no guaranteed real frequencies; "
            "linear.decay tells whether the system is stable"
        )
        raise InvalidProblemError(Mistake("smallest eigenvalue of K", float(values[0]), allowed))
    found: FloatArray = vectors * np.sqrt(np.where(values > limit, values, 0.0))
    return found


def _normalised(velocities: ComplexArray, moving: NDArray[np.intp], n: int) -> ComplexArray:
    """Shapes (m, n) whose entry of largest modulus is 1."""
    shapes = np.zeros((len(velocities), n), dtype=complex)
    largest = np.argmax(np.abs(velocities), axis=1)
    shapes[:, moving] = velocities / velocities[np.arange(len(velocities)), largest][:, None]
    return shapes


def _solved(
    stiffness: ComplexArray, force: ComplexArray, M: FloatArray, k: int, rate: float
) -> ComplexArray:
    """Solution of one harmonic, scaled to a unit mass diagonal; refuses a resonance."""
    scale = 1.0 / np.sqrt(np.diag(M))
    scaled = stiffness * scale[:, None] * scale
    try:
        inverse = np.linalg.inv(scaled)
        condition = float(np.abs(scaled).sum(0).max() * np.abs(inverse).sum(0).max())
    except np.linalg.LinAlgError:
        condition = np.inf
    if not condition <= RESONANCE_CONDITION:
        allowed = (
            "away from a natural frequency, or damped: nothing limits the response there "
            "(k Omega is the frequency)"
        )
        raise InvalidProblemError(Mistake(f"harmonic {k} of the forcing", rate, allowed))
    found: ComplexArray = scale * np.linalg.solve(scaled, scale * force)
    return found
