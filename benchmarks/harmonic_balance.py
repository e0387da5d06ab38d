"""Time and reliability of harmonic balance: python benchmarks/harmonic_balance.py [--quick]

The paper's drive, 8 sine functions per span, 6 speeds and 5 torques, every solution from a cold
start with its impedances: the set-valued method (bare, and as a whole `Response`), and a ladder in
sigma with scipy's root (analytic Jacobian, from 1 down to 1e-4), in one run on one thread.
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
from beltsim.harmonic_balance import Settings, solve
from beltsim.harmonic_balance.condensation import condense
from beltsim.harmonic_balance.saturated import balance_of
from beltsim.harmonic_balance.set_valued import solve as bare_solve
from beltsim.problem import FrictionProblem

SPEEDS = (2.8, 4.2, 5.7, 6.3, 8.0, 8.7)
TORQUES = (0.1, 0.5, 1.5, 3.5, 6.1)
BARE = Settings(estimate=False)


def bare(problem: FrictionProblem, R: int) -> Any:
    """The joint's harmonics alone."""
    problem.shared.clear()
    return bare_solve(condense(problem, R), problem.friction.Q_m, BARE)


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
    """scipy.optimize.root on the condensed balance, sigma from 1 to 1e-4."""
    problem.shared.clear()
    condensed = condense(problem, R)
    x = np.stack([condensed.velocity.real, -condensed.velocity.imag], 1).ravel()
    for sigma in 10.0 ** -np.arange(0.0, 4.01, 0.5):
        law = SaturatedCoulomb(problem.friction.Q_m, float(sigma))
        balance = balance_of(condensed, law, max(256, 24 * R))
        found = root(balance.residual, x, jac=balance.jacobian)
        if not found.success:
            raise BeltsimError
        x = found.x
    return x


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
        for method in (bare, whole, papers, ladder):
            with contextlib.suppress(BeltsimError):
                method(problems[0], R)  # compile, or load what was compiled
            times, good = [], 0
            for problem in problems:
                start = time.perf_counter()
                try:
                    method(problem, R)
                    good += 1
                except BeltsimError:
                    pass
                times.append(1e3 * (time.perf_counter() - start))
            median, most = float(np.median(times)), max(times)
            share = f"{good}/{len(problems)}"
            print(f"{method.__name__:10} {R:3} {share:>10} {median:10.2f} {most:8.2f}", flush=True)


if __name__ == "__main__":
    main()
