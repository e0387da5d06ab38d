"""The recipe by which the accuracy of harmonic balance is judged.

Coordinates 1, 2, 3, 5, 8 or 30 with modal damping of 1 to 5 %, a fundamental of 0.3 to 3 (the
lowest frequency is 0.5 to 1.5), one to three harmonics, and Q_m of 0.1 to 0.7 Q_cr, Q_s = Q_m.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
from support.problems import critical_torque, random_problem

from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem

SIZES = (1, 2, 3, 5, 8, 30)


def damped_problem(seed: int) -> FrictionProblem:
    """A random problem of the recipe."""
    draw = np.random.default_rng([seed, 313])
    base = random_problem(
        seed, int(draw.choice(SIZES)), static=False, harmonics=int(draw.integers(1, 4))
    )
    squares, modes = scipy.linalg.eigh(base.K, base.M)
    rates = 2.0 * draw.uniform(0.01, 0.05, base.n) * np.sqrt(squares)
    C = base.M @ (modes * rates) @ modes.T @ base.M
    forcing = HarmonicForcing(draw.uniform(0.3, 3.0), base.forcing.cos, base.forcing.sin)
    free = FrictionProblem(
        base.M, 0.5 * (C + C.T), base.G, base.K, base.joint, forcing, Coulomb(0.0)
    )
    return free.with_friction(Coulomb(draw.uniform(0.1, 0.7) * critical_torque(free)))
