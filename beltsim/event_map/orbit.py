r"""Periodic orbits: what to look for, and the `Response` of what was found.

When the forcing has odd harmonics only, the orbit of a symmetric joint repeats after half a period
with the opposite sign, and half a period suffices. For Q_s = Q_m any two motions approach each
other, so following the motion always leads back to where Newton converges.

Depends on: build, integrals, shooting, locked, motion, settings, walk, response, problem.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from beltsim.checks import FloatArray
from beltsim.errors import ConvergenceError, NotPeriodicError
from beltsim.event_map import build
from beltsim.event_map.integrals import integrals
from beltsim.event_map.linear_part import ComplexArray
from beltsim.event_map.locked import (
    at_rest,
    locked,
    may_move_too,
    require_bounded,
    require_stable,
    rest_place,
    resting_multipliers,
)
from beltsim.event_map.motion import fourier, sampled
from beltsim.event_map.propagate import checked_run, require_joint
from beltsim.event_map.settings import Settings, settled
from beltsim.event_map.shooting import Shooting, half_wave, shoot
from beltsim.event_map.walk import MODES, Walk, walk
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem
from beltsim.response import EventLog, Response, figures


def periodic(
    problem: FrictionProblem, settings: Settings | None = None, *, guess: Any = None
) -> Response:
    """The periodic response, exact to rounding, with its Floquet multipliers.

    Parameters
    ----------
    problem : FrictionProblem
        With a joint and a stable linear part.
    settings : Settings, optional
        `tolerance`, `harmonics`, `samples_per_period`, `max_multiple`.
    guess : array_like of shape (2n,), optional
        State at t = 0 near the orbit, such as that of a neighbouring torque. For Q_s > Q_m, where
        several orbits may exist, it tells which is meant; without one it is the locked joint where
        it can rest, else the orbit that the motion from rest approaches.

    Returns
    -------
    Response
        One period, both ends; for a joint that never moves, at the middle of its rest interval,
        with a warning where a moving orbit may exist beside it (Q_m < Q_cr <= Q_s).

    Raises
    ------
    NotPeriodicError
        When the linear part is unstable, when a harmonic of the forcing meets a mode without
        damping, or (Q_s > Q_m) when no orbit of at most `max_multiple`
        forcing periods was found.
    ConvergenceError
        When the residual stays above the tolerance.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4))
    >>> orbit = periodic(one)
    >>> orbit.events.kind.tolist(), orbit.periodic
    (['stick', 'slip-', 'stick', 'slip+'], True)
    """
    return orbit_response(problem, settled(settings), guess, moving=guess is not None)


def orbit_response(
    problem: FrictionProblem, settings: Settings, guess: Any = None, *, moving: bool = False
) -> Response:
    """As `periodic`; `moving`: the guess says which orbit is meant, not only where to start."""
    found = found_orbit(problem, settings, guess, moving=moving)
    if isinstance(found, Shooting):
        return _orbit_response(problem, found, settings)
    return _resting(problem, found, settings)


def found_orbit(
    problem: FrictionProblem, settings: Settings, guess: Any = None, *, moving: bool = False
) -> Shooting | tuple[float, float]:
    """The orbit, or the rest interval of a joint that never moves; errors as for `periodic`.

    A joint that can rest does, unless `moving` asks for the orbit near `guess`. For Q_s > Q_m
    several orbits may exist: otherwise it is the one that the motion from rest approaches.
    """
    require_joint(problem)
    require_stable(problem)
    settle = not (moving or _unique(problem))
    guess = None if settle else guess
    state = checked_run(problem, 1.0, guess)
    rest = _rest(problem)
    if rest is not None and not (moving and may_move_too(problem)):
        return rest
    if rest is None:
        require_bounded(problem)
    failures = []
    for multiple, half in _attempts(problem, settings):
        near = guess is not None
        found = shoot(problem, state, multiple, half, settings.tolerance, near, settle)
        if found.residual <= settings.tolerance and (rest is None or any(found.run.modes())):
            return found
        failures.append(found)
    if rest is not None:
        return rest
    raise _failure(problem, failures, settings)


def _rest(problem: FrictionProblem) -> tuple[float, float] | None:
    law = problem.friction
    return locked(problem).rest_interval(law.Q_s or 0.0) if isinstance(law, Coulomb) else None


def _unique(problem: FrictionProblem) -> bool:
    """Whether any two motions approach each other."""
    law = problem.friction
    return not isinstance(law, Coulomb) or law.Q_s == law.Q_m


def _attempts(problem: FrictionProblem, settings: Settings) -> Iterator[tuple[int, bool]]:
    """Periods to look for, in forcing periods, and whether by half of them.

    A symmetric problem may have an orbit that is not, when Q_s > Q_m: then halves are not all.
    """
    for multiple in range(1, settings.max_multiple + 1):
        half = multiple % 2 == 1 and half_wave(problem)
        if half:
            yield multiple, True
        if not (half and _unique(problem)):
            yield multiple, False


def _orbit_response(problem: FrictionProblem, found: Shooting, settings: Settings) -> Response:
    run = walk(problem, found.state, float(found.multiple))
    statistics = {
        "solver": "event_map",
        "multiple": found.multiple,
        "newton_steps": len(found.history) - 1,
        "periods_followed": found.followed,
        "half_wave": int(found.half),
        "residual": found.residual,
    }
    return orbit_of(problem, run, found.multipliers, statistics, settings, found.half)


def _resting(problem: FrictionProblem, rest: tuple[float, float], settings: Settings) -> Response:
    """The locked orbit at the middle of the rest interval."""
    motion = _rest_motion(problem, rest_place(rest), settings)
    text = (
        f"the joint is locked, but Q_m is below Q_cr = {locked(problem).Q_m_cr:.6g}: a moving "
        "orbit may exist beside it; give a state of it as guess to find it"
    )
    warnings = (*motion.warnings, text) if may_move_too(problem) else motion.warnings
    return replace(motion, problem=problem, rest_interval=rest, warnings=warnings)


def _rest_motion(problem: FrictionProblem, place: float, settings: Settings) -> Response:
    """The motion around a joint at rest: made once for all torques that hold it with certainty."""
    law = problem.friction
    assert isinstance(law, Coulomb)
    certain = (law.Q_s or 0.0) > (1.0 + 1e-9) * locked(problem).Q_m_cr
    kept = problem.shared.get("event_map.resting")
    if certain and kept is not None and kept[0] == (place, settings):
        found: Response = kept[1]
        return found
    run = walk(problem, at_rest(problem, place), 1.0)
    statistics = {"solver": "event_map", "multiple": 1, "newton_steps": 0, "residual": 0.0}
    found = orbit_of(problem, run, resting_multipliers(problem), statistics, settings)
    if certain:
        problem.shared["event_map.resting"] = ((place, settings), found)
    return found


def orbit_of(
    problem: FrictionProblem,
    run: Walk,
    multipliers: ComplexArray,
    statistics: dict[str, Any],
    settings: Settings,
    symmetric: bool = False,
) -> Response:
    """The `Response` of a closed walk, `symmetric` when its second half mirrors the first."""
    half = 0.5 * run.end if symmetric else None
    end = run.end if half is None else half
    coefficients: ComplexArray | None = None
    torque_coefficients: ComplexArray | None = None
    if statistics["multiple"] == 1:
        coefficients, torque_coefficients = fourier(
            problem, run, end, settings.harmonics, symmetric=symmetric
        )
    covered = integrals(problem, run, 0.0, end)
    ends = (run.initial_state, run.final_state)
    window = build.window_of(problem, covered, (0.0, run.end), ends, symmetric)
    events = build.event_log(problem, run)
    steps = max(1, round(run.end / problem.period * settings.samples_per_period))
    t = np.linspace(0.0, run.end, steps + 1)
    q, q_dot, torque = sampled(problem, run, t, half)
    speed = covered.speed / end
    touches = build.near_grazing(problem, run, speed)
    mode = MODES[run.initial_mode]
    return Response(
        problem=problem,
        t=t,
        q=q,
        q_dot=q_dot,
        friction_torque=torque,
        initial_state=run.initial_state,
        final_state=run.final_state,
        initial_mode=mode,
        events=_on_the_circle(events, run.end),
        near_grazing=touches,
        window=(0.0, run.end),
        **figures(problem, events, mode, window, cyclic=True)._asdict(),
        periodic=True,
        coefficients=coefficients,
        torque_coefficients=torque_coefficients,
        multipliers=multipliers,
        warnings=(
            *build.warnings_of(problem, (t, q), events, touches, (0.0, run.end)),
            *_unstable(multipliers),
        ),
        statistics=statistics,
    )


def _unstable(multipliers: ComplexArray) -> tuple[str, ...]:
    """A warning for an orbit that no motion approaches (possible for Q_s > Q_m only)."""
    largest = float(np.abs(multipliers).max(initial=0.0))
    if largest <= 1.0 + 1e-6:
        return ()
    return (f"the orbit is unstable: its largest Floquet multiplier has modulus {largest:.4g}",)


def _on_the_circle(events: EventLog, period: float) -> EventLog:
    """An event on the boundary is listed once, at 0."""
    if not len(events) or events.t[-1] < period:
        return events
    order = np.append(len(events) - 1, np.arange(len(events) - 1))
    parts = {name: getattr(events, name)[order] for name in events.__dataclass_fields__}
    parts["t"][0] = 0.0
    return EventLog(**parts)


def rms(orbit: Response) -> FloatArray:
    """Root mean square (n,) of each coordinate over a periodic orbit, mean included, exact.

    Parameters
    ----------
    orbit : Response
        From `periodic` or `solve_many`.

    Returns
    -------
    (n,)
        In the problem's units.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4))
    >>> rms(periodic(one)).round(4)
    array([1.0331])
    """
    problem, end = orbit.problem, orbit.window[1]
    length = 0.5 * end if orbit.statistics.get("half_wave") else end
    run = walk(problem, orbit.initial_state, length / problem.period)
    squares = integrals(problem, run, 0.0, length).squares
    root: FloatArray = np.sqrt(np.maximum(squares, 0.0) / length)
    return root


def _failure(problem: FrictionProblem, searches: list[Shooting], settings: Settings) -> Exception:
    best = min(searches, key=lambda search: search.residual)
    n, law = problem.n, problem.friction
    change = best.image - best.state
    speed = float(np.abs(best.image[n:]).max())
    if not best.half and float(np.abs(change[n:]).max()) <= 1e-9 * speed:
        drift = float(np.abs(change[:n]).max())
        text = (
            f"the velocities repeat but the position drifts by {drift:.3g} per period: nothing "
            "holds the mean place of the joint. Add stiffness, or look at a transient"
        )
        return NotPeriodicError(text)
    residual = f"residual {best.residual:.3g} after {best.followed:g} forcing periods"
    if isinstance(law, Coulomb) and law.Q_s is not None and law.Q_s > law.Q_m:
        tried = ", ".join(sorted({str(search.multiple) for search in searches}))
        text = (
            f"no orbit of period {tried} was found "
            f"({residual}). With Q_s = {law.Q_s:g} > Q_m = {law.Q_m:g} none need exist; try a "
            f"larger max_multiple ({settings.max_multiple} now) or look at a transient"
        )
        return NotPeriodicError(text)
    text = (
        f"shooting stopped at {residual}, above the tolerance {settings.tolerance:g}; "
        "try a larger tolerance or a guess from a neighbouring case"
    )
    return ConvergenceError(text, best.state, best.history)
