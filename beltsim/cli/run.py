"""`beltsim run`: integrate a drive, print what an engineer wants first, write result and pictures.

Everything that can be wrong with the input is looked at before the first step is taken.

Depends on: transient, io; the other modules of cli.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

from beltsim.cli.arguments import OUT
from beltsim.cli.exactness import exactness_lines
from beltsim.cli.mistakes import Mistakes
from beltsim.cli.motion import event_lines, figure_lines, range_lines
from beltsim.cli.operation import examined, friction_given, given, merged, require_periods
from beltsim.cli.progress import progress
from beltsim.cli.repeat import repeat_lines
from beltsim.cli.source import Source, read_source
from beltsim.cli.steady import frequency_lines, operating_lines, span_lines, warning_lines
from beltsim.cli.text import complain, say
from beltsim.cli.written import earlier, written_lines
from beltsim.errors import CoreError, ResultFileError
from beltsim.io import load, require_writable, save
from beltsim.metrics import Survey
from beltsim.problem import FrictionProblem
from beltsim.response import Response
from beltsim.transient import Settings, integrate

#: Frequencies printed before a run; `beltsim modes` lists more.
FREQUENCIES = 6
#: Periods sampled at the end, for the pictures.
DRAWN_PERIODS = 2.0


class _Job(NamedTuple):
    """A run with everything that it needs, checked."""

    source: Source
    arguments: dict[str, Any]
    problem: FrictionProblem
    survey: Survey
    settings: Settings
    periods: float
    stem: Path


def run(options: argparse.Namespace) -> int:
    """Integrate, write and print; the exit status."""
    job = _prepared(options)
    start = _start_lines(job)
    if sys.stdout.isatty():
        say(*start)
        sys.stdout.flush()
        start = []
    try:
        with progress("integrating") as tell:
            response = integrate(job.problem, job.periods, None, job.settings, progress=tell)
    except CoreError as error:
        return _gave_up(job, 1, str(error), error.partial)
    except KeyboardInterrupt as stop:
        return _gave_up(job, 130, "interrupted", getattr(stop, "partial", None))
    before = earlier(job.stem.parent)
    # files first: a reader that goes away while we print (head) must not cost the result
    written, trouble = _write(job, response, None if options.no_plot else options.format)
    say(*start, *event_lines(response, job.survey.rpm), *range_lines(response))
    say(*figure_lines(response, job.survey, job.periods))
    say(*exactness_lines(response))
    if job.source.is_result and not given(options):
        say(*repeat_lines(response, load(options.file)))
    say(*warning_lines(tuple(dict.fromkeys((*job.survey.warnings, *response.warnings)))))
    say(*written_lines(written, before))
    complain(trouble)
    return 1 if trouble else 0


def _prepared(options: argparse.Namespace) -> _Job:
    """The job, or every mistake in its input at once."""
    out, mistakes = Path(options.out or OUT), Mistakes()
    stem = out / Path(options.file).stem
    source = settings = law = problem = found = None
    with mistakes.gathered():
        source = read_source(options.file)
    arguments = merged(options, source.arguments if source else {})
    periods = require_periods(arguments, mistakes)
    with mistakes.gathered():
        settings = _settings(arguments)
    if source is not None:
        with mistakes.gathered():
            law = friction_given(source, arguments)
        with mistakes.gathered():
            problem, found = examined(source, arguments, law)
    with mistakes.gathered():
        require_writable(out)
        if source is not None:
            _require_other(_result(stem), options.file)
    mistakes.raise_any()
    assert source is not None
    assert settings is not None
    assert problem is not None
    assert found is not None
    return _Job(source, arguments, problem, found, settings, periods, stem)


def _settings(arguments: dict[str, Any]) -> Settings:
    return Settings(
        rtol=arguments.get("rtol", 1e-8),
        method=arguments.get("method", "auto"),
        samples_per_period=arguments.get("samples", 500),
        kept_periods=DRAWN_PERIODS,
        max_seconds=arguments.get("max_seconds", math.inf),
    )


def _result(stem: Path) -> Path:
    return stem.with_name(f"{stem.name}.nc")


def _require_other(target: Path, file: str) -> None:
    """A result that is run again must not be replaced by its repetition."""
    if target.exists() and target.samefile(file):
        text = f"{target} would be replaced by its own repetition; choose another folder with --out"
        raise ResultFileError(text)


def _start_lines(job: _Job) -> list[str]:
    return [
        job.source.drive.name or job.stem.name,
        *operating_lines(job.survey, job.problem),
        "",
        *span_lines(job.survey),
        "",
        *frequency_lines(job.survey, FREQUENCIES),
    ]


def _inputs(job: _Job) -> dict[str, Any]:
    """What a result file stores, so that the run can be repeated from it alone."""
    return {
        "drive": job.source.text,
        "suffix": job.source.suffix,
        "arguments": job.arguments,
        "settings": asdict(job.settings),
    }


def _write(job: _Job, response: Response, picture: str | None) -> tuple[list[Path], str]:
    """The files written, and what went wrong with the first that could not be."""
    written: list[Path] = []
    try:
        job.stem.parent.mkdir(parents=True, exist_ok=True)
        written.append(save(response, _result(job.stem), _inputs(job)))
        if picture is not None:
            from beltsim.cli.pictures import draw_layout, draw_motion  # loads matplotlib

            drive = job.source.drive
            written += draw_motion(response, job.stem, picture, job.survey.rpm, drive.name)
            written += draw_layout(drive, job.stem, picture)
    except (OSError, ResultFileError) as error:
        return written, str(error)
    return written, ""


def _gave_up(job: _Job, status: int, reason: str, partial: Response | None) -> int:
    """Keep what was computed of a run that did not reach its end; the exit status."""
    complain(reason)
    if partial is not None:
        done = partial.window[1] / job.problem.period
        name = job.stem.with_name(f"{job.stem.name}-partial")
        written, trouble = _write(job._replace(stem=name), partial, None)
        held = ""
        if len(partial.t) == 0:
            held = ": events and the state reached; no samples of so short a run, so no pictures"
        complain(trouble or f"{done:.6g} of {job.periods:g} periods are in {written[0]}{held}")
    return status
