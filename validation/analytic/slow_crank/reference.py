"""Kinematics of an inextensible belt, from Table 1.

No import from beltsim.
"""

MU, ALPHA = 0.10, 3.0


def crank() -> complex:
    """Complex amplitude of theta_1 = (mu/alpha) sin(Omega t), as Re c exp(i Omega t)."""
    return -1j * MU / ALPHA


def radii() -> tuple[float, float, float]:
    """Pulley radii in m."""
    return 0.0889, 0.0452, 0.0270
