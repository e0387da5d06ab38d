"""Who may import whom: the table of docs/architecture.md, enforced.

Every import counts, inside functions too; only blocks under `if TYPE_CHECKING` do not.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent / "beltsim"
SOLVER = {"problem", "forcing", "friction", "response"}
ANYTHING = "anything but cli"

#: What each package may import from beltsim, besides errors, checks and itself.
ALLOWED = {
    "errors": set(),
    "checks": set(),
    "drive": set(),
    "forcing": set(),
    "friction": set(),
    "problem": {"forcing", "friction"},
    "response": {"dataset"},  # Response.to_xarray alone
    "dataset": set(),
    "model": {"drive", "problem", "forcing", "friction"},
    "linear": SOLVER,
    "transient": SOLVER,
    "event_map": SOLVER,
    "harmonic_balance": SOLVER,
    "metrics": {"model", "problem", "response", "drive", "linear"},
    "io": ANYTHING,
    "plots": ANYTHING,
    "study": ANYTHING,
    "cross_check": ANYTHING,
    "report": ANYTHING,
    "cli": ANYTHING,
    "__main__": {"cli"},
}
EVERYBODY = {"errors", "checks"}
EXTENSIONS = ("_core", "_event_map")
LEAVES = {name for name, allowed in ALLOWED.items() if allowed == ANYTHING}
#: Third parties that only some packages may load.
KEPT_APART = {
    "matplotlib": LEAVES,
    "tqdm": LEAVES,
    "xarray": LEAVES | {"dataset"},
    "h5netcdf": LEAVES | {"dataset"},
    "pydantic": {"drive"} | LEAVES,
    "numba": {"harmonic_balance"},
    "scipy": set(ALLOWED) - {"errors", "checks", "drive", "forcing", "friction", "problem"},
}


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for path in sorted(ROOT.rglob("*.py"))}


class Imports(ast.NodeVisitor):
    """Absolute names that a module imports, wherever it does so; `early`: at its own loading."""

    def __init__(self, module: str, is_package: bool) -> None:
        self.package = module if is_package else module.rpartition(".")[0]
        self.found: set[str] = set()
        self.early: set[str] = set()
        self.depth = 0

    def add(self, name: str) -> None:
        self.found.add(name)
        if not self.depth:
            self.early.add(name)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self.depth += 1
        self.generic_visit(node)
        self.depth -= 1

    def visit_If(self, node: ast.If) -> None:
        if ast.unparse(node.test) in ("TYPE_CHECKING", "typing.TYPE_CHECKING"):
            for other in node.orelse:
                self.visit(other)
        else:
            self.generic_visit(node)

    def visit_Import(self, node: ast.Import) -> None:
        for alias in node.names:
            if alias.name != "beltsim":  # the attributes used count then
                self.add(alias.name)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if isinstance(node.value, ast.Name) and node.value.id == "beltsim":
            self.add(f"beltsim.{node.attr}")
        self.generic_visit(node)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        base = node.module or ""
        if node.level:
            parents = self.package.split(".")
            parents = parents[: len(parents) - node.level + 1]
            base = ".".join([*parents, base] if base else parents)
        for alias in node.names:
            name = f"{base}.{alias.name}"
            known = name in MODULES or alias.name.startswith(EXTENSIONS) or base == "beltsim"
            self.add(name if known else base)

    def visit_Call(self, node: ast.Call) -> None:
        if ast.unparse(node.func) in ("importlib.import_module", "import_module", "__import__"):
            for argument in node.args[:1]:
                if isinstance(argument, ast.Constant):
                    self.add(str(argument.value))
        self.generic_visit(node)


def read(source: str, module: str, is_package: bool = False) -> Imports:
    visitor = Imports(module, is_package)
    visitor.visit(ast.parse(source))
    return visitor


READ = {
    name: read(path.read_text(), name, path.name == "__init__.py") for name, path in MODULES.items()
}
IMPORTS = {name: visitor.found for name, visitor in READ.items()}


def package_of(module: str) -> str:
    """First part below beltsim; the root itself for beltsim/__init__.py."""
    return module.split(".")[1] if "." in module else ""


def forbidden(module: str, imported: set[str]) -> list[str]:
    """What `module` imports from beltsim against the table."""
    package = package_of(module)
    allowed = ALLOWED[package]
    wrong = []
    for name in sorted(imported):
        if name.split(".")[0] != "beltsim":
            continue
        target = package_of(name)
        fine = target in {*EVERYBODY, *EXTENSIONS, package, "__version__"}
        reachable = target != "cli" if allowed == ANYTHING else target in allowed
        if not (fine or reachable):
            wrong.append(name)
    return wrong


def test_every_package_has_a_row():
    packages = {package_of(name) for name in MODULES} - {""}
    assert packages <= set(ALLOWED)
    assert {"errors", "problem", "response"} <= packages


@pytest.mark.parametrize("module", [name for name in MODULES if name != "beltsim"])
def test_imports_follow_the_table(module):
    assert forbidden(module, IMPORTS[module]) == []


def test_the_root_loads_nothing_but_the_standard_library():
    assert {name.split(".")[0] for name in READ["beltsim"].early} <= set(sys.stdlib_module_names)


def require_no_cycle(graph: dict[str, set[str]]) -> None:
    """Raises graphlib.CycleError, which names the cycle."""
    assert set(TopologicalSorter(graph).static_order()) >= set(graph)


def test_no_cycles_between_modules():
    """At loading. A package's own __init__ is loaded on the way and does not count."""
    require_no_cycle(
        {
            name: {other for other in visitor.early if other in MODULES and other != name}
            for name, visitor in READ.items()
            if name != "beltsim"
        }
    )


