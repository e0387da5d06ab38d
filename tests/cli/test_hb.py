"""`beltsim hb`: prints the harmonics, writes a result that can be read again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import beltsim
from beltsim.cli import main

DRIVE = str(Path(__file__).parents[2] / "examples" / "zhu_parker_2008.toml")
POINT = ["--omega", "6.3", "--functions", "4", "--Q-m", "3.5"]


def test_it_prints_and_writes(tmp_path, capsys):
    assert main(["hb", DRIVE, *POINT, "-R", "9", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "Harmonic balance, R = 9" in said
    assert "with these harmonics from" in said
    found = beltsim.load(tmp_path / "zhu_parker_2008-hb.nc")
    assert found.coefficients.shape[0] == 10
    first = abs(found.coefficients[1, found.problem.joint])
    assert f"{np.degrees(first):.4g} deg" in said
    lines = [line.split() for line in said.splitlines()]
    assert ["3", "9"] in [line[:2] for line in lines]  # the third harmonic of order three
    assert "arm angle from rest" in said
    level = np.abs(found.friction_torque[np.abs(found.q_dot[:, found.problem.joint]) > 0.1])
    assert np.allclose(level, 3.5)  # a slipping arm bears the kinetic torque, nothing between


def test_a_band_takes_the_papers_method(tmp_path, capsys):
    words = ["hb", DRIVE, *POINT, "-R", "9", "--sigma", "1e-4", "--out", str(tmp_path)]
    assert main(words) == 0
    said = capsys.readouterr().out
    assert "truncated series: 1)" in said
    problem = beltsim.load(tmp_path / "zhu_parker_2008-hb.nc").problem
    assert f"from {np.degrees(1e-4 / problem.scales.time_s):.4g} deg/s (sigma = 0.0001)" in said


def test_static_friction_takes_its_events_from_the_exact_orbit_or_a_run(tmp_path, capsys):
    words = [DRIVE, *POINT, "--Q-s", "4", "--out", str(tmp_path)]
    assert main(["hb", *words, "-R", "25"]) == 0
    said = capsys.readouterr().out
    assert "taken from the exact orbit: stick, slip-, stick, slip+" in said
    assert main(["run", *words, "--periods", "80.5", "--no-plot"]) == 0
    capsys.readouterr()
    run = str(tmp_path / "zhu_parker_2008.nc")
    assert main(["hb", *words, "-R", "25", "--pattern", run]) == 0
    again = capsys.readouterr().out
    assert "events given: stick, slip-, stick, slip+" in again
    assert [line for line in again.splitlines() if "friction loss" in line] == [
        line for line in said.splitlines() if "friction loss" in line
    ]
    assert main(["hb", *words, "--pattern", run, "--sigma", "1e-3"]) == 2
    assert "left out with --sigma" in capsys.readouterr().err


def test_the_torque_of_a_band_can_be_integrated_exactly(tmp_path, capsys):
    words = ["hb", DRIVE, *POINT, "-R", "9", "--sigma", "1e-4", "--out", str(tmp_path)]
    for choice, name in (([], "sampled"), (["--projection", "exact"], "exact")):
        assert main([*words, *choice]) == 0
        found = beltsim.load(tmp_path / "zhu_parker_2008-hb.nc")
        assert found.statistics["projection"] == name
    assert "Harmonic balance, R = 9" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["-R", "0"], "--harmonics = 0: must be an integer from 1 to 1000"),
        (["-R", "100000"], "--harmonics = 100000: must be an integer from 1 to 1000"),
        (["-R", "8", "--sigma", "1e-3"], "odd for the saturated law"),
        (["--sigma", "0"], "sigma"),
        (["--projection", "fft"], "projection"),
    ],
)
def test_bad_input_is_one_line(words, told, tmp_path, capsys):
    assert main(["hb", DRIVE, *POINT, *words, "--out", str(tmp_path)]) == 2
    said = capsys.readouterr().err.strip()
    assert told in said
    assert len(said.splitlines()) == 1
