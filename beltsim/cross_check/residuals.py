r"""Is it a solution? A motion put back into the equations, on a grid, by quadrature alone.

With the impulse of every term since the start of the period,

.. math:: M\,\Delta\dot q + (C + G)\,\Delta q + K\!\int q + e_j\!\int h - \int f = 0,

no second derivative is needed, so a jump of the friction torque does no harm. Nothing here is
shared with a solver, nor with what derives the figures of a `Response`.

Depends on: checks, friction; cross_check.motion.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from beltsim.checks import FloatArray
from beltsim.cross_check.motion import Motion
from beltsim.friction import SaturatedCoulomb

#: Size at which a row counts at least, as a share of the largest. An impulse over the square root
#: of its row's mass is a velocity in units that all rows share. No integrator controls one velocity
#: more closely than its tolerance times the largest: rtol 1e-9 over the 1e-5 allowed to a residual.
SMALL_ROW = 1e-4


class Residuals(NamedTuple):
    r"""By how much a motion misses what a steady motion must meet; all relative.

    Parameters
    ----------
    torque : float
        Largest excess of the friction torque over Q_s.
    direction : float
        Largest power that friction feeds in where it may only take out (h v < 0), over Q_m times
        the largest velocity.
    sliding : float
        Missing dissipation, 1 - int h v / int Q_m |v|: zero when h = Q_m sgn v wherever it moves.
    equation : float
        Largest impulse left over in a row, over the largest of the row's terms; a row that is small
        beside the others is measured as if it had `SMALL_ROW` of the largest.
    period : float
        Largest change of the state over the period, over its largest entry; velocities over Omega.
    energy : float
        Work and losses that do not balance, over the largest of them.
    """

    torque: float
    direction: float
    sliding: float
    equation: float
    period: float
    energy: float

    @property
    def worst(self) -> float:
        """The largest of them."""
        return max(self)


def residuals(motion: Motion) -> Residuals:
    """Residuals of a motion.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing, event_map
    >>> from beltsim.cross_check.motion import motion_of
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4))
    >>> orbit = event_map.periodic(one, event_map.Settings(samples_per_period=2000))
    >>> residuals(motion_of(orbit)).worst < 1e-8
    True
    """
    return Residuals(*_law(motion), _equation(motion), _period(motion), _energy(motion))


def _law(motion: Motion) -> tuple[float, float, float]:
    """Residuals of the friction law: torque, direction, sliding."""
    law: Any = motion.problem.friction
    joint = motion.problem.joint
    if law.Q_m == 0.0:
        return max(float(np.abs(piece.torque).max()) for piece in motion.pieces), 0.0, 0.0
    limit = law.Q_m if isinstance(law, SaturatedCoulomb) else law.Q_s
    band = law.sigma if isinstance(law, SaturatedCoulomb) else 0.0
    excess = against = done = possible = 0.0
    peak = max(float(np.abs(piece.q_dot[:, joint]).max()) for piece in motion.pieces)
    for piece in motion.pieces:
        v, h = piece.q_dot[:, joint], piece.torque
        excess = max(excess, float(np.abs(h).max()) / limit - 1.0)
        against = max(against, float(-(h * v).min()))
        lost = law.Q_m * np.minimum(np.abs(v), v**2 / band if band else np.inf)
        done += float(piece.integral(h * v)[-1])
        possible += float(piece.integral(lost)[-1])
    if peak == 0.0 or possible <= 0.0:
        return excess if excess > 0.0 else 0.0, 0.0, 0.0
    return max(excess, 0.0), max(against, 0.0) / (law.Q_m * peak), abs(1.0 - done / possible)


def _equation(motion: Motion) -> float:
    """Largest impulse left over in any row, relative to the size of that row, see `SMALL_ROW`."""
    problem, joint = motion.problem, motion.problem.joint
    start = motion.pieces[0]
    t0, q0, v0 = start.t[0], start.q[0], start.q_dot[0]
    damping = problem.C + problem.G
    spring, rub = np.zeros(problem.n), 0.0
    largest = np.zeros((5, problem.n))
    left = np.zeros(problem.n)
    for piece in motion.pieces:
        sprung = spring + piece.integral(piece.q, piece.q_dot)
        rubbed = rub + piece.integral(piece.torque)
        friction = np.zeros_like(sprung)
        friction[:, joint] = rubbed
        terms = (
            (piece.q_dot - v0) @ problem.M.T,
            (piece.q - q0) @ damping.T,
            sprung @ problem.K.T,
            friction,
            -_impulse(motion, piece.t, t0),
        )
        largest = np.maximum(largest, [np.abs(term).max(axis=0) for term in terms])
        left = np.maximum(left, np.abs(sum(terms)).max(axis=0))
        spring, rub = sprung[-1], float(rubbed[-1])
    weight = 1.0 / np.sqrt(np.diag(problem.M))
    size = weight * largest.max(axis=0)
    top = float(size.max())
    return float((weight * left / np.maximum(size, SMALL_ROW * top)).max()) if top > 0.0 else 0.0


def _impulse(motion: Motion, t: FloatArray, t0: float) -> FloatArray:
    """Integral of the forcing from `t0` to each time, (nt, n)."""
    forcing = motion.problem.forcing
    rate = forcing.Omega * np.arange(1, len(forcing.cos))
    found = np.multiply.outer(t - t0, forcing.cos[0])
    for k, w in enumerate(rate.tolist(), start=1):
        wave = (np.sin(w * t) - np.sin(w * t0), np.cos(w * t0) - np.cos(w * t))
        found += (np.outer(wave[0], forcing.cos[k]) + np.outer(wave[1], forcing.sin[k])) / w
    return np.asarray(found)


def _force(motion: Motion, t: FloatArray) -> FloatArray:
    forcing = motion.problem.forcing
    angle = np.multiply.outer(forcing.Omega * t, np.arange(len(forcing.cos)))
    return np.asarray(np.cos(angle) @ forcing.cos + np.sin(angle) @ forcing.sin)


def _period(motion: Motion) -> float:
    first, last = motion.pieces[0], motion.pieces[-1]
    Omega = motion.problem.forcing.Omega
    start = np.concatenate([first.q[0], first.q_dot[0] / Omega])
    end = np.concatenate([last.q[-1], last.q_dot[-1] / Omega])
    size = float(np.abs(end).max())
    change = float(np.abs(end - start).max())
    return change / size if size > 0.0 else change


def _energy(motion: Motion) -> float:
    problem, joint = motion.problem, motion.problem.joint
    sums = np.zeros(3)
    for piece in motion.pieces:
        v = piece.q_dot
        powers = (
            np.sum(_force(motion, piece.t) * v, axis=1),
            -np.sum((v @ problem.C) * v, axis=1),
            -piece.torque * v[:, joint],
        )
        sums += [piece.integral(power)[-1] for power in powers]
    first, last = motion.pieces[0], motion.pieces[-1]
    before = _stored(motion, first.q[0], first.q_dot[0])
    after = _stored(motion, last.q[-1], last.q_dot[-1])
    size = max(float(np.abs(sums).max()), before, after)
    return abs(float(sums.sum()) - (after - before)) / size if size > 0.0 else 0.0


def _stored(motion: Motion, q: FloatArray, v: FloatArray) -> float:
    return 0.5 * float(v @ motion.problem.M @ v + q @ motion.problem.K @ q)
