"""`beltsim modes`: what a drive is like at one speed, without integrating.

Depends on: cli.source, cli.operation, cli.mistakes, cli.steady, cli.text.
"""

from __future__ import annotations

import argparse

from beltsim.cli.mistakes import Mistakes
from beltsim.cli.operation import examined, friction_given, merged
from beltsim.cli.source import read_source
from beltsim.cli.steady import (
    frequency_lines,
    meeting_lines,
    operating_lines,
    pulley_lines,
    rest_lines,
    span_lines,
    warning_lines,
)
from beltsim.cli.text import say


def run(options: argparse.Namespace) -> int:
    """Print the survey of the drive; the exit status."""
    source = read_source(options.file)
    arguments = merged(options, source.arguments)
    mistakes, law = Mistakes(), None
    with mistakes.gathered():
        law = friction_given(source, arguments)
    with mistakes.gathered():
        problem, found = examined(source, arguments, law, options.count)
    mistakes.raise_any()
    say(source.drive.name or options.file, *operating_lines(found, problem), "")
    say("Steady state", *rest_lines(found), "", *span_lines(found), "", *pulley_lines(found), "")
    say("Natural frequencies (undamped)", *frequency_lines(found, options.count))
    say(*meeting_lines(found))
    say(*warning_lines(found.warnings))
    return 0
