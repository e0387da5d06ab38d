"""`beltsim events`: exact periodic motions over a range of friction torques.

Each torque of the range gets its orbit from the event map: phases of the period, reversals, stops,
losses and stability, as a table, a dataset and one picture.

Depends on: event_map, linear, io; the other modules of cli.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from beltsim import event_map, linear
from beltsim.checks import FloatArray
from beltsim.cli.arguments import OUT
from beltsim.cli.mistakes import Mistakes
from beltsim.cli.operation import examined, friction_given, merged
from beltsim.cli.source import Source, read_source
from beltsim.cli.steady import operating_lines, warning_lines
from beltsim.cli.text import complain, say, table
from beltsim.cli.written import earlier, written_lines
from beltsim.errors import BeltsimError, InvalidProblemError, Mistake, ResultFileError
from beltsim.friction import Coulomb
from beltsim.io import require_writable
from beltsim.metrics import Survey
from beltsim.metrics.phase_pattern import phase_pattern
from beltsim.problem import FrictionProblem
from beltsim.response import Response

Found = list[tuple[float, Response | BeltsimError]]


class _Job(NamedTuple):
    """A study with everything that it needs, checked."""

    source: Source
    arguments: dict[str, Any]
    problem: FrictionProblem
    survey: Survey
    torques: FloatArray
    Q_cr: float
    multiple: int
    stem: Path


def run(options: argparse.Namespace) -> int:
    """Solve, write and print; the exit status."""
    job = _prepared(options)
    law = job.problem.friction
    ratio = law.Q_s / law.Q_m if isinstance(law, Coulomb) and law.Q_s and law.Q_m else 1.0
    problems = [job.problem.with_friction(Coulomb(Q, Q * ratio)) for Q in job.torques.tolist()]
    settings = event_map.Settings(max_multiple=job.multiple)
    solved = event_map.solve_many(problems, settings)
    found = list(zip(job.torques.tolist(), solved, strict=True))
    before = earlier(job.stem.parent)
    written, trouble = _write(job, found, ratio, None if options.no_plot else options.format)
    say(job.source.drive.name or job.stem.name, *operating_lines(job.survey, job.problem), "")
    say(*_locking_lines(job, ratio), "")
    say(*table(_TITLES, [_row(job.problem, Q, orbit) for Q, orbit in found]))
    orbits = [one for _, one in found if isinstance(one, Response)]
    texts = dict.fromkeys((*job.survey.warnings, *_warnings(job.problem, orbits)))
    say(*warning_lines(tuple(texts)))
    say(*written_lines(written, before))
    for Q, orbit in found:
        if not isinstance(orbit, Response):
            complain(f"Q_m = {Q:.4g}: {orbit}")
    complain(trouble)
    failed = any(not isinstance(orbit, Response) for _, orbit in found)
    return 1 if trouble or failed else 0


#: Warnings that each orbit has in words of its own, and what is said of all together.
_OF_AN_ORBIT = {
    "the orbit is unstable": "the orbit is unstable (column multiplier): no motion settles there",
    "the joint is locked, but": "the arm is shown locked but may move for ever from another start "
    "(Q_m < Q_cr): try `beltsim run`",
}


def _warnings(problem: FrictionProblem, orbits: list[Response]) -> list[str]:
    """Each warning of the orbits once; limits that are crossed, over all torques together."""
    names = tuple(seen.name for seen in problem.observables)
    own = (*names, *_OF_AN_ORBIT)
    found = [text for one in orbits for text in one.warnings if not text.startswith(own)]
    for start, words in _OF_AN_ORBIT.items():
        at = [
            one.problem.friction.Q_m
            for one in orbits
            if one.problem.friction and any(text.startswith(start) for text in one.warnings)
        ]
        if at:
            places = f"Q_m = {at[0]:.4g}" + (f" to {at[-1]:.4g}" if len(at) > 1 else "")
            found.append(f"at {len(at)} of {len(orbits)} torques, {places}, {words}")
    for seen in problem.observables:
        scale, unit = seen.shown
        values = [seen.at(one.t, one.q, one.problem.forcing.Omega) for one in orbits]
        for limit, sign, verb in ((seen.lower, -1.0, "falls below"), (seen.upper, 1.0, "exceeds")):
            worst = [sign * float((sign * each).max()) for each in values]
            beyond = [each for each in worst if sign * (each - limit) > 0.0]
            if beyond:
                extreme = sign * max(sign * each for each in beyond) * scale
                found.append(
                    f"{seen.name} {verb} {limit * scale:.6g}{unit} at {len(beyond)} of "
                    f"{len(orbits)} torques, as far as {extreme:.6g}{unit}"
                )
    return list(dict.fromkeys(found))


def _locking_lines(job: _Job, ratio: float) -> list[str]:
    """From which torque the arm is locked, and where it only can be."""
    if ratio == 1.0:
        return [f"The arm is locked from Q_m = {job.Q_cr:.4g}"]
    return [
        f"Q_s = {ratio:.4g} Q_m throughout, the ratio given",
        f"The arm can stay locked from Q_m = {job.Q_cr / ratio:.4g} (rows below show that orbit), "
        f"and ends locked from Q_m = {job.Q_cr:.4g}",
    ]


_TITLES = ("Q_m", "N m", "phases", "period", "nu", "stops", "stick", "loss J", "multiplier")


def _row(problem: FrictionProblem, Q: float, orbit: Response | BeltsimError) -> list[str]:
    assert problem.scales is not None  # a drive has them
    unit = problem.scales.torque_N_m
    torque = f"{Q * unit:.4g}"
    if not isinstance(orbit, Response):
        return [f"{Q:.4g}", torque, "failed", "-", "-", "-", "-", "-", "-"]
    return [
        f"{Q:.4g}",
        torque,
        phase_pattern(orbit),
        f"{_multiple(orbit)}",
        f"{orbit.velocity_reversals:.3g}",
        f"{orbit.stops_per_period:.3g}",
        f"{orbit.stick_fraction:.1%}",
        f"{orbit.dissipated_energy / _multiple(orbit) * unit:.4g}",
        f"{largest_multiplier(orbit):.4f}",
    ]


def _multiple(orbit: Response) -> int:
    """Period of an orbit in forcing periods; figures of the table are per forcing period."""
    return int(orbit.statistics.get("multiple", 1))


def largest_multiplier(orbit: Response) -> float:
    """Modulus of the largest Floquet multiplier; a locked joint's free position does not count."""
    sizes = np.sort(np.abs(np.asarray(orbit.multipliers)))
    return float(sizes[-2] if orbit.rest_interval is not None else sizes[-1])


