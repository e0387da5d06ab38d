r"""The exact motion of a Coulomb joint between events, from eigenvectors: a reference.

Between events the system is linear, so its state is a periodic particular solution plus a sum of
modes,

.. math:: y(t) = \mathrm{Re}\sum_k p_k e^{ik\Omega t} + y_0 + V e^{\Lambda (t - t_0)} b

and every event time is a root of a known function. Roots are looked for in samples dense against
the fastest mode and polished to rounding; an extremum of the same sign as its neighbours is
checked too, so two roots between two samples are not missed.

Shares nothing with beltsim's solvers: the data of the problem only, no import from beltsim. The
law: slipping ends at zero velocity; the arm then sticks when |H| <= Q_s, H being the torque that
would hold it, else slips on in the direction of H; sticking ends when |H| reaches Q_s.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

#: Samples per shortest mode period; a mode of that period is resolved to 1e-2 by a straight line.
SAMPLES_PER_CYCLE = 24


@dataclass(frozen=True)
class Run:
    """Events and end state; `travel` is the distance slipped in each forcing period.

    `rate` says how fast what ends a phase (the velocity, or the distance of the reaction from
    Q_s) passes through zero, over Omega times its largest value in the run. An error of that
    quantity moves the event by the error over Omega times the rate.
    """

    t: np.ndarray
    kind: list[str]
    position: np.ndarray
    rate: np.ndarray
    final_state: np.ndarray
    travel: np.ndarray

    def last_period(self, period: float, end: float) -> list[str]:
        """Kinds of the events in the last forcing period before `end`."""
        return [k for t, k in zip(self.t, self.kind, strict=True) if end - period < t <= end]


class _Linear:
    """Modes and particular solution of M x'' + B x' + K x = f(t) - torque e."""

    def __init__(self, M: Any, B: Any, K: Any, force: np.ndarray, e: np.ndarray, W: float) -> None:
        n = self.n = len(M)
        A = np.zeros((2 * n, 2 * n))
        A[:n, n:] = np.eye(n)
        A[n:, :n], A[n:, n:] = -np.linalg.solve(M, K), -np.linalg.solve(M, B)
        self.eigenvalues, self.V = np.linalg.eig(A)
        self.V_inverse = np.linalg.inv(self.V)
        self.rates = 1j * W * np.arange(len(force))
        self.particular = np.zeros((len(force), 2 * n), complex)
        for k in np.flatnonzero(np.any(force, axis=1)):
            rate = self.rates[k]
            x = np.linalg.solve(rate**2 * M + rate * B + K, force[k])
            self.particular[k] = np.concatenate([x, rate * x])
        self.per_torque = np.concatenate([np.linalg.solve(K, e), np.zeros(n)])

    def motion(self, t0: float, y0: np.ndarray, torque: float) -> _Motion:
        rest = y0 - self.forced(t0) + torque * self.per_torque
        return _Motion(self, t0, torque, self.V_inverse @ rest)

    def forced(self, t: float) -> np.ndarray:
        value: np.ndarray = np.real(np.exp(self.rates * t) @ self.particular)
        return value


@dataclass(frozen=True)
class _Motion:
    """One solution of a linear system, as a sum of exponentials."""

    linear: _Linear
    t0: float
    torque: float
    weights: np.ndarray

    def state(self, t: float) -> np.ndarray:
        modes = self.linear.V @ (np.exp(self.linear.eigenvalues * (t - self.t0)) * self.weights)
        forced = self.linear.forced(t) - self.torque * self.linear.per_torque
        state: np.ndarray = np.real(modes) + forced
        return state

    def watch(self, row: np.ndarray, constant: float = 0.0) -> _Signal:
        """The signal row.y(t) + constant, as one sum of exponentials."""
        linear = self.linear
        weights = np.concatenate([(row @ linear.V) * self.weights, linear.particular @ row])
        weights[len(self.weights) :] *= np.exp(linear.rates * self.t0)
        rates = np.concatenate([linear.eigenvalues, linear.rates])
        return _Signal(self.t0, rates, weights, constant - self.torque * (row @ linear.per_torque))


