"""`beltsim events`: the study of one operating point over its friction torque."""

from __future__ import annotations

import re

import numpy as np
import pytest
import xarray as xr

import beltsim
from beltsim.cli import main
from beltsim.friction import Coulomb
from beltsim.metrics.phase_pattern import phase_pattern

QUICK = ["--functions", "3", "--omega", "6.3", "--count", "9"]


@pytest.fixture(scope="module")
def study(example, tmp_path_factory):
    import contextlib
    import io

    folder, said = tmp_path_factory.mktemp("events"), io.StringIO()
    with contextlib.redirect_stdout(said):
        status = main(["events", example, "--out", str(folder), *QUICK])
    assert status == 0
    return folder, said.getvalue()


def test_table_tells_slip_from_stick(study):
    _, text = study
    rows = [
        line.split() for line in text.splitlines() if re.match(r"^  [\d.]+ +[\d.]+ +[+0-]", line)
    ]
    assert len(rows) == 9
    assert "0" not in rows[0][2]
    assert rows[-1][2] == "0"
    assert rows[-1][6] == "100.0%"


def test_dataset_and_picture(study, example):
    folder, text = study
    stem = "zhu_parker_2008-events"
    assert (folder / f"{stem}.png").stat().st_size > 10_000
    assert str(folder / f"{stem}.nc") in text
    with xr.open_dataset(folder / f"{stem}.nc", engine="h5netcdf") as data:
        assert data.sizes["Q_m"] == 9
        assert float(data.period_residual.max()) <= 1e-12
        assert (np.abs(data.multiplier) <= 1.0 + 1e-9).all()
        Q = float(data.Q_m[3])
        drive = beltsim.load_drive(example)
        problem = beltsim.assemble(drive, 6.3, friction=Coulomb(Q), n_functions=3)
        orbit = beltsim.event_map.periodic(problem)
        assert float(data.dissipated_energy[3]) == pytest.approx(orbit.dissipated_energy, rel=1e-9)
        assert int((data.event_kind[3] >= 0).sum()) == len(orbit.events)
        assert len(phase_pattern(orbit)) == len(orbit.events)


def test_losses_are_in_joule(study):
    folder, text = study
    titles, *rows = [
        line.split() for line in text.splitlines() if re.match(r"^  (Q_m|[\d.]+) ", line)
    ]
    assert titles[-3:-1] == ["loss", "J"]
    with xr.open_dataset(folder / "zhu_parker_2008-events.nc", engine="h5netcdf") as data:
        factor = float(data.friction_torque[3] / data.Q_m[3])
        joule = data.dissipated_energy.values * factor
    assert [float(row[-2]) for row in rows] == pytest.approx(joule, rel=1e-3)


def test_a_crank_that_turns_evenly_has_no_range(drive_file, tmp_path, capsys):
    file = drive_file(excitation={"firing_order": 3, "speed_fluctuation": 0.0})
    words = ["events", file, "--functions", "2", "--out", str(tmp_path / "out"), "--no-plot"]
    assert main(words) == 2
    assert "nothing moves the arm" in capsys.readouterr().err
    assert main([*words, "--to", "1", "--count", "2"]) == 0


def test_bad_ranges_are_told_at_once(example, tmp_path, capsys):
    words = ["--from", "-1", "--to", "nan", "--count", "1", "--max-multiple", "0"]
    assert main(["events", example, "--out", str(tmp_path), *words]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [line.split()[1] for line in lines] == ["--from", "--to", "--count", "--max-multiple"]
    assert not list(tmp_path.iterdir())


def test_range_must_rise(example, tmp_path, capsys):
    words = ["--from", "5", "--to", "2", "--functions", "3"]
    assert main(["events", example, "--out", str(tmp_path), *words]) == 2
    assert "above --from" in capsys.readouterr().err


def test_failed_orbits_are_listed(example, tmp_path, capsys, monkeypatch):
    from beltsim.errors import NotPeriodicError
    from beltsim.event_map import solve_many

    def spoiled(problems, settings):
        found = solve_many(problems, settings)
        found[1] = NotPeriodicError("nothing found")
        return found

    monkeypatch.setattr("beltsim.event_map.solve_many", spoiled)
    words = ["events", example, "--out", str(tmp_path), *QUICK, "--no-plot"]
    assert main(words) == 1
    said = capsys.readouterr()
    assert "failed" in said.out
    assert "nothing found" in said.err
    with xr.open_dataset(tmp_path / "zhu_parker_2008-events.nc", engine="h5netcdf") as data:
        assert np.isnan(data.stick_fraction.values).sum() == 1
        assert data.failure.values[1] == "nothing found"


def exactness(text):
    found = re.search(r"exact map\n +events +(.+)\n +end state +within (\S+) of", text)
    assert found
    return found[1], float(found[2])


@pytest.mark.parametrize("periods", ["20", "17.37"])
def test_run_says_how_far_its_last_period_is_from_exact(example, tmp_path, capsys, periods):
    words = ["--periods", periods, "--functions", "3", "--Q-m", "3.5", "--no-plot"]
    assert main(["run", example, "--out", str(tmp_path), *words]) == 0
    events, gap = exactness(capsys.readouterr().out)
    assert events.startswith("the same, times within")
    assert 0.0 < gap < 1e-6


def test_a_run_that_lost_an_event_is_told(monkeypatch):
    from support.responses import stick_slip

    from beltsim.cli.exactness import exactness_lines

    lines = "\n".join(exactness_lines(stick_slip()))
    assert "differ" in lines


def test_both_frequencies_are_named_in_the_dataset(study):
    with xr.open_dataset(study[0] / "zhu_parker_2008-events.nc", engine="h5netcdf") as data:
        assert data.attrs["Omega"] == pytest.approx(6.3)
        assert "fundamental" in data.attrs["Omega_long_name"]
        assert data.attrs["firing_frequency"] == pytest.approx(6.3)
        assert data.attrs["crank_speed_rpm"] == pytest.approx(3089.3, abs=0.1)


@pytest.mark.parametrize("verb", ["run", "plot", "modes"])
def test_its_dataset_is_no_motion(study, verb, capsys):
    assert main([verb, str(study[0] / "zhu_parker_2008-events.nc")]) == 2
    error = capsys.readouterr().err
    assert "a table of beltsim (periodic motions over the friction torque)" in error
    assert "holds no motion" in error
    assert error.count("\n") == 1


def test_unstable_and_coexisting_orbits_are_told_with_their_torques(example, tmp_path, capsys):
    words = ["--functions", "3", "--omega", "6.3", "--no-plot", "--out", str(tmp_path)]
    static = ["--Q-m", "1", "--Q-s", "6", "--from", "1", "--to", "2.5", "--count", "4"]
    main(["events", example, *words, *static])
    said = capsys.readouterr().out
    assert re.search(r"at \d of 3 torques, Q_m = .*, the orbit is unstable", said)
    assert re.search(r"at \d of 3 torques, Q_m = .*, the arm is shown locked but may move", said)
    assert "Q_s = 6 Q_m throughout, the ratio given" in said
    warned = said.split("Warnings")[1].splitlines()
    assert len(warned) == len({*warned} - {""}) + warned.count("")
