"""Finding room for labels in a drawing: away from lines, discs and the labels already placed.

Depends on: nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from beltsim.checks import FloatArray


@dataclass
class Room:
    """What a drawing already holds; grows with each label that is placed.

    Parameters
    ----------
    points : (m, 2) points that stand for the lines drawn, close together.
    center, radius : (k, 2), (k,)
        Discs drawn.
    low, high : (2,)
        Corners of the drawing.
    """

    points: FloatArray
    center: FloatArray
    radius: FloatArray
    low: FloatArray
    high: FloatArray
    boxes: list[tuple[FloatArray, FloatArray]] = field(default_factory=list)

    def clearance(self, spot: FloatArray, half: FloatArray) -> float:
        """Distance from a box about `spot`, of half-size `half`, to the nearest thing or edge."""
        to_points = _gap(self.points - spot, half)
        to_discs = _gap(self.center - spot, half) - self.radius
        to_boxes = [float(_gap(other - spot, half + size)) for other, size in self.boxes]
        to_edges = np.minimum(spot - half - self.low, self.high - spot - half)
        return float(min([to_points.min(), to_discs.min(), to_edges.min(), *to_boxes]))

    def place(self, spots: FloatArray, half: FloatArray, enough: float) -> FloatArray:
        """Take the first of `spots` (m, 2) with clearance `enough`, or else the roomiest."""
        gaps = np.array([self.clearance(spot, half) for spot in spots])
        free = np.flatnonzero(gaps >= enough)
        chosen: FloatArray = spots[free[0] if len(free) else int(gaps.argmax())]
        self.boxes.append((chosen, half))
        return chosen


def _gap(offset: FloatArray, half: FloatArray) -> FloatArray:
    """Distances from points at `offset` (..., 2) to a box about the origin; negative inside."""
    beyond = np.abs(offset) - half
    outside = np.hypot(*np.moveaxis(np.maximum(beyond, 0.0), -1, 0))
    return np.asarray(np.where(beyond.max(axis=-1) > 0.0, outside, beyond.max(axis=-1)))
