"""`beltsim validate --drive FILE`."""

from __future__ import annotations

from pathlib import Path

import pytest

from beltsim.cli import main

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
QUICK = ["--functions", "2", "--tolerance", "0.02"]


@pytest.mark.parametrize("name", ["zhu_parker_2008", "passenger_car_7_pulley"])
def test_the_solvers_agree_on_the_examples(name, capsys):
    assert main(["validate", "--drive", str(EXAMPLES / f"{name}.toml"), *QUICK]) == 0
    out = capsys.readouterr().out
    for word in ("event map", "C core", "range of tension of span 1", "dissipated energy", "agree"):
        assert word in out
    assert "DISAGREE" not in out
    assert " rad" not in out
    assert "deg" in next(line for line in out.splitlines() if line.startswith("  rms of theta_t"))
    slack = [line for line in out.splitlines() if "tension of span 1 falls below 0 N" in line]
    assert len(slack) == 1


def test_every_mistake_is_named_at_once(capsys):
    words = ["validate", "--drive", str(EXAMPLES / "zhu_parker_2008.toml")]
    assert main([*words, "--Q-m", "-1", "--functions", "0", "--tolerance", "2"]) == 2
    err = capsys.readouterr().err
    for word in ("--Q-m", "--functions", "tolerance"):
        assert word in err


@pytest.mark.parametrize("words", [["--drive"], ["--drive", "a.toml", "--no-such-option"]])
def test_words_that_cannot_be_read(words, capsys):
    assert main(["validate", *words]) == 2
    assert "beltsim:" in capsys.readouterr().err


def test_a_missing_file(capsys):
    assert main(["validate", "--drive=no-such-file.toml"]) == 2
    assert "no-such-file.toml" in capsys.readouterr().err


def test_help_says_what_it_does(capsys):
    assert main(["validate", "--drive", "x", "--help"]) == 0
    assert "every solver" in capsys.readouterr().out
