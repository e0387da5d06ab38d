"""`beltsim validate --drive FILE`: the solvers against each other on one drive.

Depends on: cross_check; the other modules of cli.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import numpy as np

from beltsim.cli.arguments import cross_check_parser
from beltsim.cli.mistakes import Mistakes
from beltsim.cli.operation import examined, friction_given, merged
from beltsim.cli.source import read_source
from beltsim.cli.steady import operating_lines, warning_lines
from beltsim.cli.text import listed, say, table
from beltsim.cross_check import Check, Difference, check, require_tolerance
from beltsim.errors import InvalidProblemError
from beltsim.metrics import Survey
from beltsim.problem import FrictionProblem

#: Rows whose difference is not relative.
REMARKS = {
    "stick fraction": " (difference)",
    "velocity reversals": " (difference)",
    "event times": " (difference in forcing periods)",
}


def run(words: Sequence[str]) -> int:
    """Solve, compare and print; the exit status: 1 when the solvers do not agree."""
    try:
        options = cross_check_parser().parse_args(words)
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else 2
    mistakes = Mistakes()
    source = read_source(options.file)
    arguments = merged(options, source.arguments)
    law, prepared = None, None
    with mistakes.gathered():
        law = friction_given(source, arguments)
    with mistakes.gathered():
        prepared = examined(source, arguments, law)
    with mistakes.gathered():
        require_tolerance(options.tolerance)
    with mistakes.gathered():
        if prepared is not None and prepared[0].joint is None:
            message = f"{options.file}: this drive has no tensioner, so there is no friction"
            raise InvalidProblemError(f"{message} for the solvers to differ in")
    mistakes.raise_any()
    assert prepared is not None
    found = check(prepared[0], options.tolerance, _progress)
    _print(source.drive.name or options.file, *prepared, found)
    return 0 if found.agrees else 1


def _progress(name: str) -> None:
    if sys.stderr.isatty():
        sys.stderr.write(f"{name} ...\n")


def _print(title: str, problem: FrictionProblem, survey: Survey, found: Check) -> None:
    say(title, *operating_lines(survey, problem), "")
    say("Solvers", *listed((one.name, _how(one)) for one in found.candidates))
    reference = found.reference
    if reference is not None and found.differences:
        others = list(dict.fromkeys(gap.candidate for gap in found.differences))
        titles = (f"relative difference from the {reference.name}", reference.name, *others)
        say("", *table(titles, _rows(found, others)))
    fields = ("torque", "direction", "sliding", "equation", "period", "energy")
    rows = [
        [name, *(f"{getattr(one, name):.1e}" for one in found.residuals.values())]
        for name in fields
    ]
    if rows:
        # nothing is judged more closely than the looser of the two can be
        admitted = [
            (one.name, f"{one.accuracy:.1e}, {one.reason}")
            for one in found.candidates
            if one.motion is not None
        ]
        say("", "Relative error that each admits", *listed(admitted))
        say("", *table(("residual on a fine grid", *found.residuals), rows))
    said = (*survey.warnings, *problem.warnings, *found.warnings)
    say(*warning_lines(tuple(dict.fromkeys(said))))
    compared = len([gap for gap in found.differences if gap.judged])
    text = f"{len(found.residuals)} solvers agree in {compared} comparisons"
    say("", *(f"DISAGREE  {fault}" for fault in found.faults), *([text] if found.agrees else []))


def _how(one: object) -> str:
    seconds, note = getattr(one, "seconds", 0.0), getattr(one, "note", "")
    return f"{note} ({seconds:.1f} s)" if getattr(one, "motion", None) else f"no result: {note}"


def _rows(found: Check, others: Sequence[str]) -> list[list[str]]:
    """A line for each quantity; of the sines of a span the one that differs most."""
    lines: dict[str, dict[str, Difference]] = {}
    for gap in found.differences:
        name = gap.quantity
        if name.startswith("rms of span"):
            name = f"{name.partition('.')[0]}, worst sine"
        line = lines.setdefault(name, {})
        kept = line.get(gap.candidate)
        if kept is None or _excess(gap) > _excess(kept):
            line[gap.candidate] = gap
    rows = []
    for name, line in lines.items():
        first = next(iter(line.values()))
        label = name + REMARKS.get(name, "")
        rows.append([label, _value(name, first), *(_cell(line[other]) for other in others)])
    return rows


def _excess(gap: Difference) -> float:
    return gap.error / gap.tolerance if gap.judged else 0.0


def _value(name: str, gap: Difference) -> str:
    if "worst" in name:
        return ""
    if name == "event times":
        return f"{gap.reference:.0f} events"
    if gap.unit == "rad":
        return f"{np.degrees(gap.reference * gap.scale):.6g} deg"
    unit = "" if gap.unit in ("", "1") else f" {gap.unit}"
    return f"{gap.reference * gap.scale:.6g}{unit}"


def _cell(gap: Difference) -> str:
    mark = " !" if not gap.agrees else "" if gap.judged else " (not judged)"
    return f"{gap.error:.1e}{mark}" if gap.error < float("inf") else f"{gap.note}{mark}"
