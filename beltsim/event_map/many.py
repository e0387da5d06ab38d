"""`solve_many`: the periodic orbits of a grid, on all cores.

Problems that share their linear system (`with_friction`) and follow each other form a chunk: its
modes are computed once, and each orbit starts from the one before. Chunks are independent, so the
result does not depend on the number of workers.

Depends on: orbit, settings, errors, problem, response.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from itertools import groupby
from typing import TypeVar

from beltsim.errors import BeltsimError, InvalidProblemError, Mistake
from beltsim.event_map.orbit import orbit_response
from beltsim.event_map.settings import Settings, settled
from beltsim.problem import FrictionProblem, listed_problems
from beltsim.response import Response

T = TypeVar("T")


def solve_many(
    problems: Iterable[FrictionProblem],
    settings: Settings | None = None,
    workers: int | None = None,
) -> list[Response | BeltsimError]:
    """`periodic` for each problem; a failure leaves its error in the list.

    Parameters
    ----------
    problems : iterable of FrictionProblem
        Those of one linear system next to each other, in the order of their friction.
    settings : Settings, optional
        The same for all. For maps of figures `survey` is quicker.
    workers : int, optional
        Threads; default: one per core that this process may use.

    Returns
    -------
    list of Response or BeltsimError
        In the order of the problems, the same bits for any number of workers.

    Raises
    ------
    InvalidProblemError
        When `workers` is not a positive integer.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[1.0]], 0, push, Coulomb(0.2))
    >>> found = solve_many([one.with_friction(Coulomb(Q)) for Q in (0.2, 0.6, 1.2)])
    >>> [round(orbit.stick_fraction, 3) for orbit in found]
    [0.0, 0.235, 1.0]
    """
    given = settled(settings)

    def solve(chunk: list[FrictionProblem]) -> list[Response | BeltsimError]:
        return _chunk(chunk, given)

    return in_chunks(solve, problems, workers)


def in_chunks(
    solve: Callable[[list[FrictionProblem]], list[T]],
    problems: Iterable[FrictionProblem],
    workers: int | None,
) -> list[T]:
    """`solve` for all chunks of one linear system, on that many threads; results in order."""
    count = _cores() if workers is None else workers
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise InvalidProblemError(Mistake("workers", workers, "None or an integer >= 1"))
    chunks = [
        list(chunk) for _, chunk in groupby(listed_problems(problems), key=lambda p: id(p.shared))
    ]
    if count == 1 or len(chunks) == 1:
        found = [solve(chunk) for chunk in chunks]
    else:
        with ThreadPoolExecutor(max_workers=count) as pool:
            found = list(pool.map(solve, chunks))
    return [one for chunk in found for one in chunk]


def _chunk(problems: list[FrictionProblem], settings: Settings) -> list[Response | BeltsimError]:
    """Orbits of one linear system, each from the one before."""
    found: list[Response | BeltsimError] = []
    guess = None
    for problem in problems:
        try:
            orbit = orbit_response(problem, settings, guess)
        except BeltsimError as error:
            found.append(error)
            continue
        found.append(orbit)
        if orbit.rest_interval is None and orbit.statistics["multiple"] == 1:
            guess = orbit.initial_state
    return found


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
