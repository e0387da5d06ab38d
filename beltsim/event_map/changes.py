r"""How a small change of the state passes from one flow to the other, packed for the C map.

The derivative of a walk is carried in the real amplitudes of the present flow: real and imaginary
part of each complex one, each real one; in cells the energy coordinates. A phase is nearly diagonal
in them, and each change of flow is one constant matrix (changes.c).

Depends on: flows, binding, status, problem, friction.
"""

from __future__ import annotations

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map import binding
from beltsim.event_map.flows import flows_of, inner_flow
from beltsim.event_map.status import require_ok
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem


def changes_of(problem: FrictionProblem) -> FloatArray:
    """The packed changes of `problem`, in the order of bm_changes; kept with its flows."""
    law = problem.friction if isinstance(problem.friction, SaturatedCoulomb) else None
    cached = problem.shared.get("event_map.changes")
    if cached is None or cached[0] != law:
        cached = (law, _changes(problem, law is not None))
        problem.shared["event_map.changes"] = cached
    found: FloatArray = cached[1]
    return found


def _changes(problem: FrictionProblem, saturated: bool) -> FloatArray:
    flows, inner = flows_of(problem), inner_flow(problem)
    free, n = flows.free, problem.n
    found = np.empty(binding.changes_reals(n, inner.N))
    sizes = (n, len(free.part.D) - 1, free.m, inner.m, int(saturated))
    joint = (problem.joint, flows.mass, flows.m_t, flows.push)
    require_ok(binding.changes(*sizes, free.Omega, free.packed, inner.packed, *joint, found))
    return found


def amplitudes(problem: FrictionProblem) -> tuple[FloatArray, FloatArray]:
    """State to real amplitudes of the free flow (2n, 2n), and back."""
    N = 2 * problem.n
    both = changes_of(problem)[: 2 * N * N].reshape(2, N, N)
    return both[0], both[1]
