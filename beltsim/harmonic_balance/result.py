"""From solved harmonics to a `Response`.

Depends on: problem, friction, response, condensation, events, margins, phases, set_valued,
settings.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, cast

import numpy as np

from beltsim.checks import FloatArray
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance import events as phases
from beltsim.harmonic_balance.condensation import ComplexArray, Condensed, Coordinates
from beltsim.harmonic_balance.margins import margins
from beltsim.harmonic_balance.phases import SIGNS, Found, Located
from beltsim.harmonic_balance.set_valued import Solved, critical_torque, reaction_range, sprung
from beltsim.harmonic_balance.settings import Settings
from beltsim.problem import FrictionProblem
from beltsim.response import EventLog, NearGrazing, Response, Window, figures

#: A band is wide when it is above this share of the largest velocity.
WIDE_BAND = 0.1
#: A mean torque above this share of Q_m is one.
MEAN_SHARE = 1e-9


def build(
    problem: FrictionProblem,
    condensed: Condensed,
    solved: Solved,
    coordinates: Coordinates,
    settings: Settings,
    statistics: dict[str, Any],
    warnings: tuple[str, ...] = (),
) -> Response:
    """The response of one period, both ends included."""
    joint, law = cast("int", problem.joint), problem.friction
    if law is None:
        raise InvalidProblemError(Mistake("friction", None, "a law"))
    Omega, period = condensed.Omega, problem.period
    rows: ComplexArray = np.zeros((condensed.R + 1, problem.n), dtype=np.complex128)
    rows[condensed.orders] = coordinates.series
    rows[0] = mean_position(problem, condensed, solved)
    if solved.locked:  # the joint rests exactly
        rows[1:, joint] = 0.0
    torque = np.zeros(condensed.R + 1, dtype=complex)
    torque[condensed.orders], torque[0] = solved.torque, solved.mean_torque
    rates = 1j * Omega * np.arange(len(rows))[:, None] * rows
    t = np.linspace(0.0, period, settings.samples_per_period + 1)
    wave = _waves_of_period(settings.samples_per_period, len(rows))
    q, q_dot = (wave @ rows).real, (wave @ rates).real
    found, samples = _phases(problem, condensed, solved, rates[:, joint], torque, wave, t)
    peak = float(np.abs(q_dot[:, joint]).max(initial=0.0))
    events = _event_log(problem, found, rows, rates, solved.located, peak)
    q[-1], q_dot[-1] = q[0], q_dot[0]
    start = np.concatenate([q[0], q_dot[0]])
    work, viscous, loss = _energies(problem, rates, torque)
    window = Window(0.0, period, start, start, work, viscous, loss)
    judged = figures(problem, events, found.initial_mode, window)
    statistics = {**statistics, "balance_residual": coordinates.residual}
    return Response(
        problem=problem,
        t=t,
        q=q,
        q_dot=q_dot,
        friction_torque=samples,
        initial_state=start,
        final_state=start,
        initial_mode=found.initial_mode,
        events=events,
        near_grazing=NearGrazing.empty(),
        window=(0.0, period),
        periodic=True,
        coefficients=rows,
        torque_coefficients=torque,
        rest_interval=_rest_interval(problem, condensed, solved, law.Q_m),
        warnings=(
            *problem.warnings,
            *warnings,
            *problem.limit_warnings(t, q),
            *_band_warnings(law, peak),
        ),
        statistics={**statistics, "velocity_peak": peak},
        **judged._asdict(),
    )


def mean_position(problem: FrictionProblem, condensed: Condensed, solved: Solved) -> FloatArray:
    """Mean of all coordinates (n,); refuses a mean torque that nothing holds."""
    mean, Q_m = solved.mean_torque, cast("Coulomb", problem.friction).Q_m
    if abs(mean) > MEAN_SHARE * Q_m and condensed.mean_unit is None:
        allowed = "regular, or the forcing half-wave symmetric: friction has a mean torque here"
        raise InvalidProblemError(Mistake("K", "singular", allowed))
    return condensed.mean_position(mean)


@lru_cache(maxsize=8)
def _waves_of_period(samples: int, count: int) -> ComplexArray:
    """exp(i k Omega t), shape (samples + 1, count), at equal steps from 0 to T."""
    wave = _wave(2.0 * np.pi * np.arange(samples + 1) / samples, count)
    wave.flags.writeable = False
    return wave


def _wave(angle: FloatArray, count: int) -> ComplexArray:
    """exp(i k angle), shape (len(angle), count)."""
    return np.asarray(np.exp(1j * np.multiply.outer(angle, np.arange(count))))


def _phases(
    problem: FrictionProblem,
    condensed: Condensed,
    solved: Solved,
    velocity: ComplexArray,
    torque: ComplexArray,
    wave: ComplexArray,
    t: FloatArray,
) -> tuple[Found, FloatArray]:
    """Events, and the torque at the samples."""
    law = problem.friction
    if isinstance(law, SaturatedCoulomb):
        level = (wave @ velocity).real / law.sigma
        return phases.of_band(velocity, law.sigma), law.Q_m * np.clip(level, -1.0, 1.0)
    if solved.locked:
        return Found(np.zeros(0), [], "stick"), (wave @ torque).real
    if solved.located is not None:
        return solved.located.found, solved.located.torque_at(t * condensed.Omega)
    if not len(solved.bounds):
        return phases.of_signs(velocity), np.zeros(len(t))
    average = phases.averaged(condensed, solved)
    Q_m, angle = cast("Coulomb", law).Q_m, t * condensed.Omega
    found = phases.of_torque(average, Q_m)
    if not found.kinds and found.initial_mode == "stick":  # it moves, so the window is too wide
        found = phases.of_signs(velocity)
    slip = found.directions(angle)
    return found, np.where(slip == 0.0, average.at(angle), Q_m * slip)


def _event_log(
    problem: FrictionProblem,
    found: Found,
    rows: ComplexArray,
    rates: ComplexArray,
    located: Located | None,
    peak: float,
) -> EventLog:
    """States from the series; the velocity of a Coulomb joint is zero at its events."""
    if not len(found.angles):
        return EventLog.empty(problem.n)
    law, joint = problem.friction, cast("int", problem.joint)
    wave = _wave(found.angles, len(rows))
    q, q_dot = (wave @ rows).real, (wave @ rates).real
    coulomb = isinstance(law, Coulomb)
    if coulomb:
        q_dot[:, joint] = 0.0
    Q_m = law.Q_m if law is not None else 0.0
    level = np.array([SIGNS[name] for name in found.modes]) * Q_m
    before, after = level[:-1].copy(), level[1:].copy()
    for i, kind in enumerate(found.kinds):
        if coulomb and kind == "stick":  # continuous: no averaging, the law's own limit
            after[i] = before[i]
        elif coulomb and kind != "reverse":
            before[i] = after[i]
        elif not coulomb:
            before[i] = after[i] = before[i] + after[i]
    if located is not None:
        before, after = located.before, located.after
    t, kinds = found.angles / problem.forcing.Omega, np.array(found.kinds)
    return EventLog(
        t=t,
        kind=kinds,
        q=q,
        q_dot=q_dot,
        position=q[:, joint],
        torque_before=before,
        torque_after=after,
        quality=np.array(["simple"] * len(t)),
        margin=margins(problem, t, q, q_dot, kinds, rates[:, joint], peak),
    )


def _energies(
    problem: FrictionProblem, rates: ComplexArray, torque: ComplexArray
) -> tuple[float, float, float]:
    """Work of the forcing, viscous loss and friction loss over one period, from the series."""
    half = 0.5 * problem.period
    force = problem.forcing.coefficients
    count = min(len(force), len(rates))
    work = half * float(np.sum(force[:count] * np.conj(rates[:count])).real)
    viscous = half * float(np.sum(np.conj(rates) * (rates @ problem.C)).real)
    loss = half * float(np.sum(torque * np.conj(rates[:, problem.joint])).real)
    return work, viscous, loss


def _rest_interval(
    problem: FrictionProblem, condensed: Condensed, solved: Solved, Q_m: float
) -> tuple[float, float] | None:
    """Rest positions of a locked joint; None when it moves or the exact law would let it."""
    if not solved.locked or critical_torque(condensed) > Q_m:
        return None
    if condensed.mean_unit is None:
        return None if sprung(condensed) else (-np.inf, np.inf)
    low, high = reaction_range(condensed)
    free, unit = condensed.mean_free[problem.joint], condensed.mean_unit[problem.joint]
    ends = sorted((float(free - unit * (Q_m - high)), float(free - unit * (-Q_m - low))))
    return ends[0], ends[1]


def _band_warnings(law: Any, peak: float) -> list[str]:
    if not isinstance(law, SaturatedCoulomb) or not 0.0 < WIDE_BAND * peak < law.sigma:
        return []
    return [
        f"the band sigma = {law.sigma:g} is wide against the largest joint velocity {peak:.3g}: "
        "the law is viscous rather than dry there"
    ]
