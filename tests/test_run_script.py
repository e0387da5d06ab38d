"""The script `run`: its verbs, its one-line failures, and when it sets up again.

The script runs in a small copy of the tree, with a PATH of nothing but the tools it may expect on
a bare Debian, and stand-ins for apt-get, sudo, dpkg-query and Python that write down their calls.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

import beltsim

ROOT = Path(__file__).parent.parent
PACKAGES = "libsundials-dev gcc libc6-dev"
#: All that the script takes from an essential Debian, besides the shell itself.
TOOLS = """cat chown cksum date dirname env find flock grep id mkdir mv readlink rm sed sort stat
tail tee true"""

#: Plays Python: answers the script's questions, "makes" an environment, "installs" into it.
PYTHON = """#!/bin/sh
case "$*" in
  *"-m venv .venv") mkdir -p .venv/bin; cat "$0" >.venv/bin/python; chmod +x .venv/bin/python
    printf '#!/bin/sh\\necho beltsim "$@"\\n' >.venv/bin/beltsim; chmod +x .venv/bin/beltsim ;;
  *"-m pip --version"*) ;;
  *"-m pip install"*) [ ! -e pip-fails ] || { cat pip-fails; exit 1; } ;;
  *"-m pytest"*) ;;
  *ensurepip*) echo "$0"; exit ;;
  *base_prefix*) echo "3 11 /usr"; exit ;;
  *) exit 1 ;;
