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

An event that moves by :math:`\delta` adds an impulse to the torque, the jump of h there times
:math:`-\delta`; the same linear equations tell what the impulse does to v and to the holding
torque, which is the derivative. Where forcing and pattern change sign after half a period, one half
is solved for.

Depends on: errors, friction, condensation, phases, pattern, set_valued, _tail.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np
from numpy.polynomial import legendre
from numpy.polynomial.polynomial import polyval

from beltsim.checks import FloatArray
from beltsim.errors import ConvergenceError
from beltsim.friction import Coulomb
from beltsim.harmonic_balance._tail import harmonics, integrated, powers, starts, terms
from beltsim.harmonic_balance.condensation import ComplexArray, Condensed
from beltsim.harmonic_balance.pattern import Pattern
from beltsim.harmonic_balance.phases import SIGNS, Found, Located, sorted_log
from beltsim.harmonic_balance.set_valued import Solved

#: Coefficients of a holding torque at least and at most, and the velocity at rest, over the size of
#: the motion, at which they suffice.
LEAST_COUNT, MOST_COUNT, AT_REST = 12, 96, 1e-8
#: Largest change of an instant, in radians, that counts as settled.
SETTLED = 1e-10
#: Difference, in radians, up to which one half of a pattern is the mirror image of the other.
MIRRORED = 1e-8
#: Points per phase at which it is seen whether a stick rests, and whether the law holds.
RESTING, JUDGE = 101, 400
#: Largest violation of the law, relative.
ACCEPTED = 1e-4
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
    equations = Instants(condensed, law, pattern)
    try:
        motion = equations.rested(equations.motion(equations.given))
        for _ in range(MOST_ROUNDS):
            motion = equations.settle(motion, history)
            now = equations.rested(motion)
            if now is motion:
                break
            motion = now
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
    torque = np.zeros(len(condensed.orders), dtype=complex)
    torque[equations.kept] = motion.torque
    return Solved(
        torque,
        condensed.velocity - condensed.mobility * torque,
        equations.mean(motion),
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

    `angles` (p,); `torque` (nS,) harmonics; `parts` (p, count): Legendre coefficients of the torque
    in each phase; `starts` (p, J + 1): its integrals where phases begin; `residual` (p,): v/V where
    a slip phase ends, h/Q_s -+ 1 where a stick phase does; `derivative` (p, p) by `angles`.
    """

    angles: FloatArray
    torque: ComplexArray
    parts: FloatArray
    starts: FloatArray
    residual: FloatArray
    derivative: FloatArray


class Instants:
    """The equations for one problem and pattern; p events, of half a period where that suffices."""

    def __init__(self, condensed: Condensed, law: Coulomb, pattern: Pattern) -> None:
        self.condensed, self.law = condensed, law
        angles, signs = pattern.angles(condensed.Omega), [SIGNS[mode] for mode in pattern.modes]
        self.half_wave = _is_half_wave(condensed, angles, np.array(signs))
        self.mirror, half = (-1, len(angles) // 2) if self.half_wave else (1, len(angles))
        self.given, self.signs = angles[:half], np.array(signs[: half + 1])
        self.turn = np.pi if self.half_wave else 2.0 * np.pi
        #: Places in `condensed.orders` of the harmonics that are present, equally spaced.
        self.kept = np.flatnonzero(
            condensed.orders % (2 if self.half_wave else 1) == self.half_wave
        )
        self.orders = np.asarray(condensed.orders[self.kept], dtype=np.float64)
        self.alpha = terms(condensed)
        tail = (1j * self.orders[:, None]) ** -np.arange(1.0, len(self.alpha) + 1.0) @ self.alpha
        self.free, self.rest = condensed.velocity[self.kept], condensed.mobility[self.kept] - tail
        self.size = float(np.abs(condensed.velocity).sum())
        self.sticks = np.flatnonzero(self.signs[1:] == 0.0)
        #: Highest integral of the torque; one more than v needs, to close the period.
        self.top = len(self.alpha) + 1
        self.count = self._first_count()

    def _first_count(self) -> int:
        """Coefficients per holding torque: enough for the waves of harmonic R in the longest."""
        if not len(self.sticks):
            return 1
        longest = np.diff(self.ends(self.given))[self.sticks].max()
        wanted = 0.5 * float(longest * self.orders[-1]) + LEAST_COUNT
        return min(8 * math.ceil(wanted / 8), MOST_COUNT)

    def ends(self, angles: FloatArray) -> FloatArray:
        """Bounds (p + 1,) of the phases."""
        return np.append(angles, angles[0] + self.turn)

    def mean(self, motion: Motion) -> float:
        """Mean torque."""
        lengths = np.diff(self.ends(motion.angles))
        return 0.0 if self.half_wave else float(lengths @ motion.parts[:, 0] / self.turn)

    def motion(self, angles: FloatArray) -> Motion:
        """The motion with events at `angles` (p,), ascending within a turn.

        Columns below: the slip torque, each coefficient of the holding torques, an impulse at each
        event.
        """
        ends, p = self.ends(angles), len(angles)
        lengths, held = np.diff(ends), len(self.sticks) * self.count
        parts = self._parts(held, p)
        waves = self._waves(ends, held)
        growth = (0.5 * lengths[:, None]) ** np.arange(self.top + 1)
        inner = growth[:, :, None] * (_ends_of_integrals(self.count, self.top) @ parts)
        impulses = np.zeros((p, parts.shape[2]))
        impulses[:, 1 + held :] = np.eye(p)
        begun = starts(lengths, inner, impulses, self.mirror)
        slope, free_slope = self._slopes(ends, waves, begun)
        found = np.eye(1 + held + p)[:, [0, *range(1 + held, 1 + held + p)]]
        if held:
            slope[:, 0] += free_slope
            right = -slope[:, [0, *range(1 + held, 1 + held + p)]]
            found[1 : 1 + held] = np.linalg.solve(slope[:, 1 : 1 + held], right)
        # from here on: column 0 the motion, then what impulses do to it
        waves, parts, begun = found.T @ waves, parts @ found, begun @ found
        motion = Motion(angles, waves[0], parts[:, :, 0], begun[:, :, 0], angles, angles)
        residual, derivative = self._conditions(motion, lengths, waves, parts, begun)
        return motion._replace(residual=residual, derivative=derivative)

    def _parts(self, held: int, p: int) -> FloatArray:
        """Legendre coefficients (p, count, columns) in each phase."""
        parts = np.zeros((p, self.count, 1 + held + p))
        parts[:, 0, 0] = self.signs[1:] * self.law.Q_m
        for place, i in enumerate(self.sticks):
            first = 1 + place * self.count
            parts[i, :, first : first + self.count] = np.eye(self.count)
        return parts

    def _waves(self, ends: FloatArray, held: int) -> ComplexArray:
        """Harmonics (columns, nS)."""
        p = len(ends) - 1
        at_events = np.exp(-1j * np.multiply.outer(ends, self.orders))
        waves = np.empty((1 + held + p, len(self.orders)), dtype=complex)
        level = self.signs[1:] * self.law.Q_m
        waves[0] = level @ (at_events[:-1] - at_events[1:]) / (1j * np.pi * self.orders)
        if held:
            i = self.sticks
            found = harmonics(self.orders, ends[i], ends[i + 1], self.count)
            waves[1 : 1 + held] = found.reshape(held, -1)
        waves[1 + held :] = at_events[:-1] / np.pi
        return np.asarray((2.0 if self.half_wave else 1.0) * waves)

    def _slopes(
        self, ends: FloatArray, waves: ComplexArray, begun: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """V' at the Gauss points of all stick phases: of each column, and without torque."""
        s, local = _collocation(self.count, self.top)
        lengths = np.diff(ends)[self.sticks]
        u = 0.5 * np.multiply.outer(lengths, s + 1.0)
        tau = (ends[self.sticks, None] + u).ravel()
        wave = np.exp(1j * np.multiply.outer(tau, self.orders)) * (1j * self.orders)
        slope = _real_product(wave, -(self.rest * waves).T)
        tail = powers(u, self.top) @ (self._weights(1) @ begun[self.sticks])
        slope -= tail.reshape(slope.shape)
        for place, length in enumerate(lengths):
            here = slice(place * self.count, (place + 1) * self.count)
            growth = self.alpha * (0.5 * length) ** np.arange(len(self.alpha))
            slope[here, 1 + here.start : 1 + here.stop] -= np.tensordot(
                growth, local[: len(growth)], 1
            )
        return slope, _real_product(wave, self.free)

    def _weights(self, times: int) -> FloatArray:
        """Of the integrals at a phase's start in the m-th power of u in the tail of v (or v')."""
        weights = np.zeros((self.top + 1, self.top + 1))
        for m in range(self.top + 1):
            for j in range(max(m + times, 1), len(self.alpha) + 1):
                weights[m, j - times - m] = self.alpha[j - 1]
        return weights

    def _conditions(
        self,
        motion: Motion,
        lengths: FloatArray,
        waves: ComplexArray,
        parts: FloatArray,
        begun: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Residual and derivative; event i begins phase i."""
        k, alternating = np.arange(self.count), (-1.0) ** np.arange(self.count)
        wave = np.exp(1j * np.multiply.outer(motion.angles, self.orders))
        v = _real_product(wave, -(self.rest * waves).T) - (self._weights(0)[0] @ begun)
        v[:, 0] += _real_product(wave, self.free)
        slope = _real_product(wave * (1j * self.orders), self.free - self.rest * motion.torque)
        first = np.einsum("k,ikc->ic", alternating, parts)
        last = np.roll(parts.sum(axis=1), 1, axis=0)
        bent = np.roll(motion.parts @ (k * (k + 1.0)) / lengths, 1)
        last[0] *= self.mirror
        bent[0] *= self.mirror
        slope -= self._weights(1)[0] @ motion.starts.T + self.alpha[0] * first[:, 0]
        jump, Q_s = first[:, 0] - last[:, 0], cast("float", self.law.Q_s)
        slips = self.signs[:-1] != 0.0
        value = np.where(slips, v[:, 0] / self.size, last[:, 0] / Q_s - self.signs[1:])
        by_jump = np.where(slips[:, None], v[:, 1:] / self.size, last[:, 1:] / Q_s)
        moving = np.where(slips, slope / self.size, bent / Q_s)
        return value, np.diag(moving) - by_jump * jump

    def velocity(
        self, motion: Motion, s: FloatArray, times: int = 0, legendres: FloatArray | None = None
    ) -> FloatArray:
        """v, or its derivative, (p, len(s)), at local abscissae s of all phases.

        `legendres` are the values there of all P_k that its polynomials need.
        """
        if legendres is None:
            legendres = np.asarray(legendre.legvander(s, self.count + self.top - 1))
        ends, smooth = self.ends(motion.angles), self.free - self.rest * motion.torque
        lengths = np.diff(ends)
        u = 0.5 * np.multiply.outer(lengths, s + 1.0)
        turn = np.exp(1j * (ends[:-1, None] + u))
        every = turn * turn if self.half_wave else turn
        v = (turn * polyval(every, smooth * (1j * self.orders) ** times)).real
        weights = self._weights(times)
        v -= np.einsum("ism,im->is", powers(u, self.top), motion.starts @ weights.T)
        inner = integrated(self.count, self.top)
        for j, alpha in enumerate(self.alpha, start=1 - times):
            within = motion.parts @ inner[j].T
            v -= alpha * (0.5 * lengths[:, None]) ** j * (within @ legendres.T)
        return np.asarray(v)

    def _on_grid(self, motion: Motion, points: int) -> FloatArray:
        s, legendres = _grid(points, self.count + self.top)
        return self.velocity(motion, s, 0, legendres)

    def rested(self, motion: Motion) -> Motion:
        """The motion with more and more coefficients, until its stick phases rest."""
        while len(self.sticks) and self.count < MOST_COUNT:
            moved = np.ptp(self._on_grid(motion, RESTING)[self.sticks], axis=1)
            if moved.max() <= AT_REST * self.size:
                break
            self.count = min(2 * self.count, MOST_COUNT)
            motion = self.motion(motion.angles)
        return motion

    def settle(self, now: Motion, history: list[float]) -> Motion:
        """Newton's method on the instants; `history` keeps the residuals."""
        for _ in range(MOST_STEPS):
            history.append(float(np.abs(now.residual).max()))
            step = -np.linalg.solve(now.derivative, now.residual)
            if not np.all(np.isfinite(step)):
                break
            room = np.diff(self.ends(now.angles))
            closing = -np.diff(np.append(step, step[0]))
            tight = closing > 0.0
            share = float((0.5 * room[tight] / closing[tight]).min(initial=1.0))
            now = self.motion(now.angles + share * step)
            if np.abs(step).max() < SETTLED:
                return now
        raise _unsettled(self.condensed, self.law, history)

    def violation(self, motion: Motion) -> tuple[float, str]:
        """How far the motion is from Coulomb's law, relative, and in what."""
        v = self._on_grid(motion, JUDGE)
        legendres = _grid(JUDGE, self.count + self.top)[1][:, : self.count]
        slopes = self.velocity(motion, np.array([-1.0]), 1)[:, 0]
        peak, Q_s = float(np.abs(v).max()), cast("float", self.law.Q_s)
        worst = (0.0, "")
        for i, (values, sign) in enumerate(zip(v, self.signs[1:], strict=True)):
            if sign:
                turned = float((-sign * values).max()) / peak
                worst = max(worst, (turned, "the joint slips against its direction"))
            else:
                moved = float(np.abs(values).max()) / peak
                held = float(np.abs(legendres @ motion.parts[i]).max()) / Q_s - 1.0
                worst = max(worst, (moved, "the joint does not rest while it sticks"))
                worst = max(worst, (held, "sticking needs more than Q_s"))
            if sign and self.signs[i]:  # event i is a reversal: what torque would stop it?
                needed = sign * (sign * self.law.Q_m + slopes[i] / self.alpha[0]) / Q_s
                worst = max(worst, (1.0 - needed, "the joint would stick where it is to reverse"))
        return worst

    def whole(self, motion: Motion) -> tuple[FloatArray, FloatArray]:
        """Bounds and Legendre coefficients of the phases of a whole period."""
        ends, parts = self.ends(motion.angles), motion.parts
        if self.half_wave:
            ends, parts = np.append(ends, ends[1:] + np.pi), np.concatenate([parts, -parts])
        return ends, parts


def _is_half_wave(condensed: Condensed, angles: FloatArray, signs: FloatArray) -> bool:
    """Whether forcing and pattern change sign after half a period."""
    half = len(angles) // 2
    if len(angles) % 2 or np.any(condensed.velocity[condensed.orders % 2 == 0]):
        return False
    apart = angles[half:] - angles[:half] - np.pi
    return bool(np.all(signs[half:] == -signs[: half + 1]) and np.abs(apart).max() <= MIRRORED)


def _real_product(wave: ComplexArray, series: ComplexArray) -> FloatArray:
    """Re(wave @ series), at half the cost of the complex product."""
    return np.asarray(wave.real @ series.real - wave.imag @ series.imag)


@lru_cache(maxsize=32)
def _collocation(count: int, top: int) -> tuple[FloatArray, FloatArray]:
    """Gauss points, and the integrals (top + 1, count, count) of all P_k there."""
    s = np.asarray(legendre.leggauss(count)[0])
    return s, np.asarray(legendre.legvander(s, count + top - 1) @ integrated(count, top))


@lru_cache(maxsize=32)
def _ends_of_integrals(count: int, top: int) -> FloatArray:
    """Integrals (top + 1, count) of all P_k at 1; row 0, the functions themselves, left out."""
    found: FloatArray = integrated(count, top).sum(axis=1)
    found[0] = 0.0
    return found


@lru_cache(maxsize=16)
def _grid(points: int, count: int) -> tuple[FloatArray, FloatArray]:
    """Equally spaced abscissae, and P_k there, k < count."""
    s = np.linspace(-1.0, 1.0, points)
    return s, np.asarray(legendre.legvander(s, count - 1))


def _located(equations: Instants, motion: Motion, pattern: Pattern) -> Located:
    """Events in the order of one period, the torque on both sides, and at any angle."""
    law, signs = equations.law, np.array([SIGNS[mode] for mode in pattern.modes])
    ends, parts = equations.whole(motion)
    at_start = parts @ (-1.0) ** np.arange(parts.shape[1])
    before = np.where(signs[:-1] == 0.0, signs[1:] * cast("float", law.Q_s), signs[:-1] * law.Q_m)
    found: Found = sorted_log(ends[:-1], pattern.kind, pattern.modes[1:])
    order = np.argsort(np.mod(ends[:-1], 2.0 * np.pi), kind="stable")

    def torque_at(angle: FloatArray) -> FloatArray:
        turned = ends[0] + np.mod(angle - ends[0], 2.0 * np.pi)
        phase = np.minimum(np.searchsorted(ends, turned, side="right") - 1, len(ends) - 2)
        s = 2.0 * (turned - ends[phase]) / np.diff(ends)[phase] - 1.0
        legendres = legendre.legvander(s, parts.shape[1] - 1)
        return np.asarray(np.einsum("sk,sk->s", legendres, parts[phase]))

    return Located(found, before[order], at_start[order], torque_at)
