"""Compiling the kernels before they are needed.

Numba compiles a kernel when it is first called and keeps it with the installation: about half a
minute the first time, a second later.

Depends on: solve, settings, problem, forcing, friction.
"""

from __future__ import annotations

import numpy as np

from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance.settings import Settings
from beltsim.harmonic_balance.solve import solve
from beltsim.problem import FrictionProblem


def compile_kernels() -> None:
    """Solve two small problems by every method, so that all kernels are there.

    Examples
    --------
    >>> compile_kernels()
    """
    for odd in (True, False):
        cos = np.array([[0.0], [1.0], [0.0 if odd else 0.3]])
        push, unit = HarmonicForcing(0.5, cos, 0.0 * cos), np.eye(1)
        one = FrictionProblem(unit, 0.1 * unit, 0.0 * unit, unit, 0, push, Coulomb(0.3))
        solve(one, 5)
        band = one.with_friction(SaturatedCoulomb(0.3, 0.05))
        for projection in ("exact", "sampled"):
            solve(band, 5, Settings(projection=projection, start="set_valued", estimate=False))
