"""Comparing candidates: where they differ, by how much, and which of them is wrong.

Depends on: checks, errors, problem; cross_check.candidates, cross_check.motion,
cross_check.residuals.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from beltsim.checks import FloatArray
from beltsim.cross_check.candidates import Candidate, candidates
from beltsim.cross_check.motion import Motion
from beltsim.cross_check.residuals import Residuals, residuals
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.problem import FrictionProblem, Observable, require_problem

#: Largest residual of a motion that claims to be exact: the quadrature behind it is no better.
EXACT_RESIDUAL = 1e-5
#: Coordinates that move less than this share of the largest of their kind are not judged.
STILL = 1e-6
#: An error of the joint's motion may be so many times larger in another coordinate.
GAIN = 5.0
#: A highest value read from the samples of a motion: less than the top by up to this.
SAMPLED = 1e-6


@dataclass(frozen=True)
class Difference:
    """One quantity of one candidate beside the reference.

    Parameters
    ----------
    candidate, quantity : str
    value, reference : float
        In the problem's own units; nan where there is no single number.
    error, tolerance : float
        Relative for amplitudes and energies, in forcing periods for instants.
    judged : bool
        Whether it counts.
    note : str
    scale, unit
        SI value of one unit of `value`, and its name; empty for plain numbers.
    """

    candidate: str
    quantity: str
    value: float
    reference: float
    error: float
    tolerance: float
    judged: bool = True
    note: str = ""
    scale: float = 1.0
    unit: str = ""

    @property
    def agrees(self) -> bool:
        """Whether the error is within the tolerance, or does not count."""
        return not self.judged or self.error <= self.tolerance


@dataclass(frozen=True, eq=False)
class Check:
    """What came of a cross-check.

    Parameters
    ----------
    candidates : tuple of Candidate
    residuals : dict of str to Residuals
        Of every candidate that gave a motion.
    differences : tuple of Difference
    """

    candidates: tuple[Candidate, ...]
    residuals: dict[str, Residuals]
    differences: tuple[Difference, ...]

    @property
    def reference(self) -> Candidate | None:
        """The first candidate with a motion."""
        return next((one for one in self.candidates if one.motion is not None), None)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Limits that the reference's motion crosses, such as a span that goes slack."""
        motion = self.reference.motion if self.reference is not None else None
        if motion is None:
            return ()
        return tuple(
            text
            for seen in motion.problem.observables
            for text in seen.warnings(motion.observed(seen))
        )

    @property
    def faults(self) -> tuple[str, ...]:
        """Everything that is wrong, in sentences; empty when the solvers agree."""
        found = []
        if len(self.residuals) < 2:
            found.append(f"{len(self.residuals)} of the solvers gave a motion: nothing to compare")
        for one in self.candidates:
            if one.denies and self.residuals:
                others = ", ".join(self.residuals)
                found.append(
                    f"{one.name} denies that there is a motion, unlike {others}: {one.note}"
                )
            if one.motion is None or one.ripple:
                continue
            name, worst = _worst(self.residuals[one.name])
            if worst > EXACT_RESIDUAL:
                limit = f"{EXACT_RESIDUAL:.0e}"
                found.append(f"{one.name} is wrong: its {name} residual is {worst:.1e} > {limit}")
        for gap in self.differences:
            if not gap.agrees:
                found.append(f"{self._sentence(gap)}; {self._verdict(gap)}")
        return tuple(found)

    @property
    def agrees(self) -> bool:
        """Whether no solver contradicts another, and none violates the equations.

        Solvers that gave no motion because a method or a budget ends there do not count.
        """
        return not self.faults

    def __repr__(self) -> str:
        moving = f"{len(self.residuals)} of {len(self.candidates)} solvers gave a motion"
        return f"<Check: {moving}; {'; '.join(self.faults) or 'they agree'}>"

    def _sentence(self, gap: Difference) -> str:
        reference = self.reference
        assert reference is not None
        return (
            f"{gap.quantity}: {gap.candidate} differs from {reference.name} by {gap.error:.2g}, "
            f"more than {gap.tolerance:.2g}"
        )

    def _verdict(self, gap: Difference) -> str:
        reference = self.reference
        assert reference is not None
        pair = {name: self.residuals[name].worst for name in (reference.name, gap.candidate)}
        wrong = max(pair, key=lambda name: pair[name])
        right = min(pair, key=lambda name: pair[name])
        name, worst = _worst(self.residuals[wrong])
        if worst <= EXACT_RESIDUAL:
            return "both satisfy the equations: the steady motion is not unique"
        return f"{wrong} is wrong: {name} residual {worst:.1e}, the other's worst {pair[right]:.1e}"


