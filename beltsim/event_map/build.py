"""From a walk to a `Response`: event log, window and warnings.

Depends on: flows, integrals, walk, settings, response.
"""

from __future__ import annotations

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map.flows import flows_of
from beltsim.event_map.integrals import Integrals
from beltsim.event_map.walk import (
    KIND,
    KINDS,
    MARGIN,
    MULTIPLE,
    STATE,
    TORQUE_AFTER,
    TORQUE_BEFORE,
    TOUCH_GAP,
    TOUCH_TIME,
    Walk,
)
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.problem import FrictionProblem
from beltsim.response import EventLog, NearGrazing, Window, grazing_warnings

#: An event is near grazing when its margin, or the relative height by which it overshoots its
#: threshold, half its relative rate squared, is below this; a touch, when its gap is.
NEAR_GRAZING = 1e-8


def event_log(problem: FrictionProblem, run: Walk) -> EventLog:
    """The walk's events with their margins and quality."""
    n, joint, law = problem.n, problem.joint, problem.friction
    assert joint is not None
    assert law is not None
    if not len(run.t):
        return EventLog.empty(n)
    state = run.reals[:, STATE:]
    kind = run.integers[:, KIND]
    margin = run.reals[:, MARGIN].copy()
    overshoot = np.ones(len(margin))
    peak = float(np.abs(run.reals[:, [TORQUE_BEFORE, TORQUE_AFTER]]).max())
    if isinstance(law, Coulomb) and peak > 0.0:
        flows = flows_of(problem)
        held, rest = flows.held.part, state[:, flows.rest]
        reaction, rate = held.signals(run.t, state[:, joint], rest)
        Q_s = law.Q_s or 0.0
        peak = max(peak, Q_s, float(np.abs(reaction).max()))
        rate = np.abs(rate) / (problem.forcing.Omega * peak)
        stops = kind < 2
        margin = np.where(stops, np.abs(np.abs(reaction) - Q_s) / peak, rate)
        speed = np.abs(reaction - run.reals[:, TORQUE_BEFORE]) / peak
        overshoot = 0.5 * np.where(stops, speed, rate) ** 2
    quality = np.where(np.minimum(margin, overshoot) < NEAR_GRAZING, "near_grazing", "simple")
    quality[run.integers[:, MULTIPLE] != 0] = "multiple"
    return EventLog(
        t=run.t,
        kind=np.array(KINDS)[kind],
        q=state[:, :n],
        q_dot=state[:, n:],
        position=state[:, joint],
        torque_before=run.reals[:, TORQUE_BEFORE],
        torque_after=run.reals[:, TORQUE_AFTER],
        quality=quality,
        margin=margin,
    )


def near_grazing(problem: FrictionProblem, run: Walk, mean_square: float) -> NearGrazing:
    """Extrema that came close to an event without being one.

    `mean_square` is of the joint's velocity, whose largest value is taken as that of a harmonic
    motion.
    """
    peak_velocity = np.sqrt(2.0 * max(mean_square, 0.0))
    law = problem.friction
    assert law is not None
    modes = run.modes()[:-1]
    peak_torque = float(np.abs(run.reals[:, TORQUE_AFTER]).max(initial=0.0))
    size = np.where(modes == 0, max(peak_torque, law.Q_m), peak_velocity)
    gap = run.reals[:, TOUCH_GAP]
    with np.errstate(divide="ignore", invalid="ignore"):
        margin = np.where(size > 0.0, gap / size, np.inf)
    close = margin < NEAR_GRAZING
    return NearGrazing(
        t=(run.starts()[:-1] + run.reals[:, TOUCH_TIME])[close],
        margin=margin[close],
        kind=np.where(modes[close] == 0, "reaction", "velocity"),
    )


def window_of(
    problem: FrictionProblem,
    found: Integrals,
    times: tuple[float, float],
    ends: tuple[FloatArray, FloatArray],
    symmetric: bool = False,
) -> Window:
    """The window between `times` with the states at its `ends`.

    `symmetric`: `found` is of the first half of a motion that repeats with the opposite sign.
    """
    often = 2.0 if symmetric else 1.0
    rubs = isinstance(problem.friction, SaturatedCoulomb)
    return Window(
        start=times[0],
        end=times[1],
        start_state=ends[0],
        end_state=ends[1],
        forcing_work=often * found.work,
        viscous_loss=often * found.loss,
        friction_loss=often * found.rubbed if rubs else None,
    )


def warnings_of(
    problem: FrictionProblem,
    samples: tuple[FloatArray, FloatArray],
    events: EventLog,
    touches: NearGrazing,
    span: tuple[float, float],
) -> tuple[str, ...]:
    """What a user should know of the last period `span`: limits crossed, events near grazing.

    `samples`: times (nt,) and coordinates (nt, n); without any, limits are not looked at.
    """
    t, q = samples
    inside = t >= span[0]
    crossed = problem.limit_warnings(t[inside], q[inside])
    return (*problem.warnings, *crossed, *grazing_warnings(events, touches, span))
