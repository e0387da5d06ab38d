r"""What every solver returns: samples, located events, and the figures derived from them.

The figures of the last period (stick fraction, dissipated energy, velocity reversals, stops) are
derived here, from the event log, for every solver alike. The solvers' independence lies in the
transition rule that made the log, which each writes for itself.

Modes are ``"slip+"``, ``"slip-"`` and ``"stick"``; they name the direction of the joint's velocity.

Depends on: checks; `problem` for its type only.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray, read_only

if TYPE_CHECKING:
    from beltsim.problem import FrictionProblem

#: Kinds of events, in the order of their codes on disk.
EVENT_KINDS = ("stick", "reverse", "slip+", "slip-")
#: Quality of an event's location, in the order of its codes on disk.
EVENT_QUALITIES = ("simple", "near_grazing", "multiple")
#: Modes of the joint and the sign of its velocity in each.
MODE_SIGNS = {"stick": 0, "slip+": 1, "slip-": -1}
#: A transient whose last period repeats within this calls itself periodic.
PERIODIC_TOLERANCE = 1e-6


def _read_only_names(names: Any) -> NDArray[np.str_]:
    array = np.array(names, dtype=np.str_)
    array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False)
class EventLog:
    """Located events of the joint, in order.

    Parameters
    ----------
    t : (ne,) times, in the problem's unit.
    kind : (ne,) of str
        ``stick`` (the velocity reaches zero and stays), ``reverse`` (reaches zero and goes on with
        the other sign), ``slip+`` and ``slip-`` (leaves stick).
    q, q_dot : (ne, n) or (ne, 0)
        State at the event; no columns when the run kept no states. The velocity of the joint is
        exactly zero at every event of a Coulomb joint.
    position : (ne,)
        Joint coordinate at the event (kept even without states).
    torque_before, torque_after : (ne,)
        Friction torque just before and just after.
    quality : (ne,) of str
        ``simple``, ``near_grazing`` (found, but a slightly different system would not have it) or
        ``multiple``.
    margin : (ne,)
        Relative distance to the other outcome, 0 at the border. ``stick``, ``reverse``: how far
        the holding reaction is from Q_s, over max(Q_s, peak reaction). ``slip+``, ``slip-``: rate
        of the reaction through Q_s, over Omega max(Q_s, peak reaction). Saturated law: rate of the
        velocity through the edge of the band, over Omega times its peak (event map: 1). Harmonic
        balance knows margins as well as instants: to O(1/R) unless a pattern locates them.
    """

    t: FloatArray
    kind: NDArray[np.str_]
    q: FloatArray
    q_dot: FloatArray
    position: FloatArray
    torque_before: FloatArray
    torque_after: FloatArray
    quality: NDArray[np.str_]
    margin: FloatArray

    def __post_init__(self) -> None:
        for name in ("t", "q", "q_dot", "position", "torque_before", "torque_after", "margin"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        for name in ("kind", "quality"):
            object.__setattr__(self, name, _read_only_names(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        counts = [f"{np.count_nonzero(self.kind == kind)} {kind}" for kind in EVENT_KINDS]
        span = f", t = {self.t[0]:.6g} to {self.t[-1]:.6g}" if len(self) else ""
        return f"<EventLog: {len(self)} events ({', '.join(counts)}){span}>"

    @classmethod
    def empty(cls, n: int = 0) -> EventLog:
        """A log without events, for a state of `n` coordinates."""
        none, states = np.zeros(0), np.zeros((0, n))
        names = np.zeros(0, dtype="U1")
        return cls(none, names, states, states, none, none, none, names, none)

    def modes_after(self, initial_mode: str) -> list[str]:
        """Mode of the joint after each event, for a run that starts in `initial_mode`."""
        modes: list[str] = []
        mode = initial_mode
        for kind in self.kind.tolist():
            other = "slip-" if mode == "slip+" else "slip+"
            mode = other if kind == "reverse" else kind
            modes.append(mode)
        return modes


@dataclass(frozen=True, eq=False)
class NearGrazing:
    """Touches of a threshold that were no events, or that tolerance cannot decide.

    Parameters
    ----------
    t : (ng,) times.
    margin : (ng,)
        How close it came, over the largest value of the same quantity in the run.
    kind : (ng,) of str
        ``"velocity"`` (an extremum close to zero while slipping) or ``"reaction"`` (an extremum
        close to the static limit while sticking).
    """

    t: FloatArray
    margin: FloatArray
    kind: NDArray[np.str_]

    def __post_init__(self) -> None:
        for name in ("t", "margin"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        object.__setattr__(self, "kind", _read_only_names(self.kind))

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        least = f", smallest margin {self.margin.min():.2g}" if len(self) else ""
        return f"<NearGrazing: {len(self)} touches{least}>"

    @classmethod
    def empty(cls) -> NearGrazing:
        """No touches."""
        return cls(np.zeros(0), np.zeros(0), np.zeros(0, dtype="U8"))


class Phase(NamedTuple):
    """A stretch of one mode: its times and the joint's positions at both ends."""

    mode: str
    start: float
    end: float
    start_position: float
    end_position: float


