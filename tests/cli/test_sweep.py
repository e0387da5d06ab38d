"""`beltsim sweep`: speeds and torques in, one dataset, one picture and a table out."""

from __future__ import annotations

import re

import numpy as np
import pytest
import xarray as xr

import beltsim
from beltsim import study
from beltsim.cli import main

QUICK = ["--functions", "3", "--no-plot"]


def swept(folder):
    with xr.open_dataset(folder / "zhu_parker_2008-sweep.nc", engine="h5netcdf") as data:
        return data.load()


def test_dataset_is_that_of_the_study(example, tmp_path, capsys):
    words = ["--rpm", "1000:4000:3", "--out", str(tmp_path), "--functions", "3"]
    assert main(["sweep", example, *words]) == 0
    data, drive = swept(tmp_path), beltsim.load_drive(example)
    assert data.Q_m.values.tolist() == pytest.approx([0.0, 0.5, np.inf])
    np.testing.assert_allclose(data.crank_speed, [1000.0, 2500.0, 4000.0])
    again = study.sweep(drive, data.Omega.values, data.Q_m.values, n_functions=3)
    np.testing.assert_array_equal(data.rms, again.rms)
    text = capsys.readouterr().out
    rows = [line.split() for line in text.splitlines() if re.match(r"^  (0|0\.5|inf) ", line)]
    arm = np.degrees(again.rms.sel(coordinate="theta_t", Q_m=0.5))
    assert float(rows[1][2]) == pytest.approx(float(arm.max()), rel=1e-3)
    assert [row[-1] for row in rows] == ["0", "0", "0"]
    assert rows[0][6:8] == ["0", "-"]  # a free arm loses nothing anywhere
    assert rows[2][2:4] == ["0", "-"]  # and a locked one moves nowhere
    assert (tmp_path / "zhu_parker_2008-sweep.png").stat().st_size > 10_000


def test_torques_in_newton_metres_and_by_series(example, tmp_path):
    words = ["--omega", "6.0:6.3:2", "--friction-torque-N-m", "29.1,14.55", "-R", "9"]
    assert main(["sweep", example, "--out", str(tmp_path), *words, *QUICK]) == 0
    data = swept(tmp_path)
    np.testing.assert_allclose(data.Q_m, [0.5, 1.0])
    assert "HarmonicBalance" in data.attrs["method"]
    assert data.reversals_of_series.notnull().all()


def test_static_friction_of_the_file_counts(tmp_path, drive_file, capsys):
    arm = beltsim.presets.zhu_parker_2008().tensioner.model_dump(exclude_none=True)
    file = drive_file(tensioner={**arm, "static_friction_torque_N_m": 29.1})
    words = ["sweep", file, "--omega", "6.0:6.3:2", "--out", str(tmp_path), *QUICK]
    assert main(words) == 0
    with xr.open_dataset(tmp_path / "drive-sweep.nc", engine="h5netcdf") as data:
        assert "static_ratio=2.0" in data.attrs["method"]
    assert "static friction 2 times the kinetic, as in the file" in capsys.readouterr().out
    assert main([*words, "--sigma", "1e-3"]) == 2
    assert "leave out --sigma" in capsys.readouterr().err


def test_picture_is_over_speed_and_torque_as_engineers_have_them(example, tmp_path, monkeypatch):
    from beltsim import plots

    drawn = []
    monkeypatch.setattr(plots, "save_figure", lambda figure, path: drawn.append(figure) or path)
    words = ["--rpm", "1000:4000:3", "--friction-torque-N-m", "0,2,4,6,8,10,inf"]
    assert main(["sweep", example, *words, "--functions", "2", "--out", str(tmp_path)]) == 0
    (figure,) = drawn
    lowest = figure.axes[-1]
    assert lowest.get_xlabel() == "crank speed (rpm)"
    assert lowest.get_xlim() == pytest.approx((1000.0, 4000.0))
    entries = {
        text.get_text(): handle.get_color()
        for text, handle in zip(
            figure.legends[0].get_texts(), figure.legends[0].get_lines(), strict=True
        )
    }
    torques = ["0 N m", "2 N m", "4 N m", "6 N m", "8 N m", "10 N m", "locked arm"]
    assert [name for name in entries if name in torques] == torques
    assert len({entries[name] for name in torques}) == len(torques)  # no colour twice


def test_speeds_about_that_of_the_file_by_default(example, tmp_path):
    words = ["--Q-m", "inf", "--functions", "2", "--no-plot", "--out", str(tmp_path)]
    assert main(["sweep", example, *words]) == 0
    drive, rpm = beltsim.load_drive(example), swept(tmp_path).crank_speed.values
    own = drive.rpm(drive.Omega)
    assert len(rpm) == 60
    assert (rpm[0], rpm[-1]) == pytest.approx((0.2 * own, 1.5 * own))


def test_points_without_solution_are_listed(example, tmp_path, capsys):
    """A belt at Omega = 60 is faster than its critical speed."""
    words = ["sweep", example, "--omega", "6:60:2", "--out", str(tmp_path), *QUICK]
    assert main(words) == 0
    assert "critical speed" in capsys.readouterr().err
    assert main([*words, "--strict"]) == 1


def test_every_mistake_is_told_at_once(example, tmp_path, capsys):
    words = ["--rpm", "3000:600:1", "--Q-m", "-1", "--sigma", "-1", "--out", str(tmp_path)]
    assert main(["sweep", example, *words, *QUICK]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert ["--rpm" in lines[0], "--Q-m" in lines[1], "sigma" in lines[2]] == [True] * 3
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [["--rpm", "600:6000"], ["--omega", "a:b:3"]])
def test_ranges_that_cannot_be_read(example, words, capsys):
    assert main(["sweep", example, *words]) == 2
    assert "sweep --help" in capsys.readouterr().err
