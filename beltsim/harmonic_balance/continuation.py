r"""Branches of solutions over a parameter, through folds: pseudo-arclength continuation.

A branch of :math:`r(x, \lambda) = 0` is followed along its own length: from a point a step is made
along the tangent of the scaled unknowns :math:`u = (x/x_s, \lambda/\lambda_s)`, and Newton's method
returns to the branch in the plane normal to it. Folds in :math:`\lambda` are no obstacle. `trace`
takes any residual; `follow` the balance of the saturated law for a problem of a parameter.

Depends on: errors, checks, friction, problem, condensation, saturated, settings.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from beltsim.checks import FloatArray, finite_array, read_only, real_number
from beltsim.errors import ConvergenceError, InvalidProblemError, Mistake, UnsupportedLawError
from beltsim.friction import SaturatedCoulomb
from beltsim.harmonic_balance.condensation import condense
from beltsim.harmonic_balance.saturated import Balance, balance_of, velocity_of
from beltsim.harmonic_balance.settings import Settings
from beltsim.problem import FrictionProblem

#: Newton steps of a correction, its largest last step, and the step of differences, scaled.
CORRECTIONS, CORRECTED, DIFFERENCE = 8, 1e-9, 1e-6
#: A step grows by this after a quick correction, and shrinks by the other after none.
GROWTH, SHRINKAGE = 1.4, 0.5
#: A tangent may turn by this between points: least cosine.
STRAIGHT = 0.8
#: Share of the parameter in the tangent at a fold, and most halvings of a step to find it.
UPRIGHT, MOST_HALVINGS = 1e-6, 40


@dataclass(frozen=True, eq=False)
class Branch:
    """Points of a branch, in order.

    Parameters
    ----------
    values : (k,) the parameter.
    x : (k, m) the unknowns.
    folds : tuple of int
        Points at which the parameter turns back, located on the branch.
    complete : bool
        Whether it was followed until it left the limits; not, where the points were used up.
    """

    values: FloatArray
    x: FloatArray
    folds: tuple[int, ...]
    complete: bool = False

    def __post_init__(self) -> None:
        for name in ("values", "x"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.values)


def trace(
    residual: Callable[[FloatArray, float], FloatArray],
    x: Any,
    value: float,
    *,
    within: tuple[float, float],
    direction: int = 1,
    step: float = 0.05,
    least_step: float = 1e-5,
    most: int = 500,
    scale: Any = None,
) -> Branch:
    """The branch of residual(x, value) = 0 through a point near (x, value).

    Parameters
    ----------
    residual : callable
        Takes x (m,) and the parameter, returns (m,).
    x : (m,) first guess at `value`.
    value : float
    within : (low, high)
        The branch ends where the parameter leaves it.
    direction : int
        +1: the parameter grows at first; -1: it falls.
    step, least_step : float
        First length of a step (also the longest is 4 times it) and the shortest, scaled.
    most : int
        Most points.
    scale : (m,), optional
        Size of the unknowns; default: the largest of |x|, for all alike. Needed where x is zero.

    Returns
    -------
    Branch
        From the first point to where it leaves `within` (`complete`), or `most` points.

    Raises
    ------
    InvalidProblemError
        When the value is not within its limits, x is zero and no scale is given, or a step, a
        limit or a number of points makes no sense.
    ConvergenceError
        When no step longer than `least_step` comes back to the branch; `partial` is the branch up
        to there.

    Examples
    --------
    >>> circle = trace(lambda x, p: x**2 + p**2 - 1.0, [1.0], 0.0, within=(-2.0, 2.0), most=60)
    >>> bool(circle.folds), float(abs(circle.values).max().round(2))
    (True, 1.0)
    """
    _require_steps(value, within, direction, step, least_step, most)
    x, sizes = _unknowns(x, scale)
    low, high = within
    units = np.append(sizes, high - low)

    def scaled(u: FloatArray) -> FloatArray:
        return np.asarray(residual(u[:-1] * units[:-1], float(u[-1] * units[-1])), dtype=float)

    along = np.zeros(len(units))
    along[-1] = 1.0
    u, history = _corrected(scaled, np.append(x, value) / units, along)
    if u is None:
        message = f"no solution near the first point at {value:g}: residual {min(history):.2g}"
        raise ConvergenceError(message, None, history)
    tangent = _tangent(scaled, u, direction * along)
    points, longest = [u], 4.0 * step
    folds: list[int] = []
    while len(points) < most:
        following, history = _corrected(scaled, u + step * tangent, tangent)
        turned = None if following is None else _tangent(scaled, following, tangent)
        if following is None or turned is None or turned @ tangent < STRAIGHT:
            step *= SHRINKAGE
            if step >= least_step:
                continue
            branch = _branch(points, units, folds)
            message = (
                f"the branch could not be followed beyond {branch.values[-1]:.6g} after "
                f"{len(branch)} points: residual {min(history):.2g}; try a smaller least_step "
                f"({least_step:g} now)"
            )
            raise ConvergenceError(message, branch, history)
        if not low <= following[-1] * units[-1] <= high:  # the last point, on the limit itself
            limit = (high if following[-1] > u[-1] else low) / units[-1]
            share = (limit - u[-1]) / (following[-1] - u[-1])
            last, _ = _corrected(scaled, u + share * (following - u), along)
            if last is not None and share > 0.0:
                points.append(last)
            return _branch(points, units, folds, complete=True)
        if turned[-1] * tangent[-1] < 0.0:
            folds.append(len(points))
            points.append(_fold(scaled, u, tangent, step))
        u, tangent = following, turned
        points.append(u)
        if len(history) <= 4:
            step = min(longest, GROWTH * step)
    return _branch(points, units, folds)


def _require_steps(
    value: Any, within: Any, direction: Any, step: Any, least_step: Any, most: Any
) -> None:
    """Refuse what a branch cannot be followed with, all of it at once."""
    mistakes = []
    limits = finite_array(within, ndim=1)
    if limits is None or len(limits) != 2 or not limits[0] < limits[1]:
        mistakes.append(Mistake("within", within, "(low, high) with low < high, both finite"))
    elif (at := real_number(value)) is None or not limits[0] <= at <= limits[1]:
        allowed = f"between {limits[0]:g} and {limits[1]:g}"
        mistakes.append(Mistake("value", value, allowed))
    if isinstance(direction, bool) or direction not in (1, -1):
        mistakes.append(Mistake("direction", direction, "1 or -1"))
    length, least = real_number(step), real_number(least_step)
    if length is None or not length > 0.0:
        mistakes.append(Mistake("step", step, "a finite number > 0"))
    elif least is None or not 0.0 < least <= length:
        mistakes.append(Mistake("least_step", least_step, f"> 0 and at most step = {length:g}"))
    if isinstance(most, bool) or not isinstance(most, int) or most < 1:
        mistakes.append(Mistake("most", most, "an integer >= 1"))
    if mistakes:
        raise InvalidProblemError(mistakes)


def _unknowns(x: Any, scale: Any) -> tuple[FloatArray, FloatArray]:
    """The first guess (m,) and the sizes (m,) of the unknowns."""
    found = finite_array(np.atleast_1d(x), ndim=1)
    if found is None or not len(found):
        raise InvalidProblemError(Mistake("x", x, "finite numbers, one per unknown"))
    if scale is None:
        if not found.any():
            raise InvalidProblemError(Mistake("scale", None, "given where x is zero: their size"))
        return found, np.full(len(found), float(np.abs(found).max()))
    sizes = finite_array(scale, ndim=1)
    if sizes is None or sizes.shape != found.shape or not (sizes > 0.0).all():
        allowed = f"positive numbers of shape ({len(found)},)"
        raise InvalidProblemError(Mistake("scale", scale, allowed))
    return found, sizes


def _fold(
    scaled: Callable[[FloatArray], FloatArray], u: FloatArray, tangent: FloatArray, step: float
) -> FloatArray:
    """The point within `step` of `u` where the branch stands upright over the parameter."""
    low, high, found = 0.0, step, u
    for _ in range(MOST_HALVINGS):
        middle = 0.5 * (low + high)
        point, _ = _corrected(scaled, u + middle * tangent, tangent)
        turned = None if point is None else _tangent(scaled, point, tangent)
        if point is None or turned is None:
            break
        found = point
        if abs(turned[-1]) <= UPRIGHT:
            break
        before = turned[-1] * tangent[-1] > 0.0
        low, high = (middle, high) if before else (low, middle)
    return found


def follow(
    problem_of: Callable[[float], FrictionProblem],
    value: float,
    *,
    within: tuple[float, float],
    R: int = 15,
    settings: Settings | None = None,
    **options: Any,
) -> Branch:
    """The response with the saturated law over a parameter of the problem.

    Parameters
    ----------
    problem_of : callable
        The problem at a value of the parameter: a torque, a frequency, a stiffness, ...
    value, within : see `trace`
    R : int
    settings : Settings, optional
        `harmonics`, `projection` and `samples` count.
    options
        As for `trace`.

    Returns
    -------
    Branch
        `x` holds pairs of the joint's velocity harmonics: Re V_r, -Im V_r.

    Raises
    ------
    UnsupportedLawError
        When the law is not `SaturatedCoulomb`.
    ConvergenceError
        As `trace`.
    """
    settings = settings or Settings()

    def balance(parameter: float) -> Balance:
        problem = problem_of(parameter)
        law = problem.friction
        if not isinstance(law, SaturatedCoulomb):
            message = "branches are followed for SaturatedCoulomb: exact friction has no derivative"
            raise UnsupportedLawError(message)
        condensed = condense(problem, R, settings.harmonics)
        return balance_of(condensed, law, settings)

    def left(x: FloatArray, parameter: float) -> FloatArray:
        now = balance(parameter)
        return now.residual(x) / max(float(np.abs(now.load).max()), now.Q_m)

    balance(value)  # refuses another law first
    condensed = condense(problem_of(value), R, settings.harmonics)
    law = cast("SaturatedCoulomb", problem_of(value).friction)
    x = velocity_of(condensed, law, settings)
    return trace(left, x, value, within=within, **options)


def _corrected(
    scaled: Callable[[FloatArray], FloatArray], guess: FloatArray, normal: FloatArray
) -> tuple[FloatArray | None, list[float]]:
    """Newton's method in the plane through `guess` normal to `normal`; residuals on the way."""
    u, history = guess, []
    for _ in range(CORRECTIONS):
        left = scaled(u)
        history.append(float(np.abs(left).max(initial=0.0)))
        if not np.isfinite(history[-1]):
            break
        matrix = np.vstack([_jacobian(scaled, u), normal])
        try:
            change = np.linalg.solve(matrix, np.append(-left, normal @ (guess - u)))
        except np.linalg.LinAlgError:
            break
        u = u + change
        if float(np.abs(change).max()) < CORRECTED:
            return u, history
    return None, history


def _tangent(
    scaled: Callable[[FloatArray], FloatArray], u: FloatArray, before: FloatArray
) -> FloatArray:
    """Unit null vector of the residual's derivative, on the side of `before`."""
    _, _, vectors = np.linalg.svd(_jacobian(scaled, u))
    tangent: FloatArray = vectors[-1]
    return tangent if tangent @ before >= 0.0 else -tangent


def _jacobian(scaled: Callable[[FloatArray], FloatArray], u: FloatArray) -> FloatArray:
    """Derivative (m, m + 1) by central differences."""
    columns = [scaled(u + DIFFERENCE * e) - scaled(u - DIFFERENCE * e) for e in np.eye(len(u))]
    return np.array(columns).T / (2.0 * DIFFERENCE)


def _branch(
    points: list[FloatArray], units: FloatArray, folds: list[int], complete: bool = False
) -> Branch:
    found = np.array(points) * units
    return Branch(found[:, -1], found[:, :-1], tuple(folds), complete)
