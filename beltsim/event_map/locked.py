"""The joint that never moves: range of its reaction and where it can rest.

Depends on: flows, problem.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from beltsim.checks import FloatArray
from beltsim.errors import NotPeriodicError
from beltsim.event_map.flows import Flow, flows_of
from beltsim.event_map.linear_part import ComplexArray
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem

#: Relative size below which a static stiffness is the rounding of its terms.
_ROUNDING = 1e-13


@dataclass(frozen=True)
class Locked:
    """Steady reaction with the joint held at zero, and how it shifts with the position held.

    `low`, `high`: its extreme values at position 0; `slope`: change per unit of position (the
    static stiffness seen by the joint, with a minus sign); 0 for a joint that nothing holds.
    """

    low: float
    high: float
    slope: float

    @property
    def Q_m_cr(self) -> float:
        """Critical torque: half the peak-to-peak of the reaction, whose mean the position takes.

        Where the position changes nothing, friction has to carry the mean as well.
        """
        if self.slope == 0.0:
            return max(abs(self.low), abs(self.high))
        return 0.5 * (self.high - self.low)

    def rest_interval(self, Q_s: float) -> tuple[float, float] | None:
        """Positions at which friction `Q_s` holds the joint for ever; None when there is none."""
        if Q_s < self.Q_m_cr:
            return None
        if self.slope == 0.0:
            return -np.inf, np.inf
        ends = ((-Q_s - self.low) / self.slope, (Q_s - self.high) / self.slope)
        return min(ends), max(ends)


def locked(problem: FrictionProblem) -> Locked:
    """The steady reaction of `problem` with its joint held; shared by all torques on it."""
    if "event_map.locked" not in problem.shared:
        held = flows_of(problem).held.part
        harmonics, static = _steady(problem)
        low, high = trigonometric_range(harmonics @ held.row + held.D)
        slope = float(held.row @ static + held.d_c)
        if abs(slope) <= _ROUNDING * (float(np.abs(held.row) @ np.abs(static)) + abs(held.d_c)):
            slope = 0.0
        problem.shared["event_map.locked"] = Locked(low, high, slope)
    found: Locked = problem.shared["event_map.locked"]
    return found


def _steady(problem: FrictionProblem) -> tuple[ComplexArray, FloatArray]:
    """Harmonics (H + 1, N) of the held system's state and its answer (N,) to a unit position."""
    held = flows_of(problem).held
    if isinstance(held, Flow):
        return held.P, held.X_c
    part = held.part
    q = part.steady("held")
    w = part.Omega * np.arange(len(q))
    static = np.linalg.lstsq(part.K, part.push, rcond=1e-12)[0]
    harmonics = np.concatenate([q, 1j * w[:, None] * q], axis=1)
    return harmonics, np.concatenate([static, np.zeros(len(static))])


def at_rest(problem: FrictionProblem, position: float) -> FloatArray:
    """State (2n,) at t = 0 of the steady motion with the joint held at `position`."""
    state = np.zeros(2 * problem.n)
    harmonics, static = _steady(problem)
    state[flows_of(problem).rest] = harmonics.real.sum(axis=0) + position * static
    state[problem.joint or 0] = position
    return state


def rest_place(rest: tuple[float, float]) -> float:
    """The middle of a rest interval; zero when the joint rests anywhere."""
    middle = 0.5 * (rest[0] + rest[1])
    return middle if np.isfinite(middle) else 0.0


def steady_rms(problem: FrictionProblem, position: float) -> FloatArray:
    """Root mean square (n,) of the coordinates with the joint held at `position`."""
    n = problem.n
    harmonics, static = _steady(problem)
    squares = 0.5 * np.sum(np.abs(harmonics[1:]) ** 2, axis=0)
    squares += (harmonics[0].real + position * static) ** 2
    found = np.full(2 * n, position**2)
    found[flows_of(problem).rest] = squares
    rms: FloatArray = np.sqrt(found[:n])
    return rms


