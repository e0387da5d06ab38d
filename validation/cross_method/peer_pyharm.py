"""Periodic motions of the set-valued law through pyHarm-os: harmonic balance with DLFT friction.

As delivered (1.2.2) its friction element counts GROUND as a substructure, and so takes half of the
load that the joint has to carry: an element meant to be rigid then yields like a spring of twice
its penalty `eps`. Setting the count to 1 mends that, at the price of poorer convergence.

No import from beltsim.
"""

from __future__ import annotations

import contextlib
import logging
import tempfile
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

SAMPLES = 1024


@dataclass(frozen=True)
class Balance:
    """Standard deviation of each coordinate over a period, and seconds that it took."""

    rms: np.ndarray
    seconds: float


def solve(problem: Any, R: int, eps: float, substructures: int | None = None) -> Balance:
    """Balance the odd harmonics up to `R`; `substructures` overrides what the element counts.

    Raises
    ------
    RuntimeError
        When the solver did not converge: pyHarm itself accepts its first point in any case.
    """
    n, Omega = len(problem.M), problem.forcing.Omega
    data = {
        "system": {"type": "Base", "nh": list(range(1, R + 1, 2)), "nti": SAMPLES},
        "substructures": {"drive": {"matrix": _matrices(problem), "ndofs": 1}},
        "connectors": _connectors(problem, eps),
        "analysis": {"point": _point(Omega)},
    }
    with _aside():
        import pyHarm

        start = time.perf_counter()
        maestro = pyHarm.Maestro(data)
        if substructures is not None:
            maestro.system.LE_nonlinear_dlft[0].nbSub = substructures
        analysis = maestro.nls["point"]
        analysis.initialise()
        seconds = time.perf_counter() - start
    found = analysis.SolList[0]
    if found.status_solver != 1:
        raise RuntimeError(f"pyHarm did not converge at Omega = {Omega}: {found.message_solver}")
    waves = found.x[:-1].reshape(-1, n)  # a row for each cosine and sine; Omega comes last
    return Balance(np.sqrt(0.5 * np.sum(waves**2, axis=0)), seconds)


@contextlib.contextmanager
def _aside() -> Iterator[None]:
    """A place where pyHarm may leave its `.pyHarm/`, with its log and its compiler's hints off."""
    off = logging.root.manager.disable
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.chdir(folder),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")
        logging.disable(logging.CRITICAL)
        try:
            yield
        finally:
            logging.disable(off)


def _matrices(problem: Any) -> dict[str, np.ndarray]:
    return {"M": problem.M, "C": problem.C + problem.G, "K": problem.K}  # its own G goes with Omega


def _connectors(problem: Any, eps: float) -> dict[str, dict[str, Any]]:
    """The friction element, and one for every harmonic of the load on every coordinate."""
    friction = {"type": "DLFTFriction", "mu": problem.friction.Q_m, "N0": 1.0, "eps": eps}
    found = {"friction": {**friction, "connect": {"drive": [problem.joint], "GROUND": [0]}}}
    load = problem.forcing.cos - 1j * problem.forcing.sin
    for k, i in np.argwhere(load):
        wave = {"ho": int(k), "dto": 0, "amp": abs(load[k, i]), "phi": -np.angle(load[k, i])}
        found[f"load {k} {i}"] = {"type": "GOForcing", "connect": {"drive": [int(i)]}, **wave}
    return {name: {**element, "dirs": [0]} for name, element in found.items()}


def _point(Omega: float) -> dict[str, Any]:
    bounds = {"puls_inf": Omega, "puls_sup": 1.001 * Omega, "puls_start": Omega}
    return {"study": "frf", "solver": "scipyroot", "verbose": False, **bounds}
