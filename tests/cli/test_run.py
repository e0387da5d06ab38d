"""`beltsim run`: what is printed is what was computed, files are whole, runs can be repeated."""

import dataclasses
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import beltsim
from beltsim.cli import main
from beltsim.cli.arguments import METHODS
from beltsim.cli.motion import figure_lines
from beltsim.errors import CoreError
from beltsim.io import load, save, stored_inputs
from beltsim.transient import Settings, integrate
from beltsim.transient.settings import METHODS as TRUE_METHODS

QUICK = ["--functions", "3", "--Q-m", "3.5"]


@pytest.fixture
def response(short_run):
    return load(short_run[0] / "zhu_parker_2008.nc")


def number(text, label):
    found = re.search(rf"^ *{label} +.*?([-+]?[0-9][0-9.e+-]*)", text, re.MULTILINE)
    assert found, label
    return float(found[1])


def test_files_of_a_run(short_run):
    names = sorted(file.name for file in short_run[0].iterdir())
    stem = "zhu_parker_2008"
    pictures = [f"{stem}-{what}.png" for what in ("arm", "layout", "tensions")]
    assert names == sorted([*pictures, f"{stem}.nc"])
    for name in names:
        assert str(short_run[0] / name) in short_run[1]


def test_the_stored_response_is_that_of_the_library(response, example):
    drive = beltsim.load_drive(example)
    problem = beltsim.assemble(drive, n_functions=3, friction=beltsim.Coulomb(3.5))
    alone = integrate(problem, 20.0, None, Settings(kept_periods=2.0))
    np.testing.assert_array_equal(alone.final_state, response.final_state)
    np.testing.assert_array_equal(alone.events.t, response.events.t)
    assert response.t[0] == pytest.approx(18.0 * problem.period)
    assert len(response.t) == 1001


def test_printed_figures_are_those_of_the_response(short_run, response):
    text, scales = short_run[1], response.problem.scales
    joule = response.dissipated_energy * scales.torque_N_m
    assert number(text, "friction loss") == pytest.approx(joule, rel=1e-3)
    watt = joule / (response.problem.period * scales.time_s)
    assert f"{watt:.0f} W" in text
    share = 100.0 * response.stick_fraction
    assert number(text, "sticking") == pytest.approx(share, abs=0.01)
    assert number(text, "stops") == response.stops_per_period == 2.0
    assert "nu = 0\n" in text
    residual = number(text, "period residual")
    assert residual == pytest.approx(response.period_residual, rel=0.1)
    assert "not yet periodic" in text
    assert number(text, "arm friction") == pytest.approx(3.5 * scales.torque_N_m, rel=1e-3)
    assert "3089.3 rpm" in text
    for warning in response.warnings:
        assert warning in text


def test_the_event_table_is_that_of_the_last_period(short_run, response):
    scales, events = response.problem.scales, response.events
    last = np.flatnonzero(events.t > response.window[0])
    rows = re.findall(r"^  (stick|slip\+|slip-|reverse) +(.*)$", short_run[1], re.MULTILINE)
    assert [kind for kind, _ in rows] == list(events.kind[last])
    for i, (_, cells) in zip(last, rows, strict=True):
        time_ms, crank, angle, before, after = map(float, cells.split()[:5])
        assert time_ms == pytest.approx(events.t[i] * scales.time_s * 1e3, abs=1e-4)
        assert angle == pytest.approx(np.degrees(events.position[i]), abs=1e-4)
        assert before == pytest.approx(events.torque_before[i] * scales.torque_N_m, abs=1e-3)
        assert after == pytest.approx(events.torque_after[i] * scales.torque_N_m, abs=1e-3)
        # the firing frequency is three times the crank's, whose angle counts within a period
        turn = np.degrees(events.t[i] * 6.3 / 3.0) % 120.0
        assert crank == pytest.approx(turn, abs=0.01)


def test_what_remains_of_the_slowest_mode(short_run, response):
    left = 100.0 * np.exp(-20.0 * beltsim.linear.decay(response.problem))
    assert f"{left:.2g} % (arm free)" in short_run[1]
    assert "after 20 periods" in short_run[1]


def test_extremes_of_the_tensions_belong_to_the_last_period(short_run, response):
    last = response.t >= response.window[0]
    tension = response.observe("tension of span 1")[last] * 300.0
    cells = re.search(r"^  tension of span 1 +(\S+) +(\S+)", short_run[1], re.MULTILINE)
    assert float(cells[1]) == pytest.approx(tension.min(), abs=0.06)
    assert float(cells[2]) == pytest.approx(tension.max(), abs=0.06)
    arm = np.degrees(response.q[last, -1])  # with the zero of the table of events
    cells = re.search(r"^  arm angle from rest +(\S+) +(\S+)", short_run[1], re.MULTILINE)
    assert float(cells[1]) == pytest.approx(arm.min(), abs=6e-4)
    assert float(cells[2]) == pytest.approx(arm.max(), abs=6e-4)


