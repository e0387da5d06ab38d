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
            self.lines += str(error).splitlines()

    def raise_any(self) -> None:
        """Raise one `InvalidProblemError` with every line, when there is one."""
        if self.lines:
            raise InvalidProblemError("\n".join(self.lines))