def resting_multipliers(problem: FrictionProblem) -> ComplexArray:
    """Floquet multipliers (2n,): of the held system, and of the joint, which is free to rest
    elsewhere but loses any velocity.
    """
    exponents = flows_of(problem).held.exponents
    pairs = np.exp(exponents * problem.period)
    return np.concatenate([pairs, pairs[exponents.imag > 0.0].conj(), [1.0, 0.0]])


def trigonometric_range(c: ComplexArray) -> tuple[float, float]:
    """Least and greatest value of Re sum_k c_k exp(i k x), from the roots of its derivative."""
    if len(c) == 1 or not np.any(c[1:]):
        return float(c[0].real), float(c[0].real)
    if len(c) == 2:
        return float(c[0].real - abs(c[1])), float(c[0].real + abs(c[1]))
    slope = 1j * np.arange(len(c)) * c
    # z^H times the derivative is a polynomial in z = exp(i x) whose unit roots are the extrema
    polynomial = np.concatenate([slope[:0:-1], [0.0], slope[1:].conj()])
    x: Any = np.angle(np.roots(polynomial))
    k = np.arange(len(c))
    for _ in range(3):  # Newton on the derivative: roots of a polynomial lose digits
        turns = np.exp(1j * np.multiply.outer(x, k))
        first = (turns @ (1j * k * c)).real
        second = (turns @ (-(k**2) * c)).real
        x = x - np.where(np.abs(second) > 0.0, first / np.where(second == 0.0, 1.0, second), 0.0)
    grid = np.linspace(0.0, 2.0 * np.pi, 4 * len(c), endpoint=False)
    values = (np.exp(1j * np.multiply.outer(np.append(x, grid), k)) @ c).real
    return float(values.min()), float(values.max())


def may_move_too(problem: FrictionProblem) -> bool:
    """Whether a joint that can rest may as well move for ever: Q_m < Q_cr <= Q_s."""
    law = problem.friction
    if not isinstance(law, Coulomb) or law.Q_s is None or law.Q_s == law.Q_m:
        return False
    return law.Q_m < locked(problem).Q_m_cr <= law.Q_s


def require_stable(problem: FrictionProblem) -> None:
    """Refuse a periodic orbit of an unstable linear part, and name the eigenvalue."""
    if problem.shared.get("event_map.stable"):
        return
    flows = flows_of(problem)
    if not _passive(problem.K):
        for name, flow in (("free", flows.free), ("held", flows.held)):
            _require_decay(name, flow.exponents)
    problem.shared["event_map.stable"] = True


def require_bounded(problem: FrictionProblem) -> None:
    """Refuse a moving orbit where forcing meets a mode without damping and friction cannot help."""
    flows, law = flows_of(problem), problem.friction
    assert law is not None
    if not isinstance(flows.free, Flow):
        bound = law.Q_s if isinstance(law, Coulomb) and law.Q_s is not None else law.Q_m
        flows.free.part.steady("free", bound, problem.joint or 0)
    if not isinstance(flows.held, Flow):
        flows.held.part.steady("held")


def _passive(K: FloatArray) -> bool:
    """K without negative eigenvalue: since C has none either, nothing can grow."""
    try:
        np.linalg.cholesky(K)
    except np.linalg.LinAlgError:
        pass
    else:
        return True
    squares = np.linalg.eigvalsh(K)
    return bool(squares[0] >= -1e-13 * squares[-1])


def _require_decay(name: str, exponents: ComplexArray) -> None:
    if not len(exponents):
        return
    worst = exponents[np.argmax(exponents.real)]
    if worst.real > 1e-10 * float(np.abs(exponents).max()):
        text = (
            f"the system with its joint {name} is unstable: eigenvalue {worst:.6g} has a "
            "positive real part; no periodic orbit is sought. Check K and the damping"
        )
        raise NotPeriodicError(text)
