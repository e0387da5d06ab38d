"""Turning points of a mass that dry friction alone brings to rest.

From rest at x the mass moves towards the centre c = sign(x) Q/k of its half swing, which takes
pi/w, and turns at 2 c - x. It stays where |x| <= Q/k.
"""

import numpy as np

#: k, Q, x0: seven, fourteen and seventeen half swings; the last stops well inside its interval.
CASES = ((4.0, 0.3, 1.0), (1.0, 0.05, -1.43), (9.0, 1.3, 5.0))


def half_swings(k: float, Q: float, x0: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and places of the turning points, the last of them where the mass stays."""
    places = []
    x = x0
    while abs(x) > Q / k:
        x = 2.0 * np.copysign(Q / k, x) - x
        places.append(x)
    return np.pi / np.sqrt(k) * np.arange(1, len(places) + 1), np.array(places)
