"""One walk through slip and stick with the C map: raw events and where it ended.

Depends on: flows, binding, status.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import CoreError
from beltsim.event_map import binding
from beltsim.event_map.flows import Flows, flows_of, inner_flow
from beltsim.event_map.status import STATUS
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.problem import FrictionProblem

MODES = {0: "stick", 1: "slip+", -1: "slip-"}
KINDS = ("stick", "reverse", "slip+", "slip-")
#: Leading columns of an event's reals and integers, as in beltsim_map.h.
TIME, TORQUE_BEFORE, TORQUE_AFTER, MARGIN, TOUCH_TIME, TOUCH_GAP, STATE = range(7)
PERIODS, KIND, MULTIPLE = range(3)
_CHUNK = 32
#: Status for too many events, and where a run's reals hold the width of the band.
_CHATTER, _SIGMA = -2, 6
#: Most forcing periods per call of the C map: an interruption waits for its end.
_STRETCH = 200_000


@dataclass(frozen=True, eq=False)
class Walk:
    """Events of a walk (raw columns) and its two ends."""

    initial_state: FloatArray
    final_state: FloatArray
    initial_mode: int
    final_mode: int
    end: float
    t: FloatArray
    integers: NDArray[np.int64]
    reals: FloatArray

    def modes(self) -> NDArray[np.int64]:
        """Mode of each phase: one more than there are events."""
        return self._modes

    @cached_property
    def _modes(self) -> NDArray[np.int64]:
        mode = self.initial_mode
        modes = [mode]
        for kind in self.integers[:, KIND].tolist():
            mode = (0, -mode, 1, -1)[kind]
            modes.append(mode)
        return np.array(modes)

    def states(self) -> FloatArray:
        """State at the start of each phase, (phases, 2n)."""
        return np.vstack([self.initial_state, self.reals[:, STATE:]])

    def starts(self) -> FloatArray:
        """Time at the start of each phase."""
        return np.concatenate([[0.0], self.t])


def run_arguments(
    problem: FrictionProblem, state: FloatArray
) -> tuple[tuple[int, ...], tuple[Any, ...]]:
    """What every call of the C map begins with: sizes, and buffers with a copy of `state` last."""
    flows, law, inner = flows_of(problem), problem.friction, inner_flow(problem)
    assert law is not None
    Q_s = law.Q_s if isinstance(law, Coulomb) else law.Q_m
    sigma = law.sigma if isinstance(law, SaturatedCoulomb) else 0.0
    limit = _event_limit(flows, problem.forcing.n_harmonics)
    reals = np.array([problem.forcing.Omega, law.Q_m, Q_s, limit, 0.0, Q_s, sigma])
    integers = np.array([problem.joint, 0, 0, 0, 0, 0], dtype=np.int64)
    sizes = (problem.n, len(problem.forcing.cos) - 1, flows.free.m, inner.m, int(sigma > 0.0))
    arrays = (flows.free.packed, inner.packed, reals, integers, np.array(state, dtype=float))
    return sizes, arrays


def walk(
    problem: FrictionProblem, state: FloatArray, periods: float, max_events: int = 10_000_000
) -> Walk:
    """Follow `problem` from `state` (2n,) over `periods` forcing periods."""
    sizes, arrays = run_arguments(problem, state)
    reals, integers, now = arrays[2:]
    initial, period = now.copy(), problem.period
    whole, width = int(np.floor(periods)), STATE + 2 * problem.n
    chunks: list[tuple[NDArray[np.int64], FloatArray]] = []
    total = 0
    while True:
        stage = min(whole, int(integers[1]) + _STRETCH)
        rest = (periods - whole) * period if stage == whole else 0.0
        capacity = min(_CHUNK << min(2 * len(chunks), 9), max_events + 1)
        found_i = np.empty((capacity, 3), dtype=np.int64)
        found_r = np.empty((capacity, width))
        events = (found_i, found_r, capacity, 0)
        status, count = binding.propagate(*sizes, *arrays, *events, stage, rest)
        chunks.append((found_i[:count], found_r[:count]))
        total += count
        if status < 0:
            raise_status(status, arrays, period, found_i[:count], found_r[:count])
        if status == 0 and stage == whole:
            break
        if total > max_events:
            text = f"{total} events, more than max_events = {max_events}; raise it or run less"
            raise CoreError(text, "BM_FULL", float(integers[1] * period + reals[4]))
    all_i, all_r = chunks[0]
    if len(chunks) > 1:
        all_i = np.concatenate([chunk[0] for chunk in chunks])
        all_r = np.concatenate([chunk[1] for chunk in chunks])
    t = all_i[:, PERIODS] * period + all_r[:, TIME]
    first, last = int(integers[5]), int(integers[2])
    return Walk(initial, now, first, last, periods * period, t, all_i, all_r)


def _event_limit(flows: Flows, harmonics: int) -> float:
    """More events per period than these exponents, or the highest harmonic, can make."""
    return 20.0 + 8.0 * max(flows.free.fastest / flows.free.Omega, float(harmonics))


def raise_status(
    status: int,
    arrays: tuple[Any, ...],
    period: float,
    integers: NDArray[np.int64] | None = None,
    reals: FloatArray | None = None,
) -> None:
    """Raise the error of a failed walk, with the time it reached and the last event, if known."""
    name, text = STATUS[status]
    run, whole = arrays[2], arrays[3]
    time = float(whole[1] * period + run[4])
    last = None
    if integers is not None and reals is not None and len(integers):
        last = (float(integers[-1, PERIODS] * period + reals[-1, TIME]), KINDS[integers[-1, KIND]])
    if status == _CHATTER and run[_SIGMA] > 0.0:
        text = (
            f"the band sigma = {run[_SIGMA]:.3g} is too narrow for the rounding of this system's "
            "velocities; use a wider one, or Coulomb(Q_m), its exact limit"
        )
    message = f"exact map stopped at t = {time:.6g}: {text}"
    raise CoreError(message, name, time, MODES[int(whole[2])], last)
