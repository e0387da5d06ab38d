"""Exact transients.

Depends on: build, integrals, motion, settings, walk, response, problem.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from beltsim.checks import finite_array, real_number
from beltsim.errors import InvalidProblemError, Mistake, UnsupportedLawError
from beltsim.event_map import build
from beltsim.event_map.integrals import integrals
from beltsim.event_map.motion import sampled
from beltsim.event_map.settings import Settings, settled
from beltsim.event_map.walk import MODES, walk
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem, require_problem
from beltsim.response import PERIODIC_TOLERANCE, Response, figures, friction_travel


def propagate(
    problem: FrictionProblem,
    periods: float = 100.0,
    initial_state: Any = None,
    settings: Settings | None = None,
) -> Response:
    """Follow the motion exactly, phase by phase.

    Parameters
    ----------
    problem : FrictionProblem
        With a joint; `Coulomb` or `SaturatedCoulomb`.
    periods : float
        Length of the run in forcing periods; any positive number.
    initial_state : array_like of shape (2n,), optional
        All q, then all q_dot; zeros by default. A joint velocity of exactly zero sticks if it can.
    settings : Settings, optional

    Returns
    -------
    Response
        Event times are exact to rounding.

    Raises
    ------
    InvalidProblemError
        For a bad `periods` or `initial_state`.
    UnsupportedLawError
        For a problem without a joint.
    CoreError
        When the event budget is met or the state leaves the range of double.

    Examples
    --------
    A mass of 1 on a spring of 1, released at 1.05 with friction 0.1, stops after five half
    swings at 0.05 on the other side:

    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> still = HarmonicForcing(1.0, [[0.0]], [[0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.0]], [[0.0]], [[1.0]], 0, still, Coulomb(0.1))
    >>> run = propagate(one, 4.0, [1.05, 0.0])
    >>> float(run.events.t[-1] / np.pi), float(run.final_state[0])
    (5.0, -0.05)
    """
    settings = settled(settings)
    require_joint(problem)
    state = checked_run(problem, periods, initial_state)
    run = walk(problem, state, periods, settings.max_events)
    return transient_response(problem, run, settings)


def require_joint(problem: FrictionProblem) -> None:
    """Refuse a problem without friction: there is nothing to locate."""
    require_problem(problem)
    if problem.friction is None:
        text = "the event map needs a friction joint; give the linear problem one with Coulomb(0)"
        raise UnsupportedLawError(text)


def checked_run(problem: FrictionProblem, periods: Any, initial_state: Any) -> Any:
    """The initial state as an array, after checking it and the length of the run."""
    mistakes = []
    length = real_number(periods)
    if length is None or not length > 0.0:
        mistakes.append(Mistake("periods", periods, "a finite number > 0"))
    state = np.zeros(2 * problem.n)
    if initial_state is not None:
        found = finite_array(initial_state, ndim=1)
        if found is None or len(found) != 2 * problem.n:
            allowed = f"a finite array of shape ({2 * problem.n},)"
            mistakes.append(Mistake("initial_state", initial_state, allowed))
        else:
            state = found
    if mistakes:
        raise InvalidProblemError(mistakes)
    return state


def transient_response(problem: FrictionProblem, run: Any, settings: Settings) -> Response:
    """The `Response` of a walk: samples and figures of its last period."""
    period, law = problem.period, problem.friction
    assert law is not None
    start = max(0.0, run.end - period)
    found = integrals(problem, run, start, run.end)
    first_state = np.concatenate([x[0] for x in sampled(problem, run, np.array([start]))[:2]])
    window = build.window_of(problem, found, (start, run.end), (first_state, run.final_state))
    events = build.event_log(problem, run)
    mode = MODES[run.initial_mode]
    figure = figures(problem, events, mode, window)
    first = {"last_period": start, "all": 0.0, "events": run.end}[settings.keep]
    steps = max(1, round((run.end - first) / period * settings.samples_per_period))
    t = np.linspace(first, run.end, steps + 1) if settings.keep != "events" else np.zeros(0)
    q, q_dot, torque = sampled(problem, run, t)
    joint = problem.joint or 0
    ends = (float(run.initial_state[joint]), float(run.final_state[joint]))
    total: float | None = None  # the saturated law's loss does not follow from positions
    if isinstance(law, Coulomb):
        total = law.Q_m * friction_travel(events, mode, 0.0, run.end, ends)
    touches = build.near_grazing(problem, run, found.speed / (run.end - start))
    residual = figure.period_residual
    return Response(
        problem=problem,
        t=t,
        q=q,
        q_dot=q_dot,
        friction_torque=torque,
        initial_state=run.initial_state,
        final_state=run.final_state,
        initial_mode=mode,
        events=events,
        near_grazing=touches,
        window=(window.start, window.end),
        **figure._asdict(),
        periodic=residual is not None and residual <= PERIODIC_TOLERANCE,
        total_dissipated_energy=total,
        warnings=build.warnings_of(problem, (t, q), events, touches, (start, run.end)),
        statistics={"solver": "event_map", "events": len(events)},
    )