def test_the_result_carries_its_inputs(short_run, example):
    inputs = stored_inputs(short_run[0] / "zhu_parker_2008.nc")
    assert inputs["drive"] == Path(example).read_text()
    assert inputs["arguments"] == {"functions": 3, "Q_m": 3.5, "periods": 20.0}
    assert inputs["settings"]["rtol"] == 1e-8


def test_a_stored_run_repeats_itself(short_run, tmp_path, capsys):
    stored = str(short_run[0] / "zhu_parker_2008.nc")
    assert main(["run", stored, "--out", str(tmp_path), "--no-plot"]) == 0
    assert "equals the stored run bit for bit" in capsys.readouterr().out
    again = load(tmp_path / "zhu_parker_2008.nc")
    np.testing.assert_array_equal(again.q, load(stored).q)
    assert stored_inputs(tmp_path / "zhu_parker_2008.nc") == stored_inputs(stored)


def test_a_stored_run_can_be_changed(short_run, tmp_path, capsys):
    """A friction in N m takes the place of the stored one over P0 r_t."""
    stored = str(short_run[0] / "zhu_parker_2008.nc")
    words = ["--out", str(tmp_path), "--no-plot", "--friction-torque-N-m", "29.1", "--periods", "1"]
    assert main(["run", stored, *words]) == 0
    assert "Repetition" not in capsys.readouterr().out
    changed = load(tmp_path / "zhu_parker_2008.nc").problem
    assert changed.friction.Q_m == pytest.approx(1.0, rel=1e-12)
    assert changed.n == 12  # three sines on each of three spans


def test_a_result_is_not_replaced_by_its_repetition(short_run, capsys):
    stored = short_run[0] / "zhu_parker_2008.nc"
    before = stored.read_bytes()
    assert main(["run", str(stored), "--out", str(short_run[0])]) == 2
    assert "replaced by its own repetition" in capsys.readouterr().err
    assert stored.read_bytes() == before


def test_options_reach_the_problem(example, tmp_path):
    words = ["--rpm", "800", "--static-friction-torque-N-m", "58.2", "--no-residual-flexibility"]
    more = ["--method", "bdf", "--rtol", "1e-6", "--samples", "40", "--functions", "4,2,3"]
    quick = ["--periods", "1.5", "--no-plot", "--out", str(tmp_path)]
    assert main(["run", example, *words, *more, *quick]) == 0
    made = load(tmp_path / "zhu_parker_2008.nc")
    drive = beltsim.load_drive(example)
    law = beltsim.Coulomb(0.5, 2.0)
    kept = beltsim.assemble(
        drive, rpm=800.0, friction=law, n_functions=[4, 2, 3], residual_flexibility=False
    )
    np.testing.assert_array_equal(made.problem.K, kept.K)
    assert made.problem.friction.Q_m == pytest.approx(0.5)
    assert made.problem.friction.Q_s == pytest.approx(2.0)
    assert made.statistics["method"] == "bdf"
    assert made.statistics["rtol"] == 1e-6
    assert len(made.t) == 61


def test_a_drive_without_tensioner(tmp_path, capsys):
    paper = beltsim.presets.zhu_parker_2008().model_dump(exclude_none=True)
    paper["pulleys"] = [dict(p, role=p["role"].replace("arm", "fixed")) for p in paper["pulleys"]]
    del paper["tensioner"], paper["overrides"]
    file = tmp_path / "fixed.json"
    file.write_text(json.dumps(paper))
    out = ["--out", str(tmp_path / "out"), "--functions", "3"]
    assert main(["run", str(file), "--periods", "2", *out]) == 0
    text = capsys.readouterr().out
    assert "Events" not in text
    assert "friction" not in text
    names = sorted(one.name for one in (tmp_path / "out").iterdir())
    assert names == ["fixed-layout.png", "fixed-tensions.png", "fixed.nc"]
    assert main(["run", str(file), "--Q-m", "1", *out]) == 2
    assert "--Q-m = 1.0: must be left out" in capsys.readouterr().err


def test_methods_are_those_of_the_integrator():
    assert METHODS == TRUE_METHODS


def test_a_run_that_stops_early_is_kept(example, tmp_path, capsys):
    words = ["--periods", "1e5", "--max-seconds", "0.8", "--out", str(tmp_path)]
    assert main(["run", example, *QUICK, *words]) == 1
    error = capsys.readouterr().err
    assert "BS_OUT_OF_TIME" in error
    assert "of 100000 periods are in" in error
    partial = load(tmp_path / "zhu_parker_2008-partial.nc")
    assert partial.statistics["complete"] == 0
    assert 100 < len(partial.t) <= 1001
    assert partial.t[-1] <= partial.window[1]
    assert (
        main(["plot", str(tmp_path / "zhu_parker_2008-partial.nc"), "--out", str(tmp_path / "p")])
        == 0
    )
    assert "arm" in capsys.readouterr().out
    shutil.rmtree(tmp_path / "p")
    assert [file.name for file in tmp_path.iterdir()] == ["zhu_parker_2008-partial.nc"]
    file = tmp_path / "zhu_parker_2008-partial.nc"
    assert len(load(file).events) > 0
    # it can be started again; giving the stored length anew would make it another run
    inputs = stored_inputs(file)
    inputs["arguments"] |= {"periods": 3.0, "max_seconds": 1e9}
    save(load(file), file, inputs)
    assert main(["run", str(file), "--no-plot", "--out", str(tmp_path / "again")]) == 0
    assert "was cut short" in capsys.readouterr().out