class Window(NamedTuple):
    """The stretch of time over which a run is judged: its last period, or all of a shorter run.

    Times are absolute, states are (2n,), `forcing_work` and `viscous_loss` are the integrals of
    f.q_dot and q_dot'C q_dot over it. `friction_loss` is given only for laws whose loss does not
    follow from event positions (the saturated law); None means: derive it.
    """

    start: float
    end: float
    start_state: FloatArray
    end_state: FloatArray
    forcing_work: float
    viscous_loss: float
    friction_loss: float | None = None


class Figures(NamedTuple):
    """Figures of one window, in the problem's units; see `Response` for their meaning."""

    stick_fraction: float
    dissipated_energy: float
    velocity_reversals: float
    stops_per_period: float
    energy_balance_residual: float
    period_residual: float | None


@dataclass(frozen=True, eq=False)
class Response:
    """Motion of a `FrictionProblem`, with its events and what follows from them.

    All values are in the problem's own units; `problem.scales` converts. Figures marked (window)
    belong to `window`, the last period of a run (all of a run shorter than one).

    Parameters
    ----------
    problem : FrictionProblem
        What was solved.
    t : (nt,) absolute times of the samples.
    q, q_dot : (nt, n) coordinates and velocities.
    friction_torque : (nt,)
        Torque of the joint: +-Q_m while slipping, the holding reaction while sticking.
    initial_state, final_state : (2n,) all q, then all q_dot.
    initial_mode : str or None
        Mode the joint starts in; None without a joint.
    events : EventLog
        Every event of the run, 0 < t <= end (a periodic orbit: 0 <= t < T).
    near_grazing : NearGrazing
    window : (start, end) of the figures.
    stick_fraction : float
        Share of the window spent sticking (window).
    dissipated_energy : float
        Kinetic torque times joint travel, exact from event positions (window).
    velocity_reversals : float
        nu = max(0, (sign changes of the joint's velocity between successive slip phases per period
        - 2) / 4) (window).
    stops_per_period : float
        ``stick`` events per period (window).
    energy_balance_residual : float
        |gain + losses - work| over the largest energy in the balance (window).
    period_residual : float or None
        Largest change of the state over the window's period, over the largest state; velocities
        are divided by Omega. None for a run shorter than one period.
    periodic : bool
        Whether `period_residual` is at most the solver's tolerance (transients: 1e-6).
    total_dissipated_energy : float or None
        Friction loss of the whole run; None for a periodic orbit.
    coefficients : (R + 1, n) complex or None
        q(t) = Re sum_k c_k exp(i k Omega t), row 0 the mean; None for transients.
    torque_coefficients : (R + 1,) complex or None
    multipliers : (2n,) complex or None
        Floquet multipliers where known.
    rest_interval : (low, high) or None
        Rest positions of a locked joint.
    warnings : tuple of str
    statistics : mapping of str to number or str
    """

    problem: FrictionProblem
    t: FloatArray
    q: FloatArray
    q_dot: FloatArray
    friction_torque: FloatArray
    initial_state: FloatArray
    final_state: FloatArray
    initial_mode: str | None
    events: EventLog
    near_grazing: NearGrazing
    window: tuple[float, float]
    stick_fraction: float
    dissipated_energy: float
    velocity_reversals: float
    stops_per_period: float
    energy_balance_residual: float
    period_residual: float | None
    periodic: bool
    total_dissipated_energy: float | None = None
    coefficients: NDArray[np.complex128] | None = None
    torque_coefficients: NDArray[np.complex128] | None = None
    multipliers: NDArray[np.complex128] | None = None
    rest_interval: tuple[float, float] | None = None
    warnings: tuple[str, ...] = ()
    statistics: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        arrays = ("t", "q", "q_dot", "friction_torque", "initial_state", "final_state")
        for name in arrays:
            object.__setattr__(self, name, read_only(getattr(self, name)))
        for name in ("coefficients", "torque_coefficients", "multipliers"):
            if getattr(self, name) is not None:
                series = np.array(getattr(self, name), dtype=np.complex128)
                series.flags.writeable = False
                object.__setattr__(self, name, series)

    def __repr__(self) -> str:
        problem = self.problem
        span = f"{self.t[0]:.6g} to {self.t[-1]:.6g}" if len(self.t) else "none"
        parts = [
            f"n = {problem.n}, {problem.friction or 'no friction'}",
            f"{len(self.t)} samples (t: {span}), {len(self.events)} events",
            f"sticks {self.stick_fraction:.2%}, loses {self.dissipated_energy:.6g} per window",
            f"{'periodic' if self.periodic else 'not periodic'}, {len(self.warnings)} warnings",
        ]
        return f"<{type(self).__name__}: {'; '.join(parts)}>"

    def observe(self, name: str) -> FloatArray:
        """Values (nt,) of the observable or coordinate `name` at the samples, in problem units.

        Raises
        ------
        KeyError
            When the problem has neither; the message lists both.
        """
        for seen in self.problem.observables:
            if seen.name == name:
                return seen.at(self.t, self.q, self.problem.forcing.Omega)
        labels = self.problem.labels or ()
        if name in labels:
            return self.q[:, labels.index(name)]
        known = ", ".join(seen.name for seen in self.problem.observables) or "none"
        raise KeyError(
            f"no observable or coordinate {name!r}; observables: {known}; "
            f"coordinates: {', '.join(labels)}"
        )

    def to_xarray(self) -> Any:
        """Labelled dataset with units, inputs and version (needs xarray)."""
        from beltsim.dataset import to_dataset  # loads xarray: only when asked for

        return to_dataset(self)


