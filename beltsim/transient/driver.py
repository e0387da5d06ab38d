"""The only module that talks to the compiled core: buffers, slices, budgets.

Python owns every buffer. A run is cut into slices of about 0.1 s; between them signals come
through, progress is told and the time budget is checked. A full event buffer is drained, and the
run goes on.

Depends on: errors, checks, problem, friction, transient.settings, `beltsim._core`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import CoreError
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.problem import FrictionProblem
from beltsim.transient.settings import Settings, events_per_period

#: Wall time between two looks at signals, in seconds.
SLICE_SECONDS = 0.1
#: Wall time to the first stretch that is sampled in case the run is stopped, and between two of
#: them, in seconds: a stretch costs some 0.05 s.
FIRST_LOOK_SECONDS, LOOK_SECONDS = 0.3, 5.0
#: Events and touches that fit in the buffers shared with the core.
EVENT_CAPACITY, TOUCH_CAPACITY = 512, 64
#: Columns of an event row and of a touch row; csrc/core/include/beltsim_core.h names them.
EVENT_COLUMNS = ("t", "position", "before", "after", "reaction", "rate", "depth")
TOUCH_COLUMNS = ("t", "distance", "mode")

LAWS = {type(None): 0, Coulomb: 1, SaturatedCoulomb: 2}
METHOD_CODES = {"adams": 0, "bdf": 1, "taylor": 2}
MODE_NAMES = {0: "stick", 1: "slip+", -1: "slip-", 2: None}
KIND_NAMES = ("stick", "reverse", "slip+", "slip-")


class GrowingTable:
    """Rows appended in blocks to one array that grows in place."""

    def __init__(self, width: int, dtype: Any) -> None:
        self._rows = np.empty((0, width), dtype)
        self._used = 0

    def append(self, block: NDArray[Any]) -> None:
        """Copy the rows of `block` behind those already there."""
        needed = self._used + len(block)
        if needed > len(self._rows):
            length = max(needed, len(self._rows) + len(self._rows) // 4)
            self._rows.resize((length, self._rows.shape[1]), refcheck=False)
        self._rows[self._used : needed] = block
        self._used = needed

    @property
    def rows(self) -> NDArray[Any]:
        """What has been appended, shape (rows, width)."""
        return self._rows[: self._used]


@dataclass
class Recording:
    """What a run has written so far.

    Rows of samples before `head` are taken on the way, in case that the run stops early; `first` is
    the first of them that counts.
    """

    sample_t: FloatArray
    sample_state: FloatArray
    sample_torque: FloatArray
    events: GrowingTable
    codes: GrowingTable
    states: GrowingTable | None
    touches: GrowingTable
    head: int = 0
    first: int = 0
    counts: NDArray[np.int64] = field(default_factory=lambda: np.zeros(3, np.int64))

    def sampled(self, finished: bool) -> slice:
        """Rows of the samples asked for; of a run that stopped before them, the latest others."""
        begun = finished or self.counts[0] > self.head
        return slice(self.head if begun else self.first, int(self.counts[0]))

    def look_ahead(self, now: float) -> bool:
        """Ask for samples of the stretch to come, once those of the stretch before are there.

        Where the run is slow, so that one follows the other, half of the earlier ones are kept.
        """
        head, t = self.head, self.sample_t
        if not head or self.counts[0] != head:
            return False
        step = t[head + 1] - t[head]
        kept, last = 0, now
        if self.first < head and now < t[head - 1] + step:
            kept, last = (head - self.first) // 2, t[head - 1]
        ahead = last + step * np.arange(1, head - kept + 1)
        ahead = ahead[ahead < t[head]]
        if not len(ahead):
            return False
        first, to = head - len(ahead) - kept, head - len(ahead)
        for rows in (t, self.sample_state, self.sample_torque):
            rows[first:to] = rows[head - kept : head].copy()
        t[to:head] = ahead
        self.first, self.counts[0] = first, to
        return True


def load_core() -> Any:
    """The extension module, or one clear error when it was not built."""
    try:
        from beltsim import _core
    except ImportError as error:
        message = (
            f"the compiled core beltsim._core cannot be loaded ({error}); build it with "
            "'pip install .' where SUNDIALS is installed (Debian: apt-get install libsundials-dev)"
        )
        raise CoreError(message, status="BS_NOT_BUILT") from error
    return _core


class Driver:
    """One run of the core, from creation to its last slice.

    Parameters
    ----------
    problem, settings
        What to integrate, and how.
    y0 : (2n,) initial state.
    t_end : float
        Absolute end of the run.
    window_start : float
        Absolute time from which the energy integrals are taken.
    sample_t : (nt,) absolute times of the samples.
    """

    def __init__(
        self,
        problem: FrictionProblem,
        settings: Settings,
        y0: FloatArray,
        t_end: float,
        window_start: float,
        sample_t: FloatArray,
    ) -> None:
        self.core_module = load_core()
        self.problem = problem
        self.settings = settings
        self.t_end = t_end
        self.core = _create(self.core_module, problem, settings, y0, t_end, window_start)
        width = 2 * problem.n
        states = settings.event_states
        late = settings.keep == "last_period" and len(sample_t) > 1 and sample_t[0] > 0.0
        head = len(sample_t) if late else 0
        self.recording = Recording(
            np.concatenate([np.zeros(head), sample_t]),
            np.empty((head + len(sample_t), width)),
            np.empty(head + len(sample_t)),
            GrowingTable(len(EVENT_COLUMNS), np.float64),
            GrowingTable(2, np.int8),
            GrowingTable(width, np.float64) if states else None,
            GrowingTable(len(TOUCH_COLUMNS), np.float64),
            head,
            head,
            np.array([head, 0, 0]),
        )
        self._look_at = time.monotonic() + FIRST_LOOK_SECONDS
        self._event_values = np.empty((EVENT_CAPACITY, len(EVENT_COLUMNS)))
        self._event_codes = np.empty((EVENT_CAPACITY, 2), np.int32)
        self._event_states = np.empty((EVENT_CAPACITY, width)) if states else None
        self._touch_values = np.empty((TOUCH_CAPACITY, len(TOUCH_COLUMNS)))

    def drain(self) -> None:
        """Move events and touches out of the shared buffers."""
        rec = self.recording
        n_events, n_touches = int(rec.counts[1]), int(rec.counts[2])
        if n_events:
            rec.events.append(self._event_values[:n_events])
            rec.codes.append(self._event_codes[:n_events])
            if rec.states is not None and self._event_states is not None:
                rec.states.append(self._event_states[:n_events])
        if n_touches:
            rec.touches.append(self._touch_values[:n_touches])
        rec.counts[1:] = 0

    def advance(self) -> int:
        """One slice; the status code of the core."""
        rec = self.recording
        if time.monotonic() >= self._look_at and rec.look_ahead(self.core.summary()["t"]):
            self._look_at = time.monotonic() + LOOK_SECONDS
        status: int = self.core.run(
            self.t_end,
            SLICE_SECONDS,
            rec.counts,
            rec.sample_t,
            rec.sample_state,
            rec.sample_torque,
            self._event_values,
            self._event_codes,
            self._event_states,
            self._touch_values,
        )
        self.drain()
        return status

    def run(self, progress: Callable[[float], None] | None) -> None:
        """To the end; raises `CoreError` (without a partial response) when it cannot."""
        deadline = time.monotonic() + self.settings.max_seconds
        try:
            while (status := self.advance()) > 0:
                if progress is not None:
                    progress(min(1.0, self.core.summary()["t"] / self.t_end))
                if time.monotonic() > deadline:
                    status = -22  # BS_OUT_OF_TIME
                    break
        finally:
            self.drain()  # a signal may come between the core's return and the drain
        if status < 0:
            raise self.error(status)
        if progress is not None:
            progress(1.0)

    def error(self, status: int) -> CoreError:
        """The exception for a negative status: what, where, and what to try."""
        name: str = self.core_module.status_name(status)
        seen = self.core.summary()
        mode = MODE_NAMES[seen["mode"]]
        last, text = None, "no event so far"
        if seen["events"]:
            last = (seen["last_event_t"], KIND_NAMES[seen["last_event_kind"]])
            text = f"last event {last[1]} at t = {last[0]:.9g}"
        solver = f" [SUNDIALS {seen['solver_code']}: {seen['solver_text']}]"
        where = f"t = {seen['t']:.9g} ({seen['t'] / self.problem.period:.6g} periods)"
        message = (
            f"{name} at {where}, mode {mode or 'linear'}, {text}, {seen['steps']} steps: "
            f"{self.core_module.status_text(status)}{solver if seen['solver_code'] else ''}"
        )
        return CoreError(message, name, seen["t"], mode, last, seen["solver_text"])

    def state(self) -> FloatArray:
        """State (2n,) at the time reached."""
        y = np.empty(2 * self.problem.n)
        self.core.state(y)
        return y

    def window_state(self) -> FloatArray:
        """State (2n,) at the start of the window; NaN before the run has passed it."""
        y = np.empty(2 * self.problem.n)
        self.core.window_state(y)
        return y


def _create(
    core_module: Any,
    problem: FrictionProblem,
    settings: Settings,
    y0: FloatArray,
    t_end: float,
    window_start: float,
) -> Any:
    law = problem.friction
    Q_m = Q_s = 0.0
    sigma = 1.0
    if isinstance(law, Coulomb):
        Q_m, Q_s = law.Q_m, float(law.Q_s or 0.0)
    elif isinstance(law, SaturatedCoulomb):
        Q_m, sigma = law.Q_m, law.sigma
    share = settings.step_share(problem)
    try:
        return core_module.Core(
            problem.n,
            -1 if problem.joint is None else problem.joint,
            LAWS[type(law)],
            METHOD_CODES[settings.method_for(problem)],
            problem.forcing.Omega,
            Q_m,
            Q_s,
            sigma,
            share * settings.rtol,
            settings.max_steps,
            settings.max_events,
            events_per_period(problem) if law is not None else math.inf,
            10.0 * settings.grazing,  # the peak may still grow: filtered afterwards
            window_start,
            problem.M,
            problem.C,
            problem.G,
            problem.K,
            problem.forcing.cos,
            problem.forcing.sin,
            share * settings.atol_for(problem, y0, t_end),
            y0,
        )
    except RuntimeError as error:
        status = str(error).split(":", 1)[0]
        raise CoreError(f"the run could not be started: {error}", status, time=0.0) from error
