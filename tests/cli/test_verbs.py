"""The verbs beside `run`: modes, plot, init, schema, validate."""

import json
import re
import tomllib

import numpy as np
import pytest
from support import responses

import beltsim
from beltsim.cli import main, validate
from beltsim.drive import template
from beltsim.io import save


def printed(capsys, *words):
    assert main(list(words)) == 0
    said = capsys.readouterr()
    assert said.err == ""
    return said.out


def test_modes_prints_the_survey(example, capsys):
    text = printed(capsys, "modes", example, "--omega", "2.8", "--count", "7")
    drive = beltsim.load_drive(example)
    found = beltsim.metrics.survey(drive, 2.8)
    for span in found.spans:
        assert re.search(rf"{re.escape(span.name)}.* {span.tension_N:.1f} ", text)
    for pulley in found.pulleys:
        row = rf"^  {pulley.name} +{pulley.wrap_deg:.1f} +{pulley.hub_load_N:.1f} "
        assert re.search(row, text, re.MULTILINE)
    for k in range(7):
        row = (
            rf"^  {k + 1} +{found.free[k].frequency_Hz:.2f} .* {found.locked[k].frequency_Hz:.2f} "
        )
        assert re.search(row, text, re.MULTILINE)
    assert f"Q_cr = {found.Q_cr:.4g}" in text
    assert f"{np.degrees(found.arm_angle_rad):+.3f} deg" in text
    assert f"{found.belt_speed_m_s:.2f} m/s" in text
    assert len(re.findall(r"^  \d+ +\d+\.\d\d ", text, re.MULTILINE)) == 7


def test_modes_of_a_stored_run_takes_its_arguments(short_run, capsys):
    text = printed(capsys, "modes", str(short_run[0] / "zhu_parker_2008.nc"))
    assert "Q_m = 3.5" in text


def test_modes_shows_a_static_torque_only_where_it_is_larger(example, capsys):
    assert "Q_s" not in printed(capsys, "modes", example)
    assert "(Q_s = 2)" in printed(capsys, "modes", example, "--Q-m", "1", "--Q-s", "2")


def test_modes_fit_a_narrow_terminal(example, capsys):
    text = printed(capsys, "modes", example)
    assert max(map(len, text.split("Warnings")[0].splitlines())) <= 80


def test_plot_of_a_drive_draws_the_layout(example, tmp_path, capsys):
    text = printed(capsys, "plot", example, "--out", str(tmp_path), "--format", "svg")
    (file,) = tmp_path.iterdir()
    assert file.name == "zhu_parker_2008-layout.svg"
    assert str(file) in text
    assert b"<svg" in file.read_bytes()


def test_plot_of_a_result_draws_everything(short_run, tmp_path, capsys):
    printed(capsys, "plot", str(short_run[0] / "zhu_parker_2008.nc"), "--out", str(tmp_path))
    names = sorted(file.name for file in tmp_path.iterdir())
    assert names == [f"zhu_parker_2008-{what}.png" for what in ("arm", "layout", "tensions")]
    for name in names:  # the same pictures as the run drew
        assert (tmp_path / name).read_bytes() == (short_run[0] / name).read_bytes()


def test_plot_of_a_result_without_a_drive(tmp_path, capsys):
    file = save(responses.stick_slip(), tmp_path / "own.nc")
    printed(capsys, "plot", str(file), "--out", str(tmp_path / "out"))
    assert sorted(one.name for one in (tmp_path / "out").iterdir()) == [
        "own-arm.png",
        "own-tensions.png",
    ]
    nothing = save(responses.bare(), tmp_path / "bare.nc")
    assert main(["plot", str(nothing), "--out", str(tmp_path / "out")]) == 2
    assert "nothing to draw" in capsys.readouterr().err


def test_init_writes_a_file_that_loads(tmp_path, capsys):
    file = tmp_path / "mine.toml"
    assert str(file) in printed(capsys, "init", str(file))
    assert file.read_text() == template()
    assert beltsim.load_drive(file).pulleys
    assert printed(capsys, "modes", str(file))


