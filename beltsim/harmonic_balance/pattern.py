"""Which periodic response is meant: the kinds and times of its events.

Depends on: errors, checks, phases.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beltsim.checks import FloatArray, read_only
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.harmonic_balance.phases import SIGNS, Found


@dataclass(frozen=True, eq=False)
class Pattern:
    """Events of one forcing period, in order, their times known roughly.

    Parameters
    ----------
    kind : sequence of str
        ``stick``, ``reverse``, ``slip+``, ``slip-``, as in `EventLog`.
    t : (p,) times, ascending, 0 <= t.
    initial_mode : str
        Mode before the first event.

    Raises
    ------
    InvalidProblemError
        For fewer than two events, for kinds that cannot follow each other, or for times that do not
        ascend.

    Examples
    --------
    >>> Pattern(["stick", "slip-", "stick", "slip+"], [0.1, 0.4, 0.6, 0.9], "slip+").modes
    ('slip+', 'stick', 'slip-', 'stick', 'slip+')
    """

    kind: tuple[str, ...]
    t: FloatArray
    initial_mode: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "kind", tuple(str(kind) for kind in self.kind))
        object.__setattr__(self, "t", read_only(self.t))
        if self.t.ndim != 1 or len(self.t) != len(self.kind) or len(self.t) < 2:
            allowed = "one time per kind, two at least (a joint without events needs no pattern)"
            raise InvalidProblemError(Mistake("pattern.t", self.t, allowed))
        if not np.isfinite(self.t).all() or self.t[0] < 0.0 or np.any(np.diff(self.t) <= 0.0):
            raise InvalidProblemError(Mistake("pattern.t", self.t, "ascending from 0 on"))
        self._check_kinds()

    @property
    def modes(self) -> tuple[str, ...]:
        """Mode before each event, and after the last."""
        return tuple(Found(self.t, list(self.kind), self.initial_mode).modes)

    def angles(self, Omega: float) -> FloatArray:
        """Angles Omega t (p,); refuses times beyond one forcing period."""
        if self.t[-1] >= 2.0 * np.pi / Omega:
            allowed = f"below one forcing period, {2.0 * np.pi / Omega:.6g}"
            raise InvalidProblemError(Mistake("pattern.t", self.t, allowed))
        return np.asarray(self.t * Omega)

    def _check_kinds(self) -> None:
        modes = self.modes
        if modes[0] not in SIGNS:
            allowed = "one of " + ", ".join(SIGNS)
            raise InvalidProblemError(Mistake("pattern.initial_mode", modes[0], allowed))
        for mode, kind in zip(modes, self.kind, strict=False):
            after = ("slip+", "slip-") if mode == "stick" else ("stick", "reverse")
            if kind not in after:
                allowed = f"{after[0]} or {after[1]} where the joint is in {mode}, not {kind!r}"
                raise InvalidProblemError(Mistake("pattern.kind", self.kind, allowed))
        if modes[-1] != modes[0]:
            allowed = f"events that lead from {modes[0]} back to it, not to {modes[-1]}"
            raise InvalidProblemError(Mistake("pattern.kind", self.kind, allowed))
