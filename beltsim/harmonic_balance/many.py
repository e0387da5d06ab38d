"""`solve_many`: independent problems, and `side_by_side`: anything, on threads.

The kernels and LAPACK release the interpreter lock. Each solution gives the same bits for any
number of workers.

Depends on: errors, problem, response, solve, settings.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from beltsim.errors import BeltsimError, InvalidProblemError, Mistake
from beltsim.harmonic_balance.settings import Settings, require_common
from beltsim.harmonic_balance.solve import solve
from beltsim.problem import FrictionProblem, listed_problems
from beltsim.response import Response

Result = TypeVar("Result")


def solve_many(
    problems: Iterable[FrictionProblem],
    settings: Settings | None = None,
    workers: int | None = None,
    *,
    R: int = 15,
) -> list[Response | BeltsimError]:
    """`solve` for each problem; a failed one leaves its error in the list.

    Parameters
    ----------
    problems : iterable of FrictionProblem
    settings : Settings, optional
        The same for all.
    workers : int, optional
        Threads; default: one per core that this process may use.
    R : int
        Highest harmonic.

    Returns
    -------
    list of Response or BeltsimError
        In the order of the problems.

    Raises
    ------
    InvalidProblemError
        When `workers`, R or the settings, which all share, cannot be used.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(1.0, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]])
    >>> mass = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[4.0]], 0, push, Coulomb(0.2))
    >>> found = solve_many([mass, mass.with_friction(Coulomb(2.0))], R=9)
    >>> [one.statistics["locked"] for one in found]
    [False, True]
    """
    require_common(R, settings)

    def one(problem: FrictionProblem) -> Response | BeltsimError:
        try:
            return solve(problem, R, settings)
        except BeltsimError as error:
            return error

    return side_by_side(one, listed_problems(problems), workers)


def side_by_side(
    function: Callable[[FrictionProblem], Result],
    problems: list[FrictionProblem],
    workers: int | None,
) -> list[Result]:
    """`function` of each problem on so many threads, in order; neighbours stay on one thread."""
    count = _cores() if workers is None else workers
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise InvalidProblemError(Mistake("workers", workers, "None or an integer >= 1"))
    if min(count, len(problems)) <= 1:
        return [function(problem) for problem in problems]
    size = max(1, len(problems) // (4 * count))
    chunks = [problems[i : i + size] for i in range(0, len(problems), size)]
    with ThreadPoolExecutor(max_workers=count) as pool:
        found = pool.map(lambda chunk: [function(problem) for problem in chunk], chunks)
        return [result for part in found for result in part]


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
