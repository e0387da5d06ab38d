"""Layouts that cannot be, each named for what it is.

The belt of a sound layout is a simple closed curve that turns once, counter-clockwise. What can
go wrong, in the order it is looked for:

* pulleys overlap (then a tangent may not exist at all);
* the list runs clockwise: the reversed list is sound;
* the belt misses a pulley: its tangents ask for nearly a full turn round it, and the signed wraps
  no longer add up to 2 pi (two such faults may cancel, so crossings are looked for as well);
* two spans cross, or a span runs through a pulley that it does not touch. A span that crosses
  another pulley's wrap arc enters that pulley, so these two tests find every crossing.

Depends on: errors, checks, tracing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from beltsim.checks import FloatArray
from beltsim.drive.tracing import Trace, cross, trace
from beltsim.drive.wording import Words
from beltsim.errors import Mistake


def layout_faults(
    names: Sequence[str], center: FloatArray, radius: FloatArray, side: FloatArray
) -> list[Mistake]:
    """Everything that makes the layout impossible; empty for a sound one.

    Parameters
    ----------
    names : (n,) names of the pulleys, for the messages.
    center : (n, 2) centres, m.
    radius : (n,) pitch radii, m.
    side : (n,) +1 inside the loop, -1 on the belt's back.

    Returns
    -------
    list of Mistake

    Examples
    --------
    A back-side pulley that stands clear of the belt:

    >>> import numpy as np
    >>> center = np.array([[0.0, 0.0], [0.4, 0.0], [0.2, 0.3]])
    >>> found = layout_faults("abc", center, np.full(3, 0.05), np.array([1.0, 1.0, -1.0]))
    >>> print(found[0].field)
    pulleys[2]
    """
    overlaps = _overlaps(names, center, radius, side)
    if overlaps:
        return overlaps
    found = _path_faults(names, center, radius, side)
    if found and not _path_faults(names[::-1], center[::-1], radius[::-1], side[::-1]):
        value = Words(f"the order {', '.join(names)}")
        allowed = "listed counter-clockwise along the belt loop; this list is clockwise: reverse it"
        return [Mistake("pulleys", value, allowed)]
    return found


def _overlaps(
    names: Sequence[str], center: FloatArray, radius: FloatArray, side: FloatArray
) -> list[Mistake]:
    """Pairs of pulleys that are not apart."""
    found = []
    n = len(radius)
    for i in range(n):
        for j in range(i + 1, n):
            distance = float(np.hypot(*(center[j] - center[i])))
            apart = float(radius[i] + radius[j])
            if distance > apart:
                continue
            h = abs(float(side[j] * radius[j] - side[i] * radius[i]))
            neighbours = j - i in (1, n - 1)
            lost = neighbours and h >= distance
            missing = "; no belt tangent exists between them" if lost else ""
            value = Words(f"{_pair(names, i, j)}, {distance:.6g} m apart")
            allowed = (
                f"more than {apart:.6g} m apart: their radii are {radius[i]:.6g} m and "
                f"{radius[j]:.6g} m, they overlap{missing}"
            )
            found.append(Mistake(f"pulleys[{i}], pulleys[{j}]", value, allowed))
    return found


def _path_faults(
    names: Sequence[str], center: FloatArray, radius: FloatArray, side: FloatArray
) -> list[Mistake]:
    """Missed pulleys, crossing spans and spans through pulleys, for pulleys that are apart."""
    path = trace(center, radius, side)
    missed = _missed(path.wrap, side)
    found = [_missed_mistake(names, j, path.wrap[j], side[j]) for j in missed]
    n = len(radius)
    # the two spans of a missed pulley always cross near it: one mistake, not three
    beside = {i for j in missed for i in (j, (j - 1) % n)}
    start = center - (side * radius)[:, None] * path.normal
    end = start + path.length[:, None] * path.direction
    for i in range(n):
        for j in range(i + 1, n):
            if not {i, j} & beside and _cross(start[i], end[i], start[j], end[j]):
                found.append(_crossing_mistake(names, i, j))
    if not missed:
        found += _pulleys_in_the_way(names, center, radius, path, start)
    turns = float(side @ path.wrap) / (2.0 * np.pi)
    if not found and round(turns) != 1:
        value = Words(f"a belt that turns {turns:.3g} times")
        allowed = "a loop that turns once counter-clockwise; check sides and order of the pulleys"
        found.append(Mistake("pulleys", value, allowed))
    return found


def _missed(wrap: FloatArray, side: FloatArray) -> list[int]:
    """Pulleys that the belt misses: as many of the most wrapped as the turns are too many."""
    excess = round(float(side @ wrap) / (2.0 * np.pi)) - 1
    if excess == 0:
        return []
    suspects = [j for j in range(len(wrap)) if side[j] * excess > 0 and wrap[j] > np.pi]
    suspects.sort(key=lambda j: -wrap[j])
    return sorted(suspects[: abs(excess)])


def _missed_mistake(names: Sequence[str], j: int, wrap: float, side: float) -> Mistake:
    degrees = float(np.degrees(wrap))
    kind, other = ("inside", "back") if side > 0 else ("back", "inside")
    value = Words(f"{names[j]}, wrapped by {degrees:.1f} deg")
    allowed = (
        f"touched by the belt, which misses it as a pulley of side {kind!r} at this place; "
        f"move it, or check its side ({other!r}?) and its place in the list"
    )
    return Mistake(f"pulleys[{j}]", value, allowed)


def _crossing_mistake(names: Sequence[str], i: int, j: int) -> Mistake:
    n = len(names)
    spans = [f"{names[k]}-{names[(k + 1) % n]}" for k in (i, j)]
    value = Words(f"spans {i + 1} ({spans[0]}) and {j + 1} ({spans[1]}), which cross")
    allowed = "spans that do not cross; check the order and the sides of these pulleys"
    return Mistake("pulleys", value, allowed)


def _pulleys_in_the_way(
    names: Sequence[str], center: FloatArray, radius: FloatArray, path: Trace, start: FloatArray
) -> list[Mistake]:
    """Spans that run through a pulley they do not touch."""
    found = []
    n = len(names)
    for i in range(n):
        for j in range(n):
            if j in (i, (i + 1) % n):
                continue
            offset = center[j] - start[i]
            along = float(np.clip(offset @ path.direction[i], 0.0, path.length[i]))
            distance = float(np.hypot(*(offset - along * path.direction[i])))
            if distance < radius[j]:
                span = f"span {i + 1} ({names[i]}-{names[(i + 1) % n]})"
                value = Words(f"{names[j]}, {distance:.6g} m from {span}")
                allowed = f"at least its radius {radius[j]:.6g} m away: the span runs through it"
                found.append(Mistake(f"pulleys[{j}]", value, allowed))
    return found


def _cross(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> bool:
    """Whether the segments ab and cd have a point in common."""
    along, other = b - a, d - c
    sides = cross(along, c - a) * cross(along, d - a), cross(other, a - c) * cross(other, b - c)
    return bool(max(float(s) for s in sides) < 0.0)


def _pair(names: Sequence[str], i: int, j: int) -> str:
    return f"{names[i]} and {names[j]}"
