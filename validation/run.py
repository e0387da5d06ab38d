"""`python -m validation.run`: run validation cases, compare, and say what agrees.

Exit status: 0 every case agrees or disagrees exactly as explained; 1 something disagrees without
explanation, an explanation no longer fits, or a case crashed; 2 an unknown case name or an
incomplete case file.

Depends on: case, compare, page, table, worker.
"""

from __future__ import annotations

import argparse
import difflib
import importlib.util
import json
import os
import sys
import threading
import time
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from validation import table, worker
from validation.case import Case, CaseError, find, load
from validation.compare import Result

ROOT = Path(__file__).resolve().parent
#: Seconds of silence after which progress is shown.
PATIENCE_S = 2.0


def main(argv: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """Run the cases named in `argv` (default: all quick ones) below `root`; the exit status."""
    options = _options(argv)
    folders = find(root)
    if options.readme and options.case:
        print("--readme writes the table of all cases: name none", file=sys.stderr)
        return 2
    chosen, unknown = _chosen(options.case, folders)
    if unknown:
        print("\n".join(unknown), file=sys.stderr)
        return 2
    unusable = _unusable(options)
    if unusable:
        print("\n".join(unusable), file=sys.stderr)
        return 2
    cases, mistakes = _loaded([folders[name] for name in chosen])
    if mistakes:
        print("\n".join(mistakes), file=sys.stderr)
        return 2
    if options.list:
        print(table.listing(cases))
        return 0
    cases = [case for case in cases if case.runtime == "quick" or _wanted(case, options)]
    if not cases:
        print("nothing to run: these cases take long, add --full", file=sys.stderr)
        return 2
    return _run(cases, options, root)


def _run(cases: Sequence[Case], options: argparse.Namespace, root: Path) -> int:
    """Run `cases`, print them, write what was asked for; the exit status."""
    start = time.perf_counter()
    results: list[Result] = []
    progress = _Progress(len(cases))
    _compile_kernels()
    count = min(options.workers, len(cases))
    try:
        for result in worker.run_all(cases, count, progress.tick):
            progress.done(result)
            results.append(result)
            print(table.terminal(result), flush=True)
            if options.stop_after and sum(not r.passed for r in results) >= options.stop_after:
                break
    except KeyboardInterrupt:
        progress.clear()
        print(f"interrupted after {len(results)} of {len(cases)} cases", file=sys.stderr)
        return 1
    seconds = time.perf_counter() - start
    print(table.summary(results, seconds))
    if options.json:
        data = table.as_data(results, seconds, _version())
        _replace(options.json, json.dumps(data, indent=1, allow_nan=False) + "\n")
    if options.html:
        from validation import page  # loads jinja2 and matplotlib

        _replace(options.html, page.html(results, seconds, _version()))
    missing = [result.case.name for result in results if result.verdict == "skipped"]
    if options.readme and missing:
        print(f"README.md stays as it was: skipped {', '.join(missing)}", file=sys.stderr)
        return 1
    if options.readme:
        readme = root / "README.md"
        text = readme.read_text(encoding="utf-8")
        _replace(readme, table.with_table(text, table.readme_table(results)))
    return 0 if results and all(result.passed for result in results) else 1


def _compile_kernels() -> None:
    """Before the clock of a case runs: in a new installation it takes half a minute."""
    from beltsim.harmonic_balance import compile_kernels

    def tell() -> None:
        print("compiling kernels, once in an installation ...", file=sys.stderr, flush=True)

    late = threading.Timer(PATIENCE_S, tell)
    late.start()
    try:
        compile_kernels()
    finally:
        late.cancel()


def _options(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m validation.run",
        description="Compare beltsim with closed forms, independent solvers and printed numbers.",
        epilog="Exit status: 0 agrees or explained; 1 disagrees or crashed; 2 bad input. "
        "`beltsim validate --drive FILE` compares the solvers on a drive of your own instead.",
    )
    parser.add_argument("case", nargs="*", help="family, family/case or case (default: all)")
    parser.add_argument("--full", action="store_true", help="also the cases that take long")
    parser.add_argument("--list", action="store_true", help="name the cases and stop")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the results as JSON")
    help_html = "write one page with a picture of every case"
    parser.add_argument("--html", type=Path, metavar="FILE", help=help_html)
    help_workers = "cases computed side by side (default: one per core)"
    parser.add_argument(
        "--workers", type=int, metavar="N", default=len(os.sched_getaffinity(0)), help=help_workers
    )
    help_stop = "stop after N cases that do not pass"
    parser.add_argument("--stop-after", type=int, metavar="N", help=help_stop)
    help_readme = "run everything and write the table of validation/README.md"
    parser.add_argument("--readme", action="store_true", help=help_readme)
    return parser.parse_args(argv)


def _unusable(options: argparse.Namespace) -> list[str]:
    """What is wrong with the options, before anything is computed."""
    found = [
        f"{name} {file}: its folder does not exist"
        for name, file in (("--json", options.json), ("--html", options.html))
        if file and not file.resolve().parent.is_dir()
    ]
    if options.workers < 1:
        found.append(f"--workers {options.workers}: must be at least 1")
    if options.stop_after is not None and options.stop_after < 1:
        found.append(f"--stop-after {options.stop_after}: must be at least 1")
    if options.html and importlib.util.find_spec("jinja2") is None:
        found.append("--html needs jinja2: pip install jinja2")
    return found


def _chosen(asked: Sequence[str], folders: dict[str, Path]) -> tuple[list[str], list[str]]:
    """Names of the cases asked for, in order, and a message for each unknown name."""
    if not asked:
        return list(folders), []
    known = {part for name in folders for part in (name, *name.split("/"))}
    unknown = []
    for name in asked:
        if name.rstrip("/") not in known:
            near = difflib.get_close_matches(name, sorted(known), n=3, cutoff=0.5)
            hint = f"; near: {', '.join(near)}" if near else "; --list names them all"
            unknown.append(f"unknown case {name!r}{hint}")
    wanted = {name.rstrip("/") for name in asked}
    return [n for n in folders if n in wanted or wanted & set(n.split("/"))], unknown


def _wanted(case: Case, options: argparse.Namespace) -> bool:
    """Whether a case that takes long was asked for: by a flag or by its own name."""
    by_name = {case.name, case.name.split("/")[1]} & set(options.case)
    return bool(options.full or options.readme or by_name)


def _loaded(folders: Sequence[Path]) -> tuple[list[Case], list[str]]:
    cases, mistakes = [], []
    for folder in folders:
        try:
            cases.append(load(folder))
        except CaseError as error:
            mistakes += str(error).splitlines()
    return cases, mistakes


def _replace(file: Path, text: str) -> None:
    """Write `file` completely or not at all."""
    draft = file.with_name(file.name + ".part")
    draft.write_text(text, encoding="utf-8")
    draft.replace(file)


def _version() -> str:
    try:
        return version("beltsim")
    except PackageNotFoundError:
        return "not installed"


class _Progress:
    """A line on standard error that says which case is being computed, once that takes long."""

    def __init__(self, total: int) -> None:
        self.total, self._done, self._width = total, 0, 0
        self._start = time.perf_counter()
        self._next = self._start + PATIENCE_S

    def tick(self, names: Sequence[str]) -> None:
        """Show what is computed, at most five times a second (ten seconds apart in a log)."""
        now = time.perf_counter()
        if now < self._next:
            return
        text = f"[{self._done + 1}/{self.total}] {', '.join(names)}, {now - self._start:.0f} s"
        if sys.stderr.isatty():
            print(f"\r{text:<{self._width}}", end="", file=sys.stderr, flush=True)
            self._width, self._next = len(text), now + 0.2
        else:
            print(text, file=sys.stderr, flush=True)
            self._next = now + 10.0

    def done(self, result: Result) -> None:
        """Count a case that has ended; show the traceback of one that crashed."""
        self._done += 1
        self.clear()
        if result.details:
            print(result.details, file=sys.stderr)

    def clear(self) -> None:
        """Take the line away, so that results can be printed."""
        if self._width:
            print("\r" + " " * self._width + "\r", end="", file=sys.stderr, flush=True)
        self._width = 0


if __name__ == "__main__":
    sys.exit(main())
