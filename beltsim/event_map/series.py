r"""One phase as a sum of exponentials, and its Fourier integrals in closed form.

.. math:: x(\tau) = \mathrm{Re}\,Z e^{\mu\tau}, \qquad 0 \le \tau \le d

holds modes, harmonics and constant alike, so every Fourier integral of a phase is a sum of

.. math:: I(s) = \int_0^d e^{s\tau}\,d\tau = (e^{sd} - 1)/s.

Depends on: flows, walk, problem.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map.cells import CellFlow
from beltsim.event_map.flows import Flow, Sums, flows_of, inner_flow
from beltsim.event_map.linear_part import ComplexArray
from beltsim.event_map.nodes import NodePiece
from beltsim.event_map.walk import Walk
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem


@dataclass(frozen=True, eq=False)
class Piece:
    """The state over one phase: its times, mode and coefficients `Z` (2n, L).

    `mu` (L,) are the exponents, `torque` (L,) the coefficients of the friction torque.
    """

    start: float
    length: float
    mode: int
    sums: Sums
    Z: ComplexArray
    torque: ComplexArray

    @property
    def mu(self) -> ComplexArray:
        """Exponents (L,)."""
        return self.sums.mu

    def cut(self, start: float, end: float) -> Piece:
        """The part between two times."""
        grown = np.exp(self.mu * (start - self.start))
        return Piece(start, end - start, self.mode, self.sums, self.Z * grown, self.torque * grown)

    def at(self, tau: FloatArray) -> FloatArray:
        """States (nt, 2n) at times `tau` (nt,) after the start."""
        grown = np.exp(np.multiply.outer(tau, self.mu))
        found: FloatArray = grown.real @ self.Z.real.T - grown.imag @ self.Z.imag.T
        return found

    def torque_at(self, tau: FloatArray) -> FloatArray:
        """Friction torque (nt,) at times `tau` after the start."""
        if self.mode:  # constant while slipping
            return np.full(len(tau), self.torque.real.sum())
        found: FloatArray = (np.exp(np.multiply.outer(tau, self.mu)) @ self.torque).real
        return found

    def fourier(self, orders: int) -> ComplexArray:
        """Integral (orders, 2n + 1) of state and friction torque times exp(-i k Omega t)."""
        rows = np.concatenate([self.Z, self.torque[None]])
        plain, mixed = self.sums.harmonics(orders, self.length)
        turn = np.exp(-1j * self.sums.Omega * self.start * np.arange(orders))
        found: ComplexArray = 0.5 * turn[:, None] * (plain @ rows.T + mixed @ rows.conj().T)
        return found


AnyPiece = Piece | NodePiece


def pieces(problem: FrictionProblem, run: Walk, start: float, end: float) -> Iterator[AnyPiece]:
    """The phases of `run` between `start` and `end`, cut at both."""
    starts, modes, states = run.starts(), run.modes(), run.states()
    ends = np.append(starts[1:], run.end)
    first = max(int(np.searchsorted(starts, start, side="right")) - 1, 0)
    for i in range(first, len(starts)):
        if starts[i] >= end and i > first:
            return
        piece = piece_of(
            problem, float(starts[i]), float(ends[i] - starts[i]), int(modes[i]), states[i]
        )
        if starts[i] < start or ends[i] > end:
            piece = piece.cut(max(start, float(starts[i])), min(end, float(ends[i])))
        yield piece


def piece_of(
    problem: FrictionProblem, start: float, length: float, mode: int, state: FloatArray
) -> AnyPiece:
    """The phase of `mode` from `state` (2n,) at time `start`."""
    flows, n, joint = flows_of(problem), problem.n, problem.joint
    assert joint is not None
    assert problem.friction is not None
    flow = flows.free if mode else inner_flow(problem)
    if isinstance(flow, CellFlow):
        load = mode * problem.friction.Q_m
        slope = None
        x = state
        if not mode and isinstance(problem.friction, SaturatedCoulomb):
            slope = problem.friction.Q_m / problem.friction.sigma
        elif not mode:
            load, x = float(state[joint]), state[flows.rest]
        y = flow.extended(start, load, x)
        return NodePiece(start, length, mode, flow, y, load, n, joint, slope)
    if mode != 0:
        load = mode * problem.friction.Q_m
        Z = _coefficients(flow, start, load, state)
        torque = np.zeros(Z.shape[1], complex)
        torque[flow.m] = load
        return Piece(start, length, mode, flow.sums, Z, torque)
    if isinstance(problem.friction, SaturatedCoulomb):
        Z = _coefficients(flow, start, 0.0, state)
        return Piece(
            start,
            length,
            mode,
            flow.sums,
            Z,
            problem.friction.Q_m / problem.friction.sigma * Z[n + joint],
        )
    position = float(state[joint])
    part = flow.part
    held = _coefficients(flow, start, position, state[flows.rest])
    Z = np.zeros((2 * n, held.shape[1]), complex)
    Z[flows.rest] = held
    Z[joint, flow.m] = position
    torque = part.row @ held
    torque[flow.m :] += part.D * flow.turns(start)
    torque[flow.m] += part.d_c * position
    return Piece(start, length, mode, flow.sums, Z, torque)


def _coefficients(flow: Flow, t: float, c: float, x: FloatArray) -> Any:
    """Coefficients (N, m + H + 1) of the state: modes first, then harmonics from 0."""
    found = np.empty((flow.N, flow.m + len(flow.P)), complex)
    harmonics = found[:, flow.m :]
    np.multiply(flow.P.T, flow.turns(t), out=harmonics)
    harmonics[:, 0] += c * flow.X_c
    a = flow.W @ (x - harmonics.real.sum(axis=1))
    np.multiply(flow.V, a, out=found[:, : flow.m])
    return found
