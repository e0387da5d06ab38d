r"""The narrow waist: a linear system with one friction joint under periodic forcing.

.. math:: M\ddot q + (C + G)\dot q + K q + e_j h_c(\dot q_j) = f(t)

with M symmetric positive definite, C symmetric positive semidefinite, G skew, K symmetric, `e_j`
the unit vector of the joint and `h_c` its friction torque. Everything upstream ends here and every
solver starts here. Nothing in this module knows what the coordinates stand for.

Blocks: `q` marks the coordinates other than the joint, `t` the joint, so that `M_qt` is the column
of M that couples the joint into the rest.

Depends on: errors, checks, forcing, friction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from beltsim.checks import FloatArray, finite_array, not_finite_words, read_only
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, FrictionLaw, SaturatedCoulomb

#: Largest relative asymmetry of M, C, K (and symmetry of G) taken for rounding.
SYMMETRY_TOLERANCE = 1e-12
#: Largest condition number of M, after scaling to a unit diagonal.
MASS_CONDITION_LIMIT = 1e12


@dataclass(frozen=True, eq=False)
class Scales:
    """What one unit of the problem is worth in SI.

    Parameters
    ----------
    time_s : float
        Seconds per unit of time.
    torque_N_m : float
        Newton metres per unit of the joint's torque.
    coordinates : array_like of shape (n,)
        SI value of one unit of each coordinate.
    units : tuple of str
        SI unit of each coordinate, such as ``"m"`` or ``"rad"``.

    Notes
    -----
    Energies scale with `torque_N_m` times the joint's coordinate scale.
    """

    time_s: float
    torque_N_m: float
    coordinates: FloatArray
    units: tuple[str, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "coordinates", read_only(self.coordinates))
        object.__setattr__(self, "units", tuple(self.units))


@dataclass(frozen=True, eq=False)
class Observable:
    r"""A quantity that follows the state, with the limits between which it is meaningful.

    .. math:: y(t) = \mathrm{row}\cdot q(t) + \sum_k c_k\cos k\Omega t + s_k\sin k\Omega t

    Parameters
    ----------
    name : str
        What it is, such as ``"tension of span 1"``.
    row : array_like of shape (n,)
        Factors of the coordinates.
    cos, sin : array_like of shape (H + 1,)
        Part that follows the forcing directly; row 0 of `cos` is the constant part.
    lower, upper : float
        Limits; a response that crosses one carries a warning.
    scale : float
        SI value of one unit.
    unit : str
        SI unit.
    """

    name: str
    row: FloatArray
    cos: FloatArray
    sin: FloatArray
    lower: float = -np.inf
    upper: float = np.inf
    scale: float = 1.0
    unit: str = "1"

    def __post_init__(self) -> None:
        for field in ("row", "cos", "sin"):
            object.__setattr__(self, field, read_only(getattr(self, field)))

    def at(self, t: FloatArray, q: FloatArray, Omega: float) -> FloatArray:
        """Values at times `t` (nt,) for coordinates `q` (nt, n): array (nt,), problem units."""
        angle = np.multiply.outer(np.asarray(t) * Omega, np.arange(len(self.cos)))
        values: FloatArray = q @ self.row + np.cos(angle) @ self.cos + np.sin(angle) @ self.sin
        return values

    @property
    def shown(self) -> tuple[float, str]:
        """Factor and unit, behind a space, in which values are printed: angles in degrees."""
        if self.unit == "rad":
            return float(np.degrees(self.scale)), " deg"
        return self.scale, "" if self.unit == "1" else f" {self.unit}"

    def warnings(self, values: FloatArray) -> list[str]:
        """One sentence per limit that `values` (nt,) of it cross: how often, and the extreme."""
        found = []
        scale, unit = self.shown
        for limit, sign, verb, extreme in (
            (self.lower, -1.0, "falls below", "lowest"),
            (self.upper, 1.0, "exceeds", "highest"),
        ):
            if np.isinf(limit):
                continue
            beyond = sign * (values - limit) > 0.0
            if not beyond.any():
                continue
            times = int(beyond[0]) + int(np.count_nonzero(beyond[1:] & ~beyond[:-1]))
            worst = float(values[beyond][np.argmax(sign * values[beyond])]) * scale
            found.append(
                f"{self.name} {verb} {limit * scale:.6g}{unit} {times} "
                f"time{'s' if times > 1 else ''} in the last period, {extreme} {worst:.6g}{unit}"
                + " from the reference"
                * (self.unit == "rad")
            )
        return found


@dataclass(frozen=True, eq=False)
class FrictionProblem:
    """A linear system with at most one friction joint, checked once and frozen.

    Parameters
    ----------
    M, C, G, K : array_like of shape (n, n)
        Mass (symmetric positive definite), damping (symmetric positive semidefinite), gyroscopic
        (skew) and stiffness (symmetric) matrices, in any consistent units.
    joint : int or None
        Index of the friction coordinate, 0 <= joint < n; None for a linear problem.
    forcing : HarmonicForcing
        Periodic forcing of the n coordinates.
    friction : Coulomb, SaturatedCoulomb or None
        Law of the joint; None exactly when `joint` is None.
    labels : sequence of str, optional
        Name of each coordinate. Default ``q0, q1, ...``.
    scales : Scales, optional
        SI values of the units; None when the problem is already in the units the user wants.
    observables : sequence of Observable, optional
        Quantities to report beside the coordinates.
    warnings : sequence of str, optional
        What upstream wants every response of this problem to say.

    Raises
    ------
    InvalidProblemError
        With every mistake found: field, value, limit.

    Examples
    --------
    >>> forcing = HarmonicForcing(1.0, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]])
    >>> one_mass = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[4.0]], 0, forcing, Coulomb(0.2))
    >>> one_mass.n, one_mass.locked().n
    (1, 0)
    """

    M: FloatArray
    C: FloatArray
    G: FloatArray
    K: FloatArray
    joint: int | None
    forcing: HarmonicForcing
    friction: FrictionLaw | None
    labels: tuple[str, ...] | None = None
    scales: Scales | None = None
    observables: tuple[Observable, ...] = ()
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        matrices, mistakes = _checked_matrices(self)
        n = len(matrices["M"]) if "M" in matrices else None
        mistakes += _joint_mistakes(self, n)
        if n is not None:
            mistakes += _companion_mistakes(self, n)
        if mistakes:
            raise InvalidProblemError(mistakes)
        for name, matrix in matrices.items():
            object.__setattr__(self, name, read_only(matrix))
        if self.joint is not None:
            object.__setattr__(self, "joint", int(self.joint))
        labels = self.labels or tuple(f"q{i}" for i in range(n or 0))
        object.__setattr__(self, "labels", tuple(labels))
        object.__setattr__(self, "observables", tuple(self.observables))
        unstable = _unstable(self.K) if n else ()
        object.__setattr__(self, "warnings", tuple(dict.fromkeys((*self.warnings, *unstable))))

    def __repr__(self) -> str:
        place = "" if self.joint is None else f" ({(self.labels or ())[self.joint]})"
        return (
            f"<FrictionProblem: n = {self.n}, joint {self.joint}{place}, {self.friction}, "
            f"Omega = {self.forcing.Omega:.6g}, harmonics up to {self.forcing.n_harmonics}>"
        )

    @property
    def n(self) -> int:
        """Number of coordinates, the joint included."""
        return len(self.M)

    @cached_property
    def shared(self) -> dict[str, Any]:
        """What solvers derive from the linear part alone; `with_friction` passes it on."""
        return {}

    @property
    def period(self) -> float:
        """Forcing period 2 pi / Omega, in the problem's time unit."""
        return self.forcing.period

    @cached_property
    def others(self) -> np.ndarray:
        """Indices of the coordinates other than the joint, shape (n - 1,) or (n,)."""
        keep = np.arange(self.n)
        return keep if self.joint is None else np.delete(keep, self.joint)

    def block(self, matrix: str, rows: str, columns: str) -> FloatArray:
        """Block of `matrix` ("M", "C", "G", "K"); `rows` and `columns` are "q" or "t"."""
        index = {"q": self.others, "t": np.atleast_1d(np.asarray(self.joint, dtype=int))}
        found: FloatArray = getattr(self, matrix)[np.ix_(index[rows], index[columns])]
        return found

    def limit_warnings(self, t: FloatArray, q: FloatArray) -> list[str]:
        """A sentence per limit of an observable that coordinates `q` (nt, n) at `t` (nt,) cross."""
        if not len(t) or not self.observables:
            return []
        orders = np.arange(max(len(seen.cos) for seen in self.observables))
        angle = np.multiply.outer(np.asarray(t) * self.forcing.Omega, orders)
        cos, sin, found = np.cos(angle), np.sin(angle), []
        for seen in self.observables:
            own = slice(len(seen.cos))
            values = q @ seen.row + cos[:, own] @ seen.cos + sin[:, own] @ seen.sin
            found += seen.warnings(values)
        return found

    def freed(self) -> FrictionProblem:
        """The same system without friction: n coordinates, no joint."""
        return replace(self, joint=None, friction=None)

    def locked(self) -> FrictionProblem:
        """The system with the joint held at zero: n - 1 coordinates, no joint."""
        if self.joint is None:
            raise InvalidProblemError(Mistake("joint", None, "an index, to lock it"))
        keep = np.ix_(self.others, self.others)
        scales = self.scales and Scales(
            self.scales.time_s,
            self.scales.torque_N_m,
            self.scales.coordinates[self.others],
            tuple(self.scales.units[i] for i in self.others),
        )
        return FrictionProblem(
            self.M[keep],
            self.C[keep],
            self.G[keep],
            self.K[keep],
            None,
            HarmonicForcing(
                self.forcing.Omega,
                self.forcing.cos[:, self.others],
                self.forcing.sin[:, self.others],
            ),
            None,
            tuple((self.labels or ())[i] for i in self.others),
            scales,
            tuple(replace(seen, row=seen.row[self.others]) for seen in self.observables),
            self.warnings,
        )

    def with_friction(self, friction: FrictionLaw) -> FrictionProblem:
        """The same system with another friction law (matrices are shared, not checked again)."""
        _require_law(friction)
        if self.joint is None:
            raise InvalidProblemError(Mistake("joint", None, "an index, to carry friction"))
        _ = self.shared  # made before it is passed on
        changed = object.__new__(FrictionProblem)
        changed.__dict__.update(self.__dict__, friction=friction)
        return changed


