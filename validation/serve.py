"""The child process of `validation.worker`: computes cases on request.

Reads folders of cases from standard input, one JSON text per line, and answers each with one line:
the rows of its `compute()`, or its error. It imports nothing heavy before a case does.

Depends on: row.
"""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import sys
import traceback
from pathlib import Path
from types import ModuleType
from typing import Any, TextIO

from validation.row import Row


def rows_of(folder: Path) -> list[tuple[Any, ...]]:
    """Rows that `compute()` in `folder`/run.py returns, as plain lists, numbers and texts."""
    module = _imported(folder / "run.py")
    rows = (row if isinstance(row, Row) else Row(*row) for row in module.compute())
    return [tuple(map(_plain, vars(row).values())) for row in rows]


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def _imported(file: Path) -> ModuleType:
    name = "_".join(("validation_case", file.parent.parent.name, file.parent.name))
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise ImportError(f"{file} cannot be imported")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _serve(requests: TextIO, answers: TextIO) -> None:
    """Answer every request until the parent closes the pipe."""
    for line in requests:
        try:
            answer: dict[str, Any] = {"rows": rows_of(Path(json.loads(line)))}
            text = json.dumps(answer)
        except (Exception, SystemExit) as error:  # a case may do anything; the rest goes on
            reason = f"{type(error).__name__}: {error}".strip()
            text = json.dumps({"error": reason, "traceback": traceback.format_exc()})
        answers.write(text + "\n")
        answers.flush()


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # whatever a case prints must not mix with the answers
    _serve(sys.stdin, answers)
