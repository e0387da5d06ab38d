"""The command `beltsim`: drive files in, tables, result files and pictures out.

Exit status: 0 done; 1 computed, but it failed or disagrees; 2 bad input (one line per mistake on
standard error, no traceback); 130 interrupted.

Only the verb that is asked for is loaded, so that `beltsim --help` costs next to nothing.

Depends on: anything; nothing depends on it.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence

from beltsim.cli.arguments import read
from beltsim.cli.text import complain
from beltsim.errors import (
    BeltsimError,
    InvalidDriveError,
    InvalidProblemError,
    ResultFileError,
    SteadyStateError,
)

DONE, FAILED, BAD_INPUT, INTERRUPTED, PIPE_CLOSED = 0, 1, 2, 130, 141
_INPUT_ERRORS = (InvalidDriveError, InvalidProblemError, ResultFileError, SteadyStateError)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv` (default: that of the process); the exit status.

    Examples
    --------
    >>> main(["modes", "no-such-file.toml"])
    2
    """
    words = list(sys.argv[1:] if argv is None else argv)
    # Matrices are small here: threads inside linear algebra only get in each other's way.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    _never_fail_on_a_letter()
    try:
        status = _dispatch(words)
        sys.stdout.flush()
    except BrokenPipeError:
        # the reader (head, less) has gone; Python would complain once more at its exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED
    except KeyboardInterrupt as stop:
        complain(str(stop) or "interrupted")
        return INTERRUPTED
    except _INPUT_ERRORS as error:
        complain(str(error))
        return BAD_INPUT
    except BeltsimError as error:
        complain(str(error))
        return FAILED
    return status


def _dispatch(words: list[str]) -> int:
    if words[:1] == ["validate"]:  # its options are those of the harness itself
        from beltsim.cli import validate

        return validate.run(words[1:])
    try:
        options = read(words)
    except SystemExit as stop:  # --help, --version, or a word that cannot be read
        return stop.code if isinstance(stop.code, int) else BAD_INPUT
    status: int = importlib.import_module(f"beltsim.cli.{options.verb}").run(options)
    return status


def _never_fail_on_a_letter() -> None:
    """Let a terminal that lacks a letter of a pulley's name show a question mark instead."""
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="replace")