def phases(
    events: EventLog, initial_mode: str, start: float, end: float, positions: tuple[float, float]
) -> Iterator[Phase]:
    """Phases of the joint between `start` and `end`, cut at both; `positions` are those there.

    An event exactly at `start` belongs to the phases after it, one at `end` ends the last.
    """
    modes = [initial_mode, *events.modes_after(initial_mode)]
    modes, times, places = _cut(events, modes, start, end, positions)
    for i, mode in enumerate(modes):
        yield Phase(mode, times[i], times[i + 1], places[i], places[i + 1])


def _cut(
    events: EventLog, modes: list[str], start: float, end: float, positions: tuple[float, float]
) -> tuple[list[str], list[float], list[float]]:
    """Those of all `modes` between two times, and times and places of their edges, one more."""
    first = int(np.searchsorted(events.t, start, side="right"))
    last = int(np.searchsorted(events.t, end, side="left"))
    times = [start, *events.t[first:last].tolist(), end]
    places = [positions[0], *events.position[first:last].tolist(), positions[1]]
    return modes[first : last + 1], times, places


def sign_changes(
    events: EventLog, initial_mode: str, start: float, end: float, *, cyclic: bool = False
) -> int:
    """Slip phases that begin in (start, end] against the direction of the slip phase before.

    `cyclic`: the log is one period of a closed orbit, so what comes before its start is its end.
    """
    modes = [initial_mode, *events.modes_after(initial_mode)]
    return _sign_changes(events, modes, start, end, cyclic)


def _sign_changes(
    events: EventLog, modes: list[str], start: float, end: float, cyclic: bool
) -> int:
    count, direction = 0, MODE_SIGNS[modes[0]]
    if cyclic and not direction:
        direction = next((MODE_SIGNS[mode] for mode in reversed(modes) if MODE_SIGNS[mode]), 0)
    for t, mode in zip(events.t.tolist(), modes[1:], strict=True):
        sign = MODE_SIGNS[mode]
        if sign and direction and sign != direction and start < t <= end:
            count += 1
        direction = sign or direction
    return count


