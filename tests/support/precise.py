"""Slip and stick in 40 digits: the judge of event times and states to rounding.

The motion between events is z(t) = exp(A t) z(0) with z = (q, q_dot, 1, h, cos, sin) in mpmath. The
order of the events comes from `support.exact`; each event time is polished here by Newton from the
double found there, and each transition rule is checked anew in 40 digits.
"""

from __future__ import annotations

from dataclasses import dataclass

import mpmath as mp
from support.exact import exact_transient

DIGITS = 40
SIGN = {"slip+": 1, "slip-": -1, "stick": 0}


@dataclass
class PreciseRun:
    """Times, kinds and final state, as mpmath numbers."""

    t: list
    kind: list[str]
    final_state: list
    period: object
    min_margin: float


def precise_transient(problem, periods, initial_state=None) -> PreciseRun:
    """Follow `problem` from `initial_state` (zeros) over `periods`, with 40 digits."""
    with mp.workdps(DIGITS):
        return _follow(problem, periods, initial_state)


def _follow(problem, periods, initial_state) -> PreciseRun:
    guide = exact_transient(problem, periods, initial_state)
    n, joint = problem.n, problem.joint
    slip, stick, reaction = _matrices(problem)
    Q_m, Q_s = mp.mpf(problem.friction.Q_m), mp.mpf(problem.friction.Q_s)
    Omega = mp.mpf(problem.forcing.Omega)
    end = mp.mpf(periods) * 2 * mp.pi / Omega
    v = mp.zeros(1, slip.rows)
    v[n + joint] = 1
    state = [
        mp.mpf(float(x)) for x in (initial_state if initial_state is not None else [0] * 2 * n)
    ]
    t, mode, times = mp.mpf(0), guide.initial_mode, []
    for guess, kind in zip(guide.t, guide.kind, strict=True):
        z = _extended(problem, state, t, SIGN[mode] * Q_m)
        A = stick if mode == "stick" else slip
        row = reaction if mode == "stick" else v
        level = (1 if kind == "slip+" else -1) * Q_s if mode == "stick" else mp.mpf(0)
        tau = mp.mpf(float(guess)) - t
        now = mp.expm(A * tau) * z
        for _ in range(3):
            step = -((row * now)[0] - level) / (row * (A * now))[0]
            tau, now = tau + step, _short(A, step, now)
        t += tau
        times.append(t)
        state = [now[i] for i in range(2 * n)]
        if mode != "stick":
            state[n + joint] = mp.mpf(0)
            H = (reaction * _extended(problem, state, t, mp.mpf(0)))[0]
            held = abs(H) <= Q_s
            assert held == (kind == "stick")
            mode = "stick" if held else ("slip+" if H > 0 else "slip-")
        else:
            mode = kind
    z = _extended(problem, state, t, SIGN[mode] * Q_m)
    last = mp.expm((stick if mode == "stick" else slip) * (end - t)) * z
    final = [last[i] for i in range(2 * n)]
    return PreciseRun(times, guide.kind, final, 2 * mp.pi / Omega, guide.min_margin)


def _short(A, step, z):
    """exp(A step) z for a step of 1e-10 or less: the series ends quickly."""
    term = total = z
    for k in range(1, 8):
        term = A * term * (step / k)
        total = total + term
    return total


def _matrices(problem):
    """Slip and stick matrices, and the row of the reaction."""
    n, joint, forcing = problem.n, problem.joint, problem.forcing
    H = len(forcing.cos) - 1
    size = 2 * n + 2 + 2 * H
    M, D, K = (mp.matrix(a.tolist()) for a in (problem.M, problem.C, problem.K))
    D = D + mp.matrix(problem.G.tolist())
    balance, drift = mp.zeros(n, size), mp.zeros(size, size)
    for i in range(n):
        for j in range(n):
            balance[i, j], balance[i, n + j] = -K[i, j], -D[i, j]
        balance[i, 2 * n] = mp.mpf(float(forcing.cos[0, i]))
        for k in range(1, H + 1):
            balance[i, 2 * n + 1 + k] = mp.mpf(float(forcing.cos[k, i]))
            balance[i, 2 * n + 1 + H + k] = mp.mpf(float(forcing.sin[k, i]))
        drift[i, n + i] = 1
    balance[joint, 2 * n + 1] = -1
    for k in range(1, H + 1):
        c, s = 2 * n + 1 + k, 2 * n + 1 + H + k
        drift[c, s], drift[s, c] = -k * mp.mpf(forcing.Omega), k * mp.mpf(forcing.Omega)
    slip, stick = drift.copy(), drift.copy()
    acceleration = mp.inverse(M) * balance
    for i in range(n):
        slip[n + i, :] = acceleration[i, :]
    stick[joint, n + joint] = mp.mpf(0)
    keep = [i for i in range(n) if i != joint]
    row = balance[joint, :]
    if keep:
        inner = mp.matrix([[M[i, j] for j in keep] for i in keep])
        rows = mp.matrix([[balance[i, j] for j in range(size)] for i in keep])
        others = mp.inverse(inner) * rows
        for k, i in enumerate(keep):
            stick[n + i, :] = others[k, :]
            row = row - M[joint, i] * others[k, :]
    row[2 * n + 1] = mp.mpf(0)
    return slip, stick, row


def _extended(problem, state, t, torque):
    Omega, H = mp.mpf(problem.forcing.Omega), len(problem.forcing.cos) - 1
    turns = [mp.cos(k * Omega * t) for k in range(1, H + 1)]
    turns += [mp.sin(k * Omega * t) for k in range(1, H + 1)]
    return mp.matrix([*state, 1, torque, *turns])
