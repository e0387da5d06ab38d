"""`solve`: one problem, one periodic response by harmonic balance.

Depends on: errors, problem, friction, response, condensation, set_valued, _instants, pattern,
saturated, result, settings.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np

from beltsim.errors import ConvergenceError, InvalidProblemError, Mistake, UnsupportedLawError
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance import _instants, saturated, set_valued
from beltsim.harmonic_balance.condensation import Condensed, Coordinates, condense
from beltsim.harmonic_balance.pattern import Pattern
from beltsim.harmonic_balance.result import build
from beltsim.harmonic_balance.set_valued import Solved
from beltsim.harmonic_balance.settings import Settings, is_integer
from beltsim.problem import FrictionProblem, require_problem
from beltsim.response import Response

#: The difference to a solution with 2R + 5 harmonics, or with about half of R, times this.
TO_MORE, TO_FEWER = 4.0, 2.0
#: Harmonics above which the second solution has fewer: one with more would cost ten times as much.
MANY = 100
#: Largest unbalanced load of any harmonic, relative, of a result that counts as converged.
BALANCED = 1e-6
DEFAULTS = Settings()


def solve(problem: FrictionProblem, R: int = 15, settings: Settings | None = None) -> Response:
    r"""Periodic response with harmonics up to `R` of the forcing.

    Exact Coulomb friction (`Coulomb` with Q_s = Q_m) is solved as it stands, without a band: from
    a cold start, for any torque. With Q_s > Q_m the response need not be unique: the pattern of its
    events, `Settings(pattern=...)`, says which one is meant, and the switching instants are solved
    for. The saturated law is solved by the paper's method.

    Parameters
    ----------
    problem : FrictionProblem
        With a joint.
    R : int
        Highest harmonic, at least that of the forcing. The error of the joint's coordinate falls
        with 1/R. Odd for the saturated law.
    settings : Settings, optional

    Returns
    -------
    Response
        One forcing period. `coefficients` and `torque_coefficients` hold the series; the events are
        the located ones of a pattern, else those of the torque averaged over T/(R + 1), see
        `beltsim.harmonic_balance.events`.
        `statistics` holds the residual history, the gap and the balance found by independent
        checks, ``Q_cr``, ``Q_cr_R`` and the ``error_estimate``: expected rms error of the joint's
        coordinate (its mean left out).

    Raises
    ------
    InvalidProblemError
        For an R or settings that cannot be used, a resonance without damping, a mean load on a
        singular K, or a problem without joint.
    UnsupportedLawError
        For Q_s > Q_m without a pattern.
    ConvergenceError
        With the residual history, the best iterate in `partial`, and what to try; for a pattern
        that does not settle, or leads to a motion that breaks the law.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4))
    >>> found = solve(one, R=31)
    >>> found.events.kind.tolist(), round(found.statistics["Q_cr_R"], 2)
    (['stick', 'slip-', 'stick', 'slip+'], 1.0)
    """
    settings = settings or DEFAULTS
    condensed, solved, coordinates = solved_series(problem, R, settings)
    law = problem.friction
    statistics = _statistics(condensed, solved, settings, _method(law, settings))
    if settings.estimate:
        statistics["error_estimate"] = _estimate(problem, condensed, solved, settings)
    warnings = _gap_warnings(solved, settings, law)
    if settings.pattern is None:
        warnings = _lock_warnings(condensed, law) + warnings
    return build(problem, condensed, solved, coordinates, settings, statistics, warnings)


def solved_series(
    problem: FrictionProblem, R: int, settings: Settings
) -> tuple[Condensed, Solved, Coordinates]:
    """The condensed problem, the joint's harmonics and all others; raises what `solve` raises."""
    _check(problem, R, settings)
    condensed = condense(problem, int(R), _harmonics(settings))
    try:
        solved = _solved(condensed, problem.friction, settings)
    except ConvergenceError as error:
        raise _with_response(error, problem, condensed, settings) from None
    coordinates = condensed.coordinates(solved.torque)
    if not coordinates.residual <= BALANCED:
        message = (
            f"the harmonics leave {coordinates.residual:.2g} of the load unbalanced at Omega = "
            f"{condensed.Omega:.6g}: the linear system is too ill-conditioned there; "
            "try more damping or another frequency"
        )
        unbalanced = ConvergenceError(message, solved, solved.residuals)
        raise _with_response(unbalanced, problem, condensed, settings)
    return condensed, solved, coordinates


