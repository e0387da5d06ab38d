"""`solve_many`: independent runs side by side on threads.

The core releases the interpreter lock, so threads use all cores; each run gives the same bits for
any number of workers.

Depends on: errors, problem, response, transient.run, transient.settings.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from threading import Event

from beltsim.errors import BeltsimError, InvalidProblemError, Mistake
from beltsim.problem import FrictionProblem, listed_problems
from beltsim.response import Response
from beltsim.transient.run import common_mistakes, integrate
from beltsim.transient.settings import Settings


def solve_many(
    problems: Iterable[FrictionProblem],
    settings: Settings | None = None,
    workers: int | None = None,
    *,
    periods: float = 100.0,
) -> list[Response | BeltsimError]:
    """`integrate` for each problem; a failed run leaves its error in the list.

    Parameters
    ----------
    problems : iterable of FrictionProblem
    settings : Settings, optional
        The same for all.
    workers : int, optional
        Threads; default: one per core that this process may use.
    periods : float
        Length of each run.

    Returns
    -------
    list of Response or BeltsimError
        In the order of the problems.

    Raises
    ------
    InvalidProblemError
        When `workers`, `periods` or `settings`, which all runs share, cannot be used.
    KeyboardInterrupt
        On Ctrl-C, within about 0.1 s: runs under way stop, the others do not begin.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(1.0, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]])
    >>> mass = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[4.0]], 0, push, Coulomb(0.2))
    >>> runs = solve_many([mass, mass.with_friction(Coulomb(0.6))], periods=5.0)
    >>> [len(run.events) > 0 for run in runs]
    [True, True]
    """
    count = _cores() if workers is None else workers
    mistakes = common_mistakes(periods, Settings() if settings is None else settings)
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        mistakes.append(Mistake("workers", workers, "None or an integer >= 1"))
    if mistakes:
        raise InvalidProblemError(mistakes)
    listed = listed_problems(problems)
    stopped = Event()

    def heed(_: float) -> None:
        if stopped.is_set():
            raise KeyboardInterrupt

    def one(problem: FrictionProblem) -> Response | BeltsimError:
        try:
            return integrate(problem, periods, None, settings, progress=heed)
        except BeltsimError as error:
            return error

    with ThreadPoolExecutor(max_workers=count) as pool:
        try:
            return list(pool.map(one, listed))
        except KeyboardInterrupt:  # signals reach the main thread alone
            stopped.set()
            raise


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
