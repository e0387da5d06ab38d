"""What the C map says when it cannot go on.

Depends on: errors.
"""

from __future__ import annotations

from beltsim.errors import CoreError

#: Name and explanation of each status below zero.
STATUS = {
    -1: ("BM_NO_MEMORY", "the workspace could not be allocated; try a smaller problem"),
    -2: ("BM_CHATTER", "more events in a period than this system can have; check its input"),
    -3: ("BM_NOT_FINITE", "the state left the range of double; is the system stable?"),
    -4: ("BM_NO_MODES", "no eigenvalues were found; is M far from singular?"),
}


def require_ok(status: int) -> None:
    """Raise `CoreError` for a call of the C map that failed."""
    if status < 0:
        name, text = STATUS[status]
        raise CoreError(f"exact map stopped: {text}", name)
