"""Collecting what is wrong with an input before anything is computed.

Depends on: errors.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from beltsim.errors import (
    InvalidDriveError,
    InvalidProblemError,
    ResultFileError,
    SteadyStateError,
)

#: The option behind a name that the library uses for it.
_OPTIONS = {
    "settings.rtol": "--rtol",
    "settings.method": "--method",
    "settings.samples_per_period": "--samples",
    "settings.max_seconds": "--max-seconds",
    "n_functions": "--functions",
    "rpm": "--rpm",
    "Omega": "--omega",
    "friction.Q_m": "--Q-m",
    "friction.Q_s": "--Q-s",
}


def as_option(line: str) -> str:
    """A complaint with the name of the command's option in place of the library's.

    Examples
    --------
    >>> as_option("settings.rtol = 3.0: must be between 1e-14 and 1e-2")
    '--rtol = 3.0: must be between 1e-14 and 1e-2'
    """
    name, equals, rest = line.partition(" = ")
    stem, bracket, index = name.partition("[")
    return f"{_OPTIONS.get(stem, stem)}{bracket}{index}{equals}{rest}"


class Mistakes:
    """Lines that say what is wrong; all of them are raised at once."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    @contextmanager
    def gathered(self) -> Iterator[None]:
        """Keep what the block complains about, and go on behind it."""
        try:
            yield
        except (InvalidDriveError, InvalidProblemError, ResultFileError, SteadyStateError) as error:
            self.lines += map(as_option, str(error).splitlines())

    def raise_any(self) -> None:
        """Raise one `InvalidProblemError` with every line, when there is one."""
        if self.lines:
            raise InvalidProblemError("\n".join(self.lines))
