"""`python -m validation.mutations`: would the quick set notice an error?

Copies the source tree, puts one deliberate error of mutations.toml at a time into the copy, builds
it where it is in C, runs the quick cases there until three have failed, and lists them; last comes
the tree without any error, which must pass. Takes up to a few minutes per error. With names: only
those errors. `--write` notes the outcome in mutations.toml and in the table of docs/validation.md.

Exit status: 0 every error was caught; 1 one was not; 2 bad input.

Depends on: nothing of the package; cmake and ninja for errors in C.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DATA = Path(__file__).with_name("mutations.toml")
PAGE = ROOT / "docs" / "validation.md"
BEGIN, END = "<!-- mutations: begin -->\n", "<!-- mutations: end -->"
#: Failing cases after which an error counts as caught.
ENOUGH = 3
#: In the order in which they are run: what is quick and wide first.
FAMILIES = ("zhu_parker_2008", "analytic", "cross_method")
#: What a build and a run of the quick set need.
PARTS = ("beltsim", "csrc", "validation", "examples", "CMakeLists.txt", "pyproject.toml")


@dataclass(frozen=True)
class Mutation:
    """One deliberate error: `old` in `file` becomes `new`."""

    name: str
    what: str
    file: str
    old: str
    new: str
    caught_by: tuple[str, ...] = ()


def load(file: Path = DATA) -> list[Mutation]:
    """The errors of `file`, in order."""
    entries = tomllib.loads(file.read_text(encoding="utf-8"))["mutation"]
    return [
        Mutation(**{**entry, "caught_by": tuple(entry.get("caught_by", ()))}) for entry in entries
    ]


def mutated(mutation: Mutation, text: str) -> str:
    """The text of its file with the error in it.

    Raises
    ------
    ValueError
        When what it replaces does not stand there exactly once.
    """
    if text.count(mutation.old) != 1:
        count = text.count(mutation.old)
        raise ValueError(
            f"{mutation.name}: {mutation.old!r} stands in {mutation.file} {count} times"
        )
    return text.replace(mutation.old, mutation.new)


class Copy:
    """A copy of the source tree with a build and an interpreter of its own.

    The interpreter sees the libraries of the present one, but not the beltsim installed there.
    """

    def __init__(self, folder: Path) -> None:
        self.root, self.venv = folder / "tree", folder / "venv"
        self.build = folder / "build"
        self.root.mkdir()
        for part in PARTS:
            here, there = ROOT / part, self.root / part
            if here.is_dir():
                shutil.copytree(here, there, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy2(here, there)
        _run([sys.executable, "-m", "venv", "--without-pip", str(self.venv)])
        site = next((self.venv / "lib").glob("python*/site-packages"))
        libraries = sysconfig.get_paths()["purelib"]
        (site / "places.pth").write_text(f"{self.root}\n{libraries}\n", encoding="utf-8")
        tool = ["cmake", "-S", str(self.root), "-B", str(self.build), "-G", "Ninja"]
        _run([*tool, "-DCMAKE_BUILD_TYPE=Release", f"-DPython_EXECUTABLE={sys.executable}"])
        self.compile()

    def compile(self) -> None:
        """Build the extensions and put them where the package looks for them."""
        _run(["cmake", "--build", str(self.build)])
        for built in self.build.rglob("*.so"):
            shutil.copy2(built, self.root / "beltsim" / built.name)

    def failing(self) -> list[str]:
        """Names of quick cases that do not pass here; the search ends with the third."""
        found: list[str] = []
        for family in FAMILIES:
            if len(found) < ENOUGH:
                found += self._failing(family, ENOUGH - len(found))
        return found

    def _failing(self, family: str, enough: int) -> list[str]:
        results = self.build / "results.json"
        results.unlink(missing_ok=True)
        python = str(self.venv / "bin" / "python")
        command = [python, "-m", "validation.run", "--json", str(results)]
        command += ["--stop-after", str(enough), family]
        done = subprocess.run(
            command, cwd=self.root, env=_environment(), capture_output=True, text=True, check=False
        )
        if not results.is_file():
            raise RuntimeError(f"the cases could not be run:\n{done.stderr[-2000:]}")
        cases = json.loads(results.read_text(encoding="utf-8"))["cases"]
        # a time limit says nothing here: the machine may be busy, and a fresh copy compiles kernels
        return [
            case["name"]
            for case in cases
            if not case["passed"] and not case["failure"].startswith("stopped after")
        ]


def _environment() -> dict[str, str]:
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "SKBUILD"))}
    tools = str(Path(sys.executable).parent)
    return kept | {"PATH": os.pathsep.join((tools, kept.get("PATH", "")))}


def _run(command: Sequence[str]) -> None:
    done = subprocess.run(command, env=_environment(), capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}:\n{(done.stdout + done.stderr)[-2000:]}")


def tried(mutation: Mutation, copy: Copy) -> list[str]:
    """Cases that fail with the error in the copy; it is taken out again."""
    file = copy.root / mutation.file
    text = file.read_text(encoding="utf-8")
    try:
        file.write_text(mutated(mutation, text), encoding="utf-8")
        if mutation.file.startswith("csrc"):
            copy.compile()
        return copy.failing()
    finally:
        file.write_text(text, encoding="utf-8")
        if mutation.file.startswith("csrc"):
            copy.compile()


def table(mutations: Sequence[Mutation]) -> str:
    """Lines of the table in docs/validation.md."""
    lines = ["| error | where | caught by, for example |", "|---|---|---|"]
    for one in mutations:
        cases = ", ".join(f"`{case.partition('/')[2]}`" for case in one.caught_by)
        lines.append(f"| {one.what} | `{one.file}` | {cases} |")
    return "\n".join(lines) + "\n"


def _write(outcomes: dict[str, list[str]]) -> None:
    """Note the outcomes in mutations.toml, and the table in the page."""
    parts = DATA.read_text(encoding="utf-8").split("[[mutation]]\n")
    for i, (part, mutation) in enumerate(zip(parts[1:], load(), strict=True), start=1):
        if mutation.name in outcomes:
            body = part.partition("caught_by")[0].rstrip()
            names = "".join(f'    "{name}",\n' for name in outcomes[mutation.name])
            parts[i] = f"{body}\ncaught_by = [\n{names}]\n\n"
    DATA.write_text("[[mutation]]\n".join(parts).rstrip() + "\n", encoding="utf-8")
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    PAGE.write_text(f"{before}{BEGIN}{table(load())}{END}{after}", encoding="utf-8")


def main(argv: Sequence[str] | None = None) -> int:
    """Try the errors; the exit status."""
    parser = argparse.ArgumentParser(prog="python -m validation.mutations", description=__doc__)
    parser.add_argument("name", nargs="*", help="errors to try (default: all)")
    parser.add_argument("--write", action="store_true", help="note the outcome in the files")
    options = parser.parse_args(argv)
    chosen = [one for one in load() if not options.name or one.name in options.name]
    if not chosen:
        names = ", ".join(one.name for one in load())
        print(f"no error is called {', '.join(options.name)}; there are: {names}", file=sys.stderr)
        return 2
    outcomes: dict[str, list[str]] = {}
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder))
        for one in chosen:
            outcomes[one.name] = tried(one, copy)
            caught = ", ".join(outcomes[one.name]) or "NOT CAUGHT"
            print(f"{one.name}: {caught}", flush=True)
            if options.write:
                _write(outcomes)
        failing = copy.failing()
    if failing:
        print(f"without any error already failing: {', '.join(failing)}", file=sys.stderr)
        return 2
    return 0 if all(outcomes.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
