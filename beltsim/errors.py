"""Every exception and warning text of beltsim starts here.

A message says what is wrong, the number, and what to try. Input errors collect every mistake
before they are raised, so one run of the program shows them all.

Depends on: nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Mistake:
    """One mistake in an input: where it stands, what stands there, and what is allowed.

    Parameters
    ----------
    field : str
        Path of the offending entry, such as ``"pulleys[2].radius_m"``.
    value : object
        The value found there.
    allowed : str
        What would be accepted, in words.

    Examples
    --------
    >>> print(Mistake("friction.Q_m", -1.0, "a finite number >= 0"))
    friction.Q_m = -1.0: must be a finite number >= 0
    """

    field: str
    value: Any
    allowed: str

    def __str__(self) -> str:
        shown = " ".join(repr(self.value).split())  # one line per mistake, arrays too
        if len(shown) > 80:
            shown = f"{shown[:77]}..."
        return f"{self.field} = {shown}: must be {self.allowed}"


def short_name(name: str, most: int = 20) -> str:
    """`name`, or its two ends where it has more than `most` characters.

    Examples
    --------
    >>> short_name("ALT"), short_name("Water pump of the second engine, rear side")
    ('ALT', 'Water pump...r side')
    """
    if len(name) <= most:
        return name
    tail = (most - 3) * 2 // 5
    return f"{name[: most - 3 - tail].rstrip()}...{name[-tail:].lstrip()}"


class BeltsimError(Exception):
    """Base of every error that beltsim raises on purpose."""


class _InvalidInputError(BeltsimError, ValueError):
    """Input that cannot be used; `mistakes` lists every one of them."""

    def __init__(self, mistakes: Sequence[Mistake] | Mistake | str) -> None:
        if isinstance(mistakes, str):
            self.mistakes: tuple[Mistake, ...] = ()
            super().__init__(mistakes)
            return
        self.mistakes = (mistakes,) if isinstance(mistakes, Mistake) else tuple(mistakes)
        super().__init__("\n".join(str(mistake) for mistake in self.mistakes))


class InvalidDriveError(_InvalidInputError):
    """A drive file or layout that cannot be, with every mistake found in it."""


class InvalidProblemError(_InvalidInputError):
    """A friction problem, solver setting or initial state that cannot be used."""


class SteadyStateError(BeltsimError):
    """The drive has no usable steady state: a slack span or a belt faster than critical."""


class ConvergenceError(BeltsimError):
    """An iteration stopped before it reached its tolerance.

    Parameters
    ----------
    message : str
        What, the number, and what to try.
    partial : object, optional
        The best iterate (a `Response` where there is one).
    residual_history : sequence of float, optional
        Residual after each iteration.
    """

    def __init__(
        self, message: str, partial: Any = None, residual_history: Sequence[float] = ()
    ) -> None:
        super().__init__(message)
        self.partial = partial
        self.residual_history = tuple(residual_history)


class NotPeriodicError(BeltsimError):
    """No periodic motion of the requested kind exists or was found."""


class UnsupportedLawError(BeltsimError):
    """The chosen solver cannot treat this friction law."""


class CoreError(BeltsimError):
    """The compiled core stopped.

    Parameters
    ----------
    message : str
        What happened, the number, and what to try.
    status : str
        Name of the core's status code, such as ``"BS_TOO_MANY_STEPS"``.
    time : float, optional
        Time reached, in the problem's own unit.
    mode : str, optional
        ``"slip+"``, ``"slip-"`` or ``"stick"`` at that time.
    last_event : tuple of (float, str), optional
        Time and kind of the last event located.
    solver_text : str, optional
        The text SUNDIALS gave.
    partial : object, optional
        What was computed until then (a `Response` where there is one).
    """

    def __init__(
        self,
        message: str,
        status: str = "",
        time: float | None = None,
        mode: str | None = None,
        last_event: tuple[float, str] | None = None,
        solver_text: str = "",
        partial: Any = None,
    ) -> None:
        super().__init__(message)
        self.status = status
        self.time = time
        self.mode = mode
        self.last_event = last_event
        self.solver_text = solver_text
        self.partial = partial


class StudyError(BeltsimError):
    """A parameter study that cannot be started or resumed."""


class ResultFileError(BeltsimError):
    """A result file that cannot be read or written, or an output folder that is closed."""
