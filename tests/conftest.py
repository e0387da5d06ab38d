"""Options and profiles of the whole suite."""

from __future__ import annotations

import signal

import pytest
from hypothesis import settings

# A shell starts its background jobs with SIGINT ignored, and so would be whatever a test starts.
signal.signal(signal.SIGINT, signal.default_int_handler)

# The same examples on every run, and no deadline on a busy machine.
settings.register_profile("beltsim", derandomize=True, deadline=None)
settings.load_profile("beltsim")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--full",
        action="store_true",
        help="random tests with the full published recipe (300 transients, 100 near-grazing ones)",
    )


@pytest.fixture(scope="session")
def full(request: pytest.FixtureRequest) -> bool:
    """Whether the random tests run the full recipe."""
    return bool(request.config.getoption("--full"))
