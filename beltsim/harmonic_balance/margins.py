r"""How far each event of a series is from its other outcome; `EventLog.margin` has the meaning.

The reaction that would hold the joint, and its rate, follow from the state at the event and the
equations of motion alone (q: the other coordinates, t: the joint, at rest; B = C + G):

.. math:: M_{qq}\ddot q = f_q - B_{qq}\dot q - K_{qq}q - K_{qt}\theta, \qquad
          H = f_t - M_{tq}\ddot q - B_{tq}\dot q - K_{tq}q - K_{tt}\theta .

The second derivatives of the series, which converge badly, are not needed. A margin is as good as
the instant: with the averaged torque of exact Coulomb friction both are known to :math:`O(1/R)`.

Depends on: checks, problem, friction.
"""

from __future__ import annotations

from typing import cast

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.problem import FrictionProblem


def margins(
    problem: FrictionProblem,
    t: FloatArray,
    q: FloatArray,
    q_dot: FloatArray,
    kind: NDArray[np.str_],
    velocity: NDArray[np.complex128],
    peak: float,
) -> FloatArray:
    """Margins (ne,) of events at `t` in the states `q`, `q_dot` (ne, n).

    `velocity`: harmonics (R + 1,) of the joint's velocity; `peak`: its largest value.
    """
    law, Omega = problem.friction, problem.forcing.Omega
    if isinstance(law, SaturatedCoulomb):
        spin = 1j * Omega * np.arange(len(velocity))
        rate = (np.exp(np.multiply.outer(t, spin)) @ (spin * velocity)).real
        return np.asarray(np.abs(rate) / (Omega * peak))
    Q_s = cast("float", cast("Coulomb", law).Q_s)
    reaction, rate = _reaction(problem, t, q, q_dot)
    size = max(Q_s, float(np.abs(reaction).max(initial=0.0)))
    if size == 0.0:  # no friction, and no force on the joint at any of its stops
        return np.zeros(len(t))
    leaves = (kind == "slip+") | (kind == "slip-")
    return np.where(leaves, np.abs(rate) / (Omega * size), np.abs(np.abs(reaction) - Q_s) / size)


def _reaction(
    problem: FrictionProblem, t: FloatArray, q: FloatArray, q_dot: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The holding reaction (ne,) and its rate in the held motion."""
    joint, others = cast("int", problem.joint), problem.others
    M, B, K = problem.M, problem.C + problem.G, problem.K
    series = problem.forcing.coefficients
    spin = 1j * problem.forcing.Omega * np.arange(len(series))
    wave = np.exp(np.multiply.outer(t, spin))
    force, force_rate = (wave @ series).real, (wave @ (spin[:, None] * series)).real
    speed = q_dot.copy()
    speed[:, joint] = 0.0
    inner = M[np.ix_(others, others)]
    speed_rate = np.zeros_like(speed)
    left = force - speed @ B.T - q @ K.T
    speed_rate[:, others] = np.linalg.solve(inner, left[:, others].T).T
    left_rate = force_rate - speed_rate @ B.T - speed @ K.T
    jerk = np.linalg.solve(inner, left_rate[:, others].T).T
    row = M[joint, others]
    return (
        left[:, joint] - speed_rate[:, others] @ row,
        left_rate[:, joint] - jerk @ row,
    )
