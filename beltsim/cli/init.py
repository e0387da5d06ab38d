"""`beltsim init`: a commented drive file to start from.

Depends on: drive, errors, io; cli.text.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from beltsim.cli.text import say
from beltsim.drive import template
from beltsim.errors import ResultFileError
from beltsim.io import whole_file


def run(options: argparse.Namespace) -> int:
    """Write the template; the exit status.

    Raises
    ------
    ResultFileError
        When the file is there already and may not be replaced, or cannot be written.
    """
    if options.path == "-":
        sys.stdout.write(template())
        return 0
    path = Path(options.path)
    if path.is_dir():
        raise ResultFileError(f"{path} is a folder; name the file to write in it")
    if path.exists() and not options.force:
        raise ResultFileError(f"{path} exists; name another file, or replace it with --force")
    with whole_file(path) as temporary:
        temporary.write_text(template(), encoding="utf-8")
    say(f"wrote {path}; check it with: beltsim modes {path}")
    return 0
