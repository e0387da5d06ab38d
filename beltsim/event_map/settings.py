"""Settings of the event map.

Depends on: errors, checks.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from beltsim.checks import real_number
from beltsim.errors import InvalidProblemError, Mistake

KEEP = ("last_period", "all", "events")


@dataclass(frozen=True)
class Settings:
    """How the event map runs and what it keeps.

    Parameters
    ----------
    samples_per_period : int
        Samples kept per forcing period (both ends included).
    keep : {"last_period", "all", "events"}
        Which part of a transient is sampled.
    max_events : int
        Budget of events; a run that meets it raises.
    harmonics : int
        Highest harmonic of the coefficients of a periodic orbit.
    tolerance : float
        Period residual below which an orbit counts as closed.
    max_multiple : int
        Largest period, in forcing periods, that `periodic` may return. 1 asks for the forcing
        period itself; more than 1 is worth trying only when Q_s > Q_m.

    Raises
    ------
    InvalidProblemError
        Naming every setting that is out of range.
    """

    samples_per_period: int = 200
    keep: str = "last_period"
    max_events: int = 10_000_000
    harmonics: int = 50
    tolerance: float = 1e-12
    max_multiple: int = 1

    def __post_init__(self) -> None:
        mistakes = []
        for name, least in (
            ("samples_per_period", 1),
            ("max_events", 1),
            ("harmonics", 0),
            ("max_multiple", 1),
        ):
            value: Any = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                mistakes.append(Mistake(f"settings.{name}", value, f"an integer >= {least}"))
        if self.keep not in KEEP:
            mistakes.append(Mistake("settings.keep", self.keep, f"one of {', '.join(KEEP)}"))
        tolerance = real_number(self.tolerance)
        if tolerance is None or not 1e-14 <= tolerance <= 1e-2:
            allowed = "a number between 1e-14 and 1e-2"
            mistakes.append(Mistake("settings.tolerance", self.tolerance, allowed))
        if mistakes:
            raise InvalidProblemError(mistakes)

    def replaced(self, **changes: Any) -> Settings:
        """A copy with some settings changed."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return Settings(**{**values, **changes})


def settled(settings: Any) -> Settings:
    """The settings given, or the default ones for None; anything else is refused."""
    if settings is None:
        return Settings()
    if not isinstance(settings, Settings):
        raise InvalidProblemError(Mistake("settings", settings, "an event_map.Settings or None"))
    return settings
