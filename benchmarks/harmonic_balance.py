"""Time and reliability of harmonic balance: python benchmarks/harmonic_balance.py [--quick]

The paper's drive, 8 sine functions per span, in one run on one thread:

* 6 speeds and 5 torques, every solution from a cold start with its impedances: the set-valued
  method (`survey` of one problem, and a whole `Response`), the paper's method with its ladder, and
  a ladder in sigma with scipy's root (analytic Jacobian, 1 to 1e-4 in 8 steps a decade or more,
  secant starts, failed steps halved);
* the map of 120 speeds and 5 torques at R = 25, from the drive to arrays;
* the search for instants alone against the number of coordinates.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import contextlib
import time
from typing import Any

import numpy as np
from scipy.optimize import root

import beltsim
from beltsim.errors import BeltsimError
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance import Settings, set_valued, solve, survey
from beltsim.harmonic_balance.condensation import condense
from beltsim.harmonic_balance.saturated import balance_of
from beltsim.problem import FrictionProblem

SPEEDS = (2.8, 4.2, 5.7, 6.3, 8.0, 8.7)
TORQUES = (0.5, 1.5, 3.5, 6.1, 10.0)
BARE = Settings(estimate=False)


def figures(problem: FrictionProblem, R: int) -> Any:
    """rms, dissipated energy and critical torques of one problem."""
    problem.shared.clear()
    found = survey([problem], workers=1, R=R)
    for error in found.failures.values():
        raise error
    return found


def whole(problem: FrictionProblem, R: int) -> Any:
    """A `Response` with samples, events and figures."""
    problem.shared.clear()
    return solve(problem, R, BARE)


def papers(problem: FrictionProblem, R: int) -> Any:
    """The paper's method with its ladder."""
    problem.shared.clear()
    law = SaturatedCoulomb(problem.friction.Q_m, 1e-4)
    return solve(problem.with_friction(law), R, Settings(estimate=False, sigma_ladder=True))


def ladder(problem: FrictionProblem, R: int) -> Any:
    """scipy.optimize.root on the condensed balance, sigma from 1 to 1e-4 with secant starts."""
    problem.shared.clear()
    condensed = condense(problem, R)
    x = np.stack([condensed.velocity.real, -condensed.velocity.imag], 1).ravel()
    level, step, before = 0.0, 0.125, (0.0, x)
    solved = False
    while not solved or level < 4.0:
        following = min(level + step, 4.0) if solved else 0.0
        law = SaturatedCoulomb(problem.friction.Q_m, 10.0**-following)
        balance = balance_of(condensed, law, Settings(samples=max(256, 24 * R)))
        guess = x
        if solved and level > before[0]:
            guess = x + (x - before[1]) * (following - level) / (level - before[0])
        found = root(balance.residual, guess, jac=balance.jacobian)
        scale = max(float(np.abs(balance.load).max()), problem.friction.Q_m)
        if np.abs(balance.residual(found.x)).max() < 1e-6 * scale:
            before, x, level, solved = (level, x), found.x, following, True
            step = min(2.0 * step, 0.125)
        elif step < 1e-3:
            raise BeltsimError
        else:
            step *= 0.5
    return x


def of_map(drive: Any, R: int) -> str:
    """The map of 600 points: its best time of five, in parts."""
    best = (np.inf, np.inf, 0)
    for _ in range(5):
        start = time.perf_counter()
        systems = [
            beltsim.assemble(drive, Omega, n_functions=8) for Omega in np.linspace(0.6, 12.0, 120)
        ]
        problems = [system.with_friction(Coulomb(Q)) for system in systems for Q in TORQUES]
        assembled = time.perf_counter()
        found = survey(problems, workers=1, R=R)
        end = time.perf_counter()
        good = int(found.converged.sum())
        best = min(best, (end - start, assembled - start, good))
    return f"{best[0]:.3f} s (assembly {best[1]:.3f} s), {best[2]} of 600 converged"


def against_size(drive: Any, R: int) -> str:
    """Microseconds of the search for instants, over the number of coordinates."""
    shown = []
    for n_functions in (8, 16, 40):
        problem = beltsim.assemble(drive, 6.3, n_functions=n_functions)
        condensed = condense(problem, R)
        times = []
        for _ in range(200):
            start = time.perf_counter()
            set_valued.solve(condensed, 3.5, BARE)
            times.append(time.perf_counter() - start)
        shown.append(f"n = {problem.n}: {1e6 * min(times):.0f} us")
    return ", ".join(shown)


def main() -> None:
    """Print one line per method and R."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--quick", action="store_true", help="R = 9 and 25 alone")
    orders = (9, 25) if options.parse_args().quick else (9, 15, 25, 51)
    drive = beltsim.presets.zhu_parker_2008()
    systems = [beltsim.assemble(drive, Omega, n_functions=8) for Omega in SPEEDS]
    problems = [system.with_friction(Coulomb(Q)) for system in systems for Q in TORQUES]
    print(f"{'method':10} {'R':>3} {'converged':>10} {'median ms':>10} {'max ms':>8}")
    for R in orders:
        for method in (figures, whole, papers, ladder):
            with contextlib.suppress(BeltsimError):
                method(problems[0], R)  # compile, or load what was compiled
            times, good = [], 0
            for problem in problems:
                trials = []
                for _ in range(5 if method in (figures, whole) else 1):
                    start = time.perf_counter()
                    failed = False
                    try:
                        method(problem, R)
                    except BeltsimError:
                        failed = True
                    trials.append(1e3 * (time.perf_counter() - start))
                good += not failed
                times.append(min(trials))
            median, most = float(np.median(times)), max(times)
            share = f"{good}/{len(problems)}"
            print(f"{method.__name__:10} {R:3} {share:>10} {median:10.3f} {most:8.2f}", flush=True)
    for R in (9, 25):
        print(f"map, R = {R}: {of_map(drive, R)}")
    for R in (9, 25):
        print(f"one torque, R = {R}, impedances known: {against_size(drive, R)}")


if __name__ == "__main__":
    main()
