"""The modes of the joint over one period, in order, as a short text.

Depends on: response (its type only).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from beltsim.response import Response

_SIGNS = {"stick": "0", "slip+": "+", "slip-": "-"}


def phase_pattern(orbit: Response) -> str:
    """Modes of one period in order, such as ``+0-0``; ``0`` is stick.

    Parameters
    ----------
    orbit : Response
        Periodic: its events are those of one period.

    Examples
    --------
    >>> from beltsim import Coulomb, FrictionProblem, HarmonicForcing, event_map
    >>> push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    >>> one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4))
    >>> phase_pattern(event_map.periodic(one))
    '0-0+'
    """
    first = orbit.initial_mode or "stick"
    return "".join(_SIGNS[mode] for mode in orbit.events.modes_after(first)) or _SIGNS[first]