@dataclass(frozen=True)
class _Signal:
    t0: float
    rates: np.ndarray
    weights: np.ndarray
    constant: float

    def at(self, t: Any, order: int = 0) -> np.ndarray:
        """The signal or its derivative at `t`."""
        delay = np.multiply.outer(np.asarray(t, float) - self.t0, self.rates)
        value: np.ndarray = np.real(np.exp(delay) @ (self.weights * self.rates**order))
        return value + self.constant if order == 0 else value

    def plus(self, forced: np.ndarray, W: float) -> _Signal:
        """The same signal with a Fourier series of fundamental W added."""
        rates = 1j * W * np.arange(len(forced))
        weights = np.concatenate([self.weights, forced * np.exp(rates * self.t0)])
        return _Signal(self.t0, np.concatenate([self.rates, rates]), weights, self.constant)


def run(problem: Any, periods: int, initial_state: Any = None) -> Run:
    """Exact motion of `problem` from rest (or `initial_state`) over whole forcing periods."""
    return _Walk(problem, periods, initial_state).run()


class _Walk:
    def __init__(self, problem: Any, periods: int, initial_state: Any) -> None:
        n, j = len(problem.M), problem.joint
        self.j, self.n, self.periods = j, n, periods
        self.period = 2.0 * np.pi / problem.forcing.Omega
        self.Q_m, self.Q_s = problem.friction.Q_m, problem.friction.Q_s
        self.y = np.zeros(2 * n) if initial_state is None else np.array(initial_state, float)
        self.keep = keep = np.delete(np.arange(n), j)
        B = problem.C + problem.G
        W = problem.forcing.Omega
        force = problem.forcing.cos - 1j * problem.forcing.sin
        e = np.zeros(n)
        e[j] = 1.0
        self.slip = _Linear(problem.M, B, problem.K, force, e, W)
        self.M, self.B, self.K, self.force, self.W = problem.M, B, problem.K, force, W
        cut = np.ix_(keep, keep)
        self.stuck_matrices = problem.M[cut], B[cut], problem.K[cut]
        # stuck: a unit displacement of the joint acts on the others as a constant load -K_qt
        column = problem.K[keep, j]
        self.stick = _Linear(*self.stuck_matrices, force[:, keep], column, W) if n > 1 else None
        fastest = max(np.abs(self.slip.eigenvalues).max(), W)
        self.step = 2.0 * np.pi / fastest / SAMPLES_PER_CYCLE
        self.events: list[tuple[float, str, float, float]] = []
        self.largest = {"velocity": 0.0, "reaction": self.Q_s}

    def run(self) -> Run:
        """Go through the phases; a mode is +1, -1 (slip) or 0 (stick)."""
        t, end = 0.0, self.periods * self.period
        v = self.y[self.n + self.j]
        mode = int(np.sign(v)) or self._at_rest(t)
        travel = np.zeros(self.periods)
        for index in range(self.periods):
            stop = (index + 1) * self.period if index + 1 < self.periods else end
            while t < stop:
                before = self.y[self.j]
                t, mode = self._phase(t, stop, mode)
                travel[index] += abs(self.y[self.j] - before)
        t_all, kinds, places, slopes = zip(*self.events, strict=True) if self.events else ((),) * 4
        watched = ["velocity" if kind in ("stick", "reverse") else "reaction" for kind in kinds]
        sizes = np.array([self.largest[name] for name in watched])
        rate = np.array(slopes) / (self.W * sizes)
        end_state = self.y.copy()
        return Run(np.array(t_all), list(kinds), np.array(places), rate, end_state, travel)

    def _phase(self, t: float, stop: float, mode: int) -> tuple[float, int]:
        """Advance to the next event, at most to `stop`; the time and mode there."""
        if mode:
            return self._slip(t, stop, mode)
        return self._stick(t, stop)

    def _slip(self, t: float, stop: float, mode: int) -> tuple[float, int]:
        motion = self.slip.motion(t, self.y, mode * self.Q_m)
        row = np.zeros(2 * self.n)
        row[self.n + self.j] = float(mode)
        speed = motion.watch(row)
        found = self._first_root(speed, t, stop, start_is_zero=row @ self.y == 0.0)
        peak = np.abs(speed.at(np.linspace(t, stop if found is None else found, 33))).max()
        self.largest["velocity"] = max(self.largest["velocity"], float(peak))
        self.y = motion.state(stop if found is None else found)
        if found is None:
            return stop, mode
        self.y[self.n + self.j] = 0.0
        after = self._at_rest(found)
        kind = "stick" if after == 0 else "reverse"
        self.events.append((found, kind, self.y[self.j], abs(float(speed.at(found, 1)))))
        return found, after

    def _stick(self, t: float, stop: float) -> tuple[float, int]:
        H = self._reaction_signal(t)
        start = float(H.at(t))
        released, side = None, 0
        for sign in (1, -1):
            gap = _Signal(H.t0, H.rates, -sign * H.weights, self.Q_s - sign * H.constant)
            limit = stop if released is None else released
            found = self._first_root(gap, t, limit, start_is_zero=sign * start >= self.Q_s)
            if found is not None:
                released, side = found, sign
        until = stop if released is None else released
        if self.stick is not None:
            q = np.concatenate([self.y[self.keep], self.y[self.n + self.keep]])
            q = self.stick.motion(t, q, self.y[self.j]).state(until)
            self.y[self.keep], self.y[self.n + self.keep] = np.split(q, 2)
        if released is None:
            return stop, 0
        kind = "slip+" if side > 0 else "slip-"
        self.events.append((released, kind, self.y[self.j], abs(float(H.at(released, 1)))))
        return released, side

    def _reaction_signal(self, t: float) -> _Signal:
        """H(t) while stuck: f_t - M_tq q'' - (C + G)_tq q' - K_tq q - K_tt x_t."""
        j, keep, n = self.j, self.keep, self.n
        constant = -self.K[j, j] * self.y[j]
        if self.stick is None:
            empty = _Signal(t, np.zeros(0, complex), np.zeros(0, complex), constant)
            return empty.plus(self.force[:, j], self.W)
        M, B, K = self.stuck_matrices
        share = np.linalg.solve(M, self.M[j, keep])  # M_tq M_qq^-1, M symmetric
        row = np.concatenate([share @ K - self.K[j, keep], share @ B - self.B[j, keep]])
        q = np.concatenate([self.y[keep], self.y[n + keep]])
        motion = self.stick.motion(t, q, self.y[j])
        constant += (share @ self.K[keep, j]) * self.y[j]
        forced = self.force[:, j] - self.force[:, keep] @ share
        return motion.watch(row, constant).plus(forced, self.W)

    def _at_rest(self, t: float) -> int:
        """Mode after the velocity has become zero."""
        H = float(self._reaction_signal(t).at(t))
        return 0 if abs(H) <= self.Q_s else int(np.sign(H))

    def _first_root(
        self, signal: _Signal, t: float, stop: float, start_is_zero: bool
    ) -> float | None:
        """First time in (t, stop] at which a signal that starts >= 0 becomes negative."""
        cells = max(2, int(np.ceil((stop - t) / self.step)))
        times = np.linspace(t, stop, cells + 1)
        values, slopes = signal.at(times), signal.at(times, 1)
        for i in range(cells):
            low, high = times[i], times[i + 1]
            rising_from_zero = i == 0 and start_is_zero
            if values[i + 1] >= 0.0:
                if rising_from_zero or not slopes[i] < 0.0 < slopes[i + 1]:
                    continue
                high = float(brentq(lambda s: signal.at(s, 1), low, high, xtol=1e-15))
                if signal.at(high) >= 0.0:
                    continue
            elif rising_from_zero:
                low = _inside(signal, low, high)
            return float(brentq(signal.at, low, high, xtol=1e-15, rtol=1e-15))
        return None


def _inside(signal: _Signal, low: float, high: float) -> float:
    """A time in a short phase that begins with a zero of its signal, for a root beyond it."""
    for k in range(1, 40):
        t = low + (high - low) * 0.5**k
        if float(signal.at(t)) > 0.0:
            return t
    raise RuntimeError(f"a phase shorter than {(high - low) * 0.5**39:.0e} begins at t = {low}")
