"""Problems that graze: an event pair appears or vanishes as the friction torque changes.

The grazing torque of a random problem is found by bisection on the event sequence of the exact
solver, to 1e-14 of itself. Offsets from it, on both sides, make near-grazing problems.

Finding one takes seconds, so a hundred of them are kept in tests/data/grazing.csv. To make the file
anew: `python -m support.grazing` in the folder tests.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from support.exact import ExactRun, exact_transient
from support.problems import critical_torque, random_problem

from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem

FILE = Path(__file__).parent.parent / "data" / "grazing.csv"
PERIODS = 3.0
OFFSETS = tuple(sign * 10.0**-k for k in range(2, 11) for sign in (1.0, -1.0))


@dataclass(frozen=True)
class GrazingCase:
    """A problem whose event sequence changes at the torque `Q_g`, at about time `t`.

    `kind`: ``velocity`` (a minimum of the speed reaches zero) or ``reaction`` (a maximum of the
    holding reaction reaches the static limit).
    """

    seed: int
    problem: FrictionProblem
    Q_g: float
    kind: str
    t: float

    def at(self, offset: float) -> FrictionProblem:
        """The problem with Q_m = Q_g (1 + offset), the ratio Q_s/Q_m kept."""
        return _with_torque(self.problem, self.Q_g * (1.0 + offset))


def stored_cases(count: int | None = None) -> list[GrazingCase]:
    """The first `count` cases of the file."""
    with FILE.open(newline="") as lines:
        rows = list(csv.DictReader(lines))[:count]
    return [
        GrazingCase(
            int(row["seed"]),
            random_problem(int(row["seed"])),
            float(row["Q_g"]),
            row["kind"],
            float(row["t"]),
        )
        for row in rows
    ]


def grazing_case(seed: int) -> GrazingCase | None:
    """A grazing case from the recipe; None when this seed's scan meets none."""
    problem = random_problem(seed)
    Q_cr = critical_torque(problem)
    torques = Q_cr * np.linspace(0.05, 0.95, 12)
    like = exact_transient(problem, 0.01)
    runs = [exact_transient(_with_torque(problem, Q), PERIODS, like=like) for Q in torques]
    for i in range(len(runs) - 1):
        if runs[i].kind != runs[i + 1].kind:
            case = _bisected(seed, problem, torques[i : i + 2], runs[i])
            if case is not None:
                return case
    return None


def _with_torque(problem: FrictionProblem, Q: float) -> FrictionProblem:
    ratio = problem.friction.Q_s / problem.friction.Q_m
    return problem.with_friction(Coulomb(Q, max(Q, Q * ratio)))


def _bisected(seed: int, problem, bracket, first: ExactRun) -> GrazingCase | None:
    """Halve [low, high] while the sequence at `low` stays that of `first`."""

    def run(Q: float) -> ExactRun:
        return exact_transient(_with_torque(problem, Q), PERIODS, like=first)

    low, high = bracket
    while high - low > 1e-14 * high:
        middle = 0.5 * (low + high)
        if run(middle).kind == first.kind:
            low = middle
        else:
            high = middle
    for Q in (low, high):
        touch = _touch(run(Q))
        if touch is not None:
            return GrazingCase(seed, problem, float(Q), *touch)
    return None  # it was an event at the end of the run, or the border of stick and reverse


def _touch(run: ExactRun) -> tuple[str, float] | None:
    """Kind and time of a touch closer than rounding explains, away from the run's end."""
    if not len(run.touch_t):
        return None
    i = int(np.argmin(run.touch_margin))
    if run.touch_margin[i] > 1e-12 or run.touch_t[i] > 0.99 * run.end:
        return None
    return run.touch_kind[i], float(run.touch_t[i])


def main() -> None:
    FILE.parent.mkdir(exist_ok=True)
    cases: list[GrazingCase] = []
    seed = 0
    while len(cases) < 100:
        case = grazing_case(seed)
        cases += [case] if case else []
        seed += 1
    with FILE.open("w", newline="") as lines:
        rows = csv.writer(lines, lineterminator="\n")
        rows.writerow(["seed", "n", "Q_g", "kind", "t"])
        rows.writerows([c.seed, c.problem.n, repr(c.Q_g), c.kind, f"{c.t:.9g}"] for c in cases)
    sys.stdout.write(f"{len(cases)} cases of {seed} seeds\n")


if __name__ == "__main__":
    main()
