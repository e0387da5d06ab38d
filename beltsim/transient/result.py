"""From the core's records to a `Response`.

Depends on: problem, friction, response, transient.driver.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from beltsim.checks import FloatArray
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.problem import FrictionProblem
from beltsim.response import (
    EVENT_KINDS,
    EVENT_QUALITIES,
    PERIODIC_TOLERANCE,
    EventLog,
    NearGrazing,
    Response,
    Window,
    figures,
    friction_travel,
    grazing_warnings,
)
from beltsim.transient.driver import MODE_NAMES, Driver, Recording

#: A band is narrow when it is below this many times the velocity that the tolerance resolves.
NARROW_BAND = 10.0
#: A band is wide when it is above this share of the largest velocity.
WIDE_BAND = 0.1


def build(driver: Driver, y0: FloatArray, window: tuple[float, float] | None) -> Response:
    """The response of a finished run, or of an interrupted one (`window` None).

    An interrupted run is judged over all of what it has; its energy balance is not known (NaN).
    """
    problem, settings, rec = driver.problem, driver.settings, driver.recording
    seen = driver.core.summary()
    final = driver.state()
    events = _event_log(problem, rec, seen)
    mode = MODE_NAMES[seen["initial_mode"]]
    span = window or (0.0, float(seen["t"]))
    view = Window(
        *span,
        driver.window_state() if window else y0,
        final,
        seen["forcing_work"] if window else np.nan,
        seen["viscous_loss"] if window else np.nan,
        _saturated_loss(problem, seen, window is not None),
    )
    with np.errstate(over="ignore", invalid="ignore"):  # an interrupted run may be running away
        found = figures(problem, events, mode, view)
    if window is None:
        found = found._replace(energy_balance_residual=np.nan)
    grazing = _near_grazing(problem, rec, seen, settings.grazing)
    kept = slice(0, 0) if settings.keep == "events" else rec.sampled(window is not None)
    n = problem.n
    return Response(
        problem=problem,
        t=rec.sample_t[kept],
        q=rec.sample_state[kept, :n],
        q_dot=rec.sample_state[kept, n:],
        friction_torque=rec.sample_torque[kept],
        initial_state=y0,
        final_state=final,
        initial_mode=mode,
        events=events,
        near_grazing=grazing,
        window=span,
        periodic=found.period_residual is not None and found.period_residual <= PERIODIC_TOLERANCE,
        total_dissipated_energy=_total_loss(problem, events, mode, seen, y0, final),
        warnings=_warnings(driver, events, grazing, seen, window, span),
        statistics=_statistics(driver, seen) | {"complete": int(window is not None)},
        **found._asdict(),
    )


def _event_log(problem: FrictionProblem, rec: Recording, seen: dict[str, Any]) -> EventLog:
    rows, codes = rec.events.rows, rec.codes.rows
    n = problem.n
    states = rec.states.rows if rec.states is not None else np.zeros((len(rows), 0))
    kind = np.array(EVENT_KINDS)[codes[:, 0]]
    return EventLog(
        t=rows[:, 0],
        kind=kind,
        q=states[:, :n],
        q_dot=states[:, n:],
        position=rows[:, 1],
        torque_before=rows[:, 2],
        torque_after=rows[:, 3],
        quality=np.array(EVENT_QUALITIES)[codes[:, 1]],
        margin=_margins(problem, rows, kind, seen),
    )


def _margins(
    problem: FrictionProblem, rows: FloatArray, kind: Any, seen: dict[str, Any]
) -> FloatArray:
    """Relative distance of each event to its other outcome; see `EventLog`.

    The saturated law has no other outcome than not reaching the edge of the band: there it is the
    rate of the velocity through the edge, over Omega times the largest velocity.
    """
    law = problem.friction
    Omega = problem.forcing.Omega
    rate = np.abs(rows[:, 5])
    if not isinstance(law, Coulomb):
        return rate / (Omega * (seen["velocity_peak"] or 1.0))
    Q_s = float(law.Q_s or 0.0)
    size = max(Q_s, seen["reaction_peak"]) or 1.0
    leaves = (kind == "slip+") | (kind == "slip-")
    margin: FloatArray = np.where(
        leaves, rate / (Omega * size), np.abs(np.abs(rows[:, 4]) - Q_s) / size
    )
    return margin


def _near_grazing(
    problem: FrictionProblem, rec: Recording, seen: dict[str, Any], threshold: float
) -> NearGrazing:
    t, distance, mode = rec.touches.rows.T
    law = problem.friction
    reaction = (mode == 0) & isinstance(law, Coulomb)
    Q_s = float(law.Q_s or 0.0) if isinstance(law, Coulomb) else 0.0
    inside = max(Q_s, seen["reaction_peak"]) or 1.0
    if isinstance(law, SaturatedCoulomb):
        inside = law.sigma  # within the band the velocity lives on its width
    margin = distance / np.where(mode == 0, inside, seen["velocity_peak"] or 1.0)
    close = margin < threshold
    names = np.where(reaction, "reaction", "velocity")
    return NearGrazing(t[close].copy(), margin[close], names[close])


def _saturated_loss(problem: FrictionProblem, seen: dict[str, Any], finished: bool) -> float | None:
    if not isinstance(problem.friction, SaturatedCoulomb):
        return None
    loss: float = seen["window_friction_loss"] if finished else seen["friction_loss"]
    return loss


def _total_loss(
    problem: FrictionProblem,
    events: EventLog,
    mode: str | None,
    seen: dict[str, Any],
    y0: FloatArray,
    final: FloatArray,
) -> float | None:
    joint, law = problem.joint, problem.friction
    if joint is None or law is None or mode is None:
        return 0.0
    if isinstance(law, SaturatedCoulomb):
        loss: float = seen["friction_loss"]
        return loss
    ends = (float(y0[joint]), float(final[joint]))
    return law.Q_m * friction_travel(events, mode, 0.0, seen["t"], ends)


def _statistics(driver: Driver, seen: dict[str, Any]) -> dict[str, Any]:
    names = (
        "steps",
        "series_steps",
        "right_sides",
        "error_test_failures",
        "convergence_failures",
        "jacobians",
        "restarts",
        "events",
        "velocity_peak",
        "reaction_peak",
    )
    method = driver.settings.method_for(driver.problem)
    return {
        "solver": "taylor" if method == "taylor" else "cvode",
        "method": method,
        "rtol": driver.settings.rtol,
        "sundials_version": driver.core_module.sundials_version,
        **{name: seen[name] for name in names},
    }


def _warnings(
    driver: Driver,
    events: EventLog,
    grazing: NearGrazing,
    seen: dict[str, Any],
    window: tuple[float, float] | None,
    span: tuple[float, float],
) -> tuple[str, ...]:
    problem, rec = driver.problem, driver.recording
    found = list(problem.warnings)
    rows = rec.sampled(window is not None)
    t, q = rec.sample_t[rows], rec.sample_state[rows, : problem.n]
    if len(t):
        inside = t >= (window[0] if window else t[-1] - problem.period)
        found += problem.limit_warnings(t[inside], q[inside])
    found += grazing_warnings(events, grazing, span)
    if isinstance(problem.friction, SaturatedCoulomb):
        found += _band_warnings(driver, seen)
    return tuple(found)


def _band_warnings(driver: Driver, seen: dict[str, Any]) -> list[str]:
    problem, settings = driver.problem, driver.settings
    law, joint = problem.friction, problem.joint
    if not isinstance(law, SaturatedCoulomb) or joint is None:
        return []
    peak = seen["velocity_peak"]
    resolved = settings.rtol * peak
    found = []
    if law.sigma < NARROW_BAND * resolved:
        found.append(
            f"the band sigma = {law.sigma:g} is narrow against the velocity error that rtol = "
            f"{settings.rtol:g} allows ({resolved:.2g}): tighten rtol or widen the band"
        )
    if peak > 0.0 and law.sigma > WIDE_BAND * peak:
        found.append(
            f"the band sigma = {law.sigma:g} is wide against the largest joint velocity "
            f"{peak:.3g}: the law is viscous rather than dry there"
        )
    return found