def check(
    problem: FrictionProblem,
    tolerance: float = 5e-3,
    progress: Callable[[str], None] | None = None,
) -> Check:
    """The steady motion of `problem` by every solver, compared and judged.

    Parameters
    ----------
    problem : FrictionProblem
        With a joint.
    tolerance : float
        Relative error that harmonic balance may estimate for itself; it takes as many harmonics
        as that needs.
    progress : callable, optional
        Called with the name of each solver before it runs.

    Raises
    ------
    InvalidProblemError
        Without a joint, or for a tolerance that is none.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4))
    >>> found = check(one, tolerance=0.03)
    >>> found.agrees, [one.name for one in found.candidates]
    (True, ['event map', 'C core', 'set-valued balance', 'saturated balance'])
    """
    require_problem(problem)
    require_tolerance(tolerance)
    if problem.joint is None:
        allowed = "an index: without a joint there is no friction"
        raise InvalidProblemError(Mistake("joint", None, allowed))
    return compare(candidates(problem, tolerance, progress))


def require_tolerance(tolerance: float) -> None:
    """Refuse a tolerance that no number of harmonics meets, or that says nothing."""
    if not 1e-4 <= tolerance <= 0.1:
        raise InvalidProblemError(Mistake("tolerance", tolerance, "between 1e-4 and 0.1"))


def compare(found: Iterable[Candidate]) -> Check:
    """Judge candidates that are there already; the first with a motion is the reference."""
    every = tuple(found)
    judged = {one.name: residuals(one.motion) for one in every if one.motion is not None}
    moving = [one for one in every if one.motion is not None]
    gaps: list[Difference] = []
    for other in moving[1:]:
        gaps += _differences(moving[0], other)
    return Check(every, judged, tuple(gaps))


def _worst(found: Residuals) -> tuple[str, float]:
    name = max(found._fields, key=lambda field: getattr(found, field))
    return name, getattr(found, name)


def _differences(reference: Candidate, other: Candidate) -> list[Difference]:
    """Every compared quantity of one candidate."""
    ours, theirs = reference.motion, other.motion
    assert ours is not None
    assert theirs is not None
    accuracy = max(reference.accuracy, other.accuracy)
    gaps = _rms(other, ours, theirs, accuracy)
    for seen in ours.problem.observables:
        gaps.append(_range(other, seen, ours, theirs, accuracy))
    gaps.append(_energy(other, ours, theirs, accuracy))
    instants = max(accuracy, other.ripple)
    return gaps + _phases(other, ours, theirs, instants)


def _rms(other: Candidate, ours: Motion, theirs: Motion, accuracy: float) -> list[Difference]:
    """Each coordinate about its mean; a ripple of the joint weighs more elsewhere."""
    problem = ours.problem
    labels = problem.labels or ()
    units = problem.scales.units if problem.scales is not None else ("1",) * problem.n
    largest = {u: max(ours.rms[i] for i in range(problem.n) if units[i] == u) for u in set(units)}
    found = []
    for i, label in enumerate(labels):
        value, reference = float(theirs.rms[i]), float(ours.rms[i])
        scale = max(reference, STILL * largest[units[i]])
        error = abs(value - reference) / scale if scale > 0.0 else abs(value - reference)
        limit = accuracy if i == problem.joint else GAIN * accuracy
        size = float(problem.scales.coordinates[i]) if problem.scales is not None else 1.0
        gap = Difference(other.name, f"rms of {label}", value, reference, error, limit)
        found.append(replace(gap, scale=size, unit=units[i]))
    return found


