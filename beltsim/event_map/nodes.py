"""Phases of flows in cells, and their integrals by Gauss points on the cells.

On a cell the motion is a short Taylor series, which 16 Gauss points integrate to rounding, squares
and products with harmonics included.

Depends on: cells, flows, walk, friction, problem.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map.cells import CellFlow
from beltsim.event_map.flows import roles_of
from beltsim.event_map.linear_part import ComplexArray
from beltsim.event_map.walk import Walk
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem

_POINTS = 16


@dataclass(frozen=True, eq=False)
class NodePiece:
    """One phase: `y` is the extended state at its start.

    `load`: friction torque while slipping, the joint's position while held. `slope`: torque per
    velocity inside the band of the saturated law, else None.
    """

    start: float
    length: float
    mode: int
    flow: CellFlow
    y: FloatArray
    load: float
    n: int
    joint: int
    slope: float | None

    def cut(self, start: float, end: float) -> NodePiece:
        """The part between two times."""
        y = self.flow.advanced(self.y, start - self.start)
        parts = (self.mode, self.flow, y, self.load, self.n, self.joint, self.slope)
        return NodePiece(start, end - start, *parts)

    @property
    def _held(self) -> bool:
        return self.mode == 0 and self.slope is None

    def at(self, tau: FloatArray) -> FloatArray:
        """States (nt, 2n) at ascending times `tau` (nt,) after the start."""
        found = self.flow.states(self.y, tau)
        if not self._held:
            return found
        n, joint = self.n, self.joint
        full = np.zeros((len(tau), 2 * n))
        full[:, np.delete(np.arange(2 * n), [joint, n + joint])] = found
        full[:, joint] = self.load
        return full

    def torque_at(self, tau: FloatArray) -> FloatArray:
        """Friction torque (nt,) at times `tau` after the start."""
        return self._torque(tau, self.at(tau))

    def _torque(self, tau: FloatArray, x: FloatArray) -> FloatArray:
        if self.mode:
            return np.full(len(tau), self.load)
        if self.slope is not None:
            slope: FloatArray = self.slope * x[:, self.n + self.joint]
            return slope
        n, joint = self.n, self.joint
        rest = np.delete(x, [joint, n + joint], axis=1)
        return self.flow.part.signals(self.start + tau, np.full(len(tau), self.load), rest)[0]

    def _nodes(self, orders: int = 1) -> tuple[FloatArray, FloatArray]:
        """Times after the start and weights, fine enough for `orders` harmonics."""
        longest = min(self.flow.d, 2.0 / (orders * self.flow.Omega))
        cells = max(1, int(np.ceil(self.length / longest)))
        x, w = np.polynomial.legendre.leggauss(_POINTS)
        h = self.length / cells
        tau = (np.arange(cells)[:, None] + 0.5 * (x + 1.0)) * h
        return tau.ravel(), np.tile(0.5 * h * w, cells)

    def quadratic(self, A: FloatArray, n: int) -> float:
        """Integral of v'A v, `v` the velocities (n,)."""
        tau, w = self._nodes()
        v = self.at(tau)[:, n:]
        return float(w @ np.einsum("ti,ij,tj->t", v, A, v))

    def rubbing(self, row: int) -> float:
        """Integral of the friction torque times component `row` of the state."""
        tau, w = self._nodes()
        x = self.at(tau)
        return float(w @ (self._torque(tau, x) * x[:, row]))

    def squares(self, rows: slice | int) -> Any:
        """Integral of the square of each of these components of the state."""
        tau, w = self._nodes()
        return w @ self.at(tau)[:, rows] ** 2

    def work(self, F: ComplexArray) -> float:
        """Work of the forcing, `F` (H + 1, n) its coefficients."""
        tau, w = self._nodes(len(F))
        turns = np.exp(
            1j * self.flow.Omega * np.multiply.outer(self.start + tau, np.arange(len(F)))
        )
        return float(w @ np.sum((turns @ F).real * self.at(tau)[:, self.n :], axis=1))

    def fourier(self, orders: int) -> ComplexArray:
        """Integral (orders, 2n + 1) of state and friction torque times exp(-i k Omega t)."""
        tau, w = self._nodes(orders)
        x = self.at(tau)
        both = np.column_stack([x, self._torque(tau, x)])
        angle = self.flow.Omega * np.multiply.outer(np.arange(orders), self.start + tau)
        return np.asarray((np.exp(-1j * angle) * w) @ both, dtype=complex)


def node_pieces(
    problem: FrictionProblem, run: Walk, start: float, end: float
) -> Iterator[NodePiece]:
    """The phases of `run` between two times whose flow comes in cells, cut at both."""
    begins, modes, states = run.starts(), run.modes(), run.states()
    ends = np.append(begins[1:], run.end)
    free, inner = roles_of(problem)
    for i, mode in enumerate(modes.tolist()):
        flow = free[1] if mode else inner[1]
        first, last = max(start, float(begins[i])), min(end, float(ends[i]))
        if not isinstance(flow, CellFlow) or last < first:
            continue
        piece = _piece(problem, flow, mode, float(begins[i]), float(ends[i]), states[i])
        yield piece if (first, last) == (begins[i], ends[i]) else piece.cut(first, last)


def _piece(
    problem: FrictionProblem, flow: CellFlow, mode: int, begin: float, end: float, x: FloatArray
) -> NodePiece:
    law, n, joint = problem.friction, problem.n, problem.joint
    assert law is not None
    assert joint is not None
    load, slope = mode * law.Q_m, None
    if not mode and isinstance(law, SaturatedCoulomb):
        slope = law.Q_m / law.sigma
    elif not mode:
        load, x = float(x[joint]), np.delete(x, [joint, n + joint])
    y = flow.extended(begin, load, x)
    return NodePiece(begin, end - begin, mode, flow, y, load, n, joint, slope)
