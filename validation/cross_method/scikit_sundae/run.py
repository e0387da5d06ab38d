"""Transients of the paper's drive by the event map, the C core and scikit-sundae, with times."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import beltsim
from validation.cross_method.agreement import different
from validation.cross_method.scikit_sundae.reference import exact_modal, peer_sundae
from validation.row import Row

PERIODS, RTOL = 10, 1e-8
POINTS = ((6.3, 0.5), (6.3, 3.5), (8.7, 3.5))


def compute() -> list[Row]:
    drive = beltsim.presets.zhu_parker_2008()
    found = []
    for Omega, Q_m in POINTS:
        problem = beltsim.assemble(drive, Omega, friction=beltsim.Coulomb(Q_m), n_functions=8)
        found += _at(problem, f"at Omega = {Omega}, Q_m = {Q_m}")
    return found


def _at(problem: Any, where: str) -> list[Row]:
    exact = exact_modal.run(problem, PERIODS)
    n = problem.n
    size = np.repeat([np.abs(half).max() for half in np.split(exact.final_state, 2)], n)
    rows, wrong, times = [], [], {}
    for name, solver in _solvers(problem).items():
        (kinds, end), times[name] = _timed(solver)
        wrong.append(different(kinds, exact.kind))
        rows.append(Row(f"end state {where}, {name}", end / size, exact.final_state / size))
    taken = ", ".join(f"{name} {1e3 * seconds:.1f} ms" for name, seconds in times.items())
    note = f"{taken} (the peer calls Python at every step: no benchmark)"
    return [Row(f"events that differ {where}", wrong, [0] * len(wrong), note=note), *rows]


def _solvers(problem: Any) -> dict[str, Callable[[], tuple[list[str], np.ndarray]]]:
    """Each gives the kinds of its events and its state at the end."""

    def event_map() -> tuple[list[str], np.ndarray]:
        run = beltsim.event_map.propagate(problem, float(PERIODS))
        return [str(kind) for kind in run.events.kind], run.final_state

    def core() -> tuple[list[str], np.ndarray]:
        settings = beltsim.transient.Settings(rtol=RTOL, keep="events")
        run = beltsim.transient.integrate(problem, float(PERIODS), None, settings)
        return [str(kind) for kind in run.events.kind], run.final_state

    def peer() -> tuple[list[str], np.ndarray]:
        run = peer_sundae.run(problem, PERIODS, rtol=RTOL, atol=0.01 * RTOL)
        return run.kind, run.final_state

    return {"event map": event_map, "C core": core, "scikit-sundae": peer}


def _timed(solver: Callable[[], Any]) -> tuple[Any, float]:
    """What it gives, and the shorter of two runs: the first may load or compile."""
    seconds = []
    for _ in range(2):
        start = time.perf_counter()
        found = solver()
        seconds.append(time.perf_counter() - start)
    return found, min(seconds)
