r"""Linear system of the whole drive, discretised with sine functions: full M, G, K.

Each span moves as :math:`w_i = y_i + [A_{0i}(1-x) + A_{1i} x]\theta_t` with
:math:`y_i = \sum_k a_{ik} \sin k\pi x`. Span equations times l_i, pulley equations times r_j and
the arm's times r_t, added and integrated by parts, lose all boundary terms; divided by r_t, the
arm's row carries its friction torque with factor one:

.. math::
    r_t M(u, v) &= \sum_i l_i\mu_i \int w w' + \sum_j r_j m_j \theta_j\theta_j'
        + r_t m_t \theta_t\theta_t' \\
    r_t G(u, v) &= -\sum_i l_i\sigma_i \int (w' w_x - w'_x w) \\
    r_t K(u, v) &= \sum_i l_i \{T_i \int w_x w'_x + \epsilon_i^2 \int y_{xx} y'_{xx}
        + \gamma_i A_i A_i'\} + r_t k_s \theta_t\theta_t' \\
    A_i(u) &= [r_i\theta_i - r_{i+1}\theta_{i+1} + arm_i\theta_t]/l_i + \int w_x w^*_x

(u moves, v and primes test). M and K come out symmetric and G skew to the last bit. Dynamic span
tensions are gamma_i A_i.

The sines left out act statically: the span gives a little more than it would with the sines kept
alone. This **residual flexibility** replaces gamma by gamma/(1 + gamma R_i),

.. math:: R_i = -\frac{d}{dT_i}\Bigl(\tfrac12\int w^{*2}_x\Bigr)
    - \sum_{k \le N_i} \frac{2 A_{ik}^2}{T_i (k\pi)^2 + \epsilon_i^2 (k\pi)^4}

Coordinates, canonical: sines of span 1, of span 2, ..., rotations of all pulleys, arm.

Depends on: model.scaling, model.steady_state, checks, errors.
"""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray, read_only
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.model.scaling import DimensionlessDrive
from beltsim.model.steady_state import SteadyState

#: Most sine functions per span; far beyond any boundary layer that double precision resolves.
MAX_FUNCTIONS = 2000


@dataclass(frozen=True, eq=False)
class Basis:
    """The trial functions of a drive, and what does not change with its speed.

    Parameters
    ----------
    counts : (n,) of int
        Sines on each canonical span.
    span : (P,) of int
        Canonical span of each sine.
    k : (P,) of int
        Wave number of each sine.
    starts : (n,) of int
        First sine of each span.
    curvature_0, curvature_1 : (P,)
        Curvatures k0 and (-1)^k k1 at the ends of the span that each sine is on.
    M : (m, m)
        Mass matrix.
    G_per_s : (m, m)
        Gyroscopic matrix of unit belt speed.
    rows : (n, m)
        A_i without the part of the steady shape.
    """

    counts: NDArray[np.intp]
    span: NDArray[np.intp]
    k: NDArray[np.intp]
    starts: NDArray[np.intp]
    curvature_0: FloatArray
    curvature_1: FloatArray
    M: FloatArray
    G_per_s: FloatArray
    rows: FloatArray

    @property
    def n_sines(self) -> int:
        """Number P of sines on all spans."""
        return len(self.k)


