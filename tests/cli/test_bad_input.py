"""Bad input: exit status 2, one line per mistake on standard error, nothing computed or written."""

import json
import os
import time

import pytest

from beltsim.cli import main
from beltsim.drive import presets
from beltsim.io import save


def refused(capsys, *words):
    """Lines of complaint of a command that must be refused."""
    status = main(list(words))
    said = capsys.readouterr()
    assert status == 2, said.err
    assert said.out == ""
    lines = said.err.splitlines()
    assert lines
    assert all(line.startswith("beltsim: ") for line in lines), said.err
    return [line.removeprefix("beltsim: ") for line in lines]


@pytest.mark.parametrize(
    ("option", "hint"),
    [
        ("--friction", "; did you mean --friction-torque-N-m?"),
        ("--perriods", "; did you mean --periods?"),
        ("--speed", ""),
    ],
)
def test_an_unknown_option_is_answered_by_its_verb(capsys, option, hint):
    (line,) = refused(capsys, "run", "drive.toml", option, "3")
    assert line == f"unrecognized arguments: {option} 3{hint} (see beltsim run --help)"


@pytest.fixture
def text():
    return presets.zhu_parker_2008().to_toml()


@pytest.fixture
def no_run(monkeypatch):
    """Fail when anything is integrated."""

    def forbidden(*_, **__):
        raise AssertionError("the integration was started")

    monkeypatch.setattr("beltsim.cli.run.integrate", forbidden)


BAD_OPTIONS = {
    "--Q-m=-1": "--Q-m = -1.0",
    "--Q-m=nan": "--Q-m = nan",
    "--friction-torque-N-m=inf": "--friction-torque-N-m = inf",
    "--Q-s=0.1": "--Q-s = 0.1",
    "--omega=0": "--omega = 0.0",
    "--omega=-3": "--omega = -3.0",
    "--rpm=nan": "--rpm = nan",
    "--functions=0": "--functions = 0",
    "--functions=4,5": "--functions = ",
    "--periods=0": "--periods = 0.0",
    "--periods=inf": "--periods = inf",
    "--rtol=0.5": "--rtol = 0.5",
    "--samples=0": "--samples = 0",
    "--max-seconds=-1": "--max-seconds = -1.0",
}


@pytest.mark.parametrize("option", BAD_OPTIONS)
def test_an_option_that_cannot_be(option, example, tmp_path, capsys, no_run):
    lines = refused(capsys, "run", example, option, "--out", str(tmp_path / "out"))
    assert len(lines) == 1
    assert lines[0].startswith(BAD_OPTIONS[option])
    assert "must be" in lines[0]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        ["--rpm", "fast"],
        ["--samples", "1.5"],
        ["--functions", "4;5"],
        ["--method", "euler"],
        ["--rpm", "800", "--omega", "3"],
        ["--Q-m", "1", "--friction-torque-N-m", "3"],
        ["--perods", "3"],
        ["--rpm"],
    ],
)
def test_a_word_that_cannot_be_read(words, example, capsys, no_run):
    (line,) = refused(capsys, "run", example, *words)
    assert words[0] in line
    assert "(see beltsim" in line


def test_every_mistake_is_told_at_once(tmp_path, text, capsys, no_run):
    file = tmp_path / "drive.toml"
    file.write_text(text.replace("radius_m = 0.0452", "radius_m = -1.0") + "\nspeed = 3\n")
    blocker = tmp_path / "file"
    blocker.write_text("")
    out = str(blocker / "out")
    lines = refused(
        capsys, "run", str(file), "--rtol", "7", "--periods", "-1", "--out", out, "--Q-m=-1"
    )
    said = "\n".join(lines)
    for word in ("pulleys[1].radius_m = -1.0", "speed", "--rtol", "--periods", "file/out"):
        assert word in said
    assert len(lines) == 5


def test_options_and_model_are_told_together(example, capsys, no_run):
    lines = refused(capsys, "run", example, "--Q-m=-1", "--functions=0")
    assert len(lines) == 2


