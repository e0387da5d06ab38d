"""Files appear whole or not at all; broken, foreign and newer files are refused by name."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import h5netcdf
import numpy as np
import pytest
from support import responses

from beltsim.dataset import SCHEMA_VERSION
from beltsim.errors import ResultFileError
from beltsim.io import load, require_writable, save, stored_inputs, whole_file


@pytest.fixture
def result(tmp_path):
    return save(responses.stick_slip(), tmp_path / "result.nc", {"a": 1})


def test_nothing_but_the_file_is_left(result):
    assert [file.name for file in result.parent.iterdir()] == ["result.nc"]
    umask = os.umask(0)
    os.umask(umask)
    assert result.stat().st_mode & 0o777 == 0o666 & ~umask


@pytest.mark.parametrize("stop", [KeyboardInterrupt(), OSError(28, "No space left on device")])
def test_an_interrupted_write_leaves_the_old_file(result, stop, monkeypatch):
    before = result.read_bytes()

    def fails(path, content):
        with path.open("wb") as file:
            file.write(content[:100])
        raise stop

    monkeypatch.setattr(Path, "write_bytes", fails)
    expected = ResultFileError if isinstance(stop, OSError) else KeyboardInterrupt
    with pytest.raises(expected):
        save(responses.stick_slip(), result)
    assert result.read_bytes() == before
    assert [file.name for file in result.parent.iterdir()] == ["result.nc"]


def test_a_full_disk_leaves_nothing(tmp_path):
    """The kernel refuses to let the file grow, in a process of its own."""
    code = """
    import resource, signal, sys
    sys.path[:0] = sys.argv[2:]
    from support import responses
    from beltsim.errors import ResultFileError
    from beltsim.io import save
    made = responses.stick_slip(periods=40)
    made.to_xarray()
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
    try:
        save(made, sys.argv[1] + "/result.nc")
    except ResultFileError as error:
        print("refused:", error)
    """
    paths = [path for path in sys.path if path]
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code), str(tmp_path), *paths],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert "refused: cannot write" in run.stdout, run.stderr
    assert run.returncode == 0, run.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_folder_below_a_file_is_refused(tmp_path):
    blocker = tmp_path / "file"
    blocker.write_text("")
    with pytest.raises(ResultFileError, match=r"output folder .*file/out cannot be written to"):
        require_writable(blocker / "out")
    with pytest.raises(ResultFileError, match=r"cannot write .*file/out/r\.nc: Not a directory"):
        save(responses.bare(), blocker / "out" / "r.nc")


def test_a_missing_folder_is_tried_and_leaves_no_trace(tmp_path):
    assert require_writable(tmp_path / "a" / "b") == tmp_path / "a" / "b"
    require_writable(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_whole_file_replaces(tmp_path):
    target = tmp_path / "x.txt"
    target.write_text("old")
    with whole_file(target) as temporary:
        temporary.write_text("new")
        assert target.read_text() == "old"
    assert target.read_text() == "new"


@pytest.mark.parametrize("share", [0.0, 0.002, 0.1, 0.5, 0.9, 0.999])
@pytest.mark.parametrize("read", [load, stored_inputs])
def test_a_file_cut_short_is_refused(result, share, read):
    whole = result.read_bytes()
    result.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(ResultFileError, match=r"no result file|cut short or damaged"):
        read(result)


def test_scrambled_bytes_never_escape_as_another_error(result):
    """Damage may go unseen inside an array of numbers, but what is seen is named."""
    whole = np.frombuffer(result.read_bytes(), np.uint8)
    random = np.random.default_rng(3)
    refused = 0
    for _ in range(40):
        broken = whole.copy()
        places = random.integers(8, len(whole), 200)
        broken[places] = random.integers(0, 256, 200)
        result.write_bytes(broken.tobytes())
        try:
            load(result)
        except ResultFileError:
            refused += 1
    assert refused > 10


@pytest.mark.parametrize("read", [load, stored_inputs])
def test_foreign_files_are_refused(tmp_path, read):
    with pytest.raises(ResultFileError, match="no such file"):
        read(tmp_path / "missing.nc")
    with pytest.raises(ResultFileError, match="is no result file"):
        read(tmp_path)
    os.mkfifo(tmp_path / "pipe.nc")
    with pytest.raises(ResultFileError, match="is no result file"):
        read(tmp_path / "pipe.nc")
    text = tmp_path / "drive.toml"
    text.write_text("name = 'x'")
    with pytest.raises(ResultFileError, match="is no result file: it is not netCDF"):
        read(text)
    foreign = tmp_path / "foreign.nc"
    with h5netcdf.File(foreign, "w") as file:
        file.attrs["title"] = "rain"
    with pytest.raises(ResultFileError, match="not written by beltsim"):
        read(foreign)


def test_a_newer_layout_is_refused(result):
    with h5netcdf.File(result, "a") as file:
        file.attrs["schema_version"] = SCHEMA_VERSION + 1
        file.attrs["beltsim_version"] = "9.9"
    with pytest.raises(ResultFileError, match=r"layout 2, written by beltsim 9\.9; .*up to 1"):
        load(result)


@pytest.mark.parametrize(
    ("name", "value"),
    [("schema_version", "two"), ("friction_law", "Stribeck"), ("warnings", "not json")],
)
def test_a_changed_attribute_is_refused(result, name, value):
    with h5netcdf.File(result, "a") as file:
        file.attrs[name] = value
    with pytest.raises(ResultFileError, match="damaged"):
        load(result)


@pytest.mark.parametrize(("name", "value"), [("M", -1.0), ("event_kind", 9), ("event_kind", -1)])
def test_a_changed_number_is_refused_where_it_cannot_be(result, name, value):
    with h5netcdf.File(result, "a") as file:
        file[name][...] = np.full_like(file[name][...], value)
    with pytest.raises(ResultFileError, match="damaged"):
        load(result)


def test_a_missing_variable_is_named(result):
    with h5netcdf.File(result, "a") as file:
        del file._h5group["K"]
    with pytest.raises(ResultFileError, match=r"damaged.*K"):
        load(result)