def test_a_failure_without_a_partial_result(example, tmp_path, monkeypatch, capsys):
    def fails(*_, **__):
        raise CoreError("the core broke at t = 1; try rtol = 1e-6", "BS_BROKEN")

    monkeypatch.setattr("beltsim.cli.run.integrate", fails)
    assert main(["run", example, *QUICK, "--out", str(tmp_path)]) == 1
    assert capsys.readouterr().err == "beltsim: the core broke at t = 1; try rtol = 1e-6\n"
    assert list(tmp_path.iterdir()) == []


def test_a_result_that_cannot_be_written_is_still_printed(example, tmp_path, monkeypatch, capsys):
    """The folder goes away while the run goes on."""
    out = tmp_path / "out"

    def slow(*words, **more):
        out.write_text("in the way")
        return integrate(*words, **more)

    monkeypatch.setattr("beltsim.cli.run.integrate", slow)
    assert main(["run", example, *QUICK, "--periods", "2", "--out", str(out)]) == 1
    said = capsys.readouterr()
    assert "friction loss" in said.out
    assert "Written" not in said.out
    assert str(out) in said.err


def start(words, folder, **options):
    return subprocess.Popen(
        [sys.executable, "-m", "beltsim", *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def test_ctrl_c_keeps_what_was_computed(example, tmp_path):
    run = start(["run", example, *QUICK, "--periods", "1e7", "--out", "."], tmp_path)
    deadline = time.monotonic() + 60.0
    while b"/_core.abi3" not in Path(f"/proc/{run.pid}/maps").read_bytes():
        assert time.monotonic() < deadline
        time.sleep(0.05)
    time.sleep(1.0)
    run.send_signal(signal.SIGINT)
    try:
        _, error = run.communicate(timeout=60)
    finally:
        run.kill()
    assert run.returncode == 130, error
    assert error.startswith("beltsim: interrupted\n")
    assert "Traceback" not in error
    partial = load(tmp_path / "zhu_parker_2008-partial.nc")
    assert 0.0 < partial.window[1] < 1e7 * partial.problem.period
    assert len(partial.t) > 100


def test_a_reader_that_goes_away(example, tmp_path):
    """As in `beltsim run ... | head -1`: no traceback, and the files are whole."""
    run = start(["run", example, *QUICK, "--periods", "2", "--no-plot"], tmp_path)
    run.stdout.close()
    error = run.stderr.read()
    run.stderr.close()
    assert run.wait(timeout=60) == 141
    assert error == ""
    assert len(load(tmp_path / "beltsim-out" / "zhu_parker_2008.nc").t) == 1001


def test_a_bar_only_on_a_terminal(example, tmp_path):
    """A run of more than two seconds, once with a pipe and once with a terminal as stderr."""
    words = ["run", example, *QUICK, "--periods", "1e7", "--max-seconds", "3", "--no-plot"]
    quiet = start(words, tmp_path)
    _, error = quiet.communicate(timeout=60)
    assert "%" not in error
    ours, theirs = os.openpty()
    loud = subprocess.Popen(
        [sys.executable, "-m", "beltsim", *words],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=theirs,
    )
    os.close(theirs)
    seen = b""
    try:
        while chunk := os.read(ours, 4096):
            seen += chunk
    except OSError:  # how Linux says that the other end was closed
        pass
    os.close(ours)
    assert loud.wait(timeout=60) == 1
    assert b"integrating" in seen
    assert b"%" in seen


def test_replaced_files_are_marked(example, tmp_path, capsys):
    words = ["run", example, *QUICK, "--periods", "1", "--out", str(tmp_path), "--no-plot"]
    assert main(words) == 0
    assert "(replaced" not in capsys.readouterr().out
    assert main([*words, "--rpm", "900"]) == 0
    assert "zhu_parker_2008.nc  (replaced an earlier one: --out FOLDER keeps both)" in (
        capsys.readouterr().out
    )


def test_a_motion_that_does_not_settle_is_told_so(response):
    restless = dataclasses.replace(response, period_residual=0.3, periodic=False)
    slow = SimpleNamespace(decay_free=0.1, decay_locked=0.1)
    said = [figure_lines(restless, slow, periods)[-2] for periods in (20.0, 500.0)]
    assert "3.0e-01 of the state (not yet periodic: run longer (--periods))" in said[0]
    assert "3.0e-01 of the state (does not settle: another period, or irregular motion)" in said[1]


def test_a_torque_given_in_newton_metres_is_refused_in_newton_metres(example, capsys):
    words = ["--friction-torque-N-m", "5", "--static-friction-torque-N-m", "4"]
    assert main(["modes", example, *words]) == 2
    assert capsys.readouterr().err == (
        "beltsim: --static-friction-torque-N-m = 4.0: must be a finite number, at least the "
        "kinetic friction torque\n"
    )
