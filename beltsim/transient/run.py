"""`integrate`: one run in time, from a problem to its `Response`.

Depends on: errors, checks, problem, friction, response, transient.driver, transient.settings.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from beltsim.checks import FloatArray, finite_array, real_number
from beltsim.errors import CoreError, InvalidProblemError, Mistake
from beltsim.problem import FrictionProblem, require_problem
from beltsim.response import Response
from beltsim.transient.driver import Driver
from beltsim.transient.result import build
from beltsim.transient.settings import Settings

#: Largest array of samples that is tried, in bytes.
LARGEST_SAMPLES = 16 * 2**30


def integrate(
    problem: FrictionProblem,
    periods: float = 100.0,
    initial_state: Any = None,
    settings: Settings | None = None,
    *,
    progress: Callable[[float], None] | None = None,
) -> Response:
    """Motion of `problem` over `periods` forcing periods, with every event located.

    Parameters
    ----------
    problem : FrictionProblem
        With a joint (Coulomb or saturated law) or without (linear).
    periods : float
        Length of the run in periods of the forcing's fundamental, > 0; need not be an integer.
    initial_state : array_like of shape (2n,), optional
        All coordinates, then all velocities, at t = 0. Default: rest at zero. A joint velocity of
        exactly zero sticks if it can.
    settings : Settings, optional
    progress : callable, optional
        Called about every 0.1 s with the share of the run that is done, 0 to 1.

    Returns
    -------
    Response
        Figures belong to the last period. Its energy balance uses Gauss quadrature of forcing work
        and viscous loss on the dense output over that period.

    Raises
    ------
    InvalidProblemError
        When an argument cannot be used.
    CoreError
        When the core stopped; `partial` holds the response until then: all events, the state
        reached, and the samples so far, with ``keep="last_period"`` those of a stretch shortly
        before; its ``statistics["complete"]`` is 0.
    KeyboardInterrupt
        On Ctrl-C, within about 0.1 s; its attribute `partial` holds the same.

    Examples
    --------
    A mass on a spring, k = 4, m = 1, with friction 0.5: it comes to rest after three half swings
    of pi/2, each 2 Q_m/k = 0.25 shorter than the one before.

    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing
    >>> rest = HarmonicForcing(2.0, cos=[[0.0]], sin=[[0.0]])
    >>> mass = FrictionProblem([[1.0]], [[0.0]], [[0.0]], [[4.0]], 0, rest, Coulomb(0.5))
    >>> run = integrate(mass, periods=3.0, initial_state=[0.8, 0.0])
    >>> [str(kind) for kind in run.events.kind], round(float(run.events.t[-1]), 6)
    (['reverse', 'reverse', 'stick'], 4.712389)
    >>> round(float(run.final_state[0]), 9)
    -0.05
    """
    settings = Settings() if settings is None else settings
    y0, t_end = _checked(problem, periods, initial_state, settings)
    window_start = max(0.0, t_end - problem.period)
    sample_t = _sample_times(problem, settings, periods, t_end)
    driver = Driver(problem, settings, y0, t_end, window_start, sample_t)
    try:
        driver.run(progress)
    except CoreError as error:
        error.partial = build(driver, y0, None)
        raise
    except KeyboardInterrupt as stop:
        stop.partial = build(driver, y0, None)  # type: ignore[attr-defined]
        raise
    return build(driver, y0, (window_start, t_end))


def _checked(
    problem: Any, periods: Any, initial_state: Any, settings: Any
) -> tuple[FloatArray, float]:
    """Initial state and end time, or every mistake in the arguments."""
    require_problem(problem)
    mistakes = common_mistakes(periods, settings)
    length = real_number(periods)
    if problem.n == 0:
        mistakes.append(Mistake("problem.n", 0, "at least 1"))
    y0: FloatArray | None = np.zeros(2 * problem.n)
    if initial_state is not None:
        y0 = finite_array(initial_state, ndim=1)
        if y0 is None or len(y0) != 2 * problem.n:
            allowed = f"{2 * problem.n} finite numbers: coordinates, then velocities"
            mistakes.append(Mistake("initial_state", initial_state, allowed))
    if mistakes or y0 is None or length is None:
        raise InvalidProblemError(mistakes)
    return np.ascontiguousarray(y0), length * problem.period


def common_mistakes(periods: Any, settings: Any) -> list[Mistake]:
    """What is wrong with the arguments that runs of several problems share."""
    mistakes = []
    if not isinstance(settings, Settings):
        mistakes.append(Mistake("settings", settings, "a transient.Settings"))
    length = real_number(periods)
    if length is None or not 0.0 < length <= 1e12:
        mistakes.append(Mistake("periods", periods, "a finite number > 0, at most 1e12"))
    return mistakes


def _sample_times(
    problem: FrictionProblem,
    settings: Settings,
    periods: float,
    t_end: float,
) -> FloatArray:
    """Times of the samples; those of the last period are taken even when they are not kept."""
    wanted = settings.kept_periods if settings.keep == "last_period" else 1.0
    length = periods if settings.keep == "all" else min(wanted, periods)
    start = max(0.0, t_end - length * problem.period)
    # a hair less, so that rounding of `periods` does not add a sample
    count = max(1, math.ceil(settings.samples_per_period * length * (1.0 - 1e-12))) + 1
    if count * (2 * problem.n + 2) * 8 > LARGEST_SAMPLES:
        allowed = f"small enough to need at most {LARGEST_SAMPLES} bytes; keep='events' needs none"
        raise InvalidProblemError(Mistake("settings.samples_per_period", f"{count} rows", allowed))
    return np.linspace(start, t_end, count)