def drive_with(text, old, new):
    assert old in text
    return text.replace(old, new)


BAD_FILES = {
    "empty": lambda text: "",
    "not toml": lambda text: "name = = 3",
    "binary": lambda text: "\x00\x01\x02",
    "unknown key": lambda text: drive_with(text, "EA_N =", "EA = 3.0\nEA_N ="),
    "wrong type": lambda text: drive_with(text, "ratio = 0.05", 'ratio = "much"'),
    "not finite": lambda text: drive_with(text, "EA_N = 120000.0", "EA_N = nan"),
    "static below kinetic": lambda text: drive_with(
        text, "friction_torque_N_m =", "static_friction_torque_N_m = 0.01\nfriction_torque_N_m ="
    ),
    "overlap": lambda text: drive_with(text, "0.0452", "0.3"),
    "Omega <= 0": lambda text: drive_with(text, "Omega = 6.3", "Omega = 0.0"),
}


@pytest.mark.parametrize("verb", ["modes", "run", "plot"])
@pytest.mark.parametrize("name", BAD_FILES)
def test_a_bad_drive_file(verb, name, tmp_path, text, capsys, no_run):
    file = tmp_path / "drive.toml"
    file.write_text(BAD_FILES[name](text))
    out = [] if verb == "modes" else ["--out", str(tmp_path / "out")]
    refused(capsys, verb, str(file), *out)
    assert not (tmp_path / "out").exists()


def test_json_with_a_mistake(tmp_path, capsys):
    tables = presets.zhu_parker_2008().model_dump(exclude_none=True)
    tables["belt"]["EA_N"] = -1.0
    file = tmp_path / "drive.json"
    file.write_text(json.dumps(tables))
    (line,) = refused(capsys, "modes", str(file))
    assert line.startswith("belt.EA_N = -1.0: must be")


@pytest.mark.parametrize("name", ["big.toml", "big.json", "big.nc"])
def test_a_file_of_one_gigabyte_is_refused_unread(name, tmp_path, capsys):
    file = tmp_path / name
    with file.open("wb") as stream:
        os.truncate(stream.fileno(), 2**30)
    start = time.process_time()
    (line,) = refused(capsys, "run", str(file), "--out", str(tmp_path))
    assert time.process_time() - start < 0.5
    assert "1073741824 bytes" in line


def test_a_slack_belt_is_named(drive_file, capsys, no_run):
    (line,) = refused(capsys, "run", drive_file(), "--rpm", "99000")
    assert "span 1" in line
    assert "faster than its critical speed" in line


@pytest.mark.parametrize("verb", ["run", "plot"])
def test_an_unwritable_folder_is_found_before_computing(verb, example, tmp_path, capsys, no_run):
    blocker = tmp_path / "file"
    blocker.write_text("")
    (line,) = refused(capsys, verb, example, "--out", str(blocker / "deep" / "out"))
    assert "cannot be written to" in line


def test_results_that_cannot_be_used(short_run, tmp_path, capsys, no_run):
    whole = (short_run[0] / "zhu_parker_2008.nc").read_bytes()
    cut = tmp_path / "cut.nc"
    cut.write_bytes(whole[: len(whole) // 2])
    for verb in ("run", "plot", "modes"):
        (line,) = refused(capsys, verb, str(cut))
        assert "cut short or damaged" in line
    from support import responses

    bare = save(responses.stick_slip(), tmp_path / "bare.nc")
    (line,) = refused(capsys, "run", str(bare))
    assert "holds no drive file" in line


def test_folders_and_missing_files(tmp_path, capsys):
    assert "no such file" in refused(capsys, "run", str(tmp_path / "x.toml"))[0]
    assert "a folder" in refused(capsys, "modes", str(tmp_path))[0]
    assert "VERB" in refused(capsys)[0]


def test_count_must_be_positive(example, capsys):
    (line,) = refused(capsys, "modes", example, "--count", "0")
    assert line.startswith("--count = 0")
