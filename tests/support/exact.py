r"""Exact transients of a Coulomb joint: the judge of every solver.

Between events the system is linear with harmonic forcing, so its state, extended by the constant,
the friction torque and the oscillators :math:`\cos k\Omega t, \sin k\Omega t`, obeys
:math:`\dot z = A z` with one matrix for slip and one for stick. On a cell of length
:math:`h = 1/(2\rho)`, `rho` the fastest eigenvalue, the Taylor series of degree 18 is exact to
rounding (0.5^19/19! = 2e-23), so every watched quantity is a known polynomial per cell. Its first
root is isolated rigorously: a cell is discarded only where the coefficients prove that there is
none, and a piece is bisected only where they prove that it is monotone. Double roots inside a cell
are therefore not missed. No eigenvectors are used: defective matrices need no special care.

Transition rule, written here from the law itself (`H` is the reaction that would hold the joint,
with the joint's velocity and acceleration zero):

* slip leaves at a zero of the velocity; then `|H| <= Q_s` means stick, otherwise the joint goes on
  in the direction of `H`;
* stick freezes the joint where it is and ends when `|H|` reaches `Q_s`, towards the sign of `H`.

Shares nothing with beltsim but the data of a `FrictionProblem`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

DEGREE = 18
CELLS = 64
FACTORIALS = np.cumprod([1.0, *range(1, DEGREE + 1)])
SIGN = {"slip+": 1.0, "slip-": -1.0, "stick": 0.0, "free": 0.0}
#: Below this share of its own size a watched quantity counts as exactly zero at a phase's start.
ROUNDING = 1e-13


class Phase(NamedTuple):
    mode: str
    t: float
    z: np.ndarray


class Touch(NamedTuple):
    """A minimum of a watched quantity that did not reach zero."""

    t: float
    value: float
    kind: str


@dataclass
class ExactRun:
    """Events, end state, and how far every decision was from going the other way.

    `rate`: speed of the watched quantity through zero, over Omega times its largest value.
    `outcome`: distance of the reaction from Q_s at a zero of the velocity, over
    max(Q_s, largest reaction); infinite for a release, which has no other outcome.
    `margin`: the smallest of rate, outcome and touch met up to this event.
    """

    t: np.ndarray
    kind: list[str]
    q: np.ndarray
    q_dot: np.ndarray
    torque_before: np.ndarray
    torque_after: np.ndarray
    rate: np.ndarray
    outcome: np.ndarray
    margin: np.ndarray
    touch_t: np.ndarray
    touch_margin: np.ndarray
    touch_kind: list[str]
    initial_mode: str
    final_mode: str
    final_state: np.ndarray
    min_margin: float
    v_peak: float
    end: float
    _phases: list[Phase] = field(repr=False)
    _system: _System = field(repr=False)

    def states(self, times) -> np.ndarray:
        """States (nt, 2n) at ascending `times`."""
        starts = np.array([phase.t for phase in self._phases])
        found = []
        for t in np.asarray(times, float):
            phase = self._phases[max(int(np.searchsorted(starts, t, side="right")) - 1, 0)]
            flow = self._system.stick if phase.mode == "stick" else self._system.slip
            cells, rest = divmod(max(t - phase.t, 0.0), flow.h)
            z = flow.inside(flow.advanced(phase.z, int(cells)), rest / flow.h)
            found.append(z[: 2 * self._system.n])
        return np.array(found)


class _Flow:
    """z' = A z on cells of length h, with the Taylor polynomials of the rows in `outputs`."""

    def __init__(self, A: np.ndarray, h: float, outputs: np.ndarray) -> None:
        self.h, self.step = h, A * h
        E = np.eye(len(A))
        for k in range(DEGREE, 0, -1):
            E = np.eye(len(A)) + self.step @ E / k
        self.powers = [E]
        rows = [outputs]
        for k in range(1, DEGREE + 1):
            rows.append(rows[-1] @ self.step / k)
        at_start = np.stack(rows, axis=1).reshape(-1, len(A))
        table = [at_start]
        for _ in range(CELLS):
            table.append(table[-1] @ E)
        self.table = np.concatenate(table)
        self.shape = (CELLS + 1, len(outputs), DEGREE + 1)

    def polynomials(self, z: np.ndarray) -> np.ndarray:
        """Coefficients (CELLS + 1, outputs, DEGREE + 1) in u = (t - cell start)/h."""
        return (self.table @ z).reshape(self.shape)

    def advanced(self, z: np.ndarray, cells: int) -> np.ndarray:
        """State `cells` cells later."""
        bit = 0
        while cells:
            while bit >= len(self.powers):
                self.powers.append(self.powers[-1] @ self.powers[-1])
            if cells & 1:
                z = self.powers[bit] @ z
            cells, bit = cells >> 1, bit + 1
        return z

    def inside(self, z: np.ndarray, u: float) -> np.ndarray:
        """State a fraction `u` of a cell later."""
        term = total = z
        for k in range(1, DEGREE + 1):
            term = self.step @ term * (u / k)
            total = total + term
        return total


