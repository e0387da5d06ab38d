"""x'' + x + f sgn(x') = cos(beta t) with stops, in 40 digits.

From rest at t0 in the direction s,

    x(t) = -s f + V cos(beta t) + a cos(t - t0) + b sin(t - t0),     V = 1/(1 - beta^2),

a and b from x(t0) = x0, x'(t0) = 0. It stops at the first later zero of x', found on a fine grid
and bisected; it stays while |cos(beta t) - x| <= f, and goes where that is exceeded, at
cos(beta t) = x + s f. Motion with stops forgets its start within a few half periods, down to the
last digit, since only the place of rest is carried over.
"""

from typing import Any

import mpmath as mp
import numpy as np

#: beta, f: one stop per half period, then two, three and four.
CASES = ((0.6, 0.6), (0.2, 0.3), (0.1, 0.4), (0.08, 0.4))
DIGITS, PERIODS, GRID = 40, 16, 1000


def events(beta: float, f: float) -> list[tuple[str, float, float]]:
    """Kind, time over the period and place of each event of one period, by time."""
    with mp.workdps(DIGITS):
        return _events(mp.mpf(beta), mp.mpf(f))


def _events(beta: Any, f: Any) -> list[tuple[str, float, float]]:
    t, x, log = mp.mpf(0), mp.mpf(0), []
    period = 2 * mp.pi / beta
    while t < PERIODS * period:
        H = mp.cos(beta * t) - x
        s = 1 if H > 0 else -1
        if abs(H) <= f:
            t, s = _release(t, x, beta, f)
            log.append(("slip+" if s > 0 else "slip-", t, x))
        t, x = _stop(t, x, s, beta, f)
        held = abs(mp.cos(beta * t) - x) <= f
        log.append(("stick" if held else "reverse", t, x))
    last = [each for each in log if each[1] >= (PERIODS - 1) * period]
    return [
        (kind, float(at / period - (PERIODS - 1)), float(place))
        for kind, at, place in last
        if at < PERIODS * period
    ]


def _release(t: Any, x: Any, beta: Any, f: Any) -> tuple[Any, int]:
    """First time after `t` at which |cos(beta t) - x| passes f, and its direction."""
    found = []
    for s in (1, -1):
        level = x + s * f
        if abs(level) <= 1:
            angle = mp.acos(level)
            # cos rises through the level at -angle, falls through it at +angle
            first = -s * angle
            turns = mp.ceil((beta * t - first) / (2 * mp.pi) + mp.mpf(10) ** (5 - DIGITS))
            found.append(((first + 2 * mp.pi * turns) / beta, s))
    return min(found)


def _stop(t0: Any, x0: Any, s: int, beta: Any, f: Any) -> tuple[Any, Any]:
    """Time and place of the first zero of x' after t0."""
    V = 1 / (1 - beta**2)
    a = x0 + s * f - V * mp.cos(beta * t0)
    b = beta * V * mp.sin(beta * t0)

    def velocity(t: Any) -> Any:
        return -beta * V * mp.sin(beta * t) - a * mp.sin(t - t0) + b * mp.cos(t - t0)

    step = np.pi / GRID
    tau = step * np.arange(1, int(2.0 / float(beta) + 2.0) * GRID)
    rough = -float(beta * V) * np.sin(float(beta) * (float(t0) + tau))
    rough += -float(a) * np.sin(tau) + float(b) * np.cos(tau)
    i = int(np.argmax(s * rough < 0.0))
    low, high = t0 + tau[i - 1], t0 + tau[i]
    if i == 0 or s * velocity(low) <= 0 or s * velocity(high) >= 0:
        raise ValueError(f"beta = {beta}, f = {f}: the grid misses a stop after {t0}")
    while high - low > mp.mpf(10) ** (4 - DIGITS):
        t = (low + high) / 2
        low, high = (t, high) if s * velocity(t) > 0 else (low, t)
    t = (low + high) / 2
    place = -s * f + V * mp.cos(beta * t) + a * mp.cos(t - t0) + b * mp.sin(t - t0)
    return t, place
