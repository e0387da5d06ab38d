r"""Derivative of the state after a walk with respect to the state before it.

Within a phase it is the flow itself. At an event it jumps (saltation): with the watched quantity
`g` reaching its threshold,

.. math:: S^+ = S^- + (f^+ - f^-)\,\frac{\nabla g\, S^-}{\dot g^-}.

* slip to stick: the others receive the joint's momentum,
  :math:`S_{\dot q} \mathrel{+}= M_{qq}^{-1}M_{qt} S_v`, and :math:`S_v = 0`;
* slip to opposite slip: the torque jumps by :math:`2 Q_m`, `M^{-1} e_t` of it per unit;
* release: nothing jumps for Q_s = Q_m; otherwise the joint's acceleration jumps by
  :math:`(Q_s - Q_m)/m`.

Depends on: flows, walk, problem.
"""

from __future__ import annotations

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map.flows import Flow, Flows, flows_of, inner_flow
from beltsim.event_map.walk import KIND, STATE, TORQUE_AFTER, TORQUE_BEFORE, Walk
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem


def jacobian(problem: FrictionProblem, run: Walk) -> FloatArray:
    """Derivative (2n, 2n) of `run.final_state` with respect to `run.initial_state`."""
    flows = flows_of(problem)
    saturated = isinstance(problem.friction, SaturatedCoulomb)
    S = np.eye(2 * problem.n)
    times = np.append(run.t, run.end)
    start, mode = 0.0, run.initial_mode
    for i, end in enumerate(times):
        if mode == 0 and saturated:
            S = _moved(inner_flow(problem), S, end - start)
        elif mode == 0:
            S = _held(flows, problem, S, end - start)
        else:
            S = _moved(flows.free, S, end - start)
        if i < len(run.t):
            if not saturated:  # the saturated law is continuous at its edges
                S = _jump(flows, problem, S, run, i)
            mode = (0, -mode, 1, -1)[int(run.integers[i, KIND])]
        start = end
    return S


def _moved(flow: Flow, S: FloatArray, tau: float) -> FloatArray:
    A = np.exp(flow.exponents * tau)[:, None] * (flow.W @ S)
    found: FloatArray = flow.V.real @ A.real - flow.V.imag @ A.imag
    return found


def _held(flows: Flows, problem: FrictionProblem, S: FloatArray, tau: float) -> FloatArray:
    """The joint stays; the others follow it through the static response to its position."""
    position = S[problem.joint]
    shift = np.outer(flows.held.X_c, position)
    after = np.zeros_like(S)
    after[flows.rest] = _moved(flows.held, S[flows.rest] - shift, tau) + shift
    after[problem.joint] = position
    return after


def _jump(flows: Flows, problem: FrictionProblem, S: FloatArray, run: Walk, i: int) -> FloatArray:
    n, joint = problem.n, problem.joint
    assert joint is not None
    kind, event = int(run.integers[i, KIND]), run.reals[i]
    v = n + joint
    if kind == 0:
        S = S.copy()
        S[n + problem.others] += np.outer(flows.m_t, S[v])
        S[v] = 0.0
        return S
    x = event[STATE:]
    before, after = event[TORQUE_BEFORE], event[TORQUE_AFTER]
    if kind == 1:
        reaction = flows.held.signal(run.t[i], x[joint], x[flows.rest])
        jump = (before - after) * flows.push
        rate = (reaction - before) / flows.mass
        S = S.copy()
        S[n:] += np.outer(jump, S[v]) / rate
        return S
    if before == after:
        return S
    gradient = flows.held.row @ S[flows.rest] + flows.held.d_c * S[joint]
    acceleration = (before - after) / flows.mass
    jump = np.zeros(2 * n)
    jump[v] = acceleration
    jump[n + problem.others] = -flows.m_t * acceleration
    rate = signal_rate(flows.held, run.t[i], x[joint], x[flows.rest])
    return S + np.outer(jump, gradient) / rate


def signal_rate(flow: Flow, t: float, c: float, x: FloatArray) -> float:
    """Time derivative of the signal in state `x` (N,) at time `t`."""
    spin = 1j * flow.Omega * np.arange(len(flow.P))
    turns = spin * np.exp(spin * t)
    a = flow.W @ (x - flow.forced(t, c))
    modal = (flow.V @ (flow.exponents * a)).real
    return float(flow.row @ (modal + (turns @ flow.P).real) + (turns @ flow.D).real)
