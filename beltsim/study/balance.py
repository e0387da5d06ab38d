"""Harmonic balance for static friction above the kinetic: an orbit in time says what is meant.

With Q_s > Q_m the balance needs the pattern of events. Solvers must not ask each other, so it is
fetched here: from the exact orbit, or from any response at hand.

Depends on: errors, friction, problem, response, event_map, harmonic_balance.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from beltsim import event_map, harmonic_balance
from beltsim.errors import InvalidProblemError, NotPeriodicError
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem
from beltsim.response import Response


def pattern_of(response: Response) -> harmonic_balance.Pattern:
    """Events of the last forcing period of `response`, as a pattern for harmonic balance.

    Raises
    ------
    InvalidProblemError
        When fewer than two events lie in it, or they do not lead back to where they began.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4))
    >>> pattern_of(event_map.propagate(one, 30.25)).kind
    ('stick', 'slip-', 'stick', 'slip+')
    """
    log, period = response.events, response.problem.period
    initial_mode, end = response.initial_mode or "stick", response.window[1]
    modes = np.array([initial_mode, *log.modes_after(initial_mode)])
    last = np.flatnonzero((log.t >= end - period) & (log.t < end))
    if not len(last):
        text = "no event in its last period, and a pattern needs two: the joint rests"
        raise InvalidProblemError(f"this response gives no pattern: {text}")
    phase = np.mod(log.t[last], period)
    order = np.argsort(phase, kind="stable")
    kinds = tuple(log.kind[last][order].tolist())
    return harmonic_balance.Pattern(kinds, phase[order], str(modes[last[order[0]]]))


def balance(
    problem: FrictionProblem, R: int = 15, settings: harmonic_balance.Settings | None = None
) -> Response:
    """`harmonic_balance.solve`; where Q_s > Q_m, with the pattern of the exact orbit.

    Parameters
    ----------
    problem, R, settings
        As for `harmonic_balance.solve`. A pattern that is given is used.

    Returns
    -------
    Response
        With ``statistics["pattern_from"] = "event_map"`` where the pattern was fetched; warnings
        of the orbit about its stability or about others beside it are kept.

    Raises
    ------
    NotPeriodicError
        When the event map finds no orbit of the forcing's own period.
    InvalidProblemError, UnsupportedLawError, ConvergenceError
        As `harmonic_balance.solve`.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4, 0.5))
    >>> balance(one).events.kind.tolist()
    ['stick', 'slip-', 'stick', 'slip+']
    """
    settings, law = settings or harmonic_balance.Settings(), problem.friction
    given = settings.pattern is not None
    if given or problem.joint is None or not isinstance(law, Coulomb) or law.Q_s == law.Q_m:
        return harmonic_balance.solve(problem, R, settings)
    try:
        orbit = event_map.periodic(problem, event_map.Settings(samples_per_period=1, harmonics=0))
    except NotPeriodicError as error:
        reason = str(error).partition("; try")[0]
        raise NotPeriodicError(
            f"for Q_s > Q_m harmonic balance needs an orbit that repeats each forcing period, and "
            f"the event map found none: {reason}. Look at a transient (beltsim run), or for longer "
            "periods with the event map (beltsim events --max-multiple 3)"
        ) from None
    if len(orbit.events):
        chosen = replace(settings, pattern=pattern_of(orbit))
        found = harmonic_balance.solve(problem, R, chosen)
    else:  # at rest the kinetic torque does not matter
        static = problem.with_friction(Coulomb(law.Q_s or 0.0))
        found = replace(harmonic_balance.solve(static, R, settings), problem=problem)
    about = (
        text.partition("; give")[0]
        for text in orbit.warnings
        if "unstable" in text or "locked" in text
    )
    return replace(
        found,
        warnings=(*found.warnings, *about),
        statistics={**found.statistics, "pattern_from": "event_map"},
    )
