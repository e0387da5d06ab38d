"""Exact frequencies of the paper's three spans as travelling strings.

A string of tension p, unit density and length L that runs at speed s between fixed ends has the
frequencies k pi (p - s^2)/(L sqrt(p)). The steady tension of the straight belt follows from Table
1, typed in here. With A = sin(beta_1) - sin(beta_2), T = p - s^2 and the slopes of the two spans
that the arm tilts, g_1 = (r_t/l_1) cos(beta_1) theta_t and g_2 = -(r_t/l_2) cos(beta_2) theta_t,

    (k_s + T [r_t/l_1 cos(beta_1)^2 + r_t/l_2 cos(beta_2)^2]) theta_t = A (T - 1)
    sum(l_i) (p - 1)/gamma = -r_t A theta_t + (l_1 g_1^2 + l_2 g_2^2)/2

No import from beltsim.
"""

import numpy as np
from scipy.optimize import brentq

P0, EA = 300.0, 120_000.0
LENGTH = np.array([0.1548, 0.3449, 0.5518])
R_1, R_T, K_R = 0.0889, 0.0970, 28.25
BETA_1, BETA_2 = np.radians([135.79, 178.74])
ALPHA = 3.0


def tension(Omega: float) -> tuple[float, float]:
    """Steady tension p of the straight belt and its speed s."""
    s = R_1 * Omega / (ALPHA * LENGTH.mean())
    A = np.sin(BETA_1) - np.sin(BETA_2)
    tilt = R_T / LENGTH[:2] * np.cos([BETA_1, BETA_2])
    turning = R_T / LENGTH[:2] @ np.cos([BETA_1, BETA_2]) ** 2

    def stretch(p: float) -> float:
        T = p - s**2
        theta_t = A * (T - 1.0) / (K_R / (P0 * R_T) + turning * T)
        chords = 0.5 * LENGTH[:2] @ (tilt * theta_t) ** 2
        return float(LENGTH.sum() * (p - 1.0) * P0 / EA + R_T * A * theta_t - chords)

    return float(brentq(stretch, 0.5, 1.5 + s**2, xtol=1e-15)), float(s)


def frequencies(Omega: float, count: int) -> np.ndarray:
    """First `count` frequencies of each span, shape (3, count)."""
    p, s = tension(Omega)
    k = np.arange(1, count + 1)
    return np.outer(LENGTH.mean() / LENGTH, k * np.pi * (p - s**2) / np.sqrt(p))