def _range(
    other: Candidate, seen: Observable, ours: Motion, theirs: Motion, accuracy: float
) -> Difference:
    """Highest less lowest value: what a locked joint's arbitrary position does not shift."""
    pair = _swing(theirs, seen.name), _swing(ours, seen.name)
    error = abs(pair[0] - pair[1]) / pair[1] if pair[1] > 0.0 else abs(pair[0])
    limit = max(GAIN * accuracy, SAMPLED)
    gap = Difference(other.name, f"range of {seen.name}", *pair, error, limit)
    return replace(gap, scale=seen.scale, unit=seen.unit)


def _swing(motion: Motion, name: str) -> float:
    low, high = motion.extremes(name)
    return high - low


def _energy(other: Candidate, ours: Motion, theirs: Motion, accuracy: float) -> Difference:
    pair = theirs.dissipated_energy, ours.dissipated_energy
    error = abs(pair[0] - pair[1]) / abs(pair[1]) if pair[1] else abs(pair[0])
    gap = Difference(other.name, "dissipated energy", *pair, error, 2.0 * accuracy)
    scales = ours.problem.scales
    if scales is None:
        return gap
    joule = scales.torque_N_m * float(scales.coordinates[ours.problem.joint])
    return replace(gap, scale=joule, unit="J")


def _phases(other: Candidate, ours: Motion, theirs: Motion, instants: float) -> list[Difference]:
    """Stick fraction, reversals nu, and event times where both have the same events.

    In a band around rest the truncated series ripples in and out: its phases are shown, not judged.
    """
    ripples = other.name == "saturated balance"
    note = "ripples of a truncated series leave its band" if ripples else ""
    stuck = theirs.stick_fraction, ours.stick_fraction
    nu = theirs.velocity_reversals, ours.velocity_reversals
    edges = max(1, len(ours.kinds))
    found = [
        Difference(other.name, name, *pair, abs(pair[0] - pair[1]), limit, not ripples, note)
        for name, pair, limit in (
            ("stick fraction", stuck, edges * instants),
            ("velocity reversals", nu, 1e-9),
        )
    ]
    shortest = 2.0 * instants if other.ripple else 0.0
    first, second = _merged(ours, shortest), _merged(theirs, shortest)
    counts = float(len(second[0])), float(len(first[0]))
    late = _latest(first, second, ours.periods)
    note = f"{len(second[0])} events, reference {len(first[0])}" if math.isinf(late) else ""
    found.append(Difference(other.name, "event times", *counts, late, instants, not ripples, note))
    return found


def _merged(motion: Motion, shortest: float) -> tuple[FloatArray, list[str]]:
    """Events, with sticks shorter than `shortest` taken for reversals in their middle."""
    angles, kinds = motion.angles.tolist(), list(motion.kinds)
    i = 0
    while shortest and i < len(kinds) and len(kinds) > 1:
        j = (i + 1) % len(kinds)
        length = (angles[j] - angles[i]) % motion.periods
        if kinds[i] == "stick" and length < shortest:
            angles[i], kinds[i] = (angles[i] + 0.5 * length) % motion.periods, "reverse"
            del angles[j], kinds[j]
        else:
            i += 1
    order = np.argsort(angles)
    return np.array(angles)[order], [kinds[k] for k in order]


def _latest(
    first: tuple[FloatArray, list[str]], second: tuple[FloatArray, list[str]], periods: int
) -> float:
    """Largest distance between events of two closed motions, in periods; inf when they differ."""
    count = len(first[1])
    if count != len(second[1]):
        return math.inf
    if count == 0:
        return 0.0
    best = math.inf
    for turn in range(count):
        if first[1] == second[1][turn:] + second[1][:turn]:
            gap = np.mod(first[0] - np.roll(second[0], -turn) + 0.5 * periods, periods)
            best = min(best, float(np.abs(gap - 0.5 * periods).max()))
    return best
