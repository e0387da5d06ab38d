"""Time and error of one run: the C core beside scikit-sundae and scipy, in one process.

    python benchmarks/transient.py [--periods 100] [--repeats 3] [--quick]

The paper's drive with 8 sine functions per span (27 degrees of freedom), from rest, at four
operating points. Every solver is timed from the matrices to the last event, its set-up included,
interleaved with the others; times are processor time of one thread, so that a busy machine does not
decide. Errors are taken against the exact piecewise-linear computation of
tests/support/exact.py:

* errx: largest error of the end state over the largest entry of it,
* errt: largest error of an event time, over the period (only where the sequence agrees).

The last table interpolates each solver's time at an equal error of 1e-8 (log-log between its
tolerances) and divides scikit-sundae's by it.

scikit-sundae: CVODE Adams, right-hand side and roots compiled by numba, one root set per mode with
directions, a new solver object per segment (an object used twice repeats its first events). scipy:
DOP853 with a terminal event per segment.
"""

# ruff: noqa: ANN001, ANN202 - numba infers the types of its kernels
from __future__ import annotations

import argparse
import math
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy reads it

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from support.exact import exact_transient

import beltsim
from beltsim import Coulomb, FrictionProblem
from beltsim.transient import Settings, integrate, solve_many

POINTS = ((6.3, 0.5), (6.3, 3.5), (8.7, 3.5), (2.8, 0.5))
EQUAL_ERROR = 1e-8
#: A peer that has not come to the end after this processor time is stopped and marked.
PATIENCE_SECONDS = 30.0


@dataclass(frozen=True)
class Outcome:
    """What a solver returns: events and the state at the end."""

    kind: list[str]
    t: np.ndarray
    final: np.ndarray


# --- one set of matrices per mode, for the peers -------------------------------------------------


class Segments:
    """First-order form of both modes, and the transition rule, written for the peers."""

    def __init__(self, problem: FrictionProblem) -> None:
        n, j = problem.n, problem.joint
        damping = problem.C + problem.G
        held = np.delete(np.arange(n), j)
        block = np.ix_(held, held)
        self.n, self.j, self.Omega = n, j, problem.forcing.Omega
        self.Q_m, self.Q_s = problem.friction.Q_m, problem.friction.Q_s
        self.slip = np.zeros((2 * n, 2 * n))
        self.slip[:n, n:] = np.eye(n)
        self.slip[n:] = -np.linalg.solve(problem.M, np.hstack([problem.K, damping]))
        self.stick = np.zeros_like(self.slip)
        self.stick[held, n + held] = 1.0
        rows = np.hstack([problem.K[held], damping[held]])
        rows[:, n + j] = 0.0
        self.stick[n + held] = -np.linalg.solve(problem.M[block], rows)
        self.u = np.zeros(2 * n)
        self.u[n:] = np.linalg.solve(problem.M, np.eye(n)[j])
        c, s = problem.forcing.cos, problem.forcing.sin
        H = len(c)
        self.slip_f, self.stick_f = np.zeros((2, 2 * n, 2 * H))
        both = np.hstack([c.T, s.T])
        self.slip_f[n:] = np.linalg.solve(problem.M, both)
        self.stick_f[n + held] = np.linalg.solve(problem.M[block], both[held])
        row = np.hstack([problem.K[j], damping[j]])
        row[n + j] = 0.0
        self.row = -row - problem.M[j] @ self.stick[n:]
        self.row_f = both[j] - problem.M[j] @ self.stick_f[n:]
        self.H = H

    def basis(self, t: float) -> np.ndarray:
        """Factors of the forcing's coefficients at time t."""
        angle = np.arange(self.H) * self.Omega * t
        return np.concatenate([np.cos(angle), np.sin(angle)])

    def reaction(self, t: float, y: np.ndarray) -> float:
        """Torque that would hold the joint."""
        return float(self.row @ y + self.row_f @ self.basis(t))

    def at_rest(self, t: float, y: np.ndarray) -> str:
        """Mode of the joint once its velocity is zero."""
        y[self.n + self.j] = 0.0
        H = self.reaction(t, y)
        if abs(H) <= self.Q_s:
            return "stick"
        return "slip+" if H > 0 else "slip-"

    def march(self, t_end: float, segment: Callable[[str, float, np.ndarray], Any]) -> Outcome:
        """Segments until `t_end`; `segment` returns (t, y, side or None)."""
        t, y = 0.0, np.zeros(2 * self.n)
        mode = self.at_rest(t, y)
        kinds, times = [], []
        began = time.process_time()
        while t < t_end:
            if time.process_time() - began > PATIENCE_SECONDS:
                return Outcome(
                    [*kinds, "gave up"], np.array([*times, t]), np.full_like(y, math.nan)
                )
            t, y, side = segment(mode, t, y)
            if side is None:
                break
            if mode == "stick":
                after = "slip+" if side > 0 else "slip-"
                y[self.n + self.j] = 0.0
                kinds.append(after)
            else:
                after = self.at_rest(t, y)
                kinds.append("stick" if after == "stick" else "reverse")
            times.append(t)
            mode = after
        return Outcome(kinds, np.array(times), y)


