"""Time of the exact event map beside scikit-sundae and scipy, in one process.

    python benchmarks/event_map.py [--periods 100] [--repeats 5] [--quick] [--no-peers]

Transients start from rest: the paper's drive with 8 sine functions per span (n = 27) at four
operating points, then random gyroscopic systems of n = 54, 108, 216 whose spectrum widens with n.
The event map is timed through `event_map.propagate` with set-up (matrices to `Response`) and with
the modes at hand ("cached"); "walk", and what is said per period and event, is without the making
of the `Response`. Its peers are those of benchmarks/transient.py, each with its set-up:
scikit-sundae (CVODE Adams, rtol 1e-8, kernels by numba, a new solver object per segment) and
scipy's DOP853 at rtol 1e-5. Errors are taken against tests/support/exact.py:

* errx: largest error of the end state over its largest entry,
* errt: largest error of an event time, over the period; nan where the sequence differs.

Times are the best of the repeats, of one thread, in processor time, so that a busy machine decides
less; maps are wall time, on one worker and on two, from the drive to arrays.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy reads it

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import transient as peers
from support.exact import exact_transient  # tests/, on the path since `transient`

import beltsim
from beltsim import Coulomb, FrictionProblem, HarmonicForcing, event_map, linear
from beltsim.event_map.walk import walk

POINTS = ((6.3, 3.5), (8.7, 3.5), (6.3, 0.5), (2.8, 0.5))
SIZES = (54, 108, 216)
TORQUES = (0.5, 1.5, 3.5, 6.1, 10.0)
EVENTS = event_map.Settings(keep="events")
LEAN = event_map.Settings(samples_per_period=1, harmonics=0)
PEERS = {"sundae": (peers.sundae, 1e-8), "dop853": (peers.dop853, 1e-5)}
FIRST = """
import time
start = time.perf_counter()
import beltsim
drive = beltsim.presets.zhu_parker_2008()
problem = beltsim.assemble(drive, 6.3, friction=beltsim.Coulomb(3.5), n_functions=8)
beltsim.event_map.periodic(problem)
print(time.perf_counter() - start)
"""


def drive_problem(Omega: float, Q_m: float, drive: Any = None) -> FrictionProblem:
    return beltsim.assemble(
        drive or beltsim.presets.zhu_parker_2008(),
        Omega,
        friction=Coulomb(Q_m),
        n_functions=8,
        residual_flexibility=False,
    )


def random_problem(n: int) -> FrictionProblem:
    """A stable gyroscopic system with frequencies up to 25 n/27 times the forcing's."""
    rng = np.random.default_rng(n)
    modes = np.linalg.qr(rng.standard_normal((n, n)))[0] * rng.uniform(0.7, 1.4, n)[:, None]
    w = np.linspace(0.5, 25.0 * n / 27.0, n)
    back = np.linalg.inv(modes)
    M, K, C = (back.T @ np.diag(d) @ back for d in (np.ones(n), w**2, 0.04 * w))
    M, K, C = ((A + A.T) / 2.0 for A in (M, K, C))
    G = 0.3 * rng.standard_normal((n, n))
    cos, sin = np.zeros((2, n)), np.zeros((2, n))
    cos[1] = rng.standard_normal(n)
    forcing = HarmonicForcing(1.0, cos, sin)
    free = FrictionProblem(M, C, G - G.T, K, 0, forcing, Coulomb(1.0))
    return free.with_friction(Coulomb(0.35 * linear.critical_torque(free)))


def fresh(of: FrictionProblem) -> FrictionProblem:
    """The same problem without what was derived from it."""
    return FrictionProblem(of.M, of.C, of.G, of.K, of.joint, of.forcing, of.friction)


