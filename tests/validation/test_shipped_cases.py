"""The cases that are shipped: complete, sourced elsewhere, and listed in README.md."""

from __future__ import annotations

import ast
import csv

import pytest

from validation import table
from validation.case import find, load
from validation.run import ROOT
from validation.worker import Worker

FOLDERS = find(ROOT)
#: Cases that take a small part of a second each.
FAST = [
    "analytic/den_hartog",
    "analytic/free_decay",
    "analytic/free_decay_damped",
    "zhu_parker_2008/belt_speed",
    "zhu_parker_2008/crank_speed",
    "zhu_parker_2008/deflection_at_arm",
    "zhu_parker_2008/largest_locking_torque",
]
FAMILIES = {"analytic", "cross_method", "zhu_parker_2008"}


def readme() -> str:
    return (ROOT / "README.md").read_text(encoding="utf-8")


def imports(file) -> set[str]:
    """Modules that a file imports, anywhere in it."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def reachable(file) -> set[str]:
    """Modules imported by a file or by the modules of `validation` that it imports."""
    found, waiting = set(), [file]
    while waiting:
        for name in imports(waiting.pop()) - found:
            found.add(name)
            module = ROOT.parent / (name.replace(".", "/") + ".py")
            if name.startswith("validation.") and module.is_file():
                waiting.append(module)
    return found


def test_every_family_has_cases():
    assert {name.split("/")[0] for name in FOLDERS} == FAMILIES


def test_no_folder_with_a_run_is_without_its_case():
    runs = {file.parent for file in ROOT.glob("*/*/run.py")}
    assert runs == set(FOLDERS.values())


@pytest.mark.parametrize("name", FOLDERS)
def test_case_is_complete(name):
    case = load(FOLDERS[name])
    assert case.tolerance_reason
    assert case.source
    functions = [
        node.name
        for node in ast.parse((case.folder / "run.py").read_text()).body
        if isinstance(node, ast.FunctionDef)
    ]
    assert functions[0] == "compute"


@pytest.mark.parametrize("file", sorted(ROOT.glob("*/*/reference.py")), ids=lambda f: f.parent.name)
def test_reference_shares_no_code_with_beltsim(file):
    assert not [name for name in reachable(file) if name.split(".")[0] == "beltsim"]


@pytest.mark.parametrize(
    "file", sorted(ROOT.glob("*/*/reference.csv")), ids=lambda f: f.parent.name
)
def test_printed_numbers_are_numbers(file):
    with file.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    assert rows
    assert all(float(row["expected"]) == float(row["expected"]) for row in rows)


def test_readme_lists_every_case_in_order():
    listed = list(dict.fromkeys(name for name, _, _ in table.readme_rows(readme())))
    assert listed == list(FOLDERS)


def test_readme_shows_passing_rows_only_and_every_explained_one():
    rows = table.readme_rows(readme())
    assert {verdict for _, _, verdict in rows} <= {"agrees", "disagrees-explained"}
    explained = {(name, quantity) for name, quantity, v in rows if v == "disagrees-explained"}
    recorded = {
        (name, entry.quantity) for name in FOLDERS for entry in load(FOLDERS[name]).explained
    }
    assert explained == recorded


def test_readme_gives_every_source_and_explanation():
    text = readme()
    for folder in FOLDERS.values():
        case = load(folder)
        assert f"| `{case.name}` | {case.source} |" in text
        assert case.explanation in text


def test_fast_cases_pass_and_stand_in_readme_as_they_come_out():
    with Worker() as worker:
        results = [worker.run(load(FOLDERS[name])) for name in FAST]
    assert [(r.case.name, r.failure, r.flags) for r in results if not r.passed] == []
    ours = table.readme_rows(table.readme_table(results))
    theirs = [row for row in table.readme_rows(readme()) if row[0] in FAST]
    assert ours == theirs