esac
echo "$*" >>calls
"""


@pytest.fixture
def tree(tmp_path):
    """A copy of what the script looks at, in a folder with a space, and a PATH of its own."""
    root = tmp_path / "a tree"
    (root / "csrc").mkdir(parents=True)
    (root / "csrc" / "core.c").write_text("int one;\n")
    (root / "CMakeLists.txt").write_text("\n")
    for name in ("run", "pyproject.toml"):
        shutil.copy(ROOT / name, root / name)
    path = tmp_path / "bin"
    path.mkdir()
    for tool in [*TOOLS.split(), "chmod"]:
        found = shutil.which(tool)
        assert found, f"{tool} is part of every Debian"
        (path / tool).symlink_to(found)
    command(path / "python", PYTHON)
    return root


def command(path: Path, text: str) -> None:
    path.unlink(missing_ok=True)
    path.write_text(text)
    path.chmod(0o755)


def run(tree: Path, *arguments: str, cwd: Path | None = None, **environment: str):
    """The script's result; by default with the stand-in for Python and no look at the system."""
    path = tree.parent / "bin"
    settings = {"PATH": str(path), "PYTHON": str(path / "python"), "BELTSIM_SKIP_SYSTEM": "1"}
    return subprocess.run(
        [str(tree / "run"), *arguments],
        env=settings | environment,
        cwd=cwd or tree,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def calls(tree: Path) -> list[str]:
    """What Python was asked to do since the last time."""
    path = tree / "calls"
    lines = path.read_text().splitlines() if path.exists() else []
    path.unlink(missing_ok=True)
    return lines


MAKES = "-m venv .venv"
INSTALLS = "-m pip install -e ."
INSTALLS_TESTS = "-m pip install -e .[test]"


@pytest.mark.parametrize("script", ["run", ".ci/run"])
def test_is_sound_shell_and_executable(script):
    subprocess.run(["sh", "-n", str(ROOT / script)], check=True)
    assert os.access(ROOT / script, os.X_OK)


@pytest.mark.parametrize("arguments", [(), ("jobs",), ("--job",)])
def test_an_unknown_verb_is_refused_with_the_usage(tree, arguments):
    result = run(tree, *arguments)
    assert result.returncode == 2
    assert "usage: ./run job" in result.stderr
    assert result.stdout == ""
    assert not (tree / ".venv").exists()


def test_help_is_no_failure(tree):
    result = run(tree, "--help")
    assert result.returncode == 0
    assert "BELTSIM_SKIP_SYSTEM" in result.stdout


# --- the system ---------------------------------------------------------------------------------


def with_system(tree: Path, uid: int, **fakes: str):
    """`./run job` as user `uid` where no package is installed, with `fakes` as more commands."""
    path = tree.parent / "bin"
    command(path / "dpkg-query", "#!/bin/sh\nexit 1\n")
    command(path / "id", f"#!/bin/sh\necho {uid}\n")
    for name, text in fakes.items():
        command(path / name.replace("_", "-"), f"#!/bin/sh\n{text}\n")
    return run(tree, "job", BELTSIM_SKIP_SYSTEM="0")


def one_line(result: subprocess.CompletedProcess[str]) -> str:
    assert result.returncode == 1
    lines = [line for line in result.stderr.splitlines() if not line.endswith(" ...")]
    assert len(lines) == 1, result.stderr
    return lines[0]


def test_no_apt_get(tree):
    assert one_line(with_system(tree, 0)) == (
        f"run: missing Debian packages and no apt-get to install them: {PACKAGES}"
    )


def test_no_sudo(tree):
    line = one_line(with_system(tree, 1000, apt_get="echo >reached"))
    assert line.endswith(f"as root, run: apt-get install -y --no-install-recommends {PACKAGES}")
    assert not (tree / "reached").exists()


def test_sudo_refused(tree):
    line = one_line(
        with_system(tree, 1000, apt_get="echo >reached", sudo='[ "$*" = "-n true" ]; exit 1')
    )
    assert "sudo was refused" in line
    assert line.endswith(f"run: sudo apt-get install -y --no-install-recommends {PACKAGES}")
    assert not (tree / "reached").exists()


def test_apt_get_fails(tree):
    result = with_system(tree, 0, apt_get='echo "no space left: $*"; exit 100')
    assert result.returncode == 1
    assert "no space left: -o" in result.stderr, "the end of the log is shown"
    assert result.stderr.splitlines()[-1].startswith("run: apt-get failed")


def test_sudo_is_used_without_a_password_and_only_what_is_missing_is_asked_for(tree):
    result = with_system(
        tree,
        1000,
        dpkg_query='case "$*" in *libc6-dev*) echo installed ;; *) echo not-installed ;; esac',
        sudo='[ "$1" = -n ] || exit 1; shift; exec "$@"',
        apt_get='echo "$DEBIAN_FRONTEND: $*" >>apt',
    )
    assert result.returncode == 0, result.stderr
    *_, install = (tree / "apt").read_text().splitlines()
    assert install.startswith("noninteractive: ")
    assert install.endswith("install -y --no-install-recommends libsundials-dev gcc")


# --- Python -------------------------------------------------------------------------------------


def test_python_too_old(tree):
    path = tree.parent / "bin" / "python3.9"
    pretend = (
        "import sys; sys.version_info = (3, 9, 2); "
        'sys.version = "3.9.2 (of old)"; exec(sys.argv[1])'
    )
    command(
        path,
        f"#!/bin/sh\nfor code; do :; done\nexec '{sys.executable}' -I -c '{pretend}' \"$code\"\n",
    )
    line = one_line(run(tree, "job", PYTHON=str(path)))
    assert re.search(r"Python >= 3\.11 needed, but .* is 3\.9\.2; .* PYTHON=", line)


def test_no_python(tree):
    line = one_line(run(tree, "job", PYTHON="/nowhere/python3"))
    assert "Python >= 3.11 needed, but there is no /nowhere/python3" in line


def test_no_sundials(tree):
    (tree / "pip-fails").write_text(missing_sundials(tree.parent))
    line = one_line(run(tree, "job"))
    assert "SUNDIALS" in line
    assert "apt-get install libsundials-dev" in line


def missing_sundials(folder: Path) -> str:
    """What CMake really says about it."""
    tools = Path(sys.executable).parent
    result = subprocess.run(
        [
            str(tools / "cmake"),
            "-S",
            str(ROOT),
            "-B",
            str(folder / "cmake"),
            "-GNinja",
            f"-DCMAKE_MAKE_PROGRAM={tools / 'ninja'}",
            "-DCMAKE_DISABLE_FIND_PACKAGE_SUNDIALS=ON",
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode != 0
    return result.stdout + result.stderr


def test_a_failing_build_shows_the_end_of_its_log(tree):
    (tree / "pip-fails").write_text("core.c:1: error: expected ';'\n")
    result = run(tree, "job")
    assert result.returncode == 1
    assert "core.c:1: error" in result.stderr
    assert result.stderr.splitlines()[-1].startswith("run: building and installing beltsim failed")


# --- when it sets up again ----------------------------------------------------------------------


def test_sets_up_once_and_passes_arguments_on(tree):
    first = run(tree, "job", "--out", "a b", cwd=Path("/"))
    assert first.returncode == 0, first.stderr
    assert first.stdout == "beltsim run examples/zhu_parker_2008.toml --out a b\n"
    assert calls(tree) == [MAKES, INSTALLS]

    again = run(tree, "job", "mine.toml", PYTHON="")
    assert again.stdout == "beltsim run mine.toml\n"
    assert again.stderr == ""
    assert calls(tree) == []

    run(tree, "test", "tests/drive", "-k", "x")
    assert calls(tree) == [INSTALLS_TESTS, "-m pytest tests/drive -k x"]
    run(tree, "job")
    assert calls(tree) == []


@pytest.mark.parametrize(
    "name", ["run", "pyproject.toml", "CMakeLists.txt", "csrc/core.c", "csrc/new.h"]
)
def test_builds_again_when_a_source_changes(tree, name):
    run(tree, "job")
    calls(tree)
    with (tree / name).open("a") as file:
        file.write("\n")
    run(tree, "job")
    assert calls(tree) == [INSTALLS]


def test_makes_a_half_made_environment_anew(tree):
    (tree / "pip-fails").write_text("interrupted\n")
    assert run(tree, "job").returncode == 1
    (tree / "pip-fails").unlink()
    calls(tree)
    assert run(tree, "job").returncode == 0
    assert calls(tree) == [MAKES, INSTALLS]


def test_makes_a_moved_environment_anew(tree):
    run(tree, "job")
    moved = tree.rename(tree.parent / "elsewhere")
    calls(moved)
    assert run(moved, "job").returncode == 0
    assert calls(moved) == [MAKES, INSTALLS]


def test_makes_the_environment_anew_when_its_python_is_gone(tree):
    run(tree, "job")
    calls(tree)
    (tree / ".venv" / "bin" / "python").unlink()
    (tree / ".venv" / "bin" / "python").symlink_to("/nowhere/python3")
    assert run(tree, "job").returncode == 0
    assert calls(tree) == [MAKES, INSTALLS]


def test_keeps_an_environment_made_by_hand(tree):
    run(tree, "job")
    (tree / ".venv" / "beltsim-stamp").unlink()
    calls(tree)
    assert run(tree, "job", PYTHON="").returncode == 0
    assert MAKES not in calls(tree)


def test_two_at_once_set_up_once(tree):
    command = [str(tree / "run"), "job"]
    path = tree.parent / "bin"
    environment = {"PATH": str(path), "PYTHON": str(path / "python"), "BELTSIM_SKIP_SYSTEM": "1"}
    both = [
        subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        for _ in "ab"
    ]
    outputs = [process.communicate(timeout=60) for process in both]
    assert [process.returncode for process in both] == [0, 0], outputs
    assert calls(tree) == [MAKES, INSTALLS]


# --- what is built ------------------------------------------------------------------------------


def test_extensions_are_built_for_the_stable_interface():
    from beltsim import _core

    built = [path.name for path in Path(_core.__file__).parent.glob("_*.so")]
    assert "_core.abi3.so" in built
    assert all(name.endswith(".abi3.so") for name in built), built


def test_one_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["version"] == beltsim.__version__ == version("beltsim")
    assert f"\nversion: {beltsim.__version__}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"VERSION {beltsim.__version__} " in (ROOT / "CMakeLists.txt").read_text()
