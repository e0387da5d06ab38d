"""`sweep`: a grid of speeds and friction torques, one dataset.

Depends on: model, study.measures, study.methods, study.labelled, errors; drive for its type only.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from beltsim import linear
from beltsim.checks import FloatArray, finite_array
from beltsim.errors import BeltsimError, InvalidDriveError, InvalidProblemError, Mistake
from beltsim.model import assemble
from beltsim.problem import FrictionProblem
from beltsim.study.labelled import labelled
from beltsim.study.measures import measured, measured_locked, surveyed
from beltsim.study.methods import EventMap, Method

if TYPE_CHECKING:
    from beltsim.drive import Drive

#: Points solved in one piece. A fixed number, so that results do not depend on the cores.
PIECE = 16


class _Piece(NamedTuple):
    """Neighbouring torques of one speed: their place in the grid."""

    row: int
    Omega: float
    columns: range


def sweep(
    drive: Drive,
    Omega: Any,
    Q_m: Any,
    method: Method | None = None,
    *,
    relative: bool = False,
    n_functions: int | Sequence[int] = 16,
    residual_flexibility: bool = True,
    spectra_of: Sequence[str] = (),
    harmonics: int = 15,
    workers: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Any:
    """Responses of `drive` over a grid of speeds and friction torques.

    Parameters
    ----------
    drive : Drive
    Omega : (no,)
        Dimensionless firing frequencies.
    Q_m : (nq,)
        Kinetic friction torques over P0 r_t; infinity is the locked arm.
    method : EventMap, HarmonicBalance or Transient, optional
        Default: `EventMap()`.
    relative : bool
        Whether `Q_m` are shares of the critical torque of each speed; their dimension is then
        ``share``, and `Q_m` a variable over (Omega, share).
    n_functions, residual_flexibility
        As for `beltsim.assemble`.
    spectra_of : sequence of str
        Labels of coordinates whose harmonics are kept, such as ``"span1.sin3"``.
    harmonics : int
        Highest harmonic kept of them.
    workers : int, optional
        Threads; default: one per core. Results do not depend on it.
    progress : callable, optional
        Called with the share done, 0 to 1.

    Returns
    -------
    xarray.Dataset
        Over (Omega, Q_m): rms of every coordinate and span, largest dynamic tensions, dissipated
        energy, stick fraction, stops, reversals, phases, spectra. A point without solution holds
        NaN, and its reason in `failure`.

    Raises
    ------
    InvalidProblemError, InvalidDriveError
        For a grid, a label or a drive that cannot be used.

    Examples
    --------
    >>> import beltsim
    >>> drive = beltsim.presets.zhu_parker_2008()
    >>> found = sweep(drive, [6.3], [3.5, np.inf], n_functions=6)
    >>> found.dissipated_energy.dims, found.stick_fraction.values.round(2).tolist()
    (('Omega', 'Q_m'), [[0.12, 1.0]])
    """
    speeds, torques = _grid(Omega, Q_m)
    method = method or EventMap()

    def problem_at(speed: float) -> FrictionProblem:
        return assemble(
            drive, speed, n_functions=n_functions, residual_flexibility=residual_flexibility
        )

    def solved(piece: _Piece) -> tuple[_Piece, list[Any]]:
        chosen = [float(torques[i]) for i in piece.columns]
        at = _Point(piece.Omega, chosen, relative)
        return piece, _piece(problem_at, at, method, signals, harmonics)

    first = _first(problem_at, speeds)
    signals = _indices(first, spectra_of)
    if signals and isinstance(method, EventMap) and method.figures_only:
        allowed = "left out where figures_only is set: spectra need the motion itself"
        raise InvalidProblemError(Mistake("spectra_of", spectra_of, allowed))
    values = np.empty((len(speeds), len(torques)), dtype=object)
    with ThreadPoolExecutor(max_workers=workers or _cores()) as pool:
        done = 0
        for piece, found in pool.map(solved, _pieces(speeds, len(torques))):
            for column, one in zip(piece.columns, found, strict=True):
                values[piece.row, column] = one
            done += len(found)
            if progress is not None:
                progress(done / values.size)
    about = {
        "method": repr(method),
        "n_functions": str(n_functions),
        "residual_flexibility": int(residual_flexibility),
    }
    signal_axis = (tuple(spectra_of), harmonics)
    return labelled(drive, first, speeds, (torques, relative), values, signal_axis, about)


class _Point(NamedTuple):
    """A speed and some torques there, or shares of its critical torque."""

    Omega: float
    values: list[float]
    relative: bool

    def torques(self, at: FrictionProblem) -> list[float]:
        """The torques themselves."""
        unit = linear.critical_torque(at) if self.relative else 1.0
        return [value * unit for value in self.values]


def _grid(Omega: Any, Q_m: Any) -> tuple[FloatArray, FloatArray]:
    speeds = finite_array(Omega, 1)
    torques = np.asarray(Q_m)
    mistakes = []
    if speeds is None or not len(speeds) or not (speeds > 0.0).all():
        mistakes.append(Mistake("Omega", Omega, "a list of finite numbers > 0"))
    good = torques.dtype.kind in "iuf" and torques.ndim == 1 and len(torques) > 0
    if not good or not (torques.astype(float) >= 0.0).all():
        mistakes.append(Mistake("Q_m", Q_m, "a list of numbers >= 0, infinity for a locked arm"))
    if mistakes:
        raise InvalidProblemError(mistakes)
    assert speeds is not None
    return speeds, torques.astype(float)


def _pieces(speeds: FloatArray, width: int) -> Iterator[_Piece]:
    for row, speed in enumerate(speeds.tolist()):
        for start in range(0, width, PIECE):
            yield _Piece(row, speed, range(start, min(start + PIECE, width)))


def _first(problem_at: Callable[[float], FrictionProblem], speeds: FloatArray) -> FrictionProblem:
    """The first operating point that has a steady state; the error of the last when none has."""
    failure: BeltsimError | None = None
    for speed in speeds.tolist():
        try:
            return problem_at(speed)
        except (InvalidDriveError, InvalidProblemError):
            raise
        except BeltsimError as error:
            failure = error
    assert failure is not None
    raise failure


def _indices(problem: FrictionProblem, labels: Sequence[str]) -> tuple[int, ...]:
    known = list(problem.labels or ())
    unknown = [label for label in labels if label not in known]
    if unknown:
        raise InvalidProblemError(Mistake("spectra_of", unknown[0], f"one of {', '.join(known)}"))
    if problem.joint is None:
        raise InvalidProblemError("a study needs a drive with a tensioner arm")
    return tuple(known.index(label) for label in labels)


def _piece(
    problem_at: Callable[[float], FrictionProblem],
    point: _Point,
    method: Method,
    signals: tuple[int, ...],
    harmonics: int,
) -> list[Any]:
    """Measures of each torque, or the error that prevented them."""
    try:
        at = problem_at(point.Omega)
        torques = point.torques(at)
    except BeltsimError as error:
        return [error] * len(point.values)
    problems = [at.with_friction(method.law(Q)) for Q in torques if np.isfinite(Q)]
    solved = iter(_solved(problems, method, signals, harmonics))
    found: list[Any] = []
    for Q in torques:
        try:
            one = next(solved)() if np.isfinite(Q) else measured_locked(at, signals, harmonics)
            found.append({"Q_m": Q} | one)
        except BeltsimError as error:
            found.append(error)
    return found


def _solved(
    problems: list[FrictionProblem], method: Method, signals: tuple[int, ...], harmonics: int
) -> list[Callable[[], Any]]:
    """For each problem a call that gives its measures, or raises why there are none."""
    if isinstance(method, EventMap) and method.figures_only:
        table = method.survey(problems)
        return [partial(surveyed, *at, table, harmonics) for at in enumerate(problems)]
    return [partial(measured, one, method, signals, harmonics) for one in method.solve(problems)]


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
