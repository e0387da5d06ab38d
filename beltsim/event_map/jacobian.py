r"""Derivative of the state after a walk with respect to the state before it.

Within a phase it is the flow itself. At an event it jumps (saltation): with the watched quantity
`g` reaching its threshold,

.. math:: S^+ = S^- + (f^+ - f^-)\,\frac{\nabla g\, S^-}{\dot g^-}.

* slip to stick: the others receive the joint's momentum,
  :math:`S_{\dot q} \mathrel{+}= M_{qq}^{-1}M_{qt} S_v`, and :math:`S_v = 0`;
* slip to opposite slip: the torque jumps by :math:`2 Q_m`, `M^{-1} e_t` of it per unit;
* release: nothing jumps for Q_s = Q_m; otherwise the joint's acceleration jumps by
  :math:`(Q_s - Q_m)/m`.

The derivative is carried in the amplitudes of the present flow, where a phase is a diagonal; each
change of flow is one constant matrix.

Depends on: flows, walk, problem.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map.cells import CellBasis
from beltsim.event_map.flows import Basis, Flows, flows_of, inner_flow
from beltsim.event_map.walk import KIND, STATE, TORQUE_AFTER, TORQUE_BEFORE, Walk
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem


@dataclass(frozen=True, eq=False)
class _Changes:
    """The two flows in amplitudes, and what leads from one to the other.

    `stick` and `release` map amplitudes (2m each); `position` (2m,) is what the free flow gains per
    unit of the held position. For the saturated law the joint's position is part of the band's
    state and `position` is zero.
    """

    free: Basis | CellBasis
    inner: Basis | CellBasis
    stick: FloatArray
    release: FloatArray
    position: FloatArray


def jacobian(problem: FrictionProblem, run: Walk) -> FloatArray:
    """Derivative (2n, 2n) of `run.final_state` with respect to `run.initial_state`."""
    flows, changes = flows_of(problem), _changes(problem)
    n, joint = problem.n, problem.joint
    saturated = isinstance(problem.friction, SaturatedCoulomb)
    velocity = changes.free.out[n + (joint or 0)]
    S, position = _begin(flows, changes, run.initial_mode, joint or 0, saturated)
    start, mode, still = 0.0, run.initial_mode, np.zeros(2 * n)
    for i, end in enumerate(np.append(run.t, run.end).tolist()):
        if mode:
            S = changes.free.moved(S, end - start, still)
        else:
            S = changes.inner.moved(S, end - start, position)
        if i == len(run.t):
            break
        kind = int(run.integers[i, KIND])
        if kind == 0:
            position = changes.free.out[joint] @ S
            S = changes.stick @ S
        elif kind == 1:
            S = S + np.outer(changes.free.into @ _reversal(problem, flows, run, i), velocity @ S)
        else:
            after = changes.release @ S + np.outer(changes.position, position)
            if not saturated and run.reals[i, TORQUE_BEFORE] != run.reals[i, TORQUE_AFTER]:
                gradient = flows.held.part.row @ (
                    changes.inner.out @ S + np.outer(flows.held.X_c, position)
                )
                gradient += flows.held.part.d_c * position
                after += np.outer(changes.free.into @ _breakaway(flows, problem, run, i), gradient)
            S = after
        mode = (0, -mode, 1, -1)[kind]
        start = end
    if mode or saturated:
        return (changes.free if mode else changes.inner).out @ S
    found = np.zeros((2 * n, 2 * n))
    found[flows.rest] = changes.inner.out @ S + np.outer(flows.held.X_c, position)
    found[joint] = position
    return found


def _begin(
    flows: Flows, changes: _Changes, mode: int, joint: int, saturated: bool
) -> tuple[FloatArray, FloatArray]:
    """Amplitudes (2m, 2n) and position row (2n,) of the identity."""
    size = len(flows.rest) + 2
    if mode or saturated:
        return (changes.free if mode else changes.inner).into, np.zeros(size)
    position = np.zeros(size)
    position[joint] = 1.0
    S = np.zeros((len(changes.inner.into), size))
    S[:, flows.rest] = changes.inner.into
    S[:, joint] = -changes.inner.into @ flows.held.X_c
    return S, position


def _changes(problem: FrictionProblem) -> _Changes:
    if isinstance(problem.friction, SaturatedCoulomb):
        free, inner = flows_of(problem).free.basis, inner_flow(problem).basis
        nothing = np.zeros(len(free.into))
        return _Changes(free, inner, inner.into @ free.out, free.into @ inner.out, nothing)
    if "event_map.changes" not in problem.shared:
        problem.shared["event_map.changes"] = _set_valued_changes(problem)
    found: _Changes = problem.shared["event_map.changes"]
    return found


def _set_valued_changes(problem: FrictionProblem) -> _Changes:
    flows, n, joint = flows_of(problem), problem.n, problem.joint
    assert joint is not None
    free, inner, rest = flows.free.basis, flows.held.basis, flows.rest
    arriving = free.out[rest] - np.outer(flows.held.X_c, free.out[joint])
    arriving[n - 1 :] += np.outer(flows.m_t, free.out[n + joint])
    released = free.into[:, rest]
    position = released @ flows.held.X_c + free.into[:, joint]
    return _Changes(free, inner, inner.into @ arriving, released @ inner.out, position)


def _reversal(problem: FrictionProblem, flows: Flows, run: Walk, i: int) -> FloatArray:
    """Jump (2n,) of the state's rate at event `i`, over the joint's acceleration before it."""
    event = run.reals[i]
    x, before, after = event[STATE:], event[TORQUE_BEFORE], event[TORQUE_AFTER]
    reaction = flows.held.part.signal(run.t[i], x[problem.joint or 0], x[flows.rest])
    jump = np.zeros(2 * problem.n)
    jump[problem.n :] = (before - after) * flows.push * flows.mass / (reaction - before)
    return jump


def _breakaway(flows: Flows, problem: FrictionProblem, run: Walk, i: int) -> FloatArray:
    """Jump (2n,) of the state's rate at release `i`, over the rate of the reaction."""
    event, n, joint = run.reals[i], problem.n, problem.joint
    assert joint is not None
    x = event[STATE:]
    acceleration = (event[TORQUE_BEFORE] - event[TORQUE_AFTER]) / flows.mass
    held = flows.held.part
    acceleration /= held.signals(run.t[i : i + 1], x[[joint]], x[None, flows.rest])[1][0]
    jump = np.zeros(2 * n)
    jump[n + joint] = acceleration
    jump[n + problem.others] = -flows.m_t * acceleration
    return jump
