r"""Periodic orbits by shooting with the exact derivative of the map.

The unknown is the state at t = 0. With :math:`\Phi` the exact map over one period and `S` its
derivative (saltation at events, rank loss in stick), Newton's step is

.. math:: x \leftarrow x + (I - S)^{-1}(\Phi(x) - x).

When the forcing has odd harmonics only, the orbit of a symmetric joint repeats after half a period
with the opposite sign, and half a period suffices. For Q_s = Q_m any two motions approach each
other, so following the motion always leads back to where Newton converges.

Depends on: build, jacobian, locked, settings, walk, response, problem.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from beltsim.checks import FloatArray
from beltsim.errors import ConvergenceError, NotPeriodicError
from beltsim.event_map import build
from beltsim.event_map.flows import ComplexArray, flows_of
from beltsim.event_map.jacobian import jacobian
from beltsim.event_map.locked import at_rest, locked, require_stable
from beltsim.event_map.propagate import checked_run, require_joint
from beltsim.event_map.series import Piece
from beltsim.event_map.settings import Settings
from beltsim.event_map.walk import MODES, Walk, walk
from beltsim.friction import Coulomb, FrictionLaw
from beltsim.problem import FrictionProblem
from beltsim.response import EventLog, Response, figures

#: Periods followed before the first Newton step, and in all before the search is given up.
_FIRST_PERIODS = 3
_MOST_PERIODS = 4000


def periodic(
    problem: FrictionProblem, settings: Settings | None = None, *, guess: Any = None
) -> Response:
    """The periodic response, exact to rounding, with its Floquet multipliers.

    Parameters
    ----------
    problem : FrictionProblem
        With a joint and a stable linear part.
    settings : Settings, optional
        `tolerance`, `harmonics`, `samples_per_period`, `max_multiple`.
    guess : array_like of shape (2n,), optional
        State at t = 0 near the orbit, such as that of a neighbouring torque.

    Returns
    -------
    Response
        One period, both ends; for a joint that never moves, at the middle of its rest interval.

    Raises
    ------
    NotPeriodicError
        When the linear part is unstable, or (Q_s > Q_m) when no orbit of at most `max_multiple`
        forcing periods was found.
    ConvergenceError
        When the residual stays above the tolerance.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4))
    >>> orbit = periodic(one)
    >>> orbit.events.kind.tolist(), orbit.periodic
    (['slip-', 'stick', 'slip+', 'stick'], True)
    """
    settings = settings or Settings()
    require_joint(problem)
    require_stable(problem)
    state = checked_run(problem, 1.0, guess)
    law = problem.friction
    if isinstance(law, Coulomb):
        rest = locked(problem).rest_interval(law.Q_s or 0.0)
        if rest is not None:
            return _resting(problem, rest, settings)
    failures = []
    for multiple in range(1, settings.max_multiple + 1):
        search = _search(problem, state, multiple, settings)
        if search.residual <= settings.tolerance:
            return _orbit_response(problem, search, settings)
        failures.append(search)
    raise _failure(law, failures, settings)


@dataclass
class _Search:
    """Where a shooting search stands."""

    problem: FrictionProblem
    periods: float
    sign: float
    state: FloatArray
    run: Walk
    residual: float
    multiple: int
    followed: float = 0.0
    history: list[float] = field(default_factory=list)

    @property
    def image(self) -> FloatArray:
        return self.sign * self.run.final_state

    def derivative(self) -> FloatArray:
        return self.sign * jacobian(self.problem, self.run)


def _search(
    problem: FrictionProblem, state: FloatArray, multiple: int, settings: Settings
) -> _Search:
    """Newton, with stretches of the motion itself wherever it does not converge."""
    half = multiple % 2 == 1 and half_wave(problem)
    periods, sign = (0.5 * multiple, -1.0) if half else (1.0 * multiple, 1.0)
    search = _follow(problem, state, periods, sign, _FIRST_PERIODS, multiple)
    stretch = 4
    while search.residual > settings.tolerance and search.followed < _MOST_PERIODS:
        better = _newton(search)
        if better is None or not better.residual < 0.9 * search.residual:
            followed, history = search.followed, search.history
            search = _follow(problem, search.state, periods, sign, stretch, multiple)
            search.followed += followed
            search.history = [*history, search.residual]
            stretch = min(2 * stretch, 256)
        else:
            search = better
    return search


def _follow(
    problem: FrictionProblem,
    state: FloatArray,
    periods: float,
    sign: float,
    stretch: int,
    multiple: int,
) -> _Search:
    """The search after following the motion over `stretch` of its periods."""
    for _ in range(stretch):
        state = sign * walk(problem, state, periods).final_state
    return _judged(problem, state, periods, sign, multiple, (stretch + 1) * periods)


def _judged(
    problem: FrictionProblem,
    state: FloatArray,
    periods: float,
    sign: float,
    multiple: int,
    followed: float,
) -> _Search:
    run = walk(problem, state, periods)
    weight = np.ones(2 * problem.n)
    weight[problem.n :] /= problem.forcing.Omega
    image = sign * run.final_state
    size = np.abs(image * weight).max()
    gap = np.abs((image - state) * weight).max()
    residual = float(gap / size) if size > 0.0 else float(gap)
    return _Search(problem, periods, sign, state, run, residual, multiple, followed)


def _newton(search: _Search) -> _Search | None:
    """The search after one Newton step; None where the derivative is singular."""
    problem = search.problem
    n = problem.n
    try:
        step = np.linalg.solve(np.eye(2 * n) - search.derivative(), search.image - search.state)
    except np.linalg.LinAlgError:
        return None
    state = search.state + step
    if search.run.initial_mode == 0 and isinstance(problem.friction, Coulomb):
        state[n + (problem.joint or 0)] = 0.0  # a joint that starts in stick is at rest
    if not np.isfinite(state).all():
        return None
    found = _judged(problem, state, search.periods, search.sign, search.multiple, 0.0)
    found.followed = search.followed + search.periods
    found.history = [*search.history, found.residual]
    return found


def half_wave(problem: FrictionProblem) -> bool:
    """Whether the forcing changes sign after half a period: odd harmonics only."""
    forcing = problem.forcing
    return not (np.any(forcing.cos[0::2]) or np.any(forcing.sin[0::2]))


def _orbit_response(problem: FrictionProblem, search: _Search, settings: Settings) -> Response:
    multipliers = np.linalg.eigvals(search.derivative()).astype(complex)
    run = search.run
    if search.sign < 0.0:
        multipliers = multipliers**2
        run = walk(problem, search.state, float(search.multiple))
    statistics = {
        "solver": "event_map",
        "multiple": search.multiple,
        "newton_steps": len(search.history),
        "periods_followed": search.followed,
        "residual": search.residual,
    }
    return orbit_of(problem, run, multipliers, None, statistics, settings)


def _resting(problem: FrictionProblem, rest: tuple[float, float], settings: Settings) -> Response:
    """The locked orbit at the middle of the rest interval."""
    flows = flows_of(problem)
    position = 0.5 * (rest[0] + rest[1])
    if not np.isfinite(position):
        position = 0.0
    run = walk(problem, at_rest(problem, position), 1.0)
    pairs = np.exp(flows.held.exponents * problem.period)
    both = np.concatenate([pairs, pairs[flows.held.exponents.imag > 0.0].conj()])
    multipliers = np.concatenate([both, [1.0, 0.0]])  # the position is free, the velocity is not
    statistics = {"solver": "event_map", "multiple": 1, "newton_steps": 0, "residual": 0.0}
    return orbit_of(problem, run, multipliers, rest, statistics, settings)


def orbit_of(
    problem: FrictionProblem,
    run: Walk,
    multipliers: ComplexArray,
    rest: tuple[float, float] | None,
    statistics: dict[str, Any],
    settings: Settings,
) -> Response:
    """The `Response` of a closed walk."""
    found = build.response_parts(problem, run, 0.0)
    window = build.window_of(problem, found)
    events = build.event_log(problem, run)
    steps = max(1, round(run.end / problem.period * settings.samples_per_period))
    t = np.linspace(0.0, run.end, steps + 1)
    q, q_dot, torque = build.sampled(found, problem.n, t)
    speed = float(np.abs(q_dot[:, problem.joint or 0]).max())
    mode = MODES[run.initial_mode]
    coefficients = torque_coefficients = None
    if statistics["multiple"] == 1:
        coefficients, torque_coefficients = fourier(problem, found, settings.harmonics)
    return Response(
        problem=problem,
        t=t,
        q=q,
        q_dot=q_dot,
        friction_torque=torque,
        initial_state=run.initial_state,
        final_state=run.final_state,
        initial_mode=mode,
        events=_on_the_circle(events, run.end),
        near_grazing=build.near_grazing(problem, run, speed),
        window=(0.0, run.end),
        **figures(problem, events, mode, window)._asdict(),
        periodic=True,
        coefficients=coefficients,
        torque_coefficients=torque_coefficients,
        multipliers=multipliers,
        rest_interval=rest,
        warnings=problem.warnings,
        statistics=statistics,
    )


def _on_the_circle(events: EventLog, period: float) -> EventLog:
    """An event on the boundary is listed once, at 0."""
    if not len(events) or events.t[-1] < period:
        return events
    order = np.append(len(events) - 1, np.arange(len(events) - 1))
    parts = {name: getattr(events, name)[order] for name in events.__dataclass_fields__}
    parts["t"][0] = 0.0
    return EventLog(**parts)


def fourier(
    problem: FrictionProblem, found: list[Piece], harmonics: int
) -> tuple[ComplexArray, ComplexArray]:
    """Exact coefficients (R + 1, n) of the coordinates and (R + 1,) of the friction torque."""
    w = problem.forcing.Omega * np.arange(harmonics + 1)
    total = np.zeros((harmonics + 1, problem.n + 1), complex)
    for piece in found:
        total += piece.fourier(np.vstack([piece.Z[: problem.n], piece.torque]), w)
    total *= 2.0 / problem.period
    total[0] *= 0.5
    return total[:, :-1], total[:, -1]


def _failure(law: FrictionLaw | None, searches: list[_Search], settings: Settings) -> Exception:
    best = min(searches, key=lambda search: search.residual)
    residual = f"residual {best.residual:.3g} after {best.followed:g} forcing periods"
    if isinstance(law, Coulomb) and law.Q_s is not None and law.Q_s > law.Q_m:
        text = (
            f"no orbit of period {', '.join(str(s.multiple) for s in searches)} was found "
            f"({residual}). With Q_s = {law.Q_s:g} > Q_m = {law.Q_m:g} none need exist; try a "
            f"larger max_multiple ({settings.max_multiple} now) or look at a transient"
        )
        return NotPeriodicError(text)
    text = (
        f"shooting stopped at {residual}, above the tolerance {settings.tolerance:g}; "
        "try a larger tolerance or a guess from a neighbouring case"
    )
    return ConvergenceError(text, best.state, best.history)
