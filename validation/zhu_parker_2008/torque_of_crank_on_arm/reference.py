"""Eq. (27) of the paper, with the deflection at the arm from collocation.

No import from beltsim.
"""

import numpy as np

from validation.cross_method.steady_state.reference import BETA_1, EA, LENGTH, P0, RADIUS, solve

MU, ALPHA = 0.10, 3.0


def amplitude(epsilon: float, Omega: float) -> float:
    """|gamma r_1/l_1 (sin beta_1 - cos beta_1 w*_1(1)) theta_1|, theta_1 = mu/alpha rad."""
    deflection = solve(epsilon, Omega)[2]
    lever = np.sin(BETA_1) - np.cos(BETA_1) * deflection
    return float(abs(EA / P0 * RADIUS[0] / LENGTH[0] * lever * MU / ALPHA))
