"""The same problem through every solver, each asked for its steady motion.

Depends on: linear, transient, event_map, harmonic_balance, errors, friction, problem, response;
cross_check.motion.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from beltsim import event_map, harmonic_balance, transient
from beltsim.cross_check.motion import Motion, motion_of
from beltsim.errors import BeltsimError, ConvergenceError, NotPeriodicError, UnsupportedLawError
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.problem import FrictionProblem
from beltsim.response import Response

#: Samples per period of the highest excited harmonic: the residuals' quadrature is then good to
#: 1e-7. Up to so many harmonics; more excite nothing that needs finer steps.
SAMPLES, MOST_HARMONICS = 4000, 8
#: Tolerance of CVODE, and the period residual at which its motion counts as steady.
RTOL, STEADY = 1e-9, 1e-9
#: Forcing periods that CVODE runs at a time, and in all.
STRETCH, MOST_PERIODS = 20, 4000
#: Longest period that the event map looks for when Q_s > Q_m, in forcing periods.
MOST_MULTIPLE = 4
#: Harmonics tried, until the solver's own estimate of its error is small enough.
HARMONICS = (15, 25, 51, 101, 201)
#: Width of the saturated law's band over the largest velocity of the joint.
BAND = 1e-3


@dataclass(frozen=True, eq=False)
class Candidate:
    """A solver and the motion that it claims to be the steady one.

    Parameters
    ----------
    name : str
    motion : Motion or None
        None when it gave none; `note` then says why.
    note : str
        How it was run.
    accuracy : float
        Relative error that it admits for amplitudes and energies, and `reason` where that comes
        from.
    ripple : float
        Share of a forcing period to which it knows an instant; 0: to `accuracy`.
    seconds : float
    reason : str
    denies : bool
        Whether it gave no motion because it says that there is none.
    """

    name: str
    motion: Motion | None = field(repr=False)
    note: str
    accuracy: float = 0.0
    ripple: float = 0.0
    seconds: float = 0.0
    reason: str = ""
    denies: bool = False


def candidates(
    problem: FrictionProblem,
    tolerance: float = 5e-3,
    progress: Callable[[str], None] | None = None,
) -> Iterator[Candidate]:
    """Candidates for the steady motion of `problem`: event map, C core, harmonic balance.

    Parameters
    ----------
    problem : FrictionProblem
        With a joint.
    tolerance : float
        Harmonics are added until harmonic balance estimates its relative error as no more than
        this.
    progress : callable, optional
        Called with the name of each solver before it runs.
    """
    found: list[Candidate] = []
    solvers: tuple[tuple[str, Callable[..., Candidate]], ...] = (
        ("event map", _event_map),
        ("C core", _transient),
        ("set-valued balance", _set_valued),
        ("saturated balance", _saturated),
    )
    for name, solver in solvers:
        if progress is not None:
            progress(name)
        start = time.perf_counter()
        try:
            one = solver(name, problem, found, tolerance)
        except BeltsimError as error:
            one = Candidate(name, None, str(error), denies=isinstance(error, NotPeriodicError))
        found.append(
            Candidate(**{**vars(one), "seconds": time.perf_counter() - start})  # as it was timed
        )
        yield found[-1]


def samples_per_period(problem: FrictionProblem) -> int:
    """Samples per forcing period, which may hold several periods of what excites most."""
    excited = np.flatnonzero(np.any(problem.forcing.coefficients != 0.0, axis=1))
    return SAMPLES * int(np.clip(excited.max(initial=1), 1, MOST_HARMONICS))


def _event_map(
    name: str, problem: FrictionProblem, found: list[Candidate], tolerance: float
) -> Candidate:
    del found, tolerance
    multiple = MOST_MULTIPLE if _static(problem) else 1
    samples = samples_per_period(problem)
    settings = event_map.Settings(samples_per_period=samples, max_multiple=multiple, harmonics=0)
    orbit = event_map.periodic(problem, settings)
    periods = int(orbit.statistics["multiple"])
    note = "exact orbit" if periods == 1 else f"exact orbit of {periods} forcing periods"
    note += "".join(f"; {text}" for text in orbit.warnings if "unstable" in text)
    motion = motion_of(orbit, periods)
    return Candidate(name, motion, note, 1e-9, reason="the map is exact to rounding")


def _transient(
    name: str, problem: FrictionProblem, found: list[Candidate], tolerance: float
) -> Candidate:
    """From rest, until the state repeats after as many periods as the event map's does."""
    del tolerance
    period = next((one.motion.periods for one in found if one.motion is not None), 1)
    settings = transient.Settings(
        rtol=RTOL,
        samples_per_period=samples_per_period(problem),
        kept_periods=float(period),
        event_states=True,
    )
    run, done, state = None, 0, None
    stretch = period * math.ceil(STRETCH / period)
    while done < MOST_PERIODS:
        run = transient.integrate(problem, float(stretch), state, settings)
        done += stretch
        state = run.final_state
        if _change(run, period) <= STEADY:
            break
    else:
        change = _change(run, period)
        raise ConvergenceError(f"not steady after {done} periods: still changes by {change:.1g}")
    method = settings.method_for(problem)
    note = f"CVODE ({method}), rtol {RTOL:g}, steady after {done} periods from rest"
    reason = "what is left of the transient, and steps of rtol 1e-9"
    return Candidate(name, motion_of(run, period), note, 1e-6, reason=reason)


