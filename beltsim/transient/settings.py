"""Settings of a transient run, and the tolerances that follow from the problem.

The default absolute tolerances are tied to an energy, so that a result does not depend on the
units of the problem, nor on a common factor of forces and friction torque.

Depends on: errors, checks, problem, friction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray, finite_array, real_number
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem

METHODS = ("auto", "adams", "bdf", "taylor")
#: The fastest decay over the fastest oscillation from which on the problem counts as stiff.
STIFF = 100.0
KEEPS = ("last_period", "all", "events")
#: Share of rtol that the default absolute tolerances allow on a full swing.
ATOL_SHARE = 0.01
#: Errors of some thousand steps add up: each step of CVODE is held to this share of both
#: tolerances, but never to less than TIGHTEST of the state, which rounding could not meet.
STEP_SHARE, TIGHTEST = 0.01, 1e-14
#: A touch or event is called near grazing below this many rtol of the peak, but never above
#: GRAZING_MOST: the error of a whole run is larger than that of one step.
GRAZING_FACTOR, GRAZING_MOST = 1e3, 1e-3
#: Events a period may have: this, plus so many per period of the fastest mode.
CHATTER_BASE, CHATTER_PER_MODE = 20.0, 8.0


@dataclass(frozen=True)
class Settings:
    """How to integrate and what to keep.

    Parameters
    ----------
    rtol : float
        Relative tolerance, 1e-14 to 1e-2. It is meant for the state after some tens of periods:
        each step of CVODE is held to a hundredth of `rtol` and `atol`.
    atol : float or array_like of shape (2n,), optional
        Absolute tolerances, coordinates then velocities. Default: 0.01 rtol times the amplitude
        that the reference energy allows each coordinate, see `default_atol`.
    method : str
        ``"adams"`` (CVODE, fixed-point corrector), ``"bdf"`` (CVODE, dense Newton), ``"taylor"``
        (local Taylor series of order 20 throughout: no CVODE, fastest), or ``"auto"``: Adams, but
        BDF where the problem is stiff: the saturated law's band, or a mode that decays a hundred
        times faster than the system oscillates.
    samples_per_period : int
        Samples per forcing period; both ends of the stretch are included.
    keep : str
        ``"last_period"``, ``"all"``, or ``"events"`` (no samples at all).
    event_states : bool
        Whether the event log keeps the full state at each event (16 n bytes per event).
    max_steps, max_events : int
        Budgets of the whole run; exceeding one is a `CoreError`.
    max_seconds : float
        Budget of wall time.
    kept_periods : float
        With ``keep="last_period"``: how many periods at the end are sampled. The figures belong to
        the very last one all the same.

    Raises
    ------
    InvalidProblemError
        With every setting that cannot be used.

    Examples
    --------
    >>> Settings(rtol=1e-10).keep
    'last_period'
    """

    rtol: float = 1e-8
    atol: Any = None
    method: str = "auto"
    samples_per_period: int = 500
    keep: str = "last_period"
    event_states: bool = True
    max_steps: int = 100_000_000
    max_events: int = 10_000_000
    max_seconds: float = math.inf
    kept_periods: float = 1.0

    def __post_init__(self) -> None:
        mistakes = []
        rtol = real_number(self.rtol)
        if rtol is None or not 1e-14 <= rtol <= 1e-2:
            mistakes.append(Mistake("settings.rtol", self.rtol, "between 1e-14 and 1e-2"))
        if self.atol is not None and not _positive(self.atol):
            allowed = "None, a finite number > 0 or an array of 2n such numbers"
            mistakes.append(Mistake("settings.atol", self.atol, allowed))
        for name, known in (("method", METHODS), ("keep", KEEPS)):
            if getattr(self, name) not in known:
                allowed = "one of " + ", ".join(known)
                mistakes.append(Mistake(f"settings.{name}", getattr(self, name), allowed))
        for name in ("samples_per_period", "max_steps", "max_events"):
            value = getattr(self, name)
            integer = isinstance(value, int | np.integer) and not isinstance(value, bool)
            if not (integer and 1 <= value <= 2**62):
                mistakes.append(Mistake(f"settings.{name}", value, "an integer >= 1"))
        if not isinstance(self.event_states, bool | np.bool_):
            mistakes.append(Mistake("settings.event_states", self.event_states, "True or False"))
        if not _is_budget(self.max_seconds):
            mistakes.append(Mistake("settings.max_seconds", self.max_seconds, "a number > 0"))
        kept = real_number(self.kept_periods)
        if kept is None or not kept > 0.0:
            allowed = "a finite number > 0"
            mistakes.append(Mistake("settings.kept_periods", self.kept_periods, allowed))
        if mistakes:
            raise InvalidProblemError(mistakes)

    @property
    def grazing(self) -> float:
        """Margin below which a touch or an event is called near grazing."""
        return min(GRAZING_MOST, GRAZING_FACTOR * self.rtol)

    def method_for(self, problem: FrictionProblem) -> str:
        """The method used for `problem`: "adams", "bdf" or "taylor"."""
        if self.method != "auto":
            return self.method
        stiff = isinstance(problem.friction, SaturatedCoulomb) or _is_stiff(problem)
        return "bdf" if stiff else "adams"

    def step_share(self, problem: FrictionProblem) -> float:
        """Share of both tolerances that one step is held to."""
        if self.method_for(problem) == "taylor":
            return 1.0  # few steps, of an error that falls with the twentieth power
        return max(STEP_SHARE, min(1.0, TIGHTEST / self.rtol))

    def atol_for(self, problem: FrictionProblem, y0: FloatArray, length: float) -> FloatArray:
        """Absolute tolerances (2n,) for a run of `length` from `y0`."""
        if self.atol is None:
            return default_atol(problem, y0, length, self.rtol)
        atol = np.asarray(self.atol, dtype=np.float64)
        if atol.ndim == 0:
            return np.full(2 * problem.n, float(atol))
        if atol.shape != (2 * problem.n,):
            allowed = f"of shape ({2 * problem.n},): coordinates, then velocities"
            raise InvalidProblemError(Mistake("settings.atol", atol.shape, allowed))
        return np.ascontiguousarray(atol)


def _positive(value: Any) -> bool:
    number = real_number(value)
    if number is not None:
        return number > 0.0
    array = finite_array(value, ndim=1)
    return array is not None and len(array) > 0 and bool(np.all(array > 0.0))


def _is_budget(value: Any) -> bool:
    if isinstance(value, float) and value == math.inf:
        return True
    number = real_number(value)
    return number is not None and number > 0.0


def _is_stiff(problem: FrictionProblem) -> bool:
    """Whether damping alone would hold an explicit method to steps far below any oscillation."""
    fastest, damping = _largest(problem.K, problem.M), _largest(problem.C, problem.M)
    forced = problem.forcing.Omega * (len(problem.forcing.cos) - 1)
    return damping > STIFF * max(math.sqrt(max(fastest, 0.0)), forced)


def _largest(matrix: FloatArray, mass: FloatArray) -> float:
    """Largest eigenvalue of a symmetric matrix over the mass matrix."""
    from scipy.linalg import eigvalsh

    last = len(mass) - 1
    if last < 0:
        return 0.0
    return float(eigvalsh(matrix, mass, subset_by_index=[last, last])[0])


def reference_energy(problem: FrictionProblem, y0: FloatArray, length: float) -> float:
    r"""Energy by which the absolute tolerances are scaled.

    The initial energy plus the larger of the greatest energies of the steady linear response with
    the joint free and with it locked; where a resonance without damping makes that huge, no more
    than the forcing can have put in within `length`. Without any of these the joint's
    :math:`Q_m^2/K_{jj}`, or 1.
    """
    n = problem.n
    q, v = y0[:n], y0[n:]
    with np.errstate(over="ignore", invalid="ignore"):  # a motion that runs away ends as inf
        start = abs(0.5 * float(v @ problem.M @ v + q @ problem.K @ q))
    keep = np.arange(n)
    steady = _harmonic_energy(problem, keep)
    if problem.joint is not None and n > 1:
        steady = max(steady, _harmonic_energy(problem, problem.others))
    energy = start + min(steady, _impulse_energy(problem, length))
    if energy > 0.0 and math.isfinite(energy):
        return energy
    if problem.joint is not None and problem.friction is not None:
        stiffness = float(problem.K[problem.joint, problem.joint])
        if stiffness > 0.0 and problem.friction.Q_m > 0.0:
            return problem.friction.Q_m**2 / stiffness
    return 1.0


def _harmonic_energy(problem: FrictionProblem, keep: NDArray[np.int_]) -> float:
    """Bound of the energy of the steady response of the coordinates `keep`."""
    block = np.ix_(keep, keep)
    M, K = problem.M[block], problem.K[block]
    damping = problem.C[block] + problem.G[block]
    size = 0.0
    for k, force in enumerate(problem.forcing.coefficients[:, keep]):
        if not force.any():
            continue
        w = k * problem.forcing.Omega
        try:
            c = np.linalg.solve(K + 1j * w * damping - w * w * M, force)
        except np.linalg.LinAlgError:
            return math.inf
        energy = np.real(np.conj(c) @ (K @ c) + w * w * (np.conj(c) @ (M @ c)))
        size += math.sqrt(abs(float(energy)))
    return 0.5 * size * size


def _impulse_energy(problem: FrictionProblem, length: float) -> float:
    """Energy that the forcing can put into masses at rest within `length`."""
    size = 0.0
    for row in (*problem.forcing.cos, *problem.forcing.sin[1:]):
        if row.any():
            size += math.sqrt(abs(float(row @ np.linalg.solve(problem.M, row))))
    return 0.5 * (size * length) ** 2


def default_atol(
    problem: FrictionProblem, y0: FloatArray, length: float, rtol: float
) -> FloatArray:
    r"""Absolute tolerances (2n,) from the reference energy E.

    .. math::
       atol_{v,i} = 0.01\,rtol\,\sqrt{2E/M_{ii}}, \qquad atol_{q,i} = 0.01\,rtol\,\sqrt{2E/K_{ii}}

    With :math:`K_{ii} \le 0` the coordinate takes :math:`atol_{v,i}/\Omega`.
    """
    energy = reference_energy(problem, y0, length)
    share = ATOL_SHARE * rtol * math.sqrt(2.0 * energy)
    velocity = share / np.sqrt(np.diag(problem.M))
    stiffness = np.diag(problem.K)
    stiff = stiffness > 0.0
    coordinate = velocity / problem.forcing.Omega
    coordinate[stiff] = share / np.sqrt(stiffness[stiff])
    # a spring far softer than the inertia at Omega says nothing about the swing
    return np.concatenate(
        [np.minimum(coordinate, 1e3 * velocity / problem.forcing.Omega), velocity]
    )


def events_per_period(problem: FrictionProblem) -> float:
    """Events of one period beyond which a run is called chatter: 20 + 8 max(w_max/Omega, H).

    `w_max` is bounded from above by Frobenius norms of the mass-scaled matrices; `H` is the highest
    harmonic of the forcing, which alone can make four events in each of its own periods.
    """
    root = np.linalg.cholesky(problem.M)
    inner = [np.linalg.solve(root, np.linalg.solve(root, A).T) for A in (problem.K, problem.G)]
    stiffness, gyroscopic = (float(np.linalg.norm(A)) for A in inner)
    fastest = math.sqrt(stiffness) + gyroscopic
    rows = np.any(problem.forcing.cos != 0.0, axis=1) | np.any(problem.forcing.sin != 0.0, axis=1)
    highest = float(np.flatnonzero(rows)[-1]) if rows.any() else 0.0
    return CHATTER_BASE + CHATTER_PER_MODE * max(fastest / problem.forcing.Omega, highest)
