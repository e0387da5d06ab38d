r"""Maps of figures: what is wanted of thousands of periodic orbits, without their motion.

`survey` finds the same orbits as `solve_many` and keeps a row of numbers of each. The figures have
the definitions of `response.figures`; here they come from mode codes directly.

Depends on: many, orbit, locked, integrals, shooting, settings, walk, errors, problem.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import BeltsimError, InvalidProblemError, Mistake
from beltsim.event_map.integrals import integrals
from beltsim.event_map.linear_part import ComplexArray
from beltsim.event_map.locked import at_rest, rest_place, resting_multipliers, steady_rms
from beltsim.event_map.many import in_chunks
from beltsim.event_map.orbit import found_orbit
from beltsim.event_map.settings import Settings, settled
from beltsim.event_map.shooting import Shooting
from beltsim.event_map.walk import KIND, STATE
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem, listed_problems


@dataclass(frozen=True, eq=False)
class Survey:
    """Figures of k periodic orbits of n coordinates, in the order of the problems.

    Parameters
    ----------
    rms : (k, n)
        Root mean square of each coordinate over the orbit, mean included.
    dissipated_energy, stick_fraction, velocity_reversals, stops_per_period : (k,)
        As in `Response`; the energy per forcing period, also of an orbit that takes several.
    multipliers : (k, 2n) complex
        Floquet multipliers.
    initial_state : (k, 2n)
        State at t = 0.
    locked : (k,) of bool
        The joint never moves; figures are at the middle of its rest interval.
    failures : mapping of int to BeltsimError
        Why a problem has no row; its numbers are NaN.
    """

    rms: FloatArray
    dissipated_energy: FloatArray
    stick_fraction: FloatArray
    velocity_reversals: FloatArray
    stops_per_period: FloatArray
    multipliers: ComplexArray
    initial_state: FloatArray
    locked: NDArray[np.bool_]
    failures: Mapping[int, BeltsimError]

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __len__(self) -> int:
        return len(self.stick_fraction)


def survey(
    problems: Iterable[FrictionProblem],
    settings: Settings | None = None,
    workers: int | None = None,
) -> Survey:
    """Figures of the periodic orbit of each problem, for maps; quicker than `solve_many`.

    Parameters
    ----------
    problems : iterable of FrictionProblem
        All of n coordinates. Those of one linear system next to each other, in the order of their
        friction.
    settings : Settings, optional
        `tolerance` and `max_multiple` count; nothing is sampled.
    workers : int, optional
        Threads; default: one per core that this process may use.

    Returns
    -------
    Survey
        The same bits for any number of workers.

    Raises
    ------
    InvalidProblemError
        When `workers` is not a positive integer, or the problems differ in n.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[1.0]], 0, push, Coulomb(0.2))
    >>> found = survey([one.with_friction(Coulomb(Q)) for Q in (0.2, 0.6, 1.2)])
    >>> found.stick_fraction.round(3).tolist(), found.locked.tolist()
    ([0.0, 0.235, 1.0], [False, False, True])
    """
    settings = settled(settings)
    problems = listed_problems(problems)
    sizes = {problem.n for problem in problems}
    if len(sizes) > 1:
        raise InvalidProblemError(Mistake("problems", f"n of {sorted(sizes)}", "all of one n"))

    def solve(chunk: list[FrictionProblem]) -> list[_Row | BeltsimError]:
        return _chunk(chunk, settings)

    return _table(in_chunks(solve, problems, workers), sizes.pop() if sizes else 0)


@dataclass(frozen=True, eq=False)
class _Row:
    """One orbit: its numbers in the order of `Survey`."""

    rms: FloatArray
    figures: tuple[float, float, float, float]
    multipliers: ComplexArray
    state: FloatArray
    locked: bool


def _table(rows: list[_Row | BeltsimError], n: int) -> Survey:
    k = len(rows)
    rms, state = np.full((k, n), np.nan), np.full((k, 2 * n), np.nan)
    figures, multipliers = np.full((4, k), np.nan), np.full((k, 2 * n), np.nan, complex)
    locked = np.zeros(k, bool)
    failures: dict[int, BeltsimError] = {}
    for i, row in enumerate(rows):
        if isinstance(row, BeltsimError):
            failures[i] = row
            continue
        rms[i], figures[:, i], multipliers[i] = row.rms, row.figures, row.multipliers
        state[i], locked[i] = row.state, row.locked
    loss, stick, reversals, stops = figures.copy()
    failed = MappingProxyType(failures)
    return Survey(rms, loss, stick, reversals, stops, multipliers, state, locked, failed)


def _chunk(problems: list[FrictionProblem], settings: Settings) -> list[_Row | BeltsimError]:
    """Rows of one linear system, each orbit from the one before."""
    rows: list[_Row | BeltsimError] = []
    guess = None
    for problem in problems:
        try:
            found = found_orbit(problem, settings, guess)
            if isinstance(found, Shooting):
                rows.append(_moving(problem, found))
                guess = found.state if found.multiple == 1 else guess
            else:
                rows.append(_resting(problem, found))
        except BeltsimError as error:
            rows.append(error)
    return rows


def _resting(problem: FrictionProblem, rest: tuple[float, float]) -> _Row:
    place = rest_place(rest)
    figures = (0.0, 1.0, 0.0, 0.0)
    state, rms = at_rest(problem, place), steady_rms(problem, place)
    return _Row(rms, figures, resting_multipliers(problem), state, True)


def _moving(problem: FrictionProblem, found: Shooting) -> _Row:
    run = found.run
    over = integrals(problem, run, 0.0, run.end, energies=False)
    rms: FloatArray = np.sqrt(np.maximum(over.squares, 0.0) / run.end)
    multipliers = found.multipliers
    return _Row(rms, _figures(problem, found, over.rubbed), multipliers, found.state, False)


def _figures(
    problem: FrictionProblem, found: Shooting, rubbed: float
) -> tuple[float, float, float, float]:
    """Dissipated energy, stick fraction, velocity reversals and stops, per forcing period."""
    run, law, joint = found.run, problem.friction, problem.joint or 0
    assert law is not None
    modes: list[int] = run.modes().tolist()
    times = [0.0, *run.t.tolist(), run.end]
    places = [run.initial_state[joint], *run.reals[:, STATE + joint], run.final_state[joint]]
    stuck = travel = 0.0
    for i, mode in enumerate(modes):
        if mode:
            travel += abs(places[i + 1] - places[i])
        else:
            stuck += times[i + 1] - times[i]
    stops = int(np.count_nonzero(run.integers[:, KIND] == 0))
    often = 1
    if found.half:  # the other half is the mirror image
        modes, often = [*modes, *(-mode for mode in modes)], 2
    loss: Any = rubbed if isinstance(law, SaturatedCoulomb) else law.Q_m * travel
    slips = [mode for mode in modes if mode]
    changes = sum(a != b for a, b in zip(slips, slips[-1:] + slips[:-1], strict=True))
    each = 1.0 / found.multiple
    reversals = max(0.0, (each * changes - 2.0) / 4.0)
    return each * often * float(loss), stuck / run.end, reversals, each * often * stops