def _require_law(friction: Any) -> None:
    if not isinstance(friction, Coulomb | SaturatedCoulomb):
        raise InvalidProblemError(Mistake("friction", friction, "Coulomb or SaturatedCoulomb"))


def _checked_matrices(problem: FrictionProblem) -> tuple[dict[str, FloatArray], list[Mistake]]:
    """The four matrices as float arrays, and what is wrong with them."""
    mistakes: list[Mistake] = []
    found: dict[str, FloatArray] = {}
    for name in "MCGK":
        array = finite_array(getattr(problem, name), ndim=2)
        if array is None or array.shape[0] != array.shape[1]:
            given = getattr(problem, name)
            value = not_finite_words(given) or given
            mistakes.append(Mistake(name, value, "a finite array of shape (n, n)"))
        else:
            found[name] = array
    if "M" not in found:
        return found, mistakes
    n = len(found["M"])
    sound = set()
    for name, array in found.items():
        if array.shape != (n, n):
            mistakes.append(Mistake(name, f"shape {array.shape}", f"of shape ({n}, {n}), as M"))
            continue
        mirror = -array.T if name == "G" else array.T
        if (array == mirror).all():  # as assembled matrices are: nothing left to measure
            sound.add(name)
            continue
        gap = float(np.abs(array - mirror).max(initial=0.0))
        limit = SYMMETRY_TOLERANCE * float(np.abs(array).max(initial=0.0))
        if gap > limit:
            word = "skew" if name == "G" else "symmetric"
            mistakes.append(Mistake(name, f"asymmetry {gap:.3g}", f"{word} within {limit:.3g}"))
        else:
            sound.add(name)
    if n > 0 and "M" in sound:
        mistakes += _definiteness_mistakes(found["M"], found["C"] if "C" in sound else None)
    return found, mistakes


