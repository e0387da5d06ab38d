"""Running cases: incomplete files, crashes, exit codes, and what is written."""

from __future__ import annotations

import json
import textwrap
import time

import pytest

from validation import case, table, worker
from validation.run import main

COMPLETE = """
title = "One is one"
claim = "The harness compares."
source = "arithmetic, row 1"
kind = "exact"
quantity = "a number"
metric = "value"
tolerance = 0.1
tolerance_reason = "chosen for the test"
runtime = "quick"
"""


@pytest.fixture
def root(tmp_path):
    (tmp_path / "README.md").write_text(f"# Toys\n\n{table.BEGIN}\n{table.END}\n\nend\n")
    return tmp_path


def add(root, name, body="return [('one', 1.0, 1.0)]", toml=COMPLETE):
    """A toy case whose `compute()` has the given body."""
    folder = root / name
    folder.mkdir(parents=True)
    (folder / "case.toml").write_text(toml)
    (folder / "reference.csv").write_text("quantity,expected\none,1.0\n")
    (folder / "run.py").write_text("def compute():\n" + textwrap.indent(body, "    "))
    return folder


def test_a_complete_case_loads(root):
    loaded = case.load(add(root, "toys/one"))
    assert (loaded.name, loaded.tolerance, loaded.expected_verdict) == ("toys/one", 0.1, "agrees")


@pytest.mark.parametrize("key", [line.split(" =")[0] for line in COMPLETE.strip().splitlines()])
def test_a_case_without_one_of_its_keys_is_refused(root, key, capsys):
    toml = "\n".join(line for line in COMPLETE.splitlines() if not line.startswith(f"{key} ="))
    add(root, "toys/one", toml=toml)
    assert main(["one"], root) == 2
    assert f"toys/one: {key} is missing" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "mistake"),
    [
        ('"chosen for the test"', '"  "', "tolerance_reason"),
        ("0.1", "-0.1", "tolerance"),
        ("0.1", "inf", "tolerance"),
        ("0.1", "true", "tolerance"),
        ('"exact"', '"guess"', "kind"),
        ('"value"', '"looks good"', "metric"),
        ('"quick"', '"later"', "runtime"),
        ('"quick"', '"quick"\ntolerence = 1', "unknown key 'tolerence'"),
        ('"quick"', '"quick"\nexpected_verdict = "disagrees"', "expected_verdict"),
        ('"quick"', '"quick"\nexpected_verdict = "disagrees-explained"', "written why"),
        ('"quick"', '"quick"\nexpected_verdict = "disagrees-explained"', "record the number"),
        ('"quick"', '"quick"\nexplanation = "because"', "only with expected_verdict"),
        ('"quick"', '"quick"\n[[override]]\nquantity = "one"\ntolerance = 9', "tolerance_reason"),
        ('"quick"', '"quick"\n[[explained]]\nquantity = "one"\ngot = 9', "within is missing"),
        ('"quick"', '"quick"\ntime_limit_s = 0', "time_limit_s"),
        ('"exact"', '"exact', "cannot be read"),
    ],
)
def test_an_unusable_case_is_refused_by_name(root, old, new, mistake):
    folder = add(root, "toys/one", toml=COMPLETE.replace(old, new, 1))
    with pytest.raises(case.CaseError, match=mistake):
        case.load(folder)


def test_all_mistakes_of_a_file_are_named_at_once(root):
    folder = root / "toys/one"
    folder.mkdir(parents=True)
    (folder / "case.toml").write_text('title = "One"\nkind = "guess"\n')
    with pytest.raises(case.CaseError) as caught:
        case.load(folder)
    text = str(caught.value)
    for word in ("claim", "source", "kind", "tolerance_reason", "run.py", "reference"):
        assert word in text


def test_exit_0_when_everything_agrees_or_is_explained(root, capsys):
    add(root, "toys/agrees")
    known = COMPLETE + textwrap.dedent("""
        expected_verdict = "disagrees-explained"
        explanation = "the source has a misprint"
        [[explained]]
        quantity = "one"
        got = 2.0
        within = 0.01
    """)
    add(root, "toys/explained", "return [('one', 2.0, 1.0)]", known)
    assert main([], root) == 0
    out = capsys.readouterr().out
    assert "toys/agrees  [exact]  AGREES" in out
    assert "DISAGREES-EXPLAINED" in out
    assert "why: the source has a misprint" in out
    assert "2 cases" in out


