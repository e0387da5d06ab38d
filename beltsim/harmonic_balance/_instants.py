r"""Coulomb friction with given phases: the switching instants and the holding torque are unknowns.

The torque is +-Q_m where the joint slips and a polynomial where it sticks. Harmonics up to R see
the full mobility A_r, all others its expansion T_r at high frequency (`_tail`): with
:math:`\tau = \Omega t`,

.. math:: v(\tau) = \mathrm{Re}\sum_{r \le R} [A_r F_r - (A_r - T_r) h_r] e^{ir\tau}
          - \sum_j \frac{\alpha_j}{\Omega^j} (I^j h)(\tau),

I^j the j-th periodic integral. Nothing is cut off, so v has its kinks exactly at the events, rests
exactly and has no ripples; the conditions hold pointwise. In a stick phase v' = 0 at Gauss points
gives the holding torque (an equation of the second kind, since
:math:`v' = -(\alpha_1/\Omega)(h - \bar h) + \ldots`: well conditioned). Left is one condition per
event, solved by Newton's method: v = 0 where a slip phase ends, |h| = Q_s where a stick phase does.

Depends on: errors, friction, condensation, phases, pattern, set_valued, _tail.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np
from numpy.polynomial import legendre

from beltsim.checks import FloatArray
from beltsim.errors import ConvergenceError
from beltsim.friction import Coulomb
from beltsim.harmonic_balance._tail import Phases, harmonics, terms
from beltsim.harmonic_balance.condensation import ComplexArray, Condensed
from beltsim.harmonic_balance.pattern import Pattern
from beltsim.harmonic_balance.phases import SIGNS, Found, Located, sorted_log
from beltsim.harmonic_balance.set_valued import Solved

#: Coefficients of a holding torque at first and at most, and the velocity at rest, over the size of
#: the motion, at which they suffice.
FIRST_COUNT, MOST_COUNT, AT_REST = 12, 96, 1e-8
#: Step of differences; share of the last residual below which their derivative is kept; largest
#: change of an instant, in radians, that counts as settled.
STEP, FALL, SETTLED = 1e-7, 0.1, 1e-10
#: Where it is seen whether a stick phase rests.
RESTING = np.linspace(-1.0, 1.0, 101)
#: Largest violation of the law, relative, and points per phase at which it is looked for.
ACCEPTED, JUDGE = 1e-4, 400
#: Most steps of Newton's method, and rounds of it between which stick phases get more coefficients.
MOST_STEPS, MOST_ROUNDS = 30, 4


def solve(condensed: Condensed, law: Coulomb, pattern: Pattern) -> Solved:
    """The response with the given pattern.

    Raises
    ------
    InvalidProblemError
        When the pattern lasts longer than a forcing period.
    ConvergenceError
        When the instants do not settle, or the motion breaks the law: a stick phase that would need
        more than Q_s, a slip phase that turns back, a reversal that Q_s would stop.
    """
    history: list[float] = []
    given = pattern.angles(condensed.Omega)
    equations = Instants(condensed, law, pattern)
    try:
        equations.refine(given)
        for _ in range(MOST_ROUNDS):
            motion = equations.settle(given, history)
            counts = list(equations.counts)
            equations.refine(motion.angles)
            if counts == equations.counts:
                break
            given = motion.angles
    except np.linalg.LinAlgError:
        raise _unsettled(condensed, law, history) from None
    gap, what = equations.violation(motion)
    if not gap <= ACCEPTED:
        message = (
            f"the pattern {', '.join(pattern.kind)} is no response at Omega = "
            f"{condensed.Omega:.6g}, Q_m = {law.Q_m:.6g}, Q_s = {law.Q_s:.6g}: {what} (by "
            f"{gap:.2g}, relative); try another pattern, or another R ({condensed.R} now)"
        )
        raise ConvergenceError(message, None, tuple(history))
    return Solved(
        motion.torque,
        condensed.velocity - condensed.mobility * motion.torque,
        motion.mean_torque,
        np.zeros(0),
        np.zeros(0),
        False,
        gap,
        len(history),
        tuple(history),
        located=_located(equations, motion, pattern),
    )


def _unsettled(condensed: Condensed, law: Coulomb, history: list[float]) -> ConvergenceError:
    least = f"residual {min(history):.2g} after {len(history)} steps" if history else "singular"
    message = (
        f"the switching instants did not settle ({least}) at Omega = {condensed.Omega:.6g}, Q_m = "
        f"{law.Q_m:.6g}, Q_s = {law.Q_s:.6g}: try a pattern closer to the response, or more "
        f"harmonics than {condensed.R}"
    )
    return ConvergenceError(message, None, tuple(history))


class Motion(NamedTuple):
    """The joint's motion for given instants.

    `torque` (nS,) harmonics; `mean_torque`; `parts`: Legendre coefficients of the torque in each
    phase; `residual` (p,): v/V where a slip phase ends, h/Q_s -+ 1 where a stick phase does.
    """

    angles: FloatArray
    torque: ComplexArray
    mean_torque: float
    parts: list[FloatArray]
    residual: FloatArray
    phases: Phases
    smooth: ComplexArray


class Instants:
    """The equations for one problem and pattern."""

    def __init__(self, condensed: Condensed, law: Coulomb, pattern: Pattern) -> None:
        self.condensed, self.law = condensed, law
        self.signs = np.array([SIGNS[mode] for mode in pattern.modes])
        self.alpha = terms(condensed)
        self.orders = np.asarray(condensed.orders, dtype=np.float64)
        powers = (1j * self.orders[:, None]) ** -np.arange(1.0, len(self.alpha) + 1.0)
        self.rest = condensed.mobility - powers @ self.alpha
        self.size = float(np.abs(condensed.velocity).sum())
        self.counts = [FIRST_COUNT if sign == 0.0 else 1 for sign in self.signs[1:]]

    def motion(self, angles: FloatArray) -> Motion:
        """The motion with events at `angles` (p,), ascending within a turn."""
        ends = np.append(angles, angles[0] + 2.0 * np.pi)
        waves, parts = self._columns(ends)
        phases = Phases(ends, parts)
        x = self._held(phases, waves)
        torque = x @ waves
        solved = [part @ x for part in parts]
        mean = sum(np.diff(ends) * [part[0] for part in solved]) / (2.0 * np.pi)
        kept = Phases(ends, [part[:, None] for part in solved])
        smooth = self.condensed.velocity - self.rest * torque
        found = Motion(angles, torque, float(mean), solved, np.zeros(0), kept, smooth)
        return found._replace(residual=self._conditions(found))

    def velocity(self, motion: Motion, phase: int, s: FloatArray, times: int = 0) -> FloatArray:
        """v, or its derivative, at local abscissae s of a phase."""
        wave, tail = self._velocity(motion.phases, motion.smooth[None, :], phase, s, times)
        return np.asarray((wave - tail)[:, 0])

    def _velocity(
        self, phases: Phases, rows: ComplexArray, phase: int, s: FloatArray, times: int
    ) -> tuple[FloatArray, FloatArray]:
        """The series part and the tail of v (or v') at s, one column per row and per function."""
        start, end = phases.ends[phase : phase + 2]
        tau = start + 0.5 * (s + 1.0) * (end - start)
        wave = np.exp(1j * np.multiply.outer(tau, self.orders)) * (1j * self.orders) ** times
        return (wave @ rows.T).real, phases.weighted(self.alpha, 1 - times, phase, s)

    def _columns(self, ends: FloatArray) -> tuple[ComplexArray, list[FloatArray]]:
        """Harmonics and Legendre parts: column 0 the slip torque, then each stick coefficient."""
        total = 1 + sum(n for n, sign in zip(self.counts, self.signs[1:], strict=True) if not sign)
        waves, parts = [np.zeros((1, len(self.orders)), dtype=complex)], []
        for i, count in enumerate(self.counts):
            found = harmonics(self.orders, ends[i], ends[i + 1], count)
            part = np.zeros((count, total))
            if self.signs[i + 1]:
                level = self.signs[i + 1] * self.law.Q_m
                waves[0] = waves[0] + level * found
                part[0, 0] = level
            else:
                first = sum(len(rows) for rows in waves)
                part[:, first : first + count] = np.eye(count)
                waves.append(found)
            parts.append(part)
        return np.concatenate(waves), parts

    def _held(self, phases: Phases, waves: ComplexArray) -> FloatArray:
        """(1, holding torques), from v' = 0 at Gauss points of the stick phases."""
        rows, right = [], []
        for i, count in enumerate(self.counts):
            if self.signs[i + 1]:
                continue
            s = _gauss_points(count)
            wave, tail = self._velocity(phases, -self.rest * waves, i, s, 1)
            slope = wave - tail
            free, _ = self._velocity(phases, self.condensed.velocity[None, :], i, s, 1)
            rows.append(slope[:, 1:])
            right.append(-free[:, 0] - slope[:, 0])
        if not rows:
            return np.ones(1)
        return np.append(1.0, np.linalg.solve(np.concatenate(rows), np.concatenate(right)))

    def _conditions(self, motion: Motion) -> FloatArray:
        wanted = np.empty(len(self.counts))
        for i in range(len(self.counts)):  # event i ends the phase before it
            if self.signs[i]:
                wanted[i] = self.velocity(motion, i, np.array([-1.0]))[0] / self.size
            else:
                wanted[i] = motion.parts[i - 1].sum() / self.law.Q_s - self.signs[i + 1]
        return wanted

    def refine(self, angles: FloatArray) -> None:
        """Double the coefficients of the stick phases that do not rest, until they do."""
        while True:
            now, short = self.motion(angles), []
            for i in np.flatnonzero(self.signs[1:] == 0.0):
                moved = float(np.ptp(self.velocity(now, int(i), RESTING))) / self.size
                if moved > AT_REST and 2 * self.counts[i] <= MOST_COUNT:
                    short.append(int(i))
            if not short:
                return
            for phase in short:
                self.counts[phase] *= 2

    def settle(self, angles: FloatArray, history: list[float]) -> Motion:
        """Newton's method on the instants; `history` keeps the residuals.

        The derivative is taken anew where a step did not lower the residual by `FALL`.
        """
        now, derivative = self.motion(angles), None
        for _ in range(MOST_STEPS):
            size = float(np.abs(now.residual).max())
            if derivative is None or not size <= FALL * history[-1]:
                derivative = self.derivative(now)
            history.append(size)
            step = -np.linalg.solve(derivative, now.residual)
            if not np.all(np.isfinite(step)):
                break
            room = np.diff(np.append(angles, angles[0] + 2.0 * np.pi))
            closing = -np.diff(np.append(step, step[0]))
            tight = closing > 0.0
            share = float((0.5 * room[tight] / closing[tight]).min(initial=1.0))
            angles = angles + share * step
            now = self.motion(angles)
            if np.abs(step).max() < SETTLED:
                return now
        raise _unsettled(self.condensed, self.law, history)

    def derivative(self, motion: Motion) -> FloatArray:
        """Derivative (p, p) of the conditions, by differences."""
        columns = [
            self.motion(motion.angles + STEP * unit).residual - motion.residual
            for unit in np.eye(len(motion.angles))
        ]
        return np.asarray(np.array(columns).T / STEP)

    def violation(self, motion: Motion) -> tuple[float, str]:
        """How far the motion is from Coulomb's law, relative, and in what."""
        s = np.linspace(-1.0, 1.0, JUDGE)
        v = [self.velocity(motion, i, s) for i in range(len(self.counts))]
        peak = max(float(np.abs(values).max()) for values in v)
        Q_s = cast("float", self.law.Q_s)
        worst = (0.0, "")
        for i, (values, sign) in enumerate(zip(v, self.signs[1:], strict=True)):
            if sign:
                turned = float((-sign * values).max()) / peak
                worst = max(worst, (turned, "the joint slips against its direction"))
            else:
                moved = float(np.abs(values).max()) / peak
                held = float(np.abs(legendre.legval(s, motion.parts[i])).max()) / Q_s - 1.0
                worst = max(worst, (moved, "the joint does not rest while it sticks"))
                worst = max(worst, (held, "sticking needs more than Q_s"))
            if sign and self.signs[i]:  # event i is a reversal: what torque would stop it?
                slope = self.velocity(motion, i, np.array([-1.0]), 1)[0]
                needed = sign * (sign * self.law.Q_m + slope / self.alpha[0]) / Q_s
                worst = max(worst, (1.0 - needed, "the joint would stick where it is to reverse"))
        return worst


@lru_cache(maxsize=32)
def _gauss_points(count: int) -> FloatArray:
    return np.asarray(legendre.leggauss(count)[0])


def _located(equations: Instants, motion: Motion, pattern: Pattern) -> Located:
    """Events in the order of one period, the torque on both sides, and at any angle."""
    signs, ends, law = equations.signs, motion.phases.ends, equations.law
    starts = np.array([float(legendre.legval(-1.0, part)) for part in motion.parts])
    before = np.where(signs[:-1] == 0.0, signs[1:] * cast("float", law.Q_s), signs[:-1] * law.Q_m)
    found: Found = sorted_log(motion.angles, pattern.kind, pattern.modes[1:])
    order = np.argsort(np.mod(motion.angles, 2.0 * np.pi), kind="stable")

    def torque_at(angle: FloatArray) -> FloatArray:
        turned = ends[0] + np.mod(angle - ends[0], 2.0 * np.pi)
        phase = np.minimum(np.searchsorted(ends, turned, side="right") - 1, len(ends) - 2)
        torque: FloatArray = np.empty_like(turned)
        for i, part in enumerate(motion.parts):
            here = phase == i
            s = 2.0 * (turned[here] - ends[i]) / (ends[i + 1] - ends[i]) - 1.0
            torque[here] = legendre.legval(s, part)
        return torque

    return Located(found, before[order], starts[order], torque_at)
