"""Time of the exact event map: transients, orbits, and a map of 600 orbits.

    python benchmarks/event_map.py [--periods 100] [--repeats 5] [--quick]

The paper's drive from rest. Transients of the map are timed with set-up (matrices to last event)
and with the modes at hand; beside it scikit-sundae (CVODE Adams, rtol 1e-8, numba) of
benchmarks/transient.py in the same run. Times are the best of the repeats, of one thread,
processor time; the map of 600 orbits is wall time, on one worker and on two.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy reads it

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

import beltsim
from beltsim import Coulomb, FrictionProblem, event_map
from beltsim.event_map.flows import flows_of
from beltsim.event_map.walk import walk

POINTS = ((6.3, 3.5), (8.7, 3.5), (6.3, 0.5), (2.8, 0.5))
FUNCTIONS = {27: 8, 54: 17, 108: 35, 216: 71}


def problem(Omega: float, Q_m: float, functions: int = 8) -> FrictionProblem:
    drive = beltsim.presets.zhu_parker_2008()
    options: dict[str, Any] = {"n_functions": functions, "residual_flexibility": False}
    return beltsim.assemble(drive, Omega, friction=Coulomb(Q_m), **options)


def fresh(of: FrictionProblem) -> FrictionProblem:
    """The same problem without what was derived from it."""
    return FrictionProblem(of.M, of.C, of.G, of.K, of.joint, of.forcing, of.friction)


def best(work: Callable[[], Any], repeats: int) -> float:
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def transients(periods: float, repeats: int, peers: bool) -> None:
    print(f"\nTransients over {periods:g} periods, n = 27")
    print("  Omega  Q_m  events  set-up ms  cached ms  us/period  us/event  sundae/set-up  /cached")
    for Omega, Q_m in POINTS:
        at = problem(Omega, Q_m)
        rest = np.zeros(2 * at.n)
        whole = best(lambda at=at, rest=rest: walk(fresh(at), rest, periods), repeats)
        flows_of(at)
        cached = best(lambda at=at, rest=rest: walk(at, rest, periods), repeats)
        events = len(walk(at, rest, periods).t)
        ratios = _peer_ratios(at, periods, (whole, cached)) if peers else ["-", "-"]
        print(
            f"  {Omega:5.1f}  {Q_m:3.1f}  {events:6d}  {1e3 * whole:9.2f}  {1e3 * cached:9.2f}  "
            f"{1e6 * cached / periods:9.1f}  {1e6 * cached / max(events, 1):8.1f}  "
            f"{ratios[0]:>13}  {ratios[1]:>7}"
        )


def _peer_ratios(at: FrictionProblem, periods: float, ours: tuple[float, float]) -> list[str]:
    import transient as peers  # benchmarks/transient.py

    if not peers.KERNELS:
        peers.KERNELS.extend(peers.make_kernels())

    peers.sundae(at, 2.0, 1e-8, 1e-10)  # compiles its kernels
    start = time.process_time()
    peers.sundae(at, periods, 1e-8, 1e-10)
    spent = time.process_time() - start
    return [f"{spent / each:.0f}" for each in ours]


def growth(periods: float, repeats: int) -> None:
    print("\nGrowth with n, at (6.3, 3.5), modes at hand")
    sizes, times = [], []
    for n, functions in FUNCTIONS.items():
        at = problem(6.3, 3.5, functions)
        rest = np.zeros(2 * at.n)
        flows_of(at)
        spent = best(lambda at=at, rest=rest: walk(at, rest, periods), repeats)
        sizes.append(at.n)
        times.append(spent)
        print(f"  n = {at.n:3d} (of {n})  {1e6 * spent / periods:8.1f} us/period")
    slope = np.polyfit(np.log(sizes), np.log(times), 1)[0]
    print(f"  exponent {slope:.2f}")


def orbits(repeats: int) -> None:
    print("\nOne periodic orbit with its multipliers, modes at hand, n = 27")
    lean = event_map.Settings(samples_per_period=1, harmonics=0)
    for Omega, Q_m in POINTS[:3]:
        at = problem(Omega, Q_m)
        event_map.periodic(at, lean)
        cold = best(lambda at=at: event_map.periodic(at, lean), 4 * repeats)
        print(f"  ({Omega}, {Q_m})  {1e3 * cold:6.2f} ms")


def big_map(points: int) -> None:
    lean = event_map.Settings(samples_per_period=1, harmonics=0)
    print(f"\nMap of {5 * points} orbits: {points} Omega x 5 Q_m, n = 27, wall time with assembly")
    torques = (0.5, 1.5, 3.5, 6.0, 10.0)
    for workers in (1, 2):
        start, busy = time.perf_counter(), time.process_time()
        grid = []
        for Omega in np.linspace(0.6, 12.0, points):
            at = problem(float(Omega), 0.5)
            grid += [at.with_friction(Coulomb(Q)) for Q in torques]
        made = time.perf_counter() - start
        found = event_map.solve_many(grid, lean, workers)
        rms = [event_map.rms(each) for each in found if not isinstance(each, Exception)]
        spent = time.perf_counter() - start
        busy = time.process_time() - busy
        print(
            f"  {workers} worker(s): {spent:.2f} s, {made:.2f} s of it assembly; "
            f"processor {busy:.2f} s; {len(found) - len(rms)} failures"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--periods", type=float, default=100.0)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--quick", action="store_true", help="no peers, a smaller map")
    options = parser.parse_args()
    transients(options.periods, options.repeats, not options.quick)
    growth(min(options.periods, 30.0), options.repeats)
    orbits(options.repeats)
    big_map(24 if options.quick else 120)


if __name__ == "__main__":
    main()