def test_exit_1_when_something_disagrees(root, capsys):
    add(root, "toys/agrees")
    add(root, "toys/off", "return [('one', 1.5, 1.0)]")
    assert main([], root) == 1
    assert "NOT PASSED  toys/off" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("raise RuntimeError('boom')", "RuntimeError: boom"),
        ("return 1 / 0", "ZeroDivisionError"),
        ("import sys; sys.exit(3)", "SystemExit: 3"),
        ("import os; os._exit(3)", "ended by itself with status 3"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "SIGSEGV"),
        ("return 7", "not iterable"),
        ("return []", "no rows"),
        ("return [('one', float('nan'), 1.0)]", "nan"),
    ],
)
def test_a_crash_fails_its_case_and_the_rest_goes_on(root, body, reason, capsys):
    add(root, "toys/a_crash", body)
    add(root, "toys/b_agrees")
    assert main([], root) == 1
    out = capsys.readouterr().out
    assert reason in out
    assert "toys/b_agrees  [exact]  AGREES" in out


def test_a_case_that_hangs_is_stopped_and_the_rest_goes_on(root, capsys):
    toml = COMPLETE + "time_limit_s = 0.5\n"
    add(root, "toys/a_hangs", "while True: pass", toml)
    add(root, "toys/b_agrees")
    assert main([], root) == 1
    out = capsys.readouterr().out
    assert "stopped after its time limit of 0.5 s" in out
    assert "toys/b_agrees  [exact]  AGREES" in out


def test_a_case_without_its_peer_is_skipped_and_the_table_left_alone(root, capsys):
    before = (root / "README.md").read_text()
    add(root, "toys/one", "raise AssertionError", COMPLETE + 'needs = "no_such_peer"\n')
    add(root, "toys/two", toml=COMPLETE + 'needs = "json"\n')
    assert main([], root) == 0
    out = capsys.readouterr().out
    assert "skipped: no_such_peer is not installed: pip install beltsim[peers]" in out
    assert "2 cases in" in out
    assert "1 agrees, 1 skipped" in out
    assert main(["--readme"], root) == 1
    assert "stays as it was: skipped toys/one" in capsys.readouterr().err
    assert (root / "README.md").read_text() == before


def test_a_note_is_shown_and_not_compared(root, tmp_path, capsys):
    body = "from validation.row import Row\nreturn [Row('one', 1.0, 1.0, note='in 3 <ms>')]"
    add(root, "toys/one", body)
    files = tmp_path / "results.json", tmp_path / "page.html"
    assert main(["--json", str(files[0]), "--html", str(files[1])], root) == 0
    assert "note, one: in 3 <ms>" in capsys.readouterr().out
    assert json.loads(files[0].read_text())["cases"][0]["rows"][0]["note"] == "in 3 <ms>"
    assert "in 3 &lt;ms&gt;" in files[1].read_text()


def test_what_a_case_prints_does_not_mix_with_its_rows(root):
    add(root, "toys/talks", "print('hello')\nreturn [('one', 1.0, 1.0)]")
    assert main([], root) == 0


def test_an_unknown_name_exits_2_with_near_matches(root, capsys):
    add(root, "toys/agrees")
    assert main(["agress"], root) == 2
    assert "unknown case 'agress'; near: agrees" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["toys", "agrees", "toys/agrees", "toys/agrees/"])
def test_a_case_answers_to_its_family_and_its_name(root, name, capsys):
    add(root, "toys/agrees")
    add(root, "others/off", "return [('one', 1.5, 1.0)]")
    assert main([name], root) == 0
    assert "others/off" not in capsys.readouterr().out


def test_long_cases_run_only_when_asked_for(root, capsys):
    add(root, "toys/agrees")
    long = COMPLETE.replace('"quick"', '"full"')
    add(root, "toys/long", "return [('one', 1.5, 1.0)]", long)
    assert main([], root) == 0
    assert main(["toys"], root) == 0
    assert main(["--full"], root) == 1
    assert main(["long"], root) == 1
    assert main(["--list"], root) == 0
    assert "toys/long" in capsys.readouterr().out


