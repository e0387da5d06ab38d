"""How far a response lies from the exact run, and what may be asked of it.

An event is *well conditioned* when the watched quantity (velocity of the joint, or reaction)
crosses its threshold at `WELL_CONDITIONED` times Omega times its largest value, or faster: an error
e of the state, relative to its size, then moves it by at most about e/(2 pi 0.2) of a period.
With Q_s > Q_m the torque jumps at a release, so a release that is badly placed displaces
everything after it; there the events count as well conditioned up to the first slower one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from support.exact import ExactRun

from beltsim.friction import Coulomb
from beltsim.response import Response

WELL_CONDITIONED = 0.2
#: Two events of one kind are the same event when they lie closer than this, in periods.
SAME_EVENT = 1e-3


class Agreement(NamedTuple):
    """`common`: leading events alike in kind and time. Errors are relative, times in periods."""

    common: int
    same_sequence: bool
    first_difference: float | None
    state_error: float
    time_errors: np.ndarray
    well_conditioned: np.ndarray


def agreement(response: Response, run: ExactRun) -> Agreement:
    """Compare events, the states at them, the samples, and the end state."""
    problem = response.problem
    period = problem.period
    limit = min(len(response.events), len(run.kind))
    common = 0
    while (
        common < limit
        and response.events.kind[common] == run.kind[common]
        and abs(response.events.t[common] - run.t[common]) < SAME_EVENT * period
    ):
        common += 1
    same = common == len(run.kind) == len(response.events)
    differing = [float(t[common]) for t in (response.events.t, run.t) if common < len(t)]
    well = run.rate >= WELL_CONDITIONED
    if isinstance(problem.friction, Coulomb) and problem.friction.Q_s > problem.friction.Q_m:
        well = np.logical_and.accumulate(well)
    return Agreement(
        common=common,
        same_sequence=same,
        first_difference=min(differing, default=None),
        state_error=_state_error(response, run, common),
        time_errors=np.abs(response.events.t[:common] - run.t[:common]) / period,
        well_conditioned=well[:common],
    )


def _state_error(response: Response, run: ExactRun, common: int) -> float:
    """Largest error of coordinates and of velocities, each over its largest value in the run."""
    n = response.problem.n
    events, end = response.events, response.final_state
    found = [np.hstack([response.q, response.q_dot]), end[None]]
    true = [run.states(response.t).reshape(-1, 2 * n), run.final_state[None]]
    if events.q.shape[1]:
        # at the exact time, so that an error of time does not count twice
        found.append(np.hstack([events.q, events.q_dot])[:common])
        true.append(run.states(events.t[:common]).reshape(-1, 2 * n))
    gap = np.abs(np.vstack(found) - np.vstack(true))
    size = np.abs(np.vstack(true))
    worst = 0.0
    for part in (slice(0, n), slice(n, 2 * n)):
        scale = size[:, part].max(initial=0.0)
        worst = max(worst, gap[:, part].max(initial=0.0) / (scale or 1.0))
    return worst


def marked(response: Response, t: float) -> bool:
    """Whether the response says near `t` that it grazes there."""
    near = SAME_EVENT * 10.0 * response.problem.period
    touches = np.abs(response.near_grazing.t - t) < near
    doubtful = (np.abs(response.events.t - t) < near) & (response.events.quality != "simple")
    return bool(touches.any() or doubtful.any())
