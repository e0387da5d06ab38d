r"""One phase as a sum of exponentials, and its integrals in closed form.

.. math:: x(\tau) = \mathrm{Re}\,Z e^{\mu\tau}, \qquad 0 \le \tau \le d

holds modes, harmonics and constant alike, so every integral over a phase is a sum of

.. math:: I(s) = \int_0^d e^{s\tau}\,d\tau = (e^{sd} - 1)/s.

Depends on: flows, walk, problem.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map.flows import ComplexArray, Flow, flows_of, inner_flow
from beltsim.event_map.walk import Walk
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem


@dataclass(frozen=True, eq=False)
class Piece:
    """The state over one phase: times, mode, exponents `mu` (L,), coefficients `Z` (2n, L).

    `torque` (L,) are the coefficients of the friction torque.
    """

    start: float
    length: float
    mode: int
    mu: ComplexArray
    Z: ComplexArray
    torque: ComplexArray

    def at(self, tau: FloatArray) -> FloatArray:
        """States (nt, 2n) at times `tau` (nt,) after the start."""
        grown = np.exp(np.multiply.outer(tau, self.mu))
        found: FloatArray = grown.real @ self.Z.real.T - grown.imag @ self.Z.imag.T
        return found

    def torque_at(self, tau: FloatArray) -> FloatArray:
        """Friction torque (nt,) at times `tau` after the start."""
        found: FloatArray = (np.exp(np.multiply.outer(tau, self.mu)) @ self.torque).real
        return found

    def products(self) -> tuple[ComplexArray, ComplexArray]:
        """Integrals of exp((mu_i + mu_j) tau) and exp((mu_i + conj mu_j) tau), both (L, L)."""
        plain = integral(self.mu[:, None] + self.mu, self.length)
        mixed = integral(self.mu[:, None] + self.mu.conj(), self.length)
        return plain, mixed

    def squares(self, rows: ComplexArray) -> FloatArray:
        """Integral of (Re rows exp(mu tau))^2 for each row (k, L): array (k,)."""
        plain, mixed = self.products()
        both = np.sum((rows @ plain) * rows, axis=1) + np.sum((rows @ mixed) * rows.conj(), axis=1)
        return 0.5 * both.real

    def fourier(self, rows: ComplexArray, w: FloatArray) -> ComplexArray:
        """Integral of Re(rows exp(mu tau)) exp(-i w t) dt for each w (nw,): array (nw, k)."""
        turn = np.exp(-1j * w * self.start)[:, None]
        plain = integral(self.mu - 1j * w[:, None], self.length) @ rows.T
        mixed = integral(self.mu.conj() - 1j * w[:, None], self.length) @ rows.conj().T
        return 0.5 * turn * (plain + mixed)


def integral(s: ComplexArray, d: float) -> ComplexArray:
    """(exp(s d) - 1)/s, with its limit at s = 0."""
    z = s * d
    small = np.abs(z) < 1e-5
    safe = np.where(small, 1.0, z)
    found: ComplexArray = np.where(small, 1.0 + z / 2.0 + z * z / 6.0, np.expm1(safe) / safe) * d
    return found


def pieces(problem: FrictionProblem, run: Walk, start: float, end: float) -> Iterator[Piece]:
    """The phases of `run` between `start` and `end`, cut at both."""
    starts, modes, states = run.starts(), run.modes(), run.states()
    ends = np.append(starts[1:], run.end)
    first = max(int(np.searchsorted(starts, start, side="right")) - 1, 0)
    for i in range(first, len(starts)):
        if starts[i] >= end and i > first:
            return
        piece = _piece(problem, starts[i], ends[i] - starts[i], int(modes[i]), states[i])
        yield _cut(piece, max(start, starts[i]), min(end, ends[i]))


def _cut(piece: Piece, start: float, end: float) -> Piece:
    grown = np.exp(piece.mu * (start - piece.start))
    return Piece(start, end - start, piece.mode, piece.mu, piece.Z * grown, piece.torque * grown)


def _piece(
    problem: FrictionProblem, start: float, length: float, mode: int, state: FloatArray
) -> Piece:
    flows, n, joint = flows_of(problem), problem.n, problem.joint
    assert joint is not None
    assert problem.friction is not None
    if mode != 0:
        load = mode * problem.friction.Q_m
        mu, Z = _sums(flows.free, start, load, state)
        torque = np.zeros(len(mu), complex)
        torque[flows.free.m] = load
        return Piece(start, length, mode, mu, Z, torque)
    if isinstance(problem.friction, SaturatedCoulomb):
        mu, Z = _sums(inner_flow(problem), start, 0.0, state)
        slope = problem.friction.Q_m / problem.friction.sigma
        return Piece(start, length, mode, mu, Z, slope * Z[n + joint])
    position = float(state[joint])
    mu, held = _sums(flows.held, start, position, state[flows.rest])
    Z = np.zeros((2 * n, len(mu)), complex)
    Z[flows.rest] = held
    Z[joint, flows.held.m] = position
    torque = flows.held.row @ held
    turns = np.exp(1j * flows.held.Omega * start * np.arange(len(flows.held.D)))
    torque[flows.held.m :] += flows.held.D * turns
    torque[flows.held.m] += flows.held.d_c * position
    return Piece(start, length, mode, mu, Z, torque)


def _sums(flow: Flow, t: float, c: float, x: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Exponents (m + H + 1,) and coefficients (N, m + H + 1): modes first, then harmonics."""
    h = np.arange(len(flow.P))
    a = flow.W @ (x - flow.forced(t, c))
    harmonics = flow.P.T * np.exp(1j * flow.Omega * t * h)
    harmonics[:, 0] += c * flow.X_c
    mu = np.concatenate([flow.exponents, 1j * flow.Omega * h])
    return mu, np.concatenate([flow.V * a, harmonics], axis=1)