def _definiteness_mistakes(M: FloatArray, C: FloatArray | None) -> list[Mistake]:
    """M must be positive definite and well conditioned, C must not feed energy in.

    Both are judged in coordinates of unit mass, so that the choice of units does not matter.
    """
    diagonal = np.diag(M)
    if diagonal.min() <= 0.0:
        return [Mistake("M", f"diagonal entry {diagonal.min():.3g}", "positive definite")]
    scale = 1.0 / np.sqrt(diagonal)
    unit = M * scale[:, None] * scale
    try:
        factor = np.linalg.cholesky(unit)
    except np.linalg.LinAlgError:
        lowest = float(np.linalg.eigvalsh(unit)[0])
        return [Mistake("M", f"smallest scaled eigenvalue {lowest:.3g}", "positive definite")]
    # With a unit diagonal the eigenvalues sum to n, so the smallest is at least det/e and the
    # condition in the 1-norm at most e n^2/det. Where that bound is enough, no inverse is needed.
    determinant = float(np.prod(np.diag(factor))) ** 2
    if np.e * len(M) ** 2 > 0.5 * MASS_CONDITION_LIMIT * determinant:
        condition = float(np.linalg.cond(unit, 1))
        if condition > MASS_CONDITION_LIMIT:
            allowed = f"at most {MASS_CONDITION_LIMIT:.0e}"
            return [Mistake("M", f"condition {condition:.3g}", allowed)]
    if C is None or not C.any():
        return []
    damping = C * scale[:, None] * scale
    shift = 1e-11 * float(np.abs(damping).max()) * len(C)
    try:  # a shift of rounding size lets semidefinite matrices pass
        np.linalg.cholesky(damping + shift * np.eye(len(C)))
    except np.linalg.LinAlgError:
        lowest = float(np.linalg.eigvalsh(damping)[0])
        return [Mistake("C", f"smallest scaled eigenvalue {lowest:.3g}", "positive semidefinite")]
    return []