class _System:
    """The two flows of a problem, with z = (q, q_dot, 1, h, cos k Omega t, sin k Omega t)."""

    def __init__(self, problem) -> None:
        M, C, G, K = problem.M, problem.C, problem.G, problem.K
        forcing = problem.forcing
        self.n, self.joint = n, joint = len(M), problem.joint
        self.Omega = forcing.Omega
        self.orders = np.arange(1, len(forcing.cos))
        H = len(self.orders)
        size = 2 * n + 2 + 2 * H
        balance = np.zeros((n, size))  # f - e h - (C + G) q' - K q
        balance[:, :n], balance[:, n : 2 * n] = -K, -(C + G)
        balance[:, 2 * n] = forcing.cos[0]
        balance[:, 2 * n + 2 : 2 * n + 2 + H] = forcing.cos[1:].T
        balance[:, 2 * n + 2 + H :] = forcing.sin[1:].T
        if joint is not None:
            balance[joint, 2 * n + 1] = -1.0
        drift = np.zeros((size, size))
        drift[:n, n : 2 * n] = np.eye(n)
        for k in self.orders:
            c, s = 2 * n + 1 + k, 2 * n + 1 + H + k
            drift[c, s], drift[s, c] = -k * self.Omega, k * self.Omega
        A_slip = drift.copy()
        A_slip[n : 2 * n] = np.linalg.solve(M, balance)
        rho = np.abs(np.linalg.eigvals(A_slip)).max()
        if joint is None:
            self.slip = _Flow(A_slip, 0.5 / rho, np.zeros((1, size)))
            return
        keep = np.delete(np.arange(n), joint)
        A_stick = drift.copy()
        A_stick[joint] = 0.0
        A_stick[n + keep] = np.linalg.solve(M[np.ix_(keep, keep)], balance[keep])
        self.reaction = balance[joint] - M[joint, keep] @ A_stick[n + keep]
        self.reaction[2 * n + 1] = 0.0
        self.acceleration = A_slip[n + joint]
        velocity = np.zeros(size)
        velocity[n + joint] = 1.0
        rho_stick = max(rho, np.abs(np.linalg.eigvals(A_stick)).max())
        self.slip = _Flow(A_slip, 0.5 / rho, velocity[None])
        self.stick = _Flow(A_stick, 0.5 / rho_stick, self.reaction[None])

    def extended(self, state: np.ndarray, t: float, torque: float) -> np.ndarray:
        angle = self.orders * self.Omega * t
        return np.concatenate([state, [1.0, torque], np.cos(angle), np.sin(angle)])