@dataclass(frozen=True, eq=False)
class LinearSystem:
    """The drive linearised about its steady state; canonical coordinates, crank included.

    Parameters
    ----------
    state : SteadyState
    basis : Basis
    M, G, K : (m, m)
    gamma : (n,)
        Stretching stiffness of each span, with the residual flexibility where that is on.
    tension_rows : (n, m)
        Dynamic tension of each span, per coordinate.
    """

    state: SteadyState
    basis: Basis
    M: FloatArray
    G: FloatArray
    K: FloatArray
    gamma: FloatArray
    tension_rows: FloatArray

    def __post_init__(self) -> None:
        for name in ("M", "G", "K", "gamma", "tension_rows"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def drive(self) -> DimensionlessDrive:
        """The drive this is a system of."""
        return self.state.drive


def discretise(
    state: SteadyState, n_functions: int | Sequence[int] = 16, residual_flexibility: bool = True
) -> LinearSystem:
    """Matrices of the linearised drive.

    Parameters
    ----------
    state : SteadyState
    n_functions : int or sequence of int
        Sine functions per span, one number for all or one per span as the user lists them.
    residual_flexibility : bool
        Whether the sines left out act statically.

    Returns
    -------
    LinearSystem

    Raises
    ------
    InvalidProblemError
        When `n_functions` is not a positive integer, or one per span.

    Examples
    --------
    >>> from beltsim.drive.presets import zhu_parker_2008
    >>> from beltsim.model import operating_point, scaling, steady_state
    >>> point = operating_point.operate(scaling.scale(zhu_parker_2008()), 6.3)
    >>> discretise(steady_state.solve(point), n_functions=[4, 5, 5]).K.shape
    (18, 18)
    """
    drive = state.drive
    basis = basis_of(drive, n_functions)
    P, i = basis.n_sines, basis.span
    T, delta, eps2 = state.T[i], state.delta[i], drive.eps2[i]
    wave = np.pi * basis.k
    wave_2 = wave**2
    # int (sin k pi x)_x w*_x dx, in closed form; zero for a string
    bent = wave * delta**2 * (basis.curvature_1 - basis.curvature_0) / (1.0 + wave_2 * delta**2)
    sine_stiffness = 0.5 * wave_2 * (T + eps2 * wave_2)

    rows = basis.rows.copy()
    rows[i, np.arange(P)] = bent
    gamma = np.full(drive.n, drive.gamma)
    if residual_flexibility:
        kept = np.add.reduceat(bent**2 / sine_stiffness, basis.starts)
        gamma = drive.gamma / (1.0 + drive.gamma * (state.flexibility - kept))
    length = drive.span_length / drive.lever
    if drive.arm is not None:
        rows[:, -1] += drive.arm_chord * (state.w_1 - state.w_0)
    weighted = np.sqrt(length * gamma)[:, None] * rows
    K = weighted.T @ weighted  # one factor times itself: symmetric to the last bit
    diagonal = np.arange(P)
    K[diagonal, diagonal] += length[i] * sine_stiffness
    if drive.arm is not None:
        K[-1, -1] += drive.k_s + float(length @ (state.T * drive.arm_chord**2))
    return LinearSystem(
        state=state,
        basis=basis,
        M=basis.M,
        G=state.point.s * basis.G_per_s,
        K=K,
        gamma=gamma,
        tension_rows=gamma[:, None] * rows,
    )


#: Bases already built, by drive and number of sines; they go when the drive goes.
_BASES: weakref.WeakKeyDictionary[DimensionlessDrive, dict[tuple[int, ...], Basis]] = (
    weakref.WeakKeyDictionary()
)


def basis_of(drive: DimensionlessDrive, n_functions: int | Sequence[int]) -> Basis:
    """The basis with `n_functions` sines per span (user's order); built once per drive."""
    counts = _checked_counts(n_functions, drive.n)
    kept = _BASES.setdefault(drive, {})
    if counts not in kept:
        kept[counts] = _built_basis(drive, np.array(counts)[drive.frame.spans])
    return kept[counts]


def _checked_counts(n_functions: Any, n: int) -> tuple[int, ...]:
    single = isinstance(n_functions, int | np.integer)
    try:
        given = [n_functions] * n if single else list(n_functions)
    except TypeError:
        given = []
    whole = all(isinstance(k, int | np.integer) and not isinstance(k, bool) for k in given)
    if len(given) != n or not whole or not all(1 <= k <= MAX_FUNCTIONS for k in given):
        allowed = f"an integer from 1 to {MAX_FUNCTIONS}, or one for each of the {n} spans"
        raise InvalidProblemError(Mistake("n_functions", n_functions, allowed))
    return tuple(int(k) for k in given)


def _built_basis(drive: DimensionlessDrive, counts: NDArray[np.intp]) -> Basis:
    n, P = drive.n, int(counts.sum())
    span = np.repeat(np.arange(n), counts)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    k = np.arange(P) - starts[span] + 1
    alternating = np.where(k % 2 == 0, 1.0, -1.0)
    k0, k1 = drive.curvatures
    basis = Basis(
        counts=counts,
        span=span,
        k=k,
        starts=starts,
        curvature_0=k0[span],
        curvature_1=alternating * k1[span],
        M=_mass(drive, span, k, alternating),
        G_per_s=_gyroscopic(drive, span, k, alternating),
        rows=_stretch_rows(drive, P),
    )
    for value in vars(basis).values():
        value.flags.writeable = False
    return basis


def _mass(
    drive: DimensionlessDrive, span: NDArray[np.intp], k: NDArray[np.intp], alternating: FloatArray
) -> FloatArray:
    A0, A1 = drive.arm_deflections
    mass = drive.span_length * drive.mu / drive.lever
    P, n = len(k), drive.n
    armed = drive.arm is not None
    M = np.zeros((P + n + armed, P + n + armed))
    M[range(P), range(P)] = 0.5 * mass[span]
    pulleys = np.arange(P, P + n)
    M[pulleys, pulleys] = drive.radius * drive.m / drive.lever
    if armed:
        M[:P, -1] = M[-1, :P] = mass[span] * (A0[span] - alternating * A1[span]) / (np.pi * k)
        M[-1, -1] = drive.m_t + float(mass @ (A0**2 + A0 * A1 + A1**2)) / 3.0
    return M


def _gyroscopic(
    drive: DimensionlessDrive, span: NDArray[np.intp], k: NDArray[np.intp], alternating: FloatArray
) -> FloatArray:
    """G of unit belt speed; sigma_i = s l_i."""
    factor = -(drive.span_length**2) / drive.lever
    P, armed = len(k), drive.arm is not None
    G = np.zeros((P + drive.n + armed, P + drive.n + armed))
    row, column = k[:, None], k[None, :]
    coupled = (span[:, None] == span[None, :]) & ((row + column) % 2 == 1)
    gap = np.where(coupled, row**2 - column**2, 1)
    G[:P, :P] = factor[span][:, None] * np.where(coupled, 4.0 * row * column / gap, 0.0)
    if armed:
        G[:P, -1] = 2.0 * (factor * drive.arm_chord)[span] * (1.0 - alternating) / (np.pi * k)
        G[-1, :P] = -G[:P, -1]
    return G


def _stretch_rows(drive: DimensionlessDrive, n_sines: int) -> FloatArray:
    """Strain of each span per pulley and arm rotation."""
    armed = drive.arm is not None
    rows = np.zeros((drive.n, n_sines + drive.n + armed))
    for i in range(drive.n):
        following = (i + 1) % drive.n
        rows[i, n_sines + i] += drive.radius[i] / drive.span_length[i]
        rows[i, n_sines + following] -= drive.radius[following] / drive.span_length[i]
    if armed:
        rows[:, -1] = drive.arm_stretch / drive.span_length
    return rows
