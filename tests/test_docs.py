"""README and docs: every block runs and prints what the page says, every link leads somewhere."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import beltsim
from docs import blocks

ROOT = Path(__file__).resolve().parents[1]
PAGES = blocks.pages()
#: Pages whose links are checked as well; their commands belong to other tests.
MORE = [ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md", ROOT / "validation" / "README.md"]
LANGUAGES = {"python", "text", "console", "sh", "toml", "math", "mermaid"}
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)|<(https?://[^>]+)>")

page_by_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)


@page_by_page
def test_every_block_prints_what_the_page_says(page: Path, tmp_path: Path):
    for seen in blocks.run_page(page, tmp_path):
        where = f"{page.name}, line {seen.line}"
        assert blocks.agrees(seen.expected, seen.printed), (
            f"{where} prints\n{seen.printed}\nand not\n{seen.expected}"
        )


@page_by_page
def test_blocks_are_of_a_known_language(page: Path):
    text = page.read_text()
    assert text.count("\n```") % 2 == 0, "a fence is not closed"
    assert {block.language for block in blocks.blocks_of(text)} <= LANGUAGES


@page_by_page
def test_toml_blocks_are_toml(page: Path):
    for block in blocks.blocks_of(page.read_text()):
        if block.language == "toml":
            tomllib.loads(block.text)


def test_import_table_is_the_one_that_is_enforced():
    from test_import_rules import ALLOWED, ANYTHING

    text = (ROOT / "docs" / "architecture.md").read_text()
    table = text.partition("| may import from beltsim |")[2].partition("\n\n")[0]
    stated = {}
    for left, right in re.findall(r"^\| (`.*?) \| (.*?) \|$", table, re.M):
        for package in re.findall(r"`(\w+)`", left):
            names = set(re.findall(r"`(\w+)`", right.replace("`to_xarray`", "")))
            stated[package] = ANYTHING if right == "anything but `cli`" else names
    enforced = {name: allowed for name, allowed in ALLOWED.items() if name != "__main__"}
    assert stated == enforced


def test_files_of_the_tree_exist():
    text = (ROOT / "docs" / "architecture.md").read_text()
    tree = next(b.text for b in blocks.blocks_of(text) if b.text.startswith("beltsim/"))
    named = re.findall(r"^([a-z][\w./]+)  ", tree, re.M)
    assert len(named) > 20
    assert not [name for name in named if not (ROOT / name).exists()]
    inside = {path.name for path in (ROOT / "beltsim").iterdir() if path.suffix != ".so"}
    inside -= {"__init__.py", "__main__.py", "__pycache__", "py.typed"}
    missing = {name for name in inside if f"beltsim/{name}" not in tree}
    assert not missing


def test_the_complete_example_is_a_drive():
    from beltsim.drive import Drive

    text = (ROOT / "docs" / "drive-file.md").read_text()
    complete = [b.text for b in blocks.blocks_of(text) if b.language == "toml"]
    drive = Drive(**tomllib.loads(complete[0]))
    fuller = beltsim.load_drive(ROOT / "examples" / "passenger_car_7_pulley.toml")
    assert drive.layout.wrap_rad == pytest.approx(fuller.layout.wrap_rad, abs=1e-12)


def test_every_key_of_a_drive_file_is_documented():
    from beltsim.drive import Drive

    text = (ROOT / "docs" / "drive-file.md").read_text()
    schema = Drive.model_json_schema()
    tables = [schema, *schema["$defs"].values()]
    keys = {key for table in tables for key in table.get("properties", {})}
    assert len(keys) > 30
    missing = sorted(key for key in keys if f"`{key}`" not in text and f"[{key}]" not in text)
    assert not missing


@page_by_page
def test_sh_blocks_name_verbs_that_run_has(page: Path):
    verbs = re.search(r"^case \$verb in\n(.*?)^esac", (ROOT / "run").read_text(), re.M | re.S)
    known = set(re.findall(r"^  (\w+)\)", verbs[1], re.M)) if verbs else set()
    for block in blocks.blocks_of(page.read_text()):
        if block.language == "sh":
            used = re.findall(r"^\./run (\w+)", block.text, re.M)
            assert set(used) <= known, f"{used} not among {known}"


@pytest.mark.parametrize("page", [*PAGES, *MORE], ids=lambda page: page.name)
def test_links_resolve(page: Path):
    for target, _ in LINK.findall(page.read_text()):
        if not target or target.startswith(("http://", "https://")):
            continue
        name, _, anchor = target.partition("#")
        aim = (page.parent / name).resolve() if name else page
        assert aim.exists(), f"{page.name}: {target}"
        assert aim.is_relative_to(ROOT), f"{page.name}: {target} leads out of the repository"
        if anchor and aim.suffix == ".md":
            assert anchor in anchors(aim.read_text()), f"{page.name}: {target}"


def anchors(text: str) -> set[str]:
    """Anchors that a rendered page has, one per heading."""
    prose = blocks.FENCE.sub("", text)
    titles = re.findall(r"^#+ (.*)$", prose, re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", [*PAGES, *MORE], ids=lambda page: page.name)
def test_pages_name_no_place_on_somebodys_machine(page: Path):
    found = re.findall(r"(?<![\w.])/(?:home|root|tmp|work|mnt|opt|Users)\b\S*", page.read_text())
    assert not found


@page_by_page
def test_formulas_survive_rendering(page: Path):
    """Inline formulas avoid what Markdown takes for its own: `}_`, `*`, `\\,`, bars in tables."""
    text = blocks.FENCE.sub("", page.read_text())
    text = re.sub(r"`[^`\n]*`", "", text)
    for line in text.splitlines():
        formulas = re.findall(r"\$([^$]+)\$", line)
        for formula in formulas:
            assert not re.search(r"[})\]]_|\*|\\[^A-Za-z]|<\S|\S>", formula), (
                f"{page.name}: {formula}"
            )
            assert not (line.startswith("|") and "|" in formula), f"{page.name}: {formula}"


@pytest.mark.parametrize("page", [*PAGES, *MORE], ids=lambda page: page.name)
def test_commands_in_prose_can_be_read(page: Path):
    """Commands that are only mentioned: verb and options exist."""
    from beltsim.cli.arguments import cross_check_parser, parser
    from validation.run import _options

    text = blocks.FENCE.sub("", page.read_text())
    mentioned = re.findall(r"`beltsim ((?!--)[^`]+)`", text)
    for command in (each for all_of in mentioned for each in all_of.split(" | ")):
        words = command.split()
        if words[0] == "validate" and "--drive" in words:
            cross_check_parser().parse_args(words[1:])
        elif words[0] == "validate":
            _options(words[1:])
        else:
            needs_file = words in (["modes"], ["run"], ["hb"], ["events"], ["sweep"], ["plot"])
            parser().parse_args([*words, "FILE"] if needs_file else words)


@page_by_page
def test_code_names_in_pages_exist(page: Path):
    """Dotted names such as `beltsim.linear.modes` and paths such as `beltsim/linear.py`."""
    text = page.read_text()
    for name in set(re.findall(r"\bbeltsim((?:\.[A-Za-z_]\w*)+)", text)):
        value = beltsim
        for part in name[1:].split("."):
            if part in ("toml", "h", "py"):
                break
            value = getattr(value, part)
    for path in set(
        re.findall(r"`((?:beltsim|csrc|tests|validation|docs|examples)/[\w./-]*)`", text)
    ):
        assert (ROOT / path).exists(), f"{page.name}: {path}"


@pytest.mark.parametrize(
    ("expected", "printed"),
    [
        ("a 1.25 b", "a 1.251 b"),
        ("a   b", "a b"),
        ("x\n...\nz 3", "x\ny\ny\nz 3"),
        ("took ... s", "took 12.5 s"),
        ("1.20e-07", "1.21e-07"),
    ],
)
def test_outputs_that_agree(expected: str, printed: str):
    assert blocks.agrees(expected, printed)


@pytest.mark.parametrize(
    ("expected", "printed"),
    [
        ("a 1.25 b", "a 1.27 b"),
        ("3 events", "4 events"),
        ("x\n...\nz 3", "x\ny"),
        ("a", "a\nb"),
        ("", "something"),
        ("1.20e-07", "1.20e-06"),
        ("-0.5", "0.5"),
    ],
)
def test_outputs_that_do_not_agree(expected: str, printed: str):
    assert not blocks.agrees(expected, printed)


def test_den_hartog_example_meets_the_closed_form():
    printed = run_example("den_hartog.py")
    rows = [line.split() for line in printed.splitlines() if re.match(r"\s+0\.\d ", line)]
    moving = [(float(row[1]), float(row[2])) for row in rows if "rests)" not in row]
    assert len(moving) >= 2
    for amplitude, formula in moving:
        assert amplitude == pytest.approx(formula, abs=1e-6)
    assert "rests)" in printed, "one row with rests"


def test_figure_of_the_drive_can_be_drawn_again(tmp_path: Path):
    script = runpy.run_path(str(ROOT / "docs" / "figures" / "drive.py"))
    script["main"](tmp_path / "drive.png")
    assert (tmp_path / "drive.png").stat().st_size > 10_000


def test_picture_of_readme_is_small():
    assert (ROOT / "docs" / "figures" / "arm.png").stat().st_size < 150_000
    assert (ROOT / "docs" / "figures" / "drive.png").stat().st_size < 150_000


def test_first_run_example_prints_what_readme_prints():
    """The ten lines of README are the example, so that they cannot drift apart."""
    readme = (ROOT / "README.md").read_text()
    shown = [block.text for block in blocks.blocks_of(readme) if block.language == "python"]
    source = (ROOT / "examples" / "first_run.py").read_text()
    body = source.split('"""', 2)[2].strip()
    assert body == shown[0].strip()
    outputs = [block.text for block in blocks.blocks_of(readme) if block.language == "text"]
    assert blocks.agrees(outputs[0], run_example("first_run.py"))


def run_example(name: str) -> str:
    """Standard output of an example, run from the root of the repository."""
    done = subprocess.run(
        [sys.executable, f"examples/{name}"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
