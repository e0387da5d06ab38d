"""`beltsim validate`: the validation harness of the source tree, or the solvers on one drive.

Depends on: errors; cli.cross_check; `validation.run` of the repository, which is no part of the
package.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from pathlib import Path

from beltsim.cli.text import complain
from beltsim.errors import ResultFileError

#: How files of drives and of results end; names of cases do not.
DRIVE_SUFFIXES = (".toml", ".nc")


def run(words: Sequence[str]) -> int:
    """Run the harness, or with ``--drive`` the cross-check; the exit status.

    Raises
    ------
    ResultFileError
        When there is no source tree to run it from.
    """
    if any(word == "--drive" or word.startswith("--drive=") for word in words):
        from beltsim.cli import cross_check  # the solvers: only when asked for

        return cross_check.run(words)
    for word in words:
        if Path(word).suffix in DRIVE_SUFFIXES:
            complain(f"{word} is no case; for a drive of your own: beltsim validate --drive {word}")
            return 2
    root = _source_tree()
    if str(root) not in sys.path:
        sys.path.insert(0, str(root))
    try:
        status: int = importlib.import_module("validation.run").main(list(words))
    except SystemExit as stop:  # its own --help, or a word it cannot read
        return stop.code if isinstance(stop.code, int) else 2
    return status


def _source_tree() -> Path:
    """The checkout that this package is run from, or the one around the working folder."""
    here = Path(__file__).resolve().parents[2]
    for place in (here, Path.cwd(), *Path.cwd().parents):
        if (place / "validation" / "run.py").is_file() and _is_ours(place / "pyproject.toml"):
            return place
    raise ResultFileError(
        "the validation cases are part of the source tree, not of the installed package; "
        "run this in a clone of the repository"
    )


def _is_ours(project: Path) -> bool:
    return project.is_file() and 'name = "beltsim"' in project.read_text(encoding="utf-8")
