"""Exact transients of the saturated law: three linear zones, with the machinery of `exact`.

Outside the band the torque is constant; inside, `h = Q_m v/sigma` is a viscous term of the joint.
The acceleration is continuous across the edges. ``stick`` names the band.

The cell length follows the band's fast eigenvalue, about Q_m/(sigma m): a band of a thousandth of
the largest velocity costs some 1e4 cells per period.
"""

from __future__ import annotations

import numpy as np
from support.exact import SIGN, ExactRun, _Flow, _System, _Walk


def saturated_transient(problem, periods=20.0, initial_state=None) -> ExactRun:
    """Run `problem`, whose friction is a SaturatedCoulomb, from t = 0."""
    system = _banded(problem)
    n = system.n
    state = np.zeros(2 * n) if initial_state is None else np.array(initial_state, float)
    return _BandWalk(system, problem, state, periods * 2.0 * np.pi / system.Omega).run()


def _banded(problem) -> _System:
    """The slip flow of the problem, and as `stick` the flow inside the band."""
    system = _System(problem)
    law, n, joint = problem.friction, problem.n, problem.joint
    size = 2 * n + 2 + 2 * len(system.orders)
    # The slip matrix is rebuilt with the damping of the band; the constant torque drops out.
    band = system.slip.step / system.slip.h
    pull = band[n : 2 * n, 2 * n + 1].copy()  # acceleration per unit of torque
    band = band.copy()
    band[n : 2 * n, n + joint] += pull * law.Q_m / law.sigma
    band[n : 2 * n, 2 * n + 1] = 0.0
    velocity = np.zeros(size)
    velocity[n + joint] = 1.0
    rho = np.abs(np.linalg.eigvals(band)).max()
    system.stick = _Flow(band, 0.5 / rho, velocity[None])
    return system


class _BandWalk(_Walk):
    """Modes slip+, slip- and the band."""

    def __init__(self, system, problem, state, end) -> None:
        self.sigma = problem.friction.sigma
        self.Q_m = self.Q_s = problem.friction.Q_m
        self._begin(system, problem, state, end)

    def _first_mode(self) -> str:
        v = self.state[self.v_index]
        if abs(v) <= self.sigma:
            return "stick"
        return "slip+" if v > 0.0 else "slip-"

    def _leave_slip(self, z: np.ndarray) -> bool:
        sign = SIGN[self.mode]

        def watched(c: np.ndarray) -> np.ndarray:
            self.v_peak = max(self.v_peak, float(np.abs(c[:, 0, 0]).max()))
            above = sign * c
            above[:, :, 0] -= self.sigma
            return above

        self.side = 0
        z, reached = self._walk(self.system.slip, z, watched, "velocity")
        return self._arrive(z, reached, sign, "stick")

    def _leave_stick(self, z: np.ndarray) -> bool:
        def watched(c: np.ndarray) -> np.ndarray:
            self.v_peak = max(self.v_peak, float(np.abs(c[:, 0, 0]).max()))
            both = np.concatenate([-c, c], axis=1)
            both[:, :, 0] += self.sigma
            return both

        z, reached = self._walk(self.system.stick, z, watched, "velocity")
        sign = 1.0 if z[self.v_index] > 0.0 else -1.0
        return self._arrive(z, reached, sign, "slip+" if sign > 0.0 else "slip-")

    def _arrive(self, z: np.ndarray, reached: bool, sign: float, mode: str) -> bool:
        self.state = z[: 2 * self.system.n].copy()
        if not reached:
            return False
        self.state[self.v_index] = sign * self.sigma
        torque = sign * self.Q_m
        z = self.system.extended(self.state, self.t, torque)
        self._record(mode, torque, torque, abs(float(self.system.acceleration @ z)), np.inf)
        self.mode, self.order, self.side = mode, 1, int(sign < 0.0)
        return True
