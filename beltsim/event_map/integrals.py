r"""Exact integrals over a stretch of a walk: work, losses and squares.

In a phase the state is :math:`x = R\,u(\tau)`, `u` the real and imaginary parts of all
exponentials: modes, harmonics, load. With the Gram matrix :math:`\Gamma = \int u u^T d\tau`, summed
over all phases of one flow by the C map, every quadratic figure is a contraction,

.. math:: \int x_i^2 = (R\,\Gamma R^T)_{ii}, \qquad \int \dot q^T C \dot q = C : R_v \Gamma R_v^T .

Flows in cells are integrated by Gauss points instead (`nodes`).

Depends on: flows, motion, nodes, walk, binding, status, problem, friction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map import binding
from beltsim.event_map.flows import FREE, Flow, roles_of
from beltsim.event_map.motion import phases_of
from beltsim.event_map.nodes import node_pieces
from beltsim.event_map.status import require_ok
from beltsim.event_map.walk import Walk
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem


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
    law, roles = problem.friction, roles_of(problem)
    squares, total, rubbed = np.zeros(problem.n), np.zeros(4), 0.0
    power = (binding.pairs(problem.forcing.coefficients), problem.C) if energies else (None, None)
    for role, flow in roles:
        if isinstance(flow, Flow):
            sums = np.zeros(4)
            phases = phases_of(problem, run, role, flow, start, end)
            require_ok(binding.integrals(phases, *power, squares, sums))
            total += sums
            if role == FREE:
                rubbed += float(sums[3])
            elif isinstance(law, SaturatedCoulomb):
                rubbed += law.Q_m / law.sigma * float(sums[0])
    if not all(isinstance(flow, Flow) for _, flow in roles):
        n, row = problem.n, problem.n + (problem.joint or 0)
        for piece in node_pieces(problem, run, start, end):
            squares += piece.squares(slice(0, n))
            work, loss = piece.work(problem.forcing.coefficients), piece.quadratic(problem.C, n)
            total += (float(piece.squares(row)), work, loss, 0.0)
            rubbed += piece.rubbing(row)
    speed, work, loss, _ = total.tolist()
    return Integrals(squares, speed, work, loss, rubbed)