def friction_travel(
    events: EventLog, initial_mode: str, start: float, end: float, positions: tuple[float, float]
) -> float:
    """Distance the joint slipped between `start` and `end`, from event positions."""
    modes = [initial_mode, *events.modes_after(initial_mode)]
    modes, _, places = _cut(events, modes, start, end, positions)
    return _travel(modes, places)


def _travel(modes: list[str], places: list[float]) -> float:
    ways = zip(modes, places[:-1], places[1:], strict=True)
    return sum(abs(after - before) for mode, before, after in ways if mode != "stick")


def grazing_warnings(
    events: EventLog, grazing: NearGrazing, span: tuple[float, float]
) -> list[str]:
    """A sentence on the events and touches of a stretch of time that are near grazing, if any."""
    close = (events.quality != "simple") & (events.t > span[0]) & (events.t <= span[1])
    touches = (grazing.t > span[0]) & (grazing.t <= span[1])
    n_events, n_touches = int(np.count_nonzero(close)), int(np.count_nonzero(touches))
    if not n_events and not n_touches:
        return []
    least = min([*events.margin[close], *grazing.margin[touches]])
    return [
        f"near grazing in the last period: {n_events} events and {n_touches} touches that another "
        f"tolerance, or a slightly different system, would not have (smallest margin {least:.3g})"
    ]


def figures(
    problem: FrictionProblem,
    events: EventLog,
    initial_mode: str | None,
    window: Window,
    *,
    cyclic: bool = False,
) -> Figures:
    """The figures of `window`, derived from the event log by the same rule for every solver.

    `cyclic`: the window is a closed orbit, with its boundary event, if any, listed at its end.
    """
    n, joint = problem.n, problem.joint
    period = problem.period
    length = window.end - window.start
    stick = loss = reversals = stops = 0.0
    if joint is not None and initial_mode is not None and problem.friction is not None:
        ends = (float(window.start_state[joint]), float(window.end_state[joint]))
        every = [initial_mode, *events.modes_after(initial_mode)]
        modes, times, places = _cut(events, every, window.start, window.end, ends)
        if length > 0.0:
            spans = zip(modes, times[:-1], times[1:], strict=True)
            stick = sum(after - before for mode, before, after in spans if mode == "stick") / length
        if window.friction_loss is not None:
            loss = window.friction_loss
        else:
            loss = problem.friction.Q_m * _travel(modes, places)
        whole = abs(length - period) <= 1e-9 * period  # both ends carry the rounding of t
        per_period = 1.0 if whole else period / length if length > 0.0 else 0.0
        changes = _sign_changes(events, every, window.start, window.end, cyclic) * per_period
        reversals = max(0.0, (changes - 2.0) / 4.0)
        inside = (events.t > window.start) & (events.t <= window.end)
        stops = float(np.count_nonzero(events.kind[inside] == "stick")) * per_period
    before = _energy(problem, window.start_state)
    after = _energy(problem, window.end_state)
    size = max(abs(window.forcing_work), loss + window.viscous_loss, abs(before), abs(after))
    gap = abs(after - before + loss + window.viscous_loss - window.forcing_work)
    return Figures(
        stick_fraction=stick,
        dissipated_energy=loss,
        velocity_reversals=reversals,
        stops_per_period=stops,
        energy_balance_residual=gap / size if size > 0.0 else 0.0,
        period_residual=_period_residual(window, n, problem.forcing.Omega, period),
    )


def _energy(problem: FrictionProblem, state: FloatArray) -> float:
    """Kinetic plus potential energy of the linear system at `state` (2n,)."""
    q, q_dot = state[: problem.n], state[problem.n :]
    with np.errstate(over="ignore", invalid="ignore"):  # of a motion that ran away: inf or nan
        return 0.5 * float(q_dot @ problem.M @ q_dot + q @ problem.K @ q)


def _period_residual(window: Window, n: int, Omega: float, period: float) -> float | None:
    """Largest change of the state over one period, relative; velocities are divided by Omega."""
    if window.end - window.start < period * (1.0 - 1e-12):
        return None
    weight = np.concatenate([np.ones(n), np.full(n, 1.0 / Omega)])
    size = float(np.abs(window.end_state * weight).max(initial=0.0))
    change = float(np.abs((window.end_state - window.start_state) * weight).max(initial=0.0))
    return change / size if size > 0.0 else change