def _unstable(K: FloatArray) -> tuple[str, ...]:
    """A warning for a K that gives way: nothing then bounds the motion."""
    try:
        np.linalg.cholesky(K)
    except np.linalg.LinAlgError:
        values = np.linalg.eigvalsh(K)
        if values[0] < -1e-11 * np.abs(values).max():
            return (
                f"K has the negative eigenvalue {values[0]:.6g}: unless G holds it, the motion "
                "runs away; linear.decay(problem) tells",
            )
    return ()


def _joint_mistakes(problem: FrictionProblem, n: int | None) -> list[Mistake]:
    """The joint must be an index, and carry a law exactly when it exists."""
    joint, friction = problem.joint, problem.friction
    if joint is None:
        if friction is None:
            return []
        return [Mistake("friction", friction, "None, since joint is None")]
    mistakes = []
    if isinstance(joint, bool | np.bool_) or not isinstance(joint, int | np.integer):
        mistakes.append(Mistake("joint", joint, "an integer index or None"))
    elif n is not None and not 0 <= joint < n:
        mistakes.append(Mistake("joint", joint, f"between 0 and {n - 1}"))
    if not isinstance(friction, Coulomb | SaturatedCoulomb):
        mistakes.append(Mistake("friction", friction, "Coulomb or SaturatedCoulomb"))
    return mistakes


def _companion_mistakes(problem: FrictionProblem, n: int) -> list[Mistake]:
    """Forcing, labels, scales and observables must have one entry per coordinate."""
    mistakes = []
    forcing = problem.forcing
    if not isinstance(forcing, HarmonicForcing):
        mistakes.append(Mistake("forcing", forcing, "a HarmonicForcing"))
    elif forcing.cos.shape[1] != n:
        mistakes.append(Mistake("forcing.cos", f"{forcing.cos.shape[1]} columns", f"{n} columns"))
    labels, scales = problem.labels, problem.scales
    if labels is not None:
        if isinstance(labels, str) or not all(isinstance(label, str) for label in labels):
            mistakes.append(Mistake("labels", labels, f"a sequence of {n} names"))
        elif len(labels) != n:
            mistakes.append(Mistake("labels", f"{len(labels)} names", f"{n} names"))
        elif len(set(labels)) < n:
            twice = next(label for label in labels if list(labels).count(label) > 1)
            places = [i for i, label in enumerate(labels) if label == twice]
            mistakes.append(Mistake("labels", f"{twice!r} at {places}", "different names"))
    if scales is not None and not isinstance(scales, Scales):
        mistakes.append(Mistake("scales", scales, "Scales or None"))
    elif scales is not None:
        if scales.coordinates.shape != (n,):
            shape = scales.coordinates.shape
            mistakes.append(Mistake("scales.coordinates", f"shape {shape}", f"of shape ({n},)"))
        if len(scales.units) != n:
            mistakes.append(Mistake("scales.units", f"{len(scales.units)} units", f"{n} units"))
    for i, seen in enumerate(problem.observables):
        if not isinstance(seen, Observable):
            mistakes.append(Mistake(f"observables[{i}]", seen, "an Observable"))
            continue
        if seen.row.shape != (n,):
            found = f"shape {seen.row.shape}"
            mistakes.append(Mistake(f"observables[{i}].row", found, f"of shape ({n},)"))
        if seen.cos.ndim != 1 or not len(seen.cos) or seen.cos.shape != seen.sin.shape:
            found = f"shapes {seen.cos.shape} and {seen.sin.shape}"
            allowed = "cos and sin of one shape (H + 1,)"
            mistakes.append(Mistake(f"observables[{i}]", found, allowed))
    return mistakes


def require_problem(problem: Any) -> None:
    """Refuse what is no FrictionProblem."""
    if not isinstance(problem, FrictionProblem):
        raise InvalidProblemError(Mistake("problem", problem, "a FrictionProblem"))


def listed_problems(problems: Any) -> list[FrictionProblem]:
    """The problems of a grid as a list; anything else is refused, with its place.

    Raises
    ------
    InvalidProblemError
        When `problems` is no sequence, or holds something that is no FrictionProblem.

    Examples
    --------
    >>> listed_problems([])
    []
    """
    try:
        found = list(problems)
    except TypeError:
        mistake = Mistake("problems", type(problems).__name__, "a sequence of FrictionProblem")
        raise InvalidProblemError(mistake) from None
    mistakes = [
        Mistake(f"problems[{i}]", one, "a FrictionProblem")
        for i, one in enumerate(found)
        if not isinstance(one, FrictionProblem)
    ]
    if mistakes:
        raise InvalidProblemError(mistakes)
    return found