# --- scikit-sundae ------------------------------------------------------------------------------


def make_kernels() -> Any:
    import numba

    @numba.njit
    def rhs(t, y, out, A, F, u, level, Omega):
        H = F.shape[1] // 2
        out[:] = A @ y
        for k in range(H):
            c, s = math.cos(k * Omega * t), math.sin(k * Omega * t)
            for i in range(out.size // 2, out.size):
                out[i] += F[i, k] * c + F[i, H + k] * s
        if level != 0.0:
            for i in range(out.size // 2, out.size):
                out[i] -= level * u[i]

    @numba.njit
    def reaction(t, y, row, row_f, Omega):
        H = row_f.size // 2
        total = row @ y
        for k in range(H):
            total += row_f[k] * math.cos(k * Omega * t) + row_f[H + k] * math.sin(k * Omega * t)
        return total

    return rhs, reaction


KERNELS: list[Any] = []


def sundae(problem: FrictionProblem, periods: float, rtol: float, atol: np.ndarray) -> Outcome:
    """Set-valued law with a new CVODE object per segment."""
    from sksundae.cvode import CVODE

    rhs_kernel, reaction_kernel = KERNELS
    s = Segments(problem)
    t_end = periods * problem.period
    at = s.n + s.j

    def segment(mode: str, t: float, y: np.ndarray) -> Any:
        stuck = mode == "stick"
        A, F = (s.stick, s.stick_f) if stuck else (s.slip, s.slip_f)
        sign = {"stick": 0.0, "slip+": 1.0, "slip-": -1.0}[mode]

        def rhs(t: float, y: np.ndarray, out: np.ndarray) -> None:
            rhs_kernel(t, y, out, A, F, s.u, sign * s.Q_m, s.Omega)

        def roots(t: float, y: np.ndarray, out: np.ndarray) -> None:
            if stuck:
                R = reaction_kernel(t, y, s.row, s.row_f, s.Omega)
                out[0], out[1] = s.Q_s - R, s.Q_s + R
            else:
                out[0] = sign * y[at]

        count = 2 if stuck else 1
        roots.terminal = [True] * count
        roots.direction = [-1] * count
        solver = CVODE(
            rhs,
            method="Adams",
            rtol=rtol,
            atol=atol,
            eventsfn=roots,
            num_events=count,
            max_num_steps=10**6,
        )
        got = solver.solve(np.array([t, t_end]), y)
        y = np.array(got.y[-1])
        if got.t_events is None or len(got.t_events) == 0:
            return got.t[-1], y, None
        side = 1 if not stuck or got.i_events[-1][0] else -1
        return float(got.t_events[-1]), np.array(got.y_events[-1]), side

    return s.march(t_end, segment)


# --- scipy --------------------------------------------------------------------------------------


def dop853(problem: FrictionProblem, periods: float, rtol: float, atol: np.ndarray) -> Outcome:
    """DOP853 of scipy with terminal events."""
    from scipy.integrate import solve_ivp

    s = Segments(problem)
    t_end = periods * problem.period
    at = s.n + s.j

    def segment(mode: str, t: float, y: np.ndarray) -> Any:
        stuck = mode == "stick"
        A, F = (s.stick, s.stick_f) if stuck else (s.slip, s.slip_f)
        sign = {"stick": 0.0, "slip+": 1.0, "slip-": -1.0}[mode]
        constant = -sign * s.Q_m * s.u

        def rhs(t: float, y: np.ndarray) -> np.ndarray:
            return A @ y + F @ s.basis(t) + constant

        if stuck:
            events = [lambda t, y: s.Q_s - s.reaction(t, y), lambda t, y: s.Q_s + s.reaction(t, y)]
        else:
            events = [lambda _t, y: sign * y[at]]
        for event in events:
            event.terminal, event.direction = True, -1.0
        got = solve_ivp(rhs, (t, t_end), y, "DOP853", events=events, rtol=rtol, atol=atol)
        if got.status != 1:
            return got.t[-1], got.y[:, -1], None
        side = 1 if len(got.t_events[0]) else -1
        which = 0 if side > 0 else 1
        return float(got.t_events[which][-1]), got.y_events[which][-1].copy(), side

    return s.march(t_end, segment)


# --- ours ---------------------------------------------------------------------------------------


def ours(method: str) -> Callable[..., Outcome]:
    def run(problem: FrictionProblem, periods: float, rtol: float, _: np.ndarray) -> Outcome:
        settings = Settings(rtol=rtol, method=method, event_states=False)
        response = integrate(problem, periods, settings=settings)
        kind = ["slip+" if k == "slip+" else str(k) for k in response.events.kind]
        return Outcome(kind, response.events.t, response.final_state)

    return run


SOLVERS: dict[str, tuple[Callable[..., Outcome], tuple[float, ...]]] = {
    "core, Adams": (ours("adams"), (1e-6, 1e-7, 1e-8, 1e-9)),
    "core, Taylor": (ours("taylor"), (1e-4, 1e-6, 1e-8)),
    "scikit-sundae, Adams": (sundae, (1e-7, 1e-8, 1e-9, 1e-10)),
    "scipy DOP853": (dop853, (1e-6, 1e-7, 1e-8)),
}


def measure(problem: FrictionProblem, periods: float, repeats: int) -> list[dict[str, Any]]:
    """Every solver at every tolerance, interleaved; the best time of the repeats."""
    exact = exact_transient(problem, periods)
    scale = np.abs(exact.final_state).max()
    rows: dict[tuple[str, float], dict[str, Any]] = {}
    for _ in range(repeats):
        for name, (solve, tolerances) in SOLVERS.items():
            for rtol in tolerances:
                began = time.process_time()
                got = solve(problem, periods, rtol, 0.01 * rtol)
                spent = time.process_time() - began
                same = got.kind == list(exact.kind)
                row = rows.setdefault((name, rtol), {"name": name, "rtol": rtol, "ms": math.inf})
                row["ms"] = min(row["ms"], 1e3 * spent)
                row["events"] = f"{len(got.t)} of {len(exact.t)}"
                row["errx"] = float(np.abs(got.final - exact.final_state).max() / scale)
                gap = float(np.abs(got.t - exact.t).max(initial=0.0)) if same else math.nan
                row["errt"] = gap / problem.period
    return list(rows.values())


def at_equal_error(rows: list[dict[str, Any]], error: float) -> float:
    """Time in ms where the error is `error`, log-log between (or beyond) the nearest two."""
    done = [r for r in rows if math.isfinite(r["errx"])]
    points = sorted((math.log(max(r["errx"], 1e-16)), math.log(r["ms"])) for r in done)
    if not points:
        return math.nan
    if len(points) == 1:
        return math.exp(points[0][1])
    x = math.log(error)
    if x <= points[0][0]:
        return math.exp(points[0][1])  # already better: no credit for less work than measured
    i = max(1, min(len(points) - 1, sum(p[0] < x for p in points)))
    (x0, y0), (x1, y1) = points[i - 1], points[i]
    if x > x1:
        return math.exp(y1)
    return math.exp(y0 + (y1 - y0) * (x - x0) / (x1 - x0)) if x1 > x0 else math.exp(y0)


def threads(periods: float) -> None:
    """Efficiency of solve_many on two threads."""
    drive = beltsim.presets.zhu_parker_2008()
    one = beltsim.assemble(drive, 6.3, friction=Coulomb(3.5), n_functions=8)
    for workers in (1, 2):
        began = time.perf_counter()
        solve_many([one] * 8, workers=workers, periods=periods)
        spent = time.perf_counter() - began
        if workers == 1:
            alone = spent
    print(f"\nsolve_many, 8 runs: {alone:.2f} s on one thread, {spent:.2f} s on two: "
          f"efficiency {alone / spent / 2:.2f}")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--periods", type=float, default=100.0)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--point", type=int, help="only this one of the four, from 1")
    parser.add_argument("--quick", action="store_true", help="10 periods, one repeat")
    options = parser.parse_args()
    periods, repeats = (10.0, 1) if options.quick else (options.periods, options.repeats)
    KERNELS.extend(make_kernels())
    drive = beltsim.presets.zhu_parker_2008()
    warm = beltsim.assemble(drive, 6.3, friction=Coulomb(3.5), n_functions=8)
    for solve, _ in SOLVERS.values():
        solve(warm, 0.5, 1e-6, 1e-8)  # compilation and imports are not timed
    ratios = []
    for Omega, Q_m in POINTS if options.point is None else (POINTS[options.point - 1],):
        problem = beltsim.assemble(drive, Omega, friction=Coulomb(Q_m), n_functions=8)
        rows = measure(problem, periods, repeats)
        print(f"\n(Omega, Q_m) = ({Omega}, {Q_m}), {periods:g} periods, n = {problem.n}\n")
        print("| solver | rtol | ms | ms/period | errx | errt | events |")
        print("|---|---|---|---|---|---|---|")
        for r in rows:
            per = r["ms"] / periods
            print(f"| {r['name']} | {r['rtol']:.0e} | {r['ms']:.1f} | {per:.3f} | {r['errx']:.1e} "
                  f"| {r['errt']:.1e} | {r['events']} |")  # fmt: skip
        equal = {
            name: at_equal_error([r for r in rows if r["name"] == name], EQUAL_ERROR)
            for name in SOLVERS
        }
        ratios.append(((Omega, Q_m), equal))
    print(f"\ntime at an equal error of {EQUAL_ERROR:g}, and the ratio scikit-sundae / solver\n")
    print("| point | " + " | ".join(SOLVERS) + " |")
    print("|---|" + "---|" * len(SOLVERS))
    for point, equal in ratios:
        peer = equal["scikit-sundae, Adams"]
        cells = " | ".join(f"{ms:.1f} ms ({peer / ms:.1f}x)" for ms in equal.values())
        print(f"| {point} | {cells} |")
    threads(periods)


if __name__ == "__main__":
    main()
