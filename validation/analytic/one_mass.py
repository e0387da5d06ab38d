"""One mass with a spring, a damper and dry friction, as a friction problem.

Depends on: beltsim.
"""

from __future__ import annotations

import beltsim


def one_mass(
    k: float, Q: float, c: float = 0.0, P: float = 0.0, Omega: float = 1.0
) -> beltsim.FrictionProblem:
    """Unit mass: x'' + c x' + k x + Q sgn(x') = P cos(Omega t); without P no forcing."""
    rows = [[0.0], [P]] if P else [[0.0]]
    forcing = beltsim.HarmonicForcing(Omega, rows, [[0.0]] * len(rows))
    return beltsim.FrictionProblem([[1.0]], [[c]], [[0.0]], [[k]], 0, forcing, beltsim.Coulomb(Q))
