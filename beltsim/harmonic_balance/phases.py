"""Events of one forcing period, and the modes between them.

Depends on: checks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from beltsim.checks import FloatArray

#: Direction of slip in each mode.
SIGNS = {"slip+": 1.0, "slip-": -1.0, "stick": 0.0}


class Found(NamedTuple):
    """Events of one forcing period: angles Omega t, kinds, and the mode the period starts in."""

    angles: FloatArray
    kinds: list[str]
    initial_mode: str

    @property
    def modes(self) -> list[str]:
        """Mode of each phase: one more than there are events."""
        modes = [self.initial_mode]
        for kind in self.kinds:
            other = "slip-" if modes[-1] == "slip+" else "slip+"
            modes.append(other if kind == "reverse" else kind)
        return modes

    def directions(self, angle: FloatArray) -> FloatArray:
        """Direction of slip at the angles Omega t: 1, -1, or 0 in stick."""
        signs = np.array([SIGNS[mode] for mode in self.modes])
        return np.asarray(signs[np.searchsorted(self.angles, angle, side="right")])


class Located(NamedTuple):
    """Events known to the solver itself: torques (ne,) on both sides of each, and at any angle."""

    found: Found
    before: FloatArray
    after: FloatArray
    torque_at: Callable[[FloatArray], FloatArray]


def sorted_log(angles: Iterable[float], kinds: Iterable[str], modes: Iterable[str]) -> Found:
    """Events of one period from any order: `modes` are those after each."""
    entries = zip(np.mod(np.array([*angles]), 2.0 * np.pi).tolist(), kinds, modes, strict=True)
    turned = sorted(entries)
    return Found(
        np.array([entry[0] for entry in turned]), [entry[1] for entry in turned], turned[-1][2]
    )
