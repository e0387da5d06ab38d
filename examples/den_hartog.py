"""Den Hartog's oscillator with matrices of one's own: the amplitude against its closed form.

One mass on a spring with dry friction and no other damping, m x'' + k x + F sgn(x') = P cos(w t).
As long as it never rests, its amplitude under harmonic forcing is known exactly (J. P. Den Hartog,
Transactions of the ASME 53, 1931):

    (k X / P)^2 = 1 / (1 - b^2)^2 - (F / P)^2 [ sin(pi/b) / (b (1 + cos(pi/b))) ]^2,  b = w / w_n

Nothing here knows about belts: a `FrictionProblem` is any linear system with one rubbing
coordinate. Run: python examples/den_hartog.py
"""

from __future__ import annotations

import numpy as np

import beltsim


def oscillator(frequency_ratio: float, friction: float) -> beltsim.FrictionProblem:
    """Unit mass and spring (w_n = 1), unit force amplitude, friction force `friction`."""
    return beltsim.FrictionProblem(
        M=[[1.0]],
        C=[[0.0]],
        G=[[0.0]],
        K=[[1.0]],
        joint=0,
        forcing=beltsim.HarmonicForcing(frequency_ratio, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]]),
        friction=beltsim.Coulomb(friction),
        labels=("x",),
    )


def exact_amplitude(frequency_ratio: float, friction: float) -> float:
    """Den Hartog's amplitude of motion without rests, in units of P / k."""
    b = frequency_ratio
    losses = np.sin(np.pi / b) / (b * (1.0 + np.cos(np.pi / b)))
    return float(np.sqrt(1.0 / (1.0 - b * b) ** 2 - (friction * losses) ** 2))


def main() -> None:
    """Compare for three friction forces, and show one with rests, which the formula excludes."""
    b = 0.8
    settings = beltsim.transient.Settings(rtol=1e-11)
    print(f"frequency ratio {b}, no viscous damping, 200 periods from rest")
    print("  F/P   amplitude   closed form   stick fraction   stops per period")
    for friction in (0.3, 0.5, 0.7, 0.9):
        response = beltsim.transient.integrate(oscillator(b, friction), 200.0, settings=settings)
        turning_points = response.events.position[response.events.t > response.window[0]]
        amplitude = float(np.abs(turning_points).max())
        rests = response.stick_fraction > 0.0
        formula = "   (it rests)" if rests else f"{exact_amplitude(b, friction):13.8f}"
        print(
            f"{friction:5.1f} {amplitude:11.8f} {formula} {response.stick_fraction:14.4f}"
            f" {response.stops_per_period:16.0f}"
        )


if __name__ == "__main__":
    main()