def _change(run: Response | None, periods: int) -> float:
    """Largest change of the state over the last `periods`, over its largest entry."""
    assert run is not None
    first = int(np.argmin(np.abs(run.t - (run.t[-1] - periods * run.problem.period))))
    weight = 1.0 / run.problem.forcing.Omega
    start = np.concatenate([run.q[first], run.q_dot[first] * weight])
    end = np.concatenate([run.q[-1], run.q_dot[-1] * weight])
    size = float(np.abs(end).max())
    change = float(np.abs(end - start).max())
    return change / size if size > 0.0 else change


def _set_valued(
    name: str, problem: FrictionProblem, found: list[Candidate], tolerance: float
) -> Candidate:
    law = problem.friction
    if not isinstance(law, Coulomb):
        raise UnsupportedLawError("the set-valued method is for Coulomb friction")
    if _static(problem):
        return _by_pattern(name, problem, found, tolerance)
    response, error = _raised(problem, tolerance)
    note = f"R = {response.statistics['R']}, error estimate {error:.1e}"
    return _of_series(name, problem, response, error, note)


def _by_pattern(
    name: str, problem: FrictionProblem, found: list[Candidate], tolerance: float
) -> Candidate:
    """With Q_s > Q_m the balance is told which motion is meant: the one of the solver before it."""
    before = next((one for one in found if one.motion is not None), None)
    if before is None or before.motion is None:
        raise UnsupportedLawError("needs the pattern of events for Q_s > Q_m, and there is none")
    motion, law = before.motion, problem.friction
    if motion.periods > 1:
        raise UnsupportedLawError(
            f"knows the forcing period only, and the motion takes {motion.periods} of them"
        )
    if not motion.kinds:
        assert isinstance(law, Coulomb)
        response, error = _raised(problem.with_friction(Coulomb(law.Q_s or 0.0)), tolerance)
        note = "a joint at rest: as with Q_s for both levels"
    else:
        times = motion.angles * problem.period
        pattern = harmonic_balance.Pattern(motion.kinds, times, motion.initial_mode)
        response, error = _raised(problem, tolerance, pattern=pattern)
        note = f"pattern of events of the {before.name}"
    note = f"R = {response.statistics['R']}, error estimate {error:.1e}; {note}"
    return _of_series(name, problem, response, error, note)


def _saturated(
    name: str, problem: FrictionProblem, found: list[Candidate], tolerance: float
) -> Candidate:
    """The paper's method, in a band that is narrow against the velocities found before."""
    law: Any = problem.friction
    sigma, error_of_band = getattr(law, "sigma", 0.0), 0.0
    if not sigma:
        joint = problem.joint or 0
        peaks = [
            float(np.abs(piece.q_dot[:, joint]).max())
            for one in found
            if one.motion is not None
            for piece in one.motion.pieces
        ]
        if not peaks or max(peaks) == 0.0:
            raise UnsupportedLawError("the saturated law cannot hold a joint that never moves")
        sigma, error_of_band = BAND * max(peaks), 6.0 * BAND
        if _static(problem) and any("stick" in one.motion.kinds for one in found if one.motion):
            raise UnsupportedLawError(
                f"the saturated law has no static level, here Q_s = {law.Q_s:.4g}, and the motion "
                "sticks"
            )
    saturated = problem.with_friction(SaturatedCoulomb(law.Q_m, sigma))
    try:
        response, error = _raised(saturated, tolerance, start="set_valued")
    except ConvergenceError:
        response, error = _raised(saturated, tolerance, sigma_ladder=True)
    note = f"R = {response.statistics['R']}, sigma = {sigma:.3g}, error estimate {error:.1e}"
    if error_of_band:
        note += f", and {error_of_band:.0e} for the band"
    return _of_series(name, problem, response, error + error_of_band, note)


def _raised(problem: FrictionProblem, tolerance: float, **settings: Any) -> tuple[Response, float]:
    """The response with the fewest harmonics that meet the tolerance, and its relative error.

    Where more harmonics do not converge, the last that did.
    """
    samples = samples_per_period(problem)
    chosen = harmonic_balance.Settings(samples_per_period=samples, **settings)
    least = len(problem.forcing.cos) - 1
    ladder = [R for R in HARMONICS if least <= R]
    joint = problem.joint or 0
    found: tuple[Response, float] | None = None
    for R in ladder or [least + 1 - least % 2]:
        try:
            response = harmonic_balance.solve(problem, R, chosen)
        except ConvergenceError:
            if found is None:
                raise
            return found
        size = float(np.std(response.q[:-1, joint]))
        estimate = response.statistics.get("error_estimate")
        error = math.inf if estimate is None else estimate / size if size > 0.0 else 0.0
        found = response, error
        if error <= tolerance:
            break
    assert found is not None
    return found


def _of_series(
    name: str, problem: FrictionProblem, response: Response, error: float, note: str
) -> Candidate:
    """A candidate whose instants are known to a ripple of its highest harmonic."""
    motion = motion_of(response, exact_events=False)
    motion = Motion(**{**_fields(motion), "problem": problem})
    ripple = 1.0 / (int(response.statistics["R"]) + 1)
    reason = "its own estimate for the joint, and a ripple T/(R + 1) for instants"
    return Candidate(name, motion, note, error, ripple, reason=reason)


def _fields(motion: Motion) -> dict[str, Any]:
    return {name: getattr(motion, name) for name in motion.__dataclass_fields__}


def _static(problem: FrictionProblem) -> bool:
    law = problem.friction
    return isinstance(law, Coulomb) and law.Q_s is not None and law.Q_s > law.Q_m