def test_only_long_cases_without_full_is_no_silent_success(root, capsys):
    add(root, "toys/long", toml=COMPLETE.replace('"quick"', '"full"'))
    assert main(["toys"], root) == 2
    assert "--full" in capsys.readouterr().err


def test_json_holds_everything(root, tmp_path):
    add(root, "toys/agrees")
    add(root, "toys/crash", "raise RuntimeError('boom')")
    add(root, "toys/nan", "return [('one', float('nan'), 1.0)]")
    file = tmp_path / "results.json"
    assert main(["--json", str(file)], root) == 1
    data = json.loads(file.read_text())
    assert data["passed"] is False
    by_name = {entry["name"]: entry for entry in data["cases"]}
    assert by_name["toys/agrees"]["rows"][0]["got"] == 1.0
    assert by_name["toys/agrees"]["tolerance_reason"] == "chosen for the test"
    assert "boom" in by_name["toys/crash"]["failure"]
    assert "RuntimeError" in by_name["toys/crash"]["details"]
    assert by_name["toys/nan"]["rows"][0]["got"] == "nan"


def test_json_into_a_missing_folder_is_found_before_computing(root, tmp_path, capsys):
    add(root, "toys/agrees")
    assert main(["--json", str(tmp_path / "no" / "results.json")], root) == 2
    captured = capsys.readouterr()
    assert "folder does not exist" in captured.err
    assert captured.out == ""


def test_readme_table_is_replaced_and_read_back(root):
    add(root, "toys/agrees", "return [('one | two', 1.0, 1.0), ('b', 1.0, 1.0)]")
    long = COMPLETE.replace('"quick"', '"full"')
    add(root, "toys/long", "return [('one', 1.5, 1.0)]", long)
    assert main(["--readme"], root) == 1
    text = (root / "README.md").read_text()
    assert text.startswith("# Toys")
    assert text.endswith("end\n")
    assert table.readme_rows(text) == [
        ("toys/agrees", "one | two", "agrees"),
        ("toys/agrees", "b", "agrees"),
        ("toys/long", "one", "disagrees"),
    ]
    assert main(["--readme"], root) == 1
    assert (root / "README.md").read_text() == text


def test_readme_with_names_is_refused(root, capsys):
    add(root, "toys/agrees")
    assert main(["--readme", "agrees"], root) == 2
    assert "name none" in capsys.readouterr().err


@pytest.mark.parametrize("workers", ["1", "3"])
def test_results_come_in_order_whatever_ends_first(root, workers, capsys):
    for i, seconds in enumerate((0.4, 0.0, 0.2, 0.0)):
        body = f"import time; time.sleep({seconds})\nreturn [('one', 1.0, 1.0)]"
        add(root, f"toys/case_{i}", body)
    assert main(["--workers", workers], root) == 0
    out = capsys.readouterr().out
    places = [out.index(f"toys/case_{i}") for i in range(4)]
    assert places == sorted(places)


def test_a_run_given_up_leaves_no_process_behind(root):
    add(root, "toys/a_quick")
    add(root, "toys/b_slow", "import time; time.sleep(60.0)\nreturn [('one', 1.0, 1.0)]")
    cases = [case.load(root / "toys" / name) for name in ("a_quick", "b_slow")]
    results = worker.run_all(cases, 2)
    assert next(results).passed
    began = time.perf_counter()
    results.close()
    assert time.perf_counter() - began < 30.0


def test_a_run_may_end_with_the_first_failure(root, capsys):
    add(root, "toys/a_agrees")
    add(root, "toys/b_off", "return [('one', 1.5, 1.0)]")
    add(root, "toys/c_agrees")
    assert main(["--stop-after", "1"], root) == 1
    out = capsys.readouterr().out
    assert "toys/b_off" in out
    assert "toys/c_agrees" not in out
    assert main(["--stop-after", "0"], root) == 2


def test_no_workers_are_refused(root, capsys):
    add(root, "toys/agrees")
    assert main(["--workers", "0"], root) == 2
    assert "--workers 0" in capsys.readouterr().err


def test_progress_is_shown_for_long_runs_only(root, capsys, monkeypatch):
    add(root, "toys/slow", "import time; time.sleep(0.5)\nreturn [('one', 1.0, 1.0)]")
    assert main([], root) == 0
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("validation.run.PATIENCE_S", 0.1)
    assert main([], root) == 0
    assert "[1/1] toys/slow" in capsys.readouterr().err
