"""`beltsim hb`: the periodic response of a drive by harmonic balance.

Depends on: harmonic_balance, study, io; the other modules of cli.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from beltsim.cli.arguments import OUT
from beltsim.cli.mistakes import Mistakes
from beltsim.cli.motion import loss_words, range_lines, reversal_words
from beltsim.cli.operation import examined, friction_given, merged, require_harmonics
from beltsim.cli.progress import patience
from beltsim.cli.source import Source, read_source
from beltsim.cli.steady import operating_lines, warning_lines
from beltsim.cli.text import complain, listed, say, table
from beltsim.cli.written import earlier, written_lines
from beltsim.errors import InvalidProblemError, Mistake, ResultFileError
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance import Pattern, Settings, reversals_of_series
from beltsim.io import load, require_writable, save
from beltsim.metrics import Survey
from beltsim.problem import FrictionProblem
from beltsim.response import Response
from beltsim.study import balance, pattern_of

#: Said when it takes long.
WAIT = (
    "solving ... (the first harmonic balance of an installation compiles its kernels, about half "
    "a minute; hundreds of harmonics take minutes)"
)
#: Harmonics listed at most; the result file has them all.
MOST_HARMONICS = 12
#: Harmonics less than this share of the largest are rounding.
ROUNDING = 1e-12


def run(options: argparse.Namespace) -> int:
    """Solve, write and print; the exit status."""
    source, arguments, problem, survey, settings = _prepared(options)
    with patience(WAIT):
        response = balance(problem, options.harmonics, settings)
    stem = Path(options.out or OUT) / Path(options.file).stem
    target, trouble = stem.with_name(f"{stem.name}-hb.nc"), ""
    inputs = {
        "drive": source.text,
        "suffix": source.suffix,
        "arguments": arguments,
        "settings": asdict(settings) | {"pattern": options.pattern},
    }
    before = earlier(stem.parent)
    try:
        stem.parent.mkdir(parents=True, exist_ok=True)
        save(response, target, inputs)
    except (OSError, ResultFileError) as error:
        trouble = str(error)
    say(source.drive.name or stem.name, *operating_lines(survey, problem), "")
    say(*_lines(response, survey.rpm))
    say(*warning_lines(tuple(dict.fromkeys((*survey.warnings, *response.warnings)))))
    say(*written_lines([] if trouble else [target], before))
    complain(trouble)
    return 1 if trouble else 0


def _lines(response: Response, rpm: float) -> list[str]:
    """Harmonics of the arm, and what the series says about its motion."""
    seen, series = response.statistics, response.coefficients
    joint = response.problem.joint
    assert joint is not None
    assert series is not None
    velocity = [1j * k * row[joint] for k, row in enumerate(series)]
    nu = f"(sign changes of the truncated series: {reversals_of_series(velocity):.3g})"
    pairs = [
        ("sticking", f"{100.0 * response.stick_fraction:.2f} % of the time"),
        ("friction loss", loss_words(response)),
        ("velocity reversals", f"{reversal_words(response)} {nu}"),
    ]
    if seen.get("error_estimate") is not None:
        pairs.append(
            ("error of the angle", f"about {_degrees(response, seen['error_estimate'])} rms")
        )
    return [
        *_method_lines(response),
        "",
        *_harmonic_lines(response, rpm),
        *range_lines(response),
        "",
        *listed(pairs),
    ]


def _method_lines(response: Response) -> list[str]:
    """How it was found; from which torque on these harmonics hold the arm, where they decide."""
    seen, head = response.statistics, f"Harmonic balance, R = {response.statistics['R']}"
    whence = "taken from the exact orbit" if "pattern_from" in seen else "given"
    if seen["method"] == "pattern":
        events = ", ".join(response.events.kind.tolist())
        return [f"{head}, with the pattern of events {whence}: {events}"]
    if "pattern_from" in seen:
        return [f"{head}, for an arm at rest, as the exact orbit has it"]
    law, scales = response.problem.friction, response.problem.scales
    if isinstance(law, SaturatedCoulomb) and scales is not None:
        speed = _degrees(response, law.sigma / scales.time_s)
        return [f"{head}, saturated law: full friction from {speed}/s (sigma = {law.sigma:g})"]
    return [
        f"{head}: the arm is locked from Q_m = {seen['Q_cr']:.4g} "
        f"(with these harmonics from {seen['Q_cr_R']:.4g})"
    ]


def _harmonic_lines(response: Response, rpm: float) -> list[str]:
    """Amplitudes of the arm's harmonics, each with its order per turn of the crank."""
    problem, series, torques = response.problem, response.coefficients, response.torque_coefficients
    joint, scales = problem.joint, problem.scales
    assert joint is not None
    assert scales is not None
    assert series is not None
    assert torques is not None
    order = problem.forcing.Omega / scales.time_s / (2.0 * np.pi * rpm / 60.0)
    sizes = np.abs(np.stack([series[1:, joint], torques[1:]]))
    seen = (sizes > ROUNDING * sizes.max(axis=1, keepdims=True)).any(axis=0)
    rows = [
        [
            str(k),
            f"{k * order:.4g}",
            _degrees(response, sizes[0, k - 1]),
            f"{sizes[1, k - 1] * scales.torque_N_m:.4g} N m",
        ]
        for k in (np.flatnonzero(seen) + 1).tolist()
    ]
    lines = table(("harmonic", "order", "arm angle", "friction"), rows[:MOST_HARMONICS])
    if len(rows) > MOST_HARMONICS:
        lines.append(f"  ... and {len(rows) - MOST_HARMONICS} more, in the result file")
    return lines


def _degrees(response: Response, angle: float) -> str:
    assert response.problem.scales is not None
    scale = response.problem.scales.coordinates[response.problem.joint or 0]
    return f"{np.degrees(angle * float(scale)):.4g} deg"


def _prepared(
    options: argparse.Namespace,
) -> tuple[Source, dict[str, Any], FrictionProblem, Survey, Settings]:
    """Everything that the solution needs, or every mistake in its input at once."""
    mistakes = Mistakes()
    source = read_source(options.file)
    arguments = merged(options, source.arguments)
    law: Coulomb | SaturatedCoulomb | None = None
    problem, found, pattern = None, None, None
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
        require_harmonics(options.harmonics)
    with mistakes.gathered():
        require_writable(Path(options.out or OUT))
    with mistakes.gathered():
        if problem is not None and options.pattern is not None:
            pattern = _pattern(options, problem)
    mistakes.raise_any()
    assert problem is not None
    assert found is not None
    if options.sigma is not None:
        Q_m = problem.friction.Q_m if problem.friction is not None else 0.0
        problem = problem.with_friction(SaturatedCoulomb(Q_m, options.sigma))
    settings = Settings(
        projection=options.projection,
        sigma_ladder=options.sigma is not None,
        pattern=pattern,
    )
    return source, arguments, problem, found, settings


def _pattern(options: argparse.Namespace, problem: FrictionProblem) -> Pattern:
    """Events of a stored run, at the same phases of the period of `problem`."""
    if options.sigma is not None:
        allowed = "left out with --sigma: the saturated law needs no pattern"
        raise InvalidProblemError(Mistake("--pattern", options.pattern, allowed))
    stored = load(options.pattern)
    found = pattern_of(stored)
    return replace(found, t=found.t * (problem.period / stored.problem.period))
