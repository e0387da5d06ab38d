"""Turning points of a mass with dry and viscous friction.

About the centre sign(x) Q/k of a half swing the motion is a damped oscillation that starts at
rest: after pi/w_d it is at rest again, with exp(-zeta pi/sqrt(1 - zeta^2)) of its amplitude on the
other side.
"""

import numpy as np

#: zeta, k, Q, x0
CASES = ((0.02, 4.0, 0.2, 1.0), (0.1, 1.0, 0.01, -2.0), (0.4, 9.0, 0.05, 5.0))


def half_swings(zeta: float, k: float, Q: float, x0: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and places of the turning points, the last of them where the mass stays."""
    root = np.sqrt(1.0 - zeta**2)
    kept = np.exp(-zeta * np.pi / root)
    places = []
    x = x0
    while abs(x) > Q / k:
        centre = np.copysign(Q / k, x)
        x = centre - kept * (x - centre)
        places.append(x)
    return np.pi / (np.sqrt(k) * root) * np.arange(1, len(places) + 1), np.array(places)
