r"""Maps of figures: what is wanted of thousands of periodic responses, without their motion.

`survey` solves as `solve_many` does, with the same checks, and keeps a row of numbers of each.

Depends on: errors, checks, problem, condensation, many, result, set_valued, settings, solve.
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
from beltsim.harmonic_balance import set_valued
from beltsim.harmonic_balance.many import side_by_side
from beltsim.harmonic_balance.result import mean_position
from beltsim.harmonic_balance.settings import Settings, require_common
from beltsim.harmonic_balance.solve import DEFAULTS, solved_series
from beltsim.problem import FrictionProblem, listed_problems


@dataclass(frozen=True, eq=False)
class Survey:
    """Figures of k periodic responses of n coordinates, in the order of the problems.

    Parameters
    ----------
    rms : (k, n)
        Root mean square of each coordinate over the period, mean included.
    dissipated_energy : (k,)
        Friction loss per forcing period.
    Q_cr, Q_cr_R : (k,)
        Torques from which the joint is locked: exactly, and with R harmonics.
    gap : (k,)
        Gap between the torque and its law (`statistics["complementarity_gap"]`).
    locked, converged : (k,) of bool
    failures : mapping of int to BeltsimError
        Why a problem has no row; its numbers are NaN.
    """

    rms: FloatArray
    dissipated_energy: FloatArray
    Q_cr: FloatArray
    Q_cr_R: FloatArray
    gap: FloatArray
    locked: NDArray[np.bool_]
    converged: NDArray[np.bool_]
    failures: Mapping[int, BeltsimError]

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __len__(self) -> int:
        return len(self.gap)


def survey(
    problems: Iterable[FrictionProblem],
    settings: Settings | None = None,
    workers: int | None = None,
    *,
    R: int = 15,
) -> Survey:
    """Figures of the periodic response of each problem; many times quicker than `solve_many`.

    Parameters
    ----------
    problems : iterable of FrictionProblem
        All of n coordinates. Torques of one linear system share its impedances.
    settings : Settings, optional
        Nothing is sampled, and no error is estimated.
    workers : int, optional
        Threads; default: one per core that this process may use.
    R : int
        Highest harmonic.

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
    >>> found = survey([one.with_friction(Coulomb(Q)) for Q in (0.2, 0.6, 1.2)], R=25)
    >>> found.dissipated_energy.round(2).tolist(), found.locked.tolist()
    ([1.04, 2.71, 0.0], [False, False, True])
    """
    require_common(R, settings)
    problems = listed_problems(problems)
    sizes = {problem.n for problem in problems}
    if len(sizes) > 1:
        raise InvalidProblemError(Mistake("problems", f"n of {sorted(sizes)}", "all of one n"))
    rows: list[Any] = side_by_side(
        lambda problem: _row(problem, R, settings or DEFAULTS), problems, workers
    )
    n, failures = sizes.pop() if sizes else 0, {}
    for i, row in enumerate(rows):
        if isinstance(row, BeltsimError):
            failures[i], rows[i] = row, (np.full(n, np.nan), *[np.nan] * 4, False)

    def column(place: int, kind: type = float) -> NDArray[Any]:
        return np.array([row[place] for row in rows], dtype=kind)

    return Survey(
        rms=column(0).reshape(len(rows), n),
        dissipated_energy=column(1),
        Q_cr=column(2),
        Q_cr_R=column(3),
        gap=column(4),
        locked=column(5, bool),
        converged=np.array([i not in failures for i in range(len(rows))], dtype=bool),
        failures=MappingProxyType(failures),
    )


def _row(problem: FrictionProblem, R: int, settings: Settings) -> tuple[Any, ...] | BeltsimError:
    """rms, dissipated energy, Q_cr, Q_cr(R), gap, locked; or why there are none."""
    try:
        condensed, solved, coordinates = solved_series(problem, R, settings)
        mean = mean_position(problem, condensed, solved)
    except BeltsimError as error:
        return error
    rms = np.sqrt(coordinates.squares + mean * mean)
    loss = coordinates.power * problem.period
    if solved.locked:
        rms[problem.joint], loss = abs(mean[problem.joint]), 0.0
    Q_cr, Q_cr_R = set_valued.critical_torque(condensed), set_valued.critical_bound(condensed)
    return rms, loss, Q_cr, Q_cr_R, solved.gap, solved.locked
