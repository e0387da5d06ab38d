"""Den Hartog's steady motion of x'' + 2 zeta x' + x + f sgn(x') = cos(beta t), without stops.

In the half period tau = pi/beta after its upper turning point x0 the mass moves down, so friction
is the constant +f and the motion is the forced oscillation, plus f, plus a free oscillation. Call
h the last two. The second half period mirrors the first: h(tau) = -h(0), h'(tau) = -h'(0). With
r = sqrt(1 - zeta^2) and D = cosh(zeta tau) + cos(r tau) that gives

    h(0) = -f [sinh(zeta tau) - (zeta/r) sin(r tau)]/D,     h'(0) = -f sin(r tau)/(r D).

The forced oscillation V cos(beta t - delta) must supply the rest of x = x0, x' = 0 at the turning
point: x0 = h(0) + sqrt(V^2 - (h'(0)/beta)^2). It turns where beta t = delta + psi, sin(psi) =
h'(0)/(beta V).
"""

import numpy as np

#: beta, zeta, f: below, near and above resonance; f at 40 to 80 % of what would make it stop.
CASES = ((0.6, 0.05, 0.2), (0.9, 0.02, 0.5), (1.3, 0.1, 0.5), (2.5, 0.05, 0.4))
#: Share of the start that may be left.
REST = 1e-9


def steady(beta: float, zeta: float, f: float) -> tuple[float, float]:
    """Amplitude, and phase of the upper turning point behind the forcing's peak in (-pi, pi]."""
    tau, r = np.pi / beta, np.sqrt(1.0 - zeta**2)
    D = np.cosh(zeta * tau) + np.cos(r * tau)
    h = -f * (np.sinh(zeta * tau) - zeta / r * np.sin(r * tau)) / D
    h_dot = -f * np.sin(r * tau) / (r * D)
    V = 1.0 / np.hypot(1.0 - beta**2, 2.0 * zeta * beta)
    delta = np.arctan2(2.0 * zeta * beta, 1.0 - beta**2)
    psi = np.arcsin(h_dot / (beta * V))
    amplitude = h + np.sqrt(V**2 - (h_dot / beta) ** 2)
    _require_no_stop(beta, zeta, f, float(amplitude), float(delta + psi))
    return float(amplitude), float(delta + psi)


def periods(beta: float, zeta: float) -> int:
    """Forcing periods after which at most REST of the start is left.

    Dry friction never adds energy to the difference of two motions, so viscous damping sets its
    slowest rate of decay, exp(-zeta t).
    """
    return int(np.ceil(np.log(1.0 / REST) / (zeta * 2.0 * np.pi / beta)))


def _require_no_stop(beta: float, zeta: float, f: float, x0: float, angle: float) -> None:
    """The mass must move down all the way from x0 to -x0, else the closed form does not hold."""
    r = np.sqrt(1.0 - zeta**2)
    stiffness = 1.0 - beta**2 + 2j * zeta * beta
    forced = np.exp(1j * angle) / stiffness
    a = x0 - forced.real - f
    b = (-np.real(1j * beta * forced) + zeta * a) / r
    t = np.linspace(0.0, np.pi / beta, 2001)[1:-1]
    free = np.exp(-zeta * t) * (
        (r * b - zeta * a) * np.cos(r * t) - (r * a + zeta * b) * np.sin(r * t)
    )
    speed = np.real(1j * beta * forced * np.exp(1j * beta * t)) + free
    if not (speed < 0.0).all():
        raise ValueError(f"beta = {beta}, zeta = {zeta}, f = {f}: the motion stops")