def best(work: Callable[[], Any], repeats: int) -> float:
    """Least processor time of the repeats, in seconds."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def errors(problem: FrictionProblem, exact: Any, kind: list[str], t: Any, final: Any) -> str:
    errx = np.abs(final - exact.final_state).max() / np.abs(exact.final_state).max()
    errt = math.nan
    if kind == list(exact.kind):
        errt = np.abs(np.asarray(t) - exact.t).max(initial=0.0) / problem.period
    return f"{errx:.0e} / {errt:.0e}"


def transient(label: str, at: FrictionProblem, few: float, options: Any, beside: bool) -> float:
    """One line of the table; returns the time per period with modes at hand.

    The event map runs over all periods, the peers and the errors over `few`.
    """
    periods, repeats = options.periods, options.repeats
    whole = best(lambda: event_map.propagate(fresh(at), periods, settings=EVENTS), repeats)
    cached = best(lambda: event_map.propagate(at, periods, settings=EVENTS), 3 * repeats)
    events = len(event_map.propagate(at, periods, settings=EVENTS).events)
    exact, run = exact_transient(at, few), event_map.propagate(at, few, settings=EVENTS)
    ours = errors(at, exact, run.events.kind.tolist(), run.events.t, run.final_state)
    bare = best(lambda: walk(at, np.zeros(2 * at.n), periods), 3 * repeats)
    cells = [f"{events}", f"{1e3 * whole:.2f}", f"{1e3 * cached:.2f}", f"{1e3 * bare:.2f}"]
    cells += [f"{1e6 * bare / periods:.1f}", f"{1e6 * bare / max(1, events):.1f}", ours]
    for solve, rtol in PEERS.values() if beside else ():
        spent, got = math.inf, None
        for _ in range(min(repeats, 2)):
            start = time.process_time()
            got = solve(at, few, rtol, 0.01 * rtol)
            spent = min(spent, time.process_time() - start)
        spent *= periods / few
        cells += [
            f"{1e3 * spent:.0f}",
            f"{spent / whole:.0f}x, {spent / cached:.0f}x",
            errors(at, exact, got.kind, got.t, got.final),
        ]
    print(f"| {label} | {at.n} | {few:g} | " + " | ".join(cells) + " |", flush=True)
    return bare / periods


def transients(options: Any, beside: bool, sizes: tuple[int, ...]) -> None:
    names, periods = list(PEERS) if beside else [], options.periods
    print(f"\n{periods:g} periods; peers and errors over fewer where so marked, scaled")
    columns = [
        "case",
        "n",
        "peers' periods",
        "events",
        "set-up ms",
        "cached ms",
        "walk ms",
        "us/period",
    ]
    columns += ["us/event", "errx / errt"]
    columns += [each for name in names for each in (f"{name} ms", "ratios", "errx / errt")]
    print("\n| " + " | ".join(columns) + " |\n|" + "---|" * len(columns))
    if beside:
        peers.KERNELS.extend(peers.make_kernels())
        for solve, rtol in PEERS.values():
            solve(drive_problem(6.3, 3.5), 1.0, rtol, rtol)  # compiles, and loads what it needs
    spent = [
        transient(f"({Omega}, {Q_m})", drive_problem(Omega, Q_m), periods, options, beside)
        for Omega, Q_m in POINTS
    ]
    cost = [(27, spent[0])]
    for n in sizes:
        few = max(3.0, round(periods * (27.0 / n) ** 1.7))
        cost.append((n, transient("random", random_problem(n), few, options, beside)))
    n, each = np.log(np.array(cost)).T
    if len(cost) > 2:
        print(f"\nexponent of the cost in n, 27 to {sizes[-1]}: {np.polyfit(n, each, 1)[0]:.2f}")


def locked(repeats: int) -> None:
    """A joint that has come to rest for ever."""
    at = drive_problem(2.8, 3.5)
    still = event_map.periodic(at).initial_state
    times = [
        best(lambda p=p: event_map.propagate(at, p, still, EVENTS), repeats)
        for p in (1000.0, 11000.0)
    ]
    print(f"\nlocked at (2.8, 3.5): {1e6 * (times[1] - times[0]) / 10000.0:.2f} us per period")


def orbits(repeats: int) -> None:
    print("\n| orbit at | survey of one, ms | periodic, few samples, ms | periodic, ms |")
    print("|---|---|---|---|")
    for Omega, Q_m in POINTS[:3]:
        at = drive_problem(Omega, Q_m)
        event_map.periodic(at)
        cells = [
            best(lambda at=at: event_map.survey([at], workers=1), 8 * repeats),
            best(lambda at=at: event_map.periodic(at, LEAN), 8 * repeats),
            best(lambda at=at: event_map.periodic(at), 8 * repeats),
        ]
        print(f"| ({Omega}, {Q_m}) | " + " | ".join(f"{1e3 * each:.2f}" for each in cells) + " |")


def grid(points: int) -> list[FrictionProblem]:
    found: list[FrictionProblem] = []
    drive = beltsim.presets.zhu_parker_2008()
    for Omega in np.linspace(0.6, 12.0, points):
        at = drive_problem(float(Omega), TORQUES[0], drive)
        found += [at.with_friction(Coulomb(Q)) for Q in TORQUES]
    return found


def maps(points: int, repeats: int) -> None:
    """Wall time of a map of figures, and of the Responses, on one worker and on two."""
    print(f"\nmap of {len(TORQUES) * points} orbits, {points} Omega x {len(TORQUES)} Q_m, n = 27\n")
    print("| call | workers | s, from the drive | of it assembly | processor s | failures |")
    print("|---|---|---|---|---|---|")
    alone: dict[str, float] = {}
    for name in ("survey", "solve_many"):
        for workers in (1, 2):
            rows = []
            for _ in range(repeats):
                start, busy = time.perf_counter(), time.process_time()
                problems = grid(points)
                made = time.perf_counter() - start
                if name == "survey":
                    failures = len(event_map.survey(problems, workers=workers).failures)
                else:
                    solved = event_map.solve_many(problems, LEAN, workers)
                    failures = sum(isinstance(each, Exception) for each in solved)
                spent = time.perf_counter() - start
                rows.append((spent, made, time.process_time() - busy, failures))
            spent, made, busy, failures = min(rows)
            print(
                f"| {name} | {workers} | {spent:.2f} | {made:.2f} | {busy:.2f} | {failures} |",
                flush=True,
            )
            if workers == 1:
                alone[name] = spent - made
            else:
                share = alone[name] / (2.0 * (spent - made))
                print(f"| {name} | efficiency on two, after assembly | {share:.2f} | | | |")


def first_result() -> None:
    command = [sys.executable, "-c", FIRST]
    times = [
        float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        for _ in range(3)
    ]
    print(f"\nfrom `import beltsim` to the first orbit: {min(times):.2f} s")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--periods", type=float, default=100.0)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--quick", action="store_true", help="no peers, no large n, a smaller map")
    parser.add_argument("--no-peers", action="store_true", help="the event map alone")
    options = parser.parse_args()
    quick = options.quick
    print(f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    beside = not (quick or options.no_peers)
    transients(options, beside, () if quick else SIZES)
    locked(options.repeats)
    orbits(options.repeats)
    maps(24 if quick else 120, min(options.repeats, 3))
    first_result()
    print(f"\nload average {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
