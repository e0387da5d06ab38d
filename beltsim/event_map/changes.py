r"""How a small change of the state passes from one flow to the other, packed for the C map.

The derivative of a walk is carried in the real amplitudes of the present flow: real and imaginary
part of each complex one, each real one; in cells the energy coordinates. A phase is nearly diagonal
in them, and each change of flow is one constant matrix. With :math:`x_r` the state without the
joint, a stop gives the others the joint's momentum,

.. math:: \dot x_r \mathrel{+}= M_{qq}^{-1}M_{qt}\,\dot q_t,

and a held place moves the held flow's equilibrium by `X_c`.

Depends on: flows, cells, binding, problem, friction.
"""

from __future__ import annotations

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map import binding
from beltsim.event_map.cells import CellFlow
from beltsim.event_map.flows import AnyFlow, flows_of, inner_flow
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem


def changes_of(problem: FrictionProblem) -> FloatArray:
    """The packed changes of `problem`, in the order of bm_changes; kept with its flows."""
    law = problem.friction if isinstance(problem.friction, SaturatedCoulomb) else None
    cached = problem.shared.get("event_map.changes")
    if cached is None or cached[0] != law:
        make = _set_valued if law is None else _saturated
        cached = (law, _packed(problem, *make(problem)))
        problem.shared["event_map.changes"] = cached
    found: FloatArray = cached[1]
    return found


def amplitudes(flow: AnyFlow) -> tuple[FloatArray, FloatArray]:
    """State to real amplitudes (N, N), and back."""
    if isinstance(flow, CellFlow):
        return flow.scale
    complex_too = np.stack([np.ones(flow.m, bool), flow.exponents.imag != 0.0], axis=1).ravel()
    into = np.stack([flow.W.real, flow.W.imag], axis=1).reshape(2 * flow.m, flow.N)
    out = np.stack([flow.V.real, -flow.V.imag], axis=2).reshape(flow.N, 2 * flow.m)
    return into[complex_too], out[:, complex_too]


def _set_valued(problem: FrictionProblem) -> tuple[FloatArray, ...]:
    flows, n, joint = flows_of(problem), problem.n, problem.joint
    assert joint is not None
    rest, X_c, held = flows.rest, flows.held.X_c, flows.held.part
    into, out = amplitudes(flows.free)
    into_held, out_held = amplitudes(flows.held)
    momentum, kick = np.zeros(2 * n - 2), np.zeros(2 * n)
    momentum[n - 1 :] = flows.m_t
    kick[n + joint] = 1.0
    kick[n + problem.others] = -flows.m_t
    return (
        into_held @ (out[rest] - np.multiply.outer(X_c, out[joint])),
        into[:, rest] @ out_held,
        into[:, rest] @ X_c + into[:, joint],
        into_held @ momentum,
        into[:, n:] @ flows.push,
        into @ kick,
        held.row @ out_held,
        np.array([held.row @ X_c + held.d_c, flows.mass]),
    )


def _saturated(problem: FrictionProblem) -> tuple[FloatArray, ...]:
    """Nothing jumps, and the band holds the whole state."""
    into, out = amplitudes(flows_of(problem).free)
    into_band, out_band = amplitudes(inner_flow(problem))
    nothing = [np.zeros(2 * problem.n) for _ in range(5)]
    return into_band @ out, into @ out_band, *nothing, np.array([0.0, 1.0])


def _packed(
    problem: FrictionProblem,
    stick: FloatArray,
    release: FloatArray,
    position: FloatArray,
    impact: FloatArray,
    push: FloatArray,
    kick: FloatArray,
    grip: FloatArray,
    numbers: FloatArray,
) -> FloatArray:
    into, out = amplitudes(flows_of(problem).free)
    joint = problem.joint or 0
    parts = [into, out, stick, release, out[joint], out[problem.n + joint]]
    parts += [position, impact, push, kick, grip, numbers]
    found = np.concatenate([part.ravel() for part in parts])
    assert len(found) == binding.changes_reals(problem.n, len(impact))
    return found