def test_init_replaces_nothing_unasked(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "drive.toml"
    file.write_text("mine")
    assert main(["init"]) == 2
    assert "--force" in capsys.readouterr().err
    assert file.read_text() == "mine"
    printed(capsys, "init", "--force")
    assert file.read_text() == template()
    assert main(["init", str(tmp_path)]) == 2
    assert main(["init", str(file / "below.toml")]) == 2


def test_init_to_standard_output(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert printed(capsys, "init", "-") == template()
    assert tomllib.loads(template())
    assert list(tmp_path.iterdir()) == []


def test_schema_is_json(capsys):
    schema = json.loads(printed(capsys, "schema"))
    assert "pulleys" in schema["properties"]


def test_help_lists_what_exists(capsys):
    text = printed(capsys, "--help")
    for verb in ["modes", "run", "hb", "events", "sweep", "validate", "plot", "init", "schema"]:
        assert re.search(rf"^ +{verb} ", text, re.MULTILINE)
    assert not re.search("^ +report ", text, re.MULTILINE)
    assert beltsim.__version__ in printed(capsys, "--version")


def test_validate_hands_on_its_words(monkeypatch, capsys):
    import validation.run

    seen = []
    monkeypatch.setattr(validation.run, "main", lambda words: seen.append(words) or 1)
    assert main(["validate", "one", "--full"]) == 1
    assert seen == [["one", "--full"]]
    monkeypatch.undo()
    assert main(["validate", "--list"]) == 0
    assert "zhu_parker_2008" in capsys.readouterr().out
    assert main(["validate", "no-such-case"]) == 2


def test_validate_of_a_file_names_the_option(capsys, example):
    assert main(["validate", example]) == 2
    assert capsys.readouterr().err == (
        f"beltsim: {example} is no case; for a drive of your own: "
        f"beltsim validate --drive {example}\n"
    )


def test_validate_outside_a_source_tree(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(validate, "__file__", str(tmp_path / "site" / "beltsim" / "cli" / "v.py"))
    assert main(["validate"]) == 2
    assert "clone of the repository" in capsys.readouterr().err


@pytest.mark.parametrize("stop", [KeyboardInterrupt(), KeyboardInterrupt("after 3 cases")])
def test_ctrl_c_anywhere_is_130(stop, monkeypatch, capsys, example):
    def interrupted(_):
        raise stop

    monkeypatch.setattr("beltsim.cli.modes.read_source", interrupted)
    assert main(["modes", example]) == 130
    assert capsys.readouterr().err == f"beltsim: {str(stop) or 'interrupted'}\n"


def test_modes_prints_the_excitation_and_which_order_meets_which_mode(capsys, drive_file):
    orders = [{"order": 3, "speed_fluctuation": 0.04}, {"order": 6, "angle_amplitude_deg": 0.1}]
    file = drive_file(excitation={"speed_fluctuation": None, "orders": orders})
    assert main(["modes", file, "--functions", "4"]) == 0
    printed = capsys.readouterr().out
    assert "excitation      order 3: 4 % of speed (0.764 deg)" in printed
    assert "\n                  order 6: 1.05 % of speed (0.1 deg)" in printed
    assert "spring torque  19.38 N m (wound up by 39.9 deg" in printed
    near = [line.split() for line in printed.partition("Near resonance")[2].splitlines()[2:]]
    assert near[0][:6] == ["order", "3", "154.46", "7", "free", "153.01"]
    assert {row[1] for row in near} == {"3", "6"}
    assert "default" not in printed


def test_modes_says_when_the_excitation_is_the_default(capsys, drive_file):
    from pathlib import Path

    file = Path(drive_file())
    text = file.read_text()
    start, end = text.index("[excitation]"), text.index("[overrides]")
    file.write_text(text[:start] + text[end:])
    assert main(["modes", str(file), "--functions", "4", "--rpm", "500"]) == 0
    printed = capsys.readouterr().out
    assert "order 3: 10 % of speed (1.91 deg) (default: the file gives none)" in printed
    assert "Near resonance" not in printed


def test_long_names_do_not_spoil_the_tables(capsys, drive_file):
    from beltsim.drive.presets import zhu_parker_2008

    pulleys = [pulley.model_dump() for pulley in zhu_parker_2008().pulleys]
    pulleys[2]["name"] = "Water pump of the second engine, rear side, 55 mm pitch"
    assert main(["modes", drive_file(pulleys=pulleys), "--functions", "4"]) == 0
    printed = capsys.readouterr().out
    assert "span 3 (Water pump...pitch - 1)" in printed
    assert max(map(len, printed.splitlines())) < 100
