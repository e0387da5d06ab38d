"""The paper's drive as a file, a short run of it, and a way to change the file."""

from pathlib import Path

import pytest

from beltsim.cli import main
from beltsim.drive import presets

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "zhu_parker_2008.toml"
QUICK = ["--functions", "3", "--Q-m", "3.5"]


@pytest.fixture(scope="session")
def example():
    return str(EXAMPLE)


@pytest.fixture(scope="session")
def short_run(tmp_path_factory):
    """Folder and printed text of a run of twenty periods with pictures."""
    import contextlib
    import io

    folder = tmp_path_factory.mktemp("run")
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        status = main(
            ["run", str(EXAMPLE), "--out", str(folder / "out"), "--periods", "20", *QUICK]
        )
    assert status == 0
    return folder / "out", printed.getvalue()


@pytest.fixture
def drive_file(tmp_path):
    """Write the paper's drive with some tables changed; the file's name."""

    def write(**tables):
        file = tmp_path / "drive.toml"
        file.write_text(presets.zhu_parker_2008().changed(**tables).to_toml())
        return str(file)

    return write
