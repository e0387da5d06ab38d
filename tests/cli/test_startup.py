"""What the command loads before it knows what is wanted, and that both ways in work."""

import resource
import subprocess
import sys

import pytest

HEAVY = ("numpy", "scipy", "xarray", "pandas", "matplotlib", "pydantic", "h5netcdf", "tqdm")


def python(*words, **options):
    return subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, timeout=60, check=False, **options
    )


@pytest.mark.parametrize("words", [["--help"], ["run", "--help"], ["--version"], ["bogus"]])
def test_words_alone_load_nothing_heavy(words):
    code = (
        f"import sys; from beltsim.cli import main; main({words!r})\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules], file=sys.stderr)"
    )
    assert python("-c", code).stderr.splitlines()[-1] == "[]"


@pytest.mark.parametrize(("verb", "spared"), [("schema", "matplotlib"), ("modes", "xarray")])
def test_a_verb_loads_only_what_it_needs(verb, spared):
    file = ["examples/zhu_parker_2008.toml"] if verb == "modes" else []
    code = (
        f"import sys; from beltsim.cli import main; main({[verb, *file]!r})\n"
        f"print({spared!r} in sys.modules, 'numpy' in sys.modules, file=sys.stderr)"
    )
    assert python("-c", code).stderr.split() == ["False", "True"]


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def test_help_takes_a_quarter_of_a_second():
    """Processor time, the best of five: a busy machine must not decide."""
    seconds = []
    for _ in range(5):
        start = processor_seconds()
        assert python("-m", "beltsim", "--help").returncode == 0
        seconds.append(processor_seconds() - start)
    assert min(seconds) < 0.25


def test_python_dash_m_is_the_same_command():
    run = python("-m", "beltsim", "modes", "no-such-file.toml")
    assert run.returncode == 2
    assert run.stderr.startswith("beltsim: no-such-file.toml: no such file")
    assert run.stdout == ""