def _method(law: Any, settings: Settings) -> str:
    if isinstance(law, SaturatedCoulomb):
        return "saturated"
    return "set_valued" if settings.pattern is None else "pattern"


def _is_sampled(method: str, settings: Settings) -> bool:
    """Whether the torque is known at samples only."""
    return method != "pattern" and settings.samples_torque(saturated=method == "saturated")


def _harmonics(settings: Settings) -> str:
    """A pattern says nothing of symmetry: all harmonics are kept."""
    return settings.harmonics if settings.pattern is None else "all"


def _check(problem: FrictionProblem, R: Any, settings: Settings) -> None:
    require_problem(problem)
    law = problem.friction
    mistakes = []
    if not isinstance(settings, Settings):
        raise InvalidProblemError(Mistake("settings", settings, "harmonic_balance.Settings"))
    if not is_integer(R, 1):
        mistakes.append(Mistake("R", R, "an integer >= 1"))
    elif isinstance(law, SaturatedCoulomb) and R % 2 == 0:
        mistakes.append(Mistake("R", R, "odd for the saturated law"))
    if problem.joint is None:
        allowed = "an index: without a joint use beltsim.linear.response"
        mistakes.append(Mistake("joint", None, allowed))
    if settings.pattern is not None:
        mistakes += _pattern_mistakes(problem, settings)
    if mistakes:
        raise InvalidProblemError(mistakes)
    settings.samples_for(int(R))
    if settings.pattern is None and isinstance(law, Coulomb) and cast("float", law.Q_s) > law.Q_m:
        message = (
            f"with Q_s = {law.Q_s:g} > Q_m = {law.Q_m:g} the periodic response is not unique: say "
            "which one is meant by the pattern of its events, from an orbit found in time: "
            "Settings(pattern=Pattern(orbit.events.kind, orbit.events.t, orbit.initial_mode))"
        )
        raise UnsupportedLawError(message)


def _pattern_mistakes(problem: FrictionProblem, settings: Settings) -> list[Mistake]:
    law = problem.friction
    refused = {
        "None for this law": not isinstance(law, Coulomb),
        "None without friction": isinstance(law, Coulomb) and not law.Q_s,
        "None without forcing": not np.any(problem.forcing.coefficients[1:]),
    }
    return [
        Mistake("settings.pattern", settings.pattern, allowed)
        for allowed, wrong in refused.items()
        if wrong
    ]


def _solved(condensed: Condensed, law: Any, settings: Settings, moves: bool = False) -> Solved:
    if isinstance(law, SaturatedCoulomb):
        return saturated.solve(condensed, law, settings)
    if settings.pattern is not None:
        return _instants.solve(condensed, law, settings.pattern)
    return set_valued.solve(condensed, law.Q_m, settings, moves)


def _with_response(
    error: ConvergenceError,
    problem: FrictionProblem,
    condensed: Condensed,
    settings: Settings,
) -> ConvergenceError:
    """The same error, carrying the best iterate as a `Response`."""
    if not isinstance(error.partial, Solved):
        return error
    statistics: dict[str, Any] = {
        "solver": "harmonic_balance",
        "method": _method(problem.friction, settings),
    }
    statistics["converged"] = False
    coordinates = condensed.coordinates(error.partial.torque)
    partial = build(problem, condensed, error.partial, coordinates, settings, statistics)
    return ConvergenceError(str(error), partial, error.residual_history)


