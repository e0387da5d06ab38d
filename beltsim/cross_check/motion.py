r"""A steady motion as smooth pieces, cut at its events, and what is read off it.

Depends on: checks, errors, problem, response.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from beltsim.checks import FloatArray
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.problem import FrictionProblem, Observable
from beltsim.response import MODE_SIGNS, Response


@dataclass(frozen=True, eq=False)
class Piece:
    """A stretch without an event inside: times (nt,), states (nt, n) and friction torque (nt,)."""

    t: FloatArray
    q: FloatArray
    q_dot: FloatArray
    torque: FloatArray

    def integral(self, values: FloatArray, slopes: FloatArray | None = None) -> FloatArray:
        """Integral of `values` (nt, ...) from the start of the piece to each of its times.

        A cubic between samples; through `slopes` where they are known.
        """
        from scipy.interpolate import CubicHermiteSpline, CubicSpline

        if slopes is None:
            curve: Any = CubicSpline(self.t, values, axis=0)
        else:
            curve = CubicHermiteSpline(self.t, values, slopes, axis=0)
        whole = curve.antiderivative()(self.t)
        return np.asarray(whole - whole[0])


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion over `periods` forcing periods that is meant to repeat.

    Parameters
    ----------
    problem : FrictionProblem
    periods : int
    pieces : tuple of Piece
        In order; together they last for all the periods.
    angles : (ne,) float
        Events in forcing periods after the start, 0 <= angle < periods.
    kinds : tuple of str
    initial_mode : str
        Mode before the first of these events.
    energy : float, optional
        Dissipated energy per period, for a motion whose torque is shown averaged over a ripple:
        too smooth to be integrated.
    """

    problem: FrictionProblem
    periods: int
    pieces: tuple[Piece, ...]
    angles: FloatArray
    kinds: tuple[str, ...]
    initial_mode: str
    energy: float | None = None

    @cached_property
    def means(self) -> FloatArray:
        """Mean of each coordinate, (n,)."""
        total = sum(piece.integral(piece.q, piece.q_dot)[-1] for piece in self.pieces)
        return np.asarray(total) / self._length

    @cached_property
    def rms(self) -> FloatArray:
        """Root mean square of each coordinate about its mean, (n,)."""
        total = 0.0
        for piece in self.pieces:
            swing = piece.q - self.means
            total += piece.integral(swing**2, 2.0 * swing * piece.q_dot)[-1]
        return np.asarray(np.sqrt(np.maximum(total, 0.0) / self._length))

    def extremes(self, name: str) -> tuple[float, float]:
        """Lowest and highest sample of the observable `name`, in problem units."""
        values = self.observed(next(s for s in self.problem.observables if s.name == name))
        return float(values.min()), float(values.max())

    def observed(self, seen: Observable) -> FloatArray:
        """Samples of an observable, in problem units; a state at an event occurs twice."""
        Omega = self.problem.forcing.Omega
        return np.concatenate([seen.at(piece.t, piece.q, Omega) for piece in self.pieces])

    @cached_property
    def dissipated_energy(self) -> float:
        """Work of the friction torque per forcing period, by quadrature unless it was given."""
        if self.energy is not None:
            return self.energy
        joint = self.problem.joint
        powers = (piece.integral(piece.torque * piece.q_dot[:, joint]) for piece in self.pieces)
        return float(sum(power[-1] for power in powers)) / self.periods

    @cached_property
    def modes(self) -> tuple[str, ...]:
        """Mode after each event."""
        found, mode = [], self.initial_mode
        for kind in self.kinds:
            mode = ("slip-" if mode == "slip+" else "slip+") if kind == "reverse" else kind
            found.append(mode)
        return tuple(found)

    @cached_property
    def stick_fraction(self) -> float:
        """Share of the time spent sticking."""
        if not self.kinds:
            return float(self.initial_mode == "stick")
        lengths = np.diff(self.angles, append=self.angles[0] + self.periods)
        stuck = sum(
            length for length, mode in zip(lengths, self.modes, strict=True) if mode == "stick"
        )
        return float(stuck) / self.periods

    @cached_property
    def velocity_reversals(self) -> float:
        """nu: changes of direction from one slip phase to the next per period, less two, over 4."""
        signs = [MODE_SIGNS[mode] for mode in self.modes if MODE_SIGNS[mode]]
        changes = sum(a != b for a, b in zip(signs, [*signs[1:], *signs[:1]], strict=True))
        return max(0.0, (changes / self.periods - 2.0) / 4.0)

    @property
    def _length(self) -> float:
        return self.periods * self.problem.period


