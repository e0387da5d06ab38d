r"""A walk as a motion: its states at given times, and its Fourier integrals in closed form.

In a phase the state is :math:`x(\tau) = \mathrm{Re}\,Z e^{\mu\tau}`, modes, harmonics and constant
alike, so every Fourier integral is a sum of

.. math:: I(s) = \int_0^d e^{s\tau}\,d\tau = (e^{sd} - 1)/s .

The C map does both for flows in modes; those in cells have `nodes`.

Depends on: flows, nodes, walk, binding, status, problem, friction.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from beltsim.checks import FloatArray
from beltsim.event_map import binding
from beltsim.event_map.flows import Flow, roles_of
from beltsim.event_map.linear_part import ComplexArray
from beltsim.event_map.nodes import node_pieces
from beltsim.event_map.status import require_ok
from beltsim.event_map.walk import Walk
from beltsim.friction import SaturatedCoulomb
from beltsim.problem import FrictionProblem


def phases_of(
    problem: FrictionProblem, run: Walk, role: int, flow: Flow, start: float, end: float
) -> tuple[Any, ...]:
    """The phases of a flow between two times, as the C map takes them."""
    law = problem.friction
    assert law is not None
    slope = law.Q_m / law.sigma if isinstance(law, SaturatedCoulomb) else 0.0
    sizes = (problem.n, len(flow.part.D) - 1, flow.m, role, problem.joint)
    numbers = (flow.Omega, law.Q_m, slope, flow.packed, start, end, run.end, run.initial_mode)
    return *sizes, *numbers, run.integers, run.reals, len(run.t), run.initial_state


def sampled(
    problem: FrictionProblem, run: Walk, t: FloatArray, half: float | None = None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coordinates, velocities (nt, n) and friction torque (nt,) at the ascending times `t`.

    `half`: what comes after that time is the mirror image of what was before.
    """
    if half is not None:
        second = int(np.searchsorted(t, half, side="right"))
        parts = sampled(problem, run, t[:second]), sampled(problem, run, t[second:] - half)
        q, q_dot, torque = (np.concatenate([a, -b]) for a, b in zip(*parts, strict=True))
        return q, q_dot, torque
    n, x, torque = problem.n, np.empty((len(t), 2 * problem.n)), np.empty(len(t))
    roles = roles_of(problem)
    for role, flow in roles:
        if isinstance(flow, Flow):
            phases = phases_of(problem, run, role, flow, 0.0, run.end)
            require_ok(binding.sample(phases, len(t), t, x, torque))
    if not all(isinstance(flow, Flow) for _, flow in roles):
        for piece in node_pieces(problem, run, 0.0, run.end):
            end = piece.start + piece.length
            first = int(np.searchsorted(t, piece.start))
            last = len(t) if end >= run.end else int(np.searchsorted(t, end))
            at = slice(first, last)
            x[at] = piece.at(t[at] - piece.start)
            torque[at] = piece.torque_at(t[at] - piece.start)
    return x[:, :n], x[:, n:], torque


def fourier(
    problem: FrictionProblem, run: Walk, end: float, harmonics: int, *, symmetric: bool = False
) -> tuple[ComplexArray, ComplexArray]:
    """Exact coefficients (R + 1, n) of the coordinates and (R + 1,) of the friction torque.

    `symmetric`: `end` is half a period, which the other half repeats with the opposite sign.
    """
    first, step = (1, 2) if symmetric else (0, 1)
    total = np.zeros((harmonics + 1, 2 * problem.n + 1), complex)
    found: Any = total[first::step].copy()
    roles = roles_of(problem)
    for role, flow in roles:
        if isinstance(flow, Flow):
            phases = phases_of(problem, run, role, flow, 0.0, end)
            require_ok(binding.fourier(phases, len(found), first, step, found.view(float)))
    if not all(isinstance(flow, Flow) for _, flow in roles):
        for piece in node_pieces(problem, run, 0.0, end):
            found += piece.fourier(harmonics + 1)[first::step]
    total[first::step] = found * (4.0 if symmetric else 2.0) / problem.period
    total[0] *= 0.5
    return total[:, : problem.n], total[:, -1]
