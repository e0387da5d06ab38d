"""`beltsim plot`: the layout of a drive file, or every picture of a result.

Depends on: io, drive; cli.source, cli.operation, cli.pictures, cli.mistakes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from beltsim.cli.arguments import OUT
from beltsim.cli.mistakes import Mistakes
from beltsim.cli.operation import rpm_of
from beltsim.cli.source import Source, read_source
from beltsim.cli.text import complain, say
from beltsim.cli.written import earlier
from beltsim.errors import ResultFileError
from beltsim.io import is_result_file, load, require_writable, stored_inputs
from beltsim.response import Response


def run(options: argparse.Namespace) -> int:
    """Draw and write; the exit status."""
    out = Path(options.out or OUT)
    mistakes = Mistakes()
    source: Source | None = None
    response: Response | None = None
    with mistakes.gathered():
        if is_result_file(options.file):
            response = load(options.file)
        if response is None or "drive" in stored_inputs(options.file):
            source = read_source(options.file)
    with mistakes.gathered():
        require_writable(out)
    mistakes.raise_any()
    from beltsim.cli.pictures import draw_layout, draw_motion  # loads matplotlib

    stem = out / Path(options.file).stem
    written, before = [], earlier(out)
    try:
        out.mkdir(parents=True, exist_ok=True)
        if response is not None and len(response.t) >= 2:
            rpm, name = (rpm_of(source), source.drive.name) if source else (None, "")
            written += draw_motion(response, stem, options.format, rpm, name)
        if source is not None:
            written += draw_layout(source.drive, stem, options.format)
    except (OSError, ResultFileError) as error:
        complain(str(error))
        return 1
    if response is not None and len(response.t) < 2:
        complain(
            f"{options.file} holds {len(response.events)} events but no samples of the motion "
            "(its run was stopped before the periods that are sampled, or kept none)"
        )
    if not written:
        raise ResultFileError(f"{options.file} holds nothing to draw: no samples and no drive")
    for path in written:
        say(f"wrote {path}{' (replaced an earlier one)' if path in before else ''}")
    return 0
