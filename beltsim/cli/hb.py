"""`beltsim hb`: the periodic response of a drive by harmonic balance.

Depends on: harmonic_balance, io; the other modules of cli.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from beltsim.cli.arguments import OUT
from beltsim.cli.mistakes import Mistakes
from beltsim.cli.motion import loss_words, range_lines, reversal_words
from beltsim.cli.operation import examined, friction_given, merged
from beltsim.cli.source import Source, read_source
from beltsim.cli.steady import operating_lines, warning_lines
from beltsim.cli.text import complain, listed, say, table
from beltsim.cli.written import earlier, written_lines
from beltsim.errors import InvalidProblemError, ResultFileError
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance import Settings, reversals_of_series, solve
from beltsim.io import require_writable, save
from beltsim.metrics import Survey
from beltsim.problem import FrictionProblem
from beltsim.response import Response

#: Harmonics listed at most; the result file has them all.
MOST_HARMONICS = 12


def run(options: argparse.Namespace) -> int:
    """Solve, write and print; the exit status."""
    source, arguments, problem, survey, settings = _prepared(options)
    response = solve(problem, options.harmonics, settings)
    stem = Path(options.out or OUT) / Path(options.file).stem
    target, trouble = stem.with_name(f"{stem.name}-hb.nc"), ""
    inputs = {
        "drive": source.text,
        "suffix": source.suffix,
        "arguments": arguments,
        "settings": asdict(settings),
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
        f"Harmonic balance, R = {seen['R']}: the arm is locked from Q_m = {seen['Q_cr']:.4g} "
        f"(with these harmonics from {seen['Q_cr_R']:.4g})",
        "",
        *_harmonic_lines(response, rpm),
        *range_lines(response),
        "",
        *listed(pairs),
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
    rows = [
        [
            str(k),
            f"{k * order:.4g}",
            _degrees(response, abs(series[k, joint])),
            f"{abs(torques[k]) * scales.torque_N_m:.4g} N m",
        ]
        for k in range(1, len(series))
        if abs(series[k, joint]) > 0.0 or abs(torques[k]) > 0.0
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
    problem, found = None, None
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
        require_writable(Path(options.out or OUT))
    mistakes.raise_any()
    assert problem is not None
    assert found is not None
    if options.sigma is not None:
        Q_m = problem.friction.Q_m if problem.friction is not None else 0.0
        problem = problem.with_friction(SaturatedCoulomb(Q_m, options.sigma))
    return source, arguments, problem, found, Settings(sigma_ladder=options.sigma is not None)