def motion_of(response: Response, periods: int = 1, *, exact_events: bool = True) -> Motion:
    """The last `periods` forcing periods of a response.

    Parameters
    ----------
    response : Response
        Sampled over at least so long, with the states at its events.
    periods : int
    exact_events : bool
        Whether the motion has its kinks at the events of the log. The motion of a truncated series
        has none, and its log is an estimate: it stays in one piece.

    Raises
    ------
    InvalidProblemError
        When the response is too short.
    """
    problem, T = response.problem, response.problem.period
    end = float(response.window[1])
    start, hair = end - periods * T, 1e-9 * T
    if response.t[0] > start + hair:
        allowed = f"a response of at least {periods} periods, all of them sampled"
        raise InvalidProblemError(Mistake("response", f"{len(response.t)} samples", allowed))
    log = response.events
    modes = [response.initial_mode or "stick", *log.modes_after(response.initial_mode or "stick")]
    first = int(np.searchsorted(log.t, start - hair))
    last = int(np.searchsorted(log.t, end - hair))  # one at the end is one at the start
    inside = slice(first, last)
    if exact_events:
        pieces = _cut(response, start, end, hair)
    else:
        keep = response.t >= start - hair
        arrays = (response.t, response.q, response.q_dot, response.friction_torque)
        pieces = [Piece(*(array[keep] for array in arrays))]
    return Motion(
        problem,
        periods,
        tuple(pieces),
        np.maximum(log.t[inside] - start, 0.0) / T,
        tuple(str(kind) for kind in log.kind[inside]),
        modes[first],
        None if exact_events else response.dissipated_energy,
    )


def _cut(response: Response, start: float, end: float, hair: float) -> list[Piece]:
    """Samples between `start` and `end`, in pieces between events, with the states at these."""
    t, q, q_dot, torque = response.t, response.q, response.q_dot, response.friction_torque
    log = response.events
    inside = np.flatnonzero((log.t > start + hair) & (log.t < end - hair))
    edges = [start - hair, *log.t[inside].tolist(), end + hair]
    pieces = []
    for i, (low, high) in enumerate(pairwise(edges)):
        first, last = i == 0, i == len(inside)
        keep = (t > low + (0.0 if first else hair)) & (t < high - (0.0 if last else hair))
        parts: list[tuple[FloatArray, ...]] = [(t[keep], q[keep], q_dot[keep], torque[keep].copy())]
        if not first:
            k = inside[i - 1]
            parts.insert(0, _at_event(log, k, log.torque_after[k]))
        if not last:
            k = inside[i]
            parts.append(_at_event(log, k, log.torque_before[k]))
        joined = [np.concatenate(column) for column in zip(*parts, strict=True)]
        _mend_ends(joined, log, hair, end - start)
        if len(joined[0]) > 1:
            pieces.append(Piece(*joined))
    return pieces


def _at_event(log: Any, k: int, torque: float) -> tuple[FloatArray, ...]:
    return log.t[k : k + 1], log.q[k : k + 1], log.q_dot[k : k + 1], np.array([torque])


def _mend_ends(joined: list[FloatArray], log: Any, hair: float, length: float) -> None:
    """A sample taken at an event has one of two torques: take the one of its own side.

    The motion repeats after `length`: an event at its start is one at its end, and the log of an
    orbit has it once.
    """
    late = log.t[:, None] + length * np.arange(-1, 2)
    for k in np.flatnonzero(np.any(np.abs(late - joined[0][0]) <= hair, axis=1)):
        joined[3][0] = log.torque_after[k]
    for k in np.flatnonzero(np.any(np.abs(late - joined[0][-1]) <= hair, axis=1)):
        joined[3][-1] = log.torque_before[k]