def test_no_cycles_between_packages():
    """At any time, inside functions too."""
    graph: dict[str, set[str]] = {}
    for name, found in IMPORTS.items():
        here = package_of(name)
        others = {package_of(other) for other in found if other.startswith("beltsim.")}
        graph.setdefault(here, set()).update(others & set(ALLOWED) - {here})
    del graph[""]
    require_no_cycle(graph)


@pytest.mark.parametrize("third_party", KEPT_APART)
def test_third_parties_stay_where_they_belong(third_party):
    users = {
        name
        for name, found in IMPORTS.items()
        if any(other.split(".")[0] == third_party for other in found)
    }
    assert {package_of(name) for name in users} <= KEPT_APART[third_party]
    if third_party == "numba":
        assert users <= {"beltsim.harmonic_balance._kernels"}


def test_each_extension_is_imported_by_one_module():
    users: dict[str, list[str]] = {}
    for name, found in IMPORTS.items():
        for other in found:
            tail = other.rpartition(".")[2]
            extension = tail.startswith(EXTENSIONS) and other not in MODULES
            if other.startswith("beltsim.") and extension:
                users.setdefault(other, []).append(name)
    for extension, modules in users.items():
        assert len(modules) == 1, extension
        assert package_of(modules[0]) in ("transient", "event_map")


@pytest.mark.parametrize(
    ("source", "module", "wrong"),
    [
        ("from beltsim.model import scaling", "beltsim.problem", ["beltsim.model"]),
        ("def f():\n    import beltsim.linear", "beltsim.transient.runs", ["beltsim.linear"]),
        ("from beltsim import cli", "beltsim.plots.motion", ["beltsim.cli"]),
        ("from beltsim import load", "beltsim.linear", ["beltsim.load"]),
        ("from ..drive import layout", "beltsim.linear.modes", ["beltsim.drive"]),
        (
            "import importlib\nimportlib.import_module('beltsim.io')",
            "beltsim.drive",
            ["beltsim.io"],
        ),
        ("if TYPE_CHECKING:\n    from beltsim.io import load", "beltsim.drive", []),
        ("from beltsim.errors import BeltsimError", "beltsim.checks", []),
        ("from beltsim import __version__", "beltsim.drive", []),
        ("import beltsim\nbeltsim.__version__", "beltsim.dataset", []),
        ("import beltsim\nbeltsim.load('a')", "beltsim.dataset", ["beltsim.load"]),
    ],
)
def test_the_checker_sees_what_it_must(source, module, wrong):
    found = [
        name.replace(".layout", "").replace(".scaling", "")
        for name in forbidden(module, read(source, module).found)
    ]
    assert found == wrong


HEAVY = ("numpy", "scipy", "xarray", "matplotlib", "pydantic", "numba", "h5netcdf", "tqdm")


def loaded_after(code: str) -> set[str]:
    """Heavy packages loaded after `code` in a fresh interpreter."""
    script = f"{code}\nimport sys\nprint(*[n for n in {HEAVY} if n in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT.parent,
    )
    return set(done.stdout.splitlines()[-1].split())


def test_importing_beltsim_loads_nothing_heavy():
    assert loaded_after("import beltsim; dir(beltsim)") == set()


def test_the_checker_of_loaded_packages_sees_them():
    assert "numpy" in loaded_after("import beltsim; beltsim.FrictionProblem")


def test_a_problem_needs_numpy_alone():
    assert loaded_after("import beltsim; beltsim.FrictionProblem, beltsim.Response") == {"numpy"}


@pytest.mark.parametrize("words", [["--help"], ["--version"], ["run", "--help"], ["no-such-verb"]])
def test_the_command_starts_without_anything_heavy(words):
    code = f"""
from beltsim.cli import main
try:
    main({words!r})
except SystemExit:
    pass"""
    assert loaded_after(code) == set()
