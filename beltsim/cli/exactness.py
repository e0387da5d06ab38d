"""How far the last period of a run is from the exact motion that starts where it starts.

Depends on: event_map, response, problem, forcing; cli.text.
"""

from __future__ import annotations

import numpy as np

from beltsim import event_map
from beltsim.checks import FloatArray
from beltsim.cli.text import listed
from beltsim.forcing import HarmonicForcing
from beltsim.problem import FrictionProblem
from beltsim.response import Response


def exactness_lines(response: Response) -> list[str]:
    """Lines for the terminal; none for a run without a joint or shorter than a period."""
    problem, (start, end) = response.problem, response.window
    period = problem.period
    if problem.friction is None or end - start < period * (1.0 - 1e-9):
        return []
    first = int(np.argmin(np.abs(response.t - start)))
    if abs(response.t[first] - start) > 1e-9 * period:
        return []
    state = np.concatenate([response.q[first], response.q_dot[first]])
    settings = event_map.Settings(keep="events")
    exact = event_map.propagate(later(problem, start), 1.0, state, settings)
    inside = (response.events.t > start) & (response.events.t <= end)
    kinds, times = response.events.kind[inside], response.events.t[inside] - start
    if kinds.tolist() == exact.events.kind.tolist():
        worst = float(np.abs(times - exact.events.t).max(initial=0.0)) / period
        events = f"the same, times within {worst:.1e} of a period"
    else:
        events = f"differ: {' '.join(kinds)} here, {' '.join(exact.events.kind)} exactly"
    gap = _relative(problem, response.final_state, exact.final_state)
    pairs = [("events", events), ("end state", f"within {gap:.1e} of its largest entry")]
    return ["", "Last period against the exact map", *listed(pairs)]


def later(problem: FrictionProblem, t: float) -> FrictionProblem:
    """The same problem with its clock set forward by `t`."""
    forcing = problem.forcing
    turned = (
        forcing.coefficients
        * np.exp(1j * np.arange(len(forcing.cos)) * ((forcing.Omega * t) % (2.0 * np.pi)))[:, None]
    )
    sin = -turned.imag
    sin[0] = 0.0
    shifted = HarmonicForcing(forcing.Omega, turned.real, sin)
    parts = (problem.M, problem.C, problem.G, problem.K, problem.joint)
    return FrictionProblem(*parts, shifted, problem.friction)


def _relative(problem: FrictionProblem, state: FloatArray, other: FloatArray) -> float:
    """Largest difference over the largest entry, velocities over Omega."""
    weight = np.repeat([1.0, 1.0 / problem.forcing.Omega], problem.n)
    size = float(np.abs(other * weight).max())
    gap = float(np.abs((state - other) * weight).max())
    return gap / size if size > 0.0 else gap
