"""The page of results: complete, self-contained, the same bytes each time."""

from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from validation import page, pictures
from validation.case import Explained, Override
from validation.compare import compare, failed
from validation.row import Row
from validation.run import main
from validation.table import SCHEMA, as_data

from .test_compare import CASE

KNOWN = replace(
    CASE,
    name="toy/known",
    expected_verdict="disagrees-explained",
    explanation="a misprint of <b> & more",
    explained=(Explained("off", got=2.0, within=0.1, explanation="this row too"),),
    overrides=(Override("fine", 0.5, "read from a picture", "value"),),
)
CURVE = replace(CASE, name="toy/curve", metric="max")
x = np.linspace(0.0, 1.0, 40)
RESULTS = [
    compare(KNOWN, [("off", 2.0, 1.0), ("fine", 1.0, 1.0), ("tiny $x$", 1e-9, 1e-9)]),
    compare(CURVE, [Row("wave", np.sin(x) + 1e-3, np.sin(x), x, "time, s", "angle, rad")]),
    compare(replace(CURVE, name="toy/rms", metric="rms"), [Row("wave", x, x + 1e-3)]),
    compare(replace(CURVE, name="toy/nan"), [Row("gap", [1.0, np.nan, 2.0], [1.0, 1.0, 2.0])]),
    compare(replace(CASE, name="toy/zero", tolerance=0.0), [("same", 1.0, 1.0)]),
    failed(replace(CASE, name="toy/crash"), "boom", details="Traceback <...>"),
]


@pytest.fixture(scope="module")
def text():
    return page.html(RESULTS, 1.5, "0.0")


def test_every_case_has_its_section_with_claim_source_tolerance_and_reason(text):
    for result in RESULTS:
        case = result.case
        section = text[text.index(f'<section id="{case.name.replace("/", "-")}">') :]
        section = section[: section.index("</section>")]
        for part in (case.claim, case.source, case.tolerance_reason, case.kind, result.verdict):
            assert part in section
        assert section.count("<svg") == (0 if result.failure else 1)
        for row in result.rows:
            assert f"<td>{row.quantity}" in section


def test_explanations_overrides_and_failures_are_shown_and_escaped(text):
    for part in (
        "a misprint of &lt;b&gt; &amp; more",
        "off: this row too",
        "read from a picture",
        "failed: boom",
        "Traceback &lt;...&gt;",
        "Not passed",
    ):
        assert part in text


def test_nothing_is_loaded_and_nothing_runs(text):
    assert "<script" not in text
    assert "@import" not in text
    for found in re.findall(r"(?:href|src)\s*=\s*[\"']([^\"']*)", text):
        assert found.startswith(("#", "data:")), found
    for found in re.findall(r"url\(([^)]*)\)", text):
        assert found.startswith("#"), found


def test_pictures_are_well_formed_and_name_their_axes(text):
    svgs = re.findall(r"<svg.*?</svg>", text, flags=re.DOTALL)
    texts = [" ".join(ElementTree.fromstring(svg).itertext()) for svg in svgs]
    assert len(texts) == 5
    assert "time, s" in texts[1]
    assert "angle, rad" in texts[1]
    for shown in texts:
        for word in ("reference", "beltsim", "tolerance", "error"):
            assert word in shown


def test_the_names_inside_pictures_do_not_collide(text):
    svgs = re.findall(r"<svg.*?</svg>", text, flags=re.DOTALL)
    clips = [set(re.findall(r'<clipPath id="([^"]*)"', svg)) for svg in svgs]
    assert len(set().union(*clips)) == sum(map(len, clips))


def test_the_same_results_give_the_same_bytes(text):
    assert page.html(RESULTS, 1.5, "0.0") == text


def test_of_many_curves_those_nearest_to_their_tolerance_are_drawn():
    rows = [Row(f"wave {i}", x + 1e-5 * i, x) for i in range(pictures.MOST_CURVES + 2)]
    drawn, left_out = pictures.of_case(compare(CURVE, rows))
    assert (len(drawn), left_out) == (pictures.MOST_CURVES, 2)
    assert "wave 1" not in "".join(drawn)
    assert f"wave {pictures.MOST_CURVES + 1}" in drawn[-1]


def test_large_arrays_become_pixels_inside_the_page():
    many = np.linspace(0.0, 1.0, pictures.MOST_VECTORS + 1)
    (svg,), _ = pictures.of_case(compare(CURVE, [Row("wave", many, many + 1e-3)]))
    assert "data:image/png;base64" in svg
    assert len(svg) < 60_000


def test_labels_stand_in_the_data():
    data = as_data(RESULTS, 1.5, "0.0")
    assert data["schema"] == SCHEMA == 3
    row = data["cases"][1]["rows"][0]
    assert (row["x_label"], row["y_label"]) == ("time, s", "angle, rad")


@pytest.mark.parametrize("abscissa", [[0.0, 1.0], [0.0, np.inf, 1.0]])
def test_an_abscissa_that_does_not_fit_fails_the_case(abscissa):
    result = compare(CURVE, [Row("a", [1.0, 2.0, 3.0], [1.0, 2.0, 3.0], x=abscissa)])
    assert "x must be" in result.failure


def test_the_page_is_written_by_the_command(tmp_path):
    folder = tmp_path / "toys" / "one"
    folder.mkdir(parents=True)
    keys = ("title", "claim", "source", "kind", "quantity", "metric", "tolerance_reason", "runtime")
    toml = "".join(f'{key} = "{getattr(CASE, key)}"\n' for key in keys)
    (folder / "case.toml").write_text(f"{toml}tolerance = 0.1\n")
    (folder / "reference.csv").write_text("quantity,expected\none,1.0\n")
    (folder / "run.py").write_text("def compute():\n    return [('one', 1.0, 1.0)]\n")
    target = tmp_path / "page.html"
    assert main(["--html", str(target)], tmp_path) == 0
    assert "Passed" in target.read_text()
    assert main(["--html", str(tmp_path / "no" / "page.html")], tmp_path) == 2
