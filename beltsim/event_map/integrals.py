r"""Exact integrals over a stretch of a walk: work, losses and squares.

In a phase the state is :math:`x = R\,u(\tau)`, `u` the real and imaginary parts of all
exponentials: modes, harmonics, load. With the Gram matrix :math:`\Gamma = \int u u^T d\tau`, summed
over all phases of one flow by the C map, every quadratic figure is a contraction,

.. math:: \int x_i^2 = (R\,\Gamma R^T)_{ii}, \qquad \int \dot q^T C \dot q = C : R_v \Gamma R_v^T .

Flows in cells are integrated by Gauss points instead (`nodes`).

Depends on: flows, series, walk, binding, problem, friction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.event_map import binding
from beltsim.event_map.cells import CellFlow
from beltsim.event_map.flows import Flow, flows_of, inner_flow
from beltsim.event_map.nodes import NodePiece
from beltsim.event_map.series import piece_of
from beltsim.event_map.walk import TIME, Walk, raise_status
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem


@dataclass(frozen=True, eq=False)
class Integrals:
    """Over a stretch of time: `squares` (n,) of q, `speed` the square of the joint's velocity, the
    forcing's work, the viscous loss and the friction's.

    The friction loss is given for the saturated law only; for the others it follows from the
    joint's travel.
    """

    squares: FloatArray
    speed: float
    work: float
    loss: float
    rubbed: float


@dataclass(frozen=True, eq=False)
class _Rows:
    """What turns the Gram matrix of a flow into figures.

    `q` (n, 2L) and `speed` (2L,) are rows of R, the latter of the joint's velocity; `energy`
    (2, 4L^2) gives work and viscous loss.
    """

    q: FloatArray
    speed: FloatArray
    energy: FloatArray


def integrals(problem: FrictionProblem, run: Walk, start: float, end: float) -> Integrals:
    """The integrals of `run` between two times."""
    n, law = problem.n, problem.friction
    begins, modes, states = run.starts(), run.modes(), run.states()
    first = np.maximum(start - begins, 0.0)
    last = np.minimum(np.append(begins[1:], run.end), end) - begins
    inside = last > first
    squares, energy, speed, rubbed = np.zeros(n), np.zeros(2), 0.0, 0.0
    for flow, chosen in ((flows_of(problem).free, modes != 0), (inner_flow(problem), modes == 0)):
        at = np.flatnonzero(inside & chosen)
        if not len(at):
            continue
        if isinstance(flow, CellFlow):
            for i in at:
                piece = piece_of(
                    problem, float(begins[i]), float(last[i]), int(modes[i]), states[i]
                )
                assert isinstance(piece, NodePiece)
                if first[i] > 0.0:
                    piece = piece.cut(float(begins[i] + first[i]), float(begins[i] + last[i]))
                squares += piece.squares(slice(0, n))
                speed += float(piece.squares(n + (problem.joint or 0)))
                energy += (piece.work(problem.forcing.coefficients), piece.quadratic(problem.C, n))
                rubbed += piece.rubbing(n + (problem.joint or 0))
            continue
        rows = _rows(problem, flow)
        gram = _gram(problem, flow, run, at, (first[at], last[at]), modes[at], states[at])
        squares += ((rows.q @ gram) * rows.q).sum(axis=1)
        energy += rows.energy @ gram.ravel()
        moved = gram @ rows.speed
        fast = float(rows.speed @ moved)
        speed += fast
        if isinstance(law, SaturatedCoulomb):
            slipped = float(moved[len(gram) // 2 - 1])  # with the load, the constant torque
            rubbed += slipped if modes[at[0]] else law.Q_m / law.sigma * fast
    return Integrals(squares, speed, float(energy[0]), float(energy[1]), rubbed)


def _gram(
    problem: FrictionProblem,
    flow: Flow,
    run: Walk,
    at: NDArray[np.intp],
    stretch: tuple[FloatArray, FloatArray],
    modes: NDArray[np.int64],
    states: FloatArray,
) -> FloatArray:
    """The Gram matrix (2L, 2L) of the phases `at`."""
    law, joint = problem.friction, problem.joint
    assert law is not None
    load = np.asarray(modes * law.Q_m, dtype=float)
    if flow is flows_of(problem).held:
        load = states[:, joint].copy()
        states = states[:, flows_of(problem).rest]
    L = flow.m + len(flow.P) + 1
    found = np.zeros((2 * L, 2 * L))
    begin = np.concatenate([[0.0], run.reals[:, TIME]])[at]
    sizes = (flow.N, flow.m, len(flow.P) - 1, flow.Omega)
    status = binding.gram(
        *sizes, flow.packed, begin, *stretch, load, np.ascontiguousarray(states), found, len(at)
    )
    if status < 0:
        raise_status(status)
    return found


def _rows(problem: FrictionProblem, flow: Flow) -> _Rows:
    """Rows of `flow`, kept with it: they are the same for all torques."""
    if flow.rows:
        found: _Rows = flow.rows[0]
        return found
    n, joint, m, held = problem.n, problem.joint, flow.m, flow is flows_of(problem).held
    B = np.column_stack([flow.V, flow.P.T, flow.X_c])
    if held:
        inner, B = B, np.zeros((2 * n, B.shape[1]), complex)
        B[flows_of(problem).rest] = inner
        B[joint, -1] = 1.0
    force = np.zeros((n, B.shape[1]), complex)
    force[:, m : m + len(flow.P)] = problem.forcing.coefficients.T
    R, F = (np.concatenate([part.real, part.imag], axis=1) for part in (B, force))
    v = R[n:]
    energy = np.array([(F.T @ v).ravel(), (v.T @ (problem.C @ v)).ravel()])
    rows = _Rows(R[:n].copy(), v[joint].copy(), energy)
    flow.rows.append(rows)
    return rows
