r"""Phases of the joint, read from the torque of a truncated series.

**Exact Coulomb friction.** While the joint sticks, the truncated velocity ripples about zero and
the torque switches between its bounds; only the torque's average over a ripple has a meaning: it is
the reaction that holds the joint. So the torque is averaged over a window of :math:`w = T/(R + 1)`.
Where the average is at a bound for a while, the joint slips; a stretch between, longer than 1.5 w,
is a stick (the window's width taken off); a shorter one is a reversal at its middle when the sign
changes, and nothing when it does not. Instants are thus known to about w/2.

**Saturated law.** Events are the located roots of v = sigma and v = -sigma.

Depends on: reversals, condensation, phases, set_valued.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from beltsim.checks import FloatArray
from beltsim.harmonic_balance.condensation import ComplexArray, Condensed
from beltsim.harmonic_balance.phases import Found, sorted_log
from beltsim.harmonic_balance.reversals import sign_change_angles
from beltsim.harmonic_balance.set_valued import Solved

#: A stretch between slips is a stick when it is longer than this many windows.
SHORTEST_STICK = 1.5
SLIP = {1: "slip+", -1: "slip-"}


class Averaged(NamedTuple):
    """The torque averaged over a window: piecewise linear between `angles`, 0 to 2 pi."""

    angles: FloatArray
    values: FloatArray
    window: float

    def at(self, angle: FloatArray) -> FloatArray:
        """Averages at the angles Omega t."""
        return np.interp(np.mod(angle, 2.0 * np.pi), self.angles, self.values)


def averaged(condensed: Condensed, solved: Solved) -> Averaged:
    """Moving average of the torque over T/(R + 1)."""
    d = condensed.divisor
    turns = 2.0 * np.pi / d * np.arange(d)
    bounds = np.concatenate([*(solved.bounds[:-1] / d + turn for turn in turns), [2.0 * np.pi]])
    levels = np.tile(solved.levels, d)
    window = 2.0 * np.pi / (condensed.R + 1)
    area = np.concatenate([[0.0], np.cumsum(levels * np.diff(bounds))])
    ends = np.mod(np.concatenate([bounds - 0.5 * window, bounds + 0.5 * window]), 2.0 * np.pi)
    angles = np.unique(np.concatenate([[0.0], ends, [2.0 * np.pi]]))
    mean = area[-1] / (2.0 * np.pi)

    def integral(angle: FloatArray) -> FloatArray:
        ripple = np.interp(np.mod(angle, 2.0 * np.pi), bounds, area - mean * bounds)
        return np.asarray(ripple + mean * angle)

    values = (integral(angles + 0.5 * window) - integral(angles - 0.5 * window)) / window
    return Averaged(angles, values, window)


def of_torque(average: Averaged, Q_m: float) -> Found:
    """Events from the averaged torque of exact Coulomb friction."""
    runs = _slip_runs(average, Q_m)
    if not runs:
        return Found(np.zeros(0), [], "stick")
    log: list[tuple[float, str, str]] = []
    for (sign, _, end), (following, start, _) in zip(runs, [*runs[1:], runs[0]], strict=True):
        length = np.mod(start - end, 2.0 * np.pi)
        if length > SHORTEST_STICK * average.window:
            log.append((end + 0.5 * average.window, "stick", "stick"))
            log.append((start - 0.5 * average.window, SLIP[following], SLIP[following]))
        elif sign != following:
            log.append((end + 0.5 * length, "reverse", SLIP[following]))
    if not log:
        return Found(np.zeros(0), [], SLIP[runs[0][0]])
    return sorted_log(*zip(*log, strict=True))


def of_band(velocity: ComplexArray, sigma: float) -> Found:
    """Events of the saturated law, for a velocity series (R + 1,)."""
    log: list[tuple[float, str, str]] = []
    slopes = 1j * np.arange(len(velocity)) * velocity
    for sign in (1, -1):
        shifted = velocity.copy()
        shifted[0] -= sign * sigma
        for angle in sign_change_angles(shifted):
            rising = (np.exp(1j * angle * np.arange(len(slopes))) @ slopes).real > 0.0
            leaves = rising == (sign > 0)
            kind = SLIP[sign] if leaves else "stick"
            log.append((float(angle), kind, kind))
    if not log:
        start = float(velocity.real.sum())
        mode = "stick" if abs(start) < sigma else SLIP[1 if start > 0.0 else -1]
        return Found(np.zeros(0), [], mode)
    return sorted_log(*zip(*log, strict=True))


def of_signs(velocity: ComplexArray) -> Found:
    """Events without friction: every sign change is a reversal."""
    angles = sign_change_angles(velocity)
    start = float((np.exp(1e-9j * np.arange(len(velocity))) @ velocity).real)
    if len(angles) == 0:
        return Found(angles, [], "stick" if start == 0.0 else SLIP[1 if start > 0.0 else -1])
    return Found(angles, ["reverse"] * len(angles), SLIP[1 if start > 0.0 else -1])


def _slip_runs(average: Averaged, Q_m: float) -> list[tuple[int, float, float]]:
    """Stretches (sign, start, end) in which the average is at a bound, in order on the circle."""
    saturated = np.where(np.abs(average.values) >= Q_m * (1.0 - 1e-6), np.sign(average.values), 0.0)
    runs: list[tuple[int, float, float]] = []
    for i in range(len(saturated) - 1):
        sign = int(saturated[i])
        if sign == 0 or saturated[i + 1] != sign:
            continue
        start, end = float(average.angles[i]), float(average.angles[i + 1])
        if runs and runs[-1][0] == sign and runs[-1][2] == start:
            runs[-1] = (sign, runs[-1][1], end)
        else:
            runs.append((sign, start, end))
    whole = len(runs) > 1 and runs[0][1] == 0.0 and runs[-1][2] == average.angles[-1]
    if whole and runs[0][0] == runs[-1][0]:  # one run that passes the end of the period
        sign, start, _ = runs.pop()
        runs[0] = (sign, start - 2.0 * np.pi, runs[0][2])
    return runs