def _statistics(
    condensed: Condensed, solved: Solved, settings: Settings, method: str
) -> dict[str, Any]:
    return {
        "solver": "harmonic_balance",
        "method": method,
        "projection": "sampled" if _is_sampled(method, settings) else "exact",
        "R": condensed.R,
        "half_wave": condensed.half_wave,
        "divisor": condensed.divisor,
        "harmonics": len(condensed.orders),
        "cells": len(solved.levels),
        "iterations": solved.iterations,
        "residual_history": solved.residuals,
        "complementarity_gap": solved.gap,
        "converged": True,
        "locked": solved.locked,
        "Q_cr": set_valued.critical_torque(condensed),
        "Q_cr_R": set_valued.critical_bound(condensed),
    }


def _lock_warnings(condensed: Condensed, law: Any) -> tuple[str, ...]:
    """Between Q_cr(R) and Q_cr the truncated problem is locked and the exact one is not."""
    Q_cr, Q_cr_R = set_valued.critical_torque(condensed), set_valued.critical_bound(condensed)
    if not isinstance(law, Coulomb) or not Q_cr_R <= law.Q_m < Q_cr * (1.0 - 1e-9):
        return ()
    return (
        f"Q_m = {law.Q_m:.6g} lies between Q_cr(R) = {Q_cr_R:.6g}, from which {condensed.R} "
        f"harmonics lock the joint, and Q_cr = {Q_cr:.6g}, from which it really locks: use more "
        "harmonics",
    )


def _gap_warnings(solved: Solved, settings: Settings, law: Any) -> tuple[str, ...]:
    """A gap above the one asked for is accepted up to `ACCEPTED_GAP`, but never in silence."""
    method = _method(law, settings)
    if method == "saturated" and solved.gap > saturated.DISCREPANT:
        return (
            f"too few samples: harmonics of the torque differ by up to {solved.gap:.2g} Q_m from "
            "those of the law; take more samples or projection='exact'",
        )
    if method != "set_valued" or _is_sampled(method, settings) or solved.gap <= settings.tolerance:
        return ()
    return (
        f"the torque misses its law by a gap of {solved.gap:.2g}, above the tolerance "
        f"{settings.tolerance:g}: cells cannot be cut finer; use fewer harmonics or accept it",
    )


def _estimate(
    problem: FrictionProblem, condensed: Condensed, solved: Solved, settings: Settings
) -> float | None:
    """Four times the rms difference of the joint's coordinate to a solution with 2R + 5 harmonics.

    The error falls at least like 1/R, so the larger solution has at most about half of it;
    the rest of the factor is for edges that both place alike. Above `MANY` harmonics, twice the
    difference to a solution with half as many: about the same. None when that one is not found.
    """
    law = problem.friction
    other, factor = _second(problem, condensed.R, solved.locked)
    if settings.samples is not None:
        settings = replace(settings, samples=max(settings.samples, 2 * other + 1))
    if solved.located is not None:
        events = solved.located.found
        nearer = Pattern(tuple(events.kinds), events.angles / condensed.Omega, events.initial_mode)
        settings = replace(settings, pattern=nearer)
    compared = condense(problem, other, _harmonics(settings))
    try:
        second = _solved(compared, law, settings, moves=other > condensed.R and not solved.locked)
    except ConvergenceError:
        return None
    if solved.locked and second.locked:
        return 0.0
    highest = max(condensed.R, other)
    theta = np.zeros((2, highest + 1), dtype=complex)
    for row, (view, found) in zip(theta, ((condensed, solved), (compared, second)), strict=True):
        row[view.orders] = found.velocity / (1j * view.orders * view.Omega)
    difference = float(np.sqrt(0.5 * np.sum(np.abs(theta[0] - theta[1]) ** 2)))
    return factor * difference


def _second(problem: FrictionProblem, R: int, locked: bool) -> tuple[int, float]:
    """Harmonics of the solution to compare with, on no common grid of cells, and the factor.

    A locked joint is compared with more: with fewer harmonics it would be locked all the more.
    """
    fewer = (R - 5) // 2 | 1
    if R > MANY and not locked and fewer >= len(problem.forcing.coefficients) - 1:
        return fewer, TO_FEWER
    return 2 * R + 5, TO_MORE