def _prepared(options: argparse.Namespace) -> _Job:
    """The job, or every mistake in its input at once."""
    out, mistakes = Path(options.out or OUT), Mistakes()
    source = read_source(options.file)
    arguments = merged(options, source.arguments)
    law, problem, found = None, None, None
    with mistakes.gathered():
        law = friction_given(source, arguments)
    with mistakes.gathered():
        problem, found = examined(source, arguments, law)
    with mistakes.gathered():
        if problem is not None and problem.joint is None:
            raise InvalidProblemError(
                f"{options.file}: this drive has no tensioner, so no friction"
            )
    with mistakes.gathered():
        _require_range(options)
    with mistakes.gathered():
        require_writable(out)
    mistakes.raise_any()
    assert problem is not None
    assert found is not None
    Q_cr = linear.critical_torque(problem)
    low = 0.02 * Q_cr if options.lowest is None else options.lowest
    high = 1.05 * Q_cr if options.highest is None else options.highest
    if Q_cr == 0.0 and options.highest is None:
        said = "nothing moves the arm (no speed_fluctuation?), so any friction locks it; name --to"
        raise InvalidProblemError(f"{options.file}: {said}")
    if not low < high:
        raise InvalidProblemError(Mistake("--to", high, f"above --from, {low:.4g}"))
    torques = np.linspace(low, high, options.count)
    stem = out / Path(options.file).stem
    return _Job(source, arguments, problem, found, torques, Q_cr, options.max_multiple, stem)


def _require_range(options: argparse.Namespace) -> None:
    mistakes = []
    for name, value in (("--from", options.lowest), ("--to", options.highest)):
        if value is not None and not 0.0 <= value < np.inf:
            mistakes.append(Mistake(name, value, "a finite number >= 0"))
    if not 2 <= options.count <= 100_000:
        mistakes.append(Mistake("--count", options.count, "an integer from 2 to 100000"))
    if not 1 <= options.max_multiple <= 1000:
        mistakes.append(Mistake("--max-multiple", options.max_multiple, "from 1 to 1000"))
    if mistakes:
        raise InvalidProblemError(mistakes)


def _write(job: _Job, found: Found, ratio: float, picture: str | None) -> tuple[list[Path], str]:
    """The files written, and what went wrong with the first that could not be."""
    from beltsim.cli.event_dataset import dataset  # loads xarray
    from beltsim.io import save_dataset

    written: list[Path] = []
    try:
        job.stem.parent.mkdir(parents=True, exist_ok=True)
        data = dataset(job.problem, found, job.Q_cr)
        inputs = {"drive": job.source.text, "suffix": job.source.suffix}
        data.attrs["firing_frequency"] = job.survey.Omega
        data.attrs["firing_frequency_long_name"] = (
            "Omega as commands print it: firing order times crank speed"
        )
        data.attrs["crank_speed_rpm"] = job.survey.rpm
        data.attrs["inputs"] = json.dumps({**inputs, "arguments": job.arguments})
        written.append(save_dataset(data, job.stem.with_name(f"{job.stem.name}-events.nc")))
        orbits = [orbit for _, orbit in found if isinstance(orbit, Response)]
        if picture is not None and orbits:
            from beltsim import plots  # loads matplotlib

            name = f"{job.source.drive.name}\n" if job.source.drive.name else ""
            title = f"{name}Phases of the arm at {job.survey.rpm:.0f} rpm"
            figure = plots.event_phases(orbits, job.Q_cr / ratio, title)
            path = job.stem.with_name(f"{job.stem.name}-events.{picture}")
            written.append(plots.save_figure(figure, path))
    except (OSError, ResultFileError) as error:
        return written, str(error)
    return written, ""
