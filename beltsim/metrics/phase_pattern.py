"""The modes of the joint over one period, in order, as a short text.

Depends on: response (its type only).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from beltsim.response import Response

_SIGNS = {"stick": "0", "slip+": "+", "slip-": "-"}


def phase_pattern(orbit: Response) -> str:
    """Modes of the last period in order, such as ``+0-0``; ``0`` is stick.

    Parameters
    ----------
    orbit : Response
        One period of an orbit, or a run, whose window counts.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing, event_map
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4))
    >>> phase_pattern(event_map.periodic(one))
    '0-0+'
    """
    start, end = orbit.window
    mode, found = orbit.initial_mode or "stick", ""
    for t, after in zip(orbit.events.t, orbit.events.modes_after(mode), strict=True):
        if t >= end:
            break
        mode = after
        found += _SIGNS[mode] if t >= start else ""
    return found or _SIGNS[mode]
