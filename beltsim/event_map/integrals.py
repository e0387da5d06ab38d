r"""Exact integrals over a stretch of a walk: work, losses and squares.

In a phase the state is :math:`x = R\,u(\tau)`, `u` the real and imaginary parts of all
exponentials: modes, harmonics, load. With the Gram matrix :math:`\Gamma = \int u u^T d\tau`, summed
over all phases of one flow by the C map, every quadratic figure is a contraction,

.. math:: \int x_i^2 = (R\,\Gamma R^T)_{ii}, \qquad \int \dot q^T C \dot q = C : R_v \Gamma R_v^T .

Flows in cells are integrated by Gauss points instead (`nodes`).

Depends on: flows, series, nodes, walk, binding, status, problem, friction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map import binding
from beltsim.event_map.flows import Flow, flows_of, inner_flow
from beltsim.event_map.nodes import NodePiece
from beltsim.event_map.series import pieces
from beltsim.event_map.status import require_ok
from beltsim.event_map.walk import Walk
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem

#: What the C map calls the phases of a flow.
_FREE, _HELD, _BAND = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Integrals:
    """Over a stretch of time: `squares` (n,) of q, `speed` the square of the joint's velocity, the
    forcing's work, the viscous loss and that of friction.
    """

    squares: FloatArray
    speed: float
    work: float
    loss: float
    rubbed: float


def integrals(
    problem: FrictionProblem, run: Walk, start: float, end: float, *, energies: bool = True
) -> Integrals:
    """The integrals of `run` between two times; work and viscous loss only with `energies`."""
    law, inner = problem.friction, inner_flow(problem)
    assert law is not None
    squares, sums, rubbed = np.zeros(problem.n), np.zeros(3), 0.0
    stretch, free = (start, end, energies), flows_of(problem).free
    if isinstance(free, Flow):
        *others, slipped = _added(problem, run, free, _FREE, stretch, squares)
        sums += others
        rubbed += slipped
    if isinstance(inner, Flow):
        role = _BAND if isinstance(law, SaturatedCoulomb) else _HELD
        *others, _ = _added(problem, run, inner, role, stretch, squares)
        sums += others
        rubbed += law.Q_m / law.sigma * others[0] if isinstance(law, SaturatedCoulomb) else 0.0
    if not (isinstance(free, Flow) and isinstance(inner, Flow)):
        more, slipped = _in_cells(problem, run, start, end, squares)
        sums += more
        rubbed += slipped
    speed, work, loss = sums.tolist()
    return Integrals(squares, speed, work, loss, rubbed)


def _added(
    problem: FrictionProblem,
    run: Walk,
    flow: Flow,
    role: int,
    stretch: tuple[float, float, bool],
    squares: FloatArray,
) -> FloatArray:
    """Adds to `squares` over phases in modes; speed, work, loss and load times speed."""
    assert problem.friction is not None
    start, end, energies = stretch
    sizes = (problem.n, len(flow.part.D) - 1, flow.m, role, problem.joint)
    window = (start, end, run.end, run.initial_mode)
    events = (run.integers, run.reals, len(run.t), run.initial_state)
    power = (binding.pairs(problem.forcing.coefficients), problem.C) if energies else (None, None)
    found = np.zeros(4)
    status = binding.integrals(
        *sizes,
        flow.Omega,
        problem.friction.Q_m,
        flow.packed,
        *window,
        *events,
        *power,
        squares,
        found,
    )
    require_ok(status)
    return found


def _in_cells(
    problem: FrictionProblem, run: Walk, start: float, end: float, squares: FloatArray
) -> tuple[FloatArray, float]:
    """As `_added` over the phases in cells: speed, work and loss (3,), and friction's loss."""
    n, row = problem.n, problem.n + (problem.joint or 0)
    sums, rubbed = np.zeros(3), 0.0
    for piece in pieces(problem, run, start, end):
        if isinstance(piece, NodePiece):
            squares += piece.squares(slice(0, n))
            work, loss = piece.work(problem.forcing.coefficients), piece.quadratic(problem.C, n)
            sums += (float(piece.squares(row)), work, loss)
            rubbed += piece.rubbing(row)
    return sums, rubbed