def exact_transient(problem, periods=20.0, initial_state=None, like=None) -> ExactRun:
    """Run `problem` from t = 0 over `periods` forcing periods.

    `like`: a run of the same problem with another friction torque, whose matrices are reused.
    """
    system = _System(problem) if like is None else like._system
    n, end = system.n, periods * 2.0 * np.pi / system.Omega
    state = np.zeros(2 * n) if initial_state is None else np.array(initial_state, float)
    if problem.joint is None:
        phase = Phase("free", 0.0, system.extended(state, 0.0, 0.0))
        final = system.slip.advanced(phase.z, int(end // system.slip.h))
        final = system.slip.inside(final, (end % system.slip.h) / system.slip.h)
        log: list = []
        return _finish(system, problem, log, [], [phase], final[: 2 * n], end, (0.0, 0.0))
    return _Walk(system, problem, state, end).run()


class _Walk:
    """One run of a problem with a joint."""

    def __init__(self, system: _System, problem, state: np.ndarray, end: float) -> None:
        self.Q_m, self.Q_s = problem.friction.Q_m, problem.friction.Q_s
        self._begin(system, problem, state, end)

    def _begin(self, system: _System, problem, state: np.ndarray, end: float) -> None:
        self.system, self.problem, self.end = system, problem, end
        self.log: list = []
        self.touches: list[Touch] = []
        self.v_peak = 0.0
        self.H_peak = self.Q_s
        self.state, self.t = state, 0.0
        self.order = 0  # leading Taylor coefficients that vanish at the phase's start,
        self.side = 0  # of this one of the watched quantities (stick: 0 at +Q_s, 1 at -Q_s)
        self.mode = self._first_mode()
        self.phases: list[Phase] = []

    @property
    def v_index(self) -> int:
        return self.system.n + self.system.joint

    def _reaction(self) -> np.ndarray:
        """Taylor coefficients of the holding reaction for the joint held from now on."""
        z = self.system.extended(self.state, self.t, 0.0)
        return self.system.stick.table[: DEGREE + 1] @ z

    def _first_mode(self) -> str:
        v = self.state[self.v_index]
        if v != 0.0:
            return "slip+" if v > 0.0 else "slip-"
        H = self._reaction()
        side = 1.0 if H[0] >= 0.0 else -1.0
        slipping = "slip+" if side > 0 else "slip-"
        excess = abs(H[0]) - self.Q_s
        if abs(excess) > ROUNDING * max(abs(H[0]), self.Q_s):
            self.order = 1 if excess > 0.0 else 0
            return slipping if excess > 0.0 else "stick"
        if not H.any():
            return "stick"
        # On the limit: the first derivative of the reaction that is not zero decides.
        first = _first_derivative(H)
        if first is None:
            return "stick"
        if side * H[first] > 0.0:
            self.order = 1 if self.Q_s > self.Q_m else 1 + first
            return slipping
        self.order, self.side = first, int(side < 0.0)
        return "stick"

    def run(self) -> ExactRun:
        while True:
            if len(self.phases) > 20 and self.t == self.phases[-20].t:
                raise RuntimeError(f"the reference does not move on at t = {self.t}")
            torque = SIGN[self.mode] * self.Q_m
            z = self.system.extended(self.state, self.t, torque)
            self.phases.append(Phase(self.mode, self.t, z))
            found = self._leave_slip(z) if self.mode != "stick" else self._leave_stick(z)
            if not found:
                peaks = (self.v_peak, self.H_peak)
                return _finish(
                    self.system,
                    self.problem,
                    self.log,
                    self.touches,
                    self.phases,
                    self.state,
                    self.end,
                    peaks,
                )

    def _leave_slip(self, z: np.ndarray) -> bool:
        sign = SIGN[self.mode]
        flow = self.system.slip

        def watched(c: np.ndarray) -> np.ndarray:
            self.v_peak = max(self.v_peak, float(np.abs(c[:, 0, 0]).max()))
            return sign * c

        self.side = 0
        z, reached = self._walk(flow, z, watched, "velocity")
        self.state = z[: 2 * self.system.n].copy()
        if not reached:
            return False
        before = abs(float(self.system.acceleration @ z))
        self.state[self.v_index] = 0.0
        H = float(self._reaction()[0])
        self.H_peak = max(self.H_peak, abs(H))
        gap = abs(H) - self.Q_s
        self.order = 0
        # A falling speed means sign*H <= Q_m: only rounding can put it beyond Q_s.
        if (gap <= ROUNDING * abs(H) or sign * H > 0.0) and self.Q_s > 0.0:
            self._record("stick", sign * self.Q_m, H, before, gap)
            self.mode = "stick"
            return True
        self.order = 1
        self._record("reverse", sign * self.Q_m, -sign * self.Q_m, before, gap)
        self.mode = "slip-" if sign > 0 else "slip+"
        return True

    def _leave_stick(self, z: np.ndarray) -> bool:
        def watched(c: np.ndarray) -> np.ndarray:
            both = np.concatenate([-c, c], axis=1)
            both[:, :, 0] += self.Q_s
            return both

        z, reached = self._walk(self.system.stick, z, watched, "reaction")
        self.state = z[: 2 * self.system.n].copy()
        if not reached:
            return False
        H = self._reaction()
        sign = 1.0 if H[0] > 0.0 else -1.0
        first = _first_derivative(H)
        if first is not None and sign * H[first] < 0.0:  # touches the limit and turns back
            self.touches.append(Touch(self.t, 0.0, "reaction"))
            self.order, self.side = first, int(sign < 0.0)
            return True
        rate = abs(H[1]) / self.system.stick.h
        self.mode = "slip+" if sign > 0.0 else "slip-"
        self._record(self.mode, sign * self.Q_s, sign * self.Q_m, rate, np.inf)
        self.order = 1 if self.Q_s > self.Q_m else 2
        return True

    def _walk(self, flow: _Flow, z: np.ndarray, watched, kind: str) -> tuple[np.ndarray, bool]:
        """Go on until one of the watched quantities falls through zero, or to the end."""
        n2, order = 2 * self.system.n, self.order
        while True:
            left = (self.end - self.t) / flow.h
            cells = min(CELLS, int(np.ceil(left)))
            c = watched(flow.polynomials(z)[: cells + 1])
            for i, u in self._roots(c[:cells], order, self.side):
                if i + u > left:
                    break
                self._note_minima(c[: i + 1], flow.h, kind, order)
                self.t += (i + u) * flow.h
                return flow.inside(flow.advanced(z, i), u), True
            self._note_minima(c, flow.h, kind, order)
            if left <= CELLS:
                whole = int(left)
                self.t = self.end
                return flow.inside(flow.advanced(z, whole), left - whole), False
            z, self.t, order = flow.advanced(z, CELLS), self.t + CELLS * flow.h, 0
            z = self.system.extended(z[:n2], self.t, z[n2 + 1])  # oscillators anew: no drift

    @staticmethod
    def _roots(c: np.ndarray, order: int, side: int):
        """The first root, as (cell, fraction).

        `order` leading coefficients of quantity `side` are zero: the root there is divided out.
        """
        sure = c[:, :, 0] > np.abs(c[:, :, 1:]).sum(axis=2)
        for i in np.flatnonzero(~sure.all(axis=1)):
            found = []
            for j, p in enumerate(c[i]):
                strip = order if i == 0 and j == side else 0
                while strip and strip < DEGREE and abs(p[strip]) < _tiny(p):
                    strip += 1
                u = first_root(p[strip:])
                if u is not None:
                    found.append(u)
            if found:
                yield int(i), min(found)
                return

    def _note_minima(self, c: np.ndarray, h: float, kind: str, order: int) -> None:
        slope = c[:, :, 1]
        for i, j in np.argwhere((slope[:-1] < 0.0) & (slope[1:] > 0.0)):
            if i == 0 and order:  # the zero that the phase starts from
                continue
            p = c[i, j]
            slopes = p[1:] * np.arange(1, DEGREE + 1)
            if _value(slopes, 1.0) <= 0.0:
                u = 1.0
            else:
                u = brentq(lambda x, d=slopes: _value(d, x), 0.0, 1.0, xtol=1e-14)
            self.touches.append(Touch(self.t + (i + u) * h, _value(p, u), kind))

    def _record(self, kind, before, after, speed, gap) -> None:
        n = self.system.n
        state = self.state.copy()
        self.log.append((self.t, kind, state[:n], state[n:], before, after, speed, gap))


def _first_derivative(p: np.ndarray) -> int | None:
    """Order of the first derivative that is more than rounding."""
    return next((k for k in range(1, len(p)) if abs(p[k]) > _tiny(p)), None)


def _tiny(p: np.ndarray) -> float:
    return ROUNDING * float(np.abs(p).sum())


def _value(p: np.ndarray, u: float) -> float:
    total = 0.0
    for coefficient in p[::-1].tolist():
        total = total * u + coefficient
    return total


def first_root(p: np.ndarray) -> float | None:
    """First u in [0, 1] where the polynomial, positive before, falls to zero; None if nowhere."""
    if p[0] <= 0.0:
        return 0.0
    k = np.arange(len(p))
    p1 = (p * k)[1:]
    p2 = (p1 * k[: len(p1)])[1:]
    bound3 = float(np.abs(p2 * k[: len(p2)]).sum())  # of |p'''| on [0, 1]
    pieces = [(0.0, 1.0)]
    while pieces:
        a, b = pieces.pop()
        m, r = 0.5 * (a + b), 0.5 * (b - a)
        v0, v1, v2 = _value(p, m), abs(_value(p1, m)), abs(_value(p2, m))
        if abs(v0) > v1 * r + 0.5 * v2 * r**2 + bound3 * r**3 / 6.0:
            if v0 < 0.0:
                return a
            continue
        if v1 > v2 * r + 0.5 * bound3 * r**2 or r < 1e-10:  # monotone, or at rounding
            if _value(p, a) <= 0.0:
                return a
            if _value(p, b) <= 0.0:
                return float(brentq(lambda x: _value(p, x), a, b, xtol=1e-18, rtol=1e-15))
            continue
        pieces += [(m, b), (a, m)]
    return None


def _finish(system, problem, log, touches, phases, final, end, peaks) -> ExactRun:
    v_peak, H_peak = peaks
    n, Omega = system.n, system.Omega
    rate, outcome = [], []
    for _, kind, _, _, _, _, speed, gap in log:
        size = v_peak if kind in ("stick", "reverse") else H_peak
        rate.append(speed / (Omega * size))
        outcome.append(abs(gap) / H_peak if H_peak > 0.0 else 1.0)
    sizes = {"velocity": v_peak or 1.0, "reaction": H_peak or 1.0}
    touch_t = np.array([touch.t for touch in touches])
    touch_margin = np.array([max(touch.value, 0.0) / sizes[touch.kind] for touch in touches])
    t = np.array([entry[0] for entry in log])
    margin = np.minimum(rate, outcome) if log else np.zeros(0)
    for i in range(len(t)):
        earlier = touch_margin[touch_t <= t[i]] if len(touch_t) else np.zeros(0)
        margin[i] = min(margin[: i + 1].min(), earlier.min(initial=np.inf))
    lowest = min(margin.min(initial=np.inf), touch_margin.min(initial=np.inf))
    return ExactRun(
        t=t,
        kind=[entry[1] for entry in log],
        q=np.array([entry[2] for entry in log]).reshape(-1, n),
        q_dot=np.array([entry[3] for entry in log]).reshape(-1, n),
        torque_before=np.array([entry[4] for entry in log]),
        torque_after=np.array([entry[5] for entry in log]),
        rate=np.array(rate),
        outcome=np.array(outcome),
        margin=margin,
        touch_t=touch_t,
        touch_margin=touch_margin,
        touch_kind=[touch.kind for touch in touches],
        initial_mode=phases[0].mode,
        final_mode=phases[-1].mode,
        final_state=final,
        min_margin=float(lowest),
        v_peak=v_peak,
        end=end,
        _phases=phases,
        _system=system,
    )
