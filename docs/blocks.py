"""Runs the code blocks of the documentation and compares what they print with what the page says.

Conventions of a page:

* `python` blocks run in order, in one namespace per page. A `text` block that follows one is its
  output.
* `console` blocks hold commands after `$ ` and their output below. `$ echo $?` asks for the exit
  status of the command before. They run in a scratch folder that contains `examples`.
* `sh` blocks show commands that set up the machine (`./run ...`); they are not run from here.
* In an output a line `...` stands for any lines and `...` within a line for any text. Numbers must
  agree to one and a half units of the last digit shown; blanks count as one.

`python docs/blocks.py` checks every page; with `--update` it writes what was printed into the
pages. Review the difference: an output that moved wants a reason.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])|(?<=\w)\d+", re.IGNORECASE)
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMAND_TIME_LIMIT_S = 120


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, and where the text stands in the page."""

    language: str
    text: str
    start: int
    end: int
    line: int


@dataclass(frozen=True)
class Outcome:
    """What a block printed, what the page says it prints, and where that stands in the page."""

    line: int
    expected: str
    printed: str
    start: int
    end: int


def pages() -> list[Path]:
    """Every page of the documentation, README first."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks_of(text: str) -> list[Block]:
    """Fenced blocks of a page, in order."""
    return [
        Block(m[1], m[2], m.start(2), m.end(2), text.count("\n", 0, m.start(2)) + 1)
        for m in FENCE.finditer(text)
    ]


def run_page(page: Path, folder: Path) -> Iterator[Outcome]:
    """Run all blocks of `page` with `folder` as the working directory."""
    if not (folder / "examples").exists():
        (folder / "examples").symlink_to(ROOT / "examples")
    text = page.read_text()
    found = blocks_of(text)
    namespace: dict[str, object] = {"__name__": page.stem}
    for block, following in zip_longest(found, found[1:]):
        if block.language == "python":
            printed = _run_python(block, page, namespace, folder)
            follows = following is not None and following.language == "text"
            between = text[block.end : following.start] if follows and following else ""
            if following and follows and not re.sub(r"```\w*|\s", "", between):
                yield Outcome(block.line, following.text, printed, following.start, following.end)
            else:
                yield Outcome(block.line, "", printed, -1, -1)
        elif block.language == "console":
            yield from _run_console(block, folder)


def _run_python(block: Block, page: Path, namespace: dict[str, object], folder: Path) -> str:
    code = compile("\n" * (block.line - 1) + block.text, str(page), "exec")
    out = io.StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(out):
        exec(code, namespace)
    return out.getvalue()


def _run_console(block: Block, folder: Path) -> Iterator[Outcome]:
    status = 0
    position = block.start
    for part in re.split(r"^(?=\$ )", block.text, flags=re.MULTILINE):
        command, _, expected = part.partition("\n")
        start = position + len(command) + 1
        position += len(part)
        if not command:
            continue
        if not command.startswith("$ "):
            raise ValueError(f"line {block.line}: a console block starts with a command: {part!r}")
        line = block.line + block.text[: start - block.start].count("\n") - 1
        if command == "$ echo $?":
            printed = f"{status}\n"
        else:
            done = _run_command(command[2:], folder)
            status, printed = done.returncode, done.stdout
        yield Outcome(line, expected, printed, start, position)


def _run_command(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    words = shlex.split(command)
    if words[0] not in ("beltsim", "python", "cat"):
        raise ValueError(f"pages may run beltsim, python and cat, not {command!r}")
    if words[0] == "beltsim":
        words[:1] = [sys.executable, "-m", "beltsim"]
    elif words[0] == "python":
        words[0] = sys.executable
    return subprocess.run(
        words,
        cwd=folder,
        env={**os.environ, "COLUMNS": "100", "MPLBACKEND": "Agg"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=COMMAND_TIME_LIMIT_S,
        check=False,
    )


def agrees(expected: str, printed: str) -> bool:
    """Whether an output is what the page shows, by the rules at the top of this file."""
    wanted, got = expected.strip().splitlines(), printed.strip().splitlines()
    return _lines_agree([w.rstrip() for w in wanted], [g.rstrip() for g in got])


def _lines_agree(wanted: list[str], got: list[str]) -> bool:
    for i, line in enumerate(wanted):
        if line.strip() == "...":
            rest = wanted[i + 1 :]
            return any(_lines_agree(rest, got[j:]) for j in range(i, len(got) + 1))
        if i >= len(got) or not _line_agrees(line, got[i]):
            return False
    return len(wanted) == len(got)


def _line_agrees(wanted: str, got: str) -> bool:
    numbers: list[str] = []
    pattern = ""
    for piece in re.split(rf"({NUMBER.pattern}|\.\.\.|\s+)", wanted.strip(), flags=re.IGNORECASE):
        if piece == "...":
            pattern += ".*?"
        elif piece.isspace():
            pattern += r"\s+"
        elif NUMBER.fullmatch(piece):
            numbers.append(piece)
            pattern += r"([-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)"
        else:
            pattern += re.escape(piece)
    match = re.fullmatch(pattern, got.strip())
    return match is not None and all(map(_number_agrees, numbers, match.groups()))


def _number_agrees(wanted: str, got: str) -> bool:
    mantissa, _, exponent = wanted.lower().partition("e")
    last_digit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    if "." not in mantissa and not exponent:
        return int(wanted) == float(got)
    return abs(float(wanted) - float(got)) <= 1.5 * last_digit


def update(page: Path, outcomes: list[Outcome]) -> None:
    """Write the printed outputs of `outcomes` into `page`, last one first."""
    text = page.read_text()
    for seen in reversed(outcomes):
        text = text[: seen.start] + seen.printed.rstrip() + "\n" + text[seen.end :]
    page.write_text(text)


def main() -> int:
    """Check every page, or the pages named; `--update` rewrites outputs that do not agree."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    sys.path.insert(0, str(ROOT))  # for blocks that import `validation`
    parser.add_argument("page", nargs="*", type=Path)
    parser.add_argument("--update", action="store_true", help="write the outputs into the pages")
    options = parser.parse_args()
    wrong = 0
    for page in [path.resolve() for path in options.page] or pages():
        with tempfile.TemporaryDirectory() as folder:
            moved = [o for o in run_page(page, Path(folder)) if not agrees(o.expected, o.printed)]
        for seen in moved:
            where = f"{page.relative_to(ROOT)}:{seen.line}"
            sys.stdout.write(f"{where} prints\n{seen.printed}and not\n{seen.expected}\n")
        wrong += len(moved)
        if options.update:
            update(page, [seen for seen in moved if seen.start >= 0])
    return 1 if wrong and not options.update else 0


if __name__ == "__main__":
    sys.exit(main())
