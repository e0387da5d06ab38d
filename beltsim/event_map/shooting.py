r"""The search for a periodic orbit, which the C map does.

The unknown is the state at t = 0. With :math:`\Phi` the exact map over one period and `S` its
derivative (saltation at events, rank loss in stick), Newton's step is

.. math:: x \leftarrow x + (I - S)^{-1}(\Phi(x) - x),

and where it does not help, the motion is followed for a while.

Depends on: changes, flows, walk, binding, problem.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map import binding
from beltsim.event_map.changes import changes_of
from beltsim.event_map.linear_part import ComplexArray
from beltsim.event_map.walk import (
    PERIODS,
    STATE,
    TIME,
    Walk,
    raise_status,
    run_arguments,
    walk,
)
from beltsim.problem import FrictionProblem

#: Residual to which a motion is followed where that decides which orbit is found.
_SETTLED = 1e-6
#: Residuals kept of a search; the last one is always that of its end.
_HISTORY = 100
#: Events of the orbit's walk for which room is made beforehand.
_EVENTS = 32


@dataclass(frozen=True, eq=False)
class Shooting:
    """Where a search ended: a state (2n,) at t = 0 and what it becomes.

    `half`: the search was over half of the orbit's `multiple` forcing periods, and `image` has the
    opposite sign. `run` is that walk. `derivative` (2n, 2n) is that of the image, in amplitudes of
    the free flow, and its eigenvalues give the `multipliers` (2n,) of the orbit. `residual` is the
    largest change of the state over its largest entry, velocities over Omega.
    """

    multiple: int
    half: bool
    state: FloatArray
    image: FloatArray
    residual: float
    followed: float
    history: tuple[float, ...]
    derivative: FloatArray
    multipliers: ComplexArray
    run: Walk


def shoot(
    problem: FrictionProblem,
    state: FloatArray,
    multiple: int,
    half: bool,
    tolerance: float,
    near: bool,
    settle: bool = False,
) -> Shooting:
    """Look for an orbit of `multiple` forcing periods from `state` (2n,).

    `near`: the state is expected to be close, so Newton's method starts there. `settle`: the orbit
    wanted is the one that the motion from `state` approaches.

    Raises
    ------
    CoreError
        When the motion itself cannot be followed.
    """
    N = 2 * problem.n
    sizes, arrays = run_arguments(problem, state)
    periods, sign = (0.5 * multiple, -1.0) if half else (1.0 * multiple, 1.0)
    search = np.array([periods, sign, tolerance, float(near), 0.0, _SETTLED if settle else 0.0])
    history, image, derivative = np.empty(_HISTORY), np.empty(N), np.empty((N, N))
    multipliers = np.empty(N, dtype=complex)
    found = (search, history, image, derivative, multipliers.view(float))
    integers, reals = np.empty((_EVENTS, 3), dtype=np.int64), np.empty((_EVENTS, STATE + N))
    status, steps, count, first, last = binding.orbit(
        *sizes, *arrays, changes_of(problem), *found, integers, reals, _HISTORY, _EVENTS
    )
    if status < 0:
        raise_status(status, arrays, problem.period)
    state = arrays[-1]
    if count > _EVENTS:
        run = walk(problem, state, periods)
    else:
        t = integers[:count, PERIODS] * problem.period + reals[:count, TIME]
        ends = (state, sign * image, first, last, periods * problem.period)
        run = Walk(*ends, t, integers[:count], reals[:count])
    residuals = tuple(history[: min(steps, _HISTORY)].tolist())
    reached = (float(search[3]), float(search[4]), residuals)
    multipliers = multipliers**2 if half else multipliers
    return Shooting(multiple, half, state, image, *reached, derivative, multipliers, run)


def half_wave(problem: FrictionProblem) -> bool:
    """Whether the forcing changes sign after half a period: odd harmonics only."""
    forcing = problem.forcing
    return not (np.any(forcing.cos[0::2]) or np.any(forcing.sin[0::2]))
