"""Whether a repeated run gave what the stored one did.

Depends on: response (for its type only); numpy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from beltsim.response import Response


def repeat_lines(response: Response, stored: Response) -> list[str]:
    """One line under a heading: the same bits, or how far apart the two runs end."""
    return ["", "Repetition", f"  {_verdict(response, stored)}"]


def _verdict(response: Response, stored: Response) -> str:
    if abs(stored.window[1] - response.window[1]) > 1e-9 * response.window[1]:
        return "the stored run was cut short, and this one goes on"
    pairs = [
        (response.final_state, stored.final_state),
        (response.events.t, stored.events.t),
        (response.q, stored.q),
    ]
    if all(np.array_equal(one, other) for one, other in pairs):
        return "equals the stored run bit for bit"
    size = float(np.abs(stored.final_state).max(initial=0.0)) or 1.0
    gap = float(np.abs(response.final_state - stored.final_state).max(initial=0.0)) / size
    same = [*response.events.kind] == [*stored.events.kind]
    words = "the same events" if same else "another sequence of events"
    return f"{words} as the stored run; the final state differs by {gap:.1e} of its size"
