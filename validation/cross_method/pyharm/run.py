"""Periodic motions of the paper's drive by harmonic balance, here and in pyHarm, with times."""

import time
from typing import Any

import numpy as np

import beltsim
from validation.cross_method.pyharm.reference import peer_pyharm
from validation.row import Row

R = 25
POINTS = ((6.3, 0.5), (6.3, 3.5), (8.7, 3.5))
#: Penalties with which the element converges at R = 25: as delivered, and with the ground left out.
EPS, EPS_MENDED = 1e3, 1e2


def compute() -> list[Row]:
    drive = beltsim.presets.zhu_parker_2008()
    found = []
    for Omega, Q_m in POINTS:
        problem = beltsim.assemble(drive, Omega, friction=beltsim.Coulomb(Q_m), n_functions=8)
        if not found:
            peer_pyharm.solve(problem, 3, EPS)  # compiles its kernels
        found += _at(problem, f"rms of the arm at Omega = {Omega}, Q_m = {Q_m}", Omega < 8.0)
    return found


def _at(problem: Any, what: str, mended: bool) -> list[Row]:
    """Rows of one point; the mended element does not converge everywhere."""
    arm = problem.joint
    exact = float(beltsim.event_map.rms(beltsim.event_map.periodic(problem))[arm])
    beltsim.harmonic_balance.solve(problem, R)  # loads its kernels
    start = time.perf_counter()
    series = beltsim.harmonic_balance.solve(problem, R)
    taken = f"{1e3 * (time.perf_counter() - start):.1f} ms"
    ours = float(np.std(series.q[:-1, arm]))
    peer = peer_pyharm.solve(problem, R, EPS)
    note = f"{taken}; pyHarm {1e3 * peer.seconds:.0f} ms, without compiling"
    rows = [
        Row(f"{what}, harmonic balance", ours, exact, note=note),
        Row(f"{what}, pyHarm as delivered", exact, float(peer.rms[arm])),
    ]
    if mended:
        other = peer_pyharm.solve(problem, R, EPS_MENDED, substructures=1)
        note = f"pyHarm {1e3 * other.seconds:.0f} ms"
        rows.append(Row(f"{what}, pyHarm without ground", exact, float(other.rms[arm]), note=note))
    return rows
