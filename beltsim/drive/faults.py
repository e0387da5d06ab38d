"""Layouts that cannot be, each named for what it is.

The belt of a sound layout is a simple closed curve that turns once, counter-clockwise. What can
go wrong, in the order it is looked for:

* pulleys overlap (then a tangent may not exist at all);
* the list runs clockwise: the reversed list is sound;
* the belt misses a pulley: its tangents ask for nearly a full turn round it, and the signed wraps
  no longer add up to 2 pi (two such faults may cancel, so crossings are looked for as well);
* two spans cross, or a span runs through a pulley that it does not touch. A span that crosses
  another pulley's wrap arc enters that pulley, so these two tests find every crossing.

Where the other side of one pulley would make the layout sound, that is said in place of its
consequences, which show at its neighbours too.

Depends on: errors, checks, tracing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from beltsim.checks import FloatArray
from beltsim.drive.tracing import Trace, cross, trace
from beltsim.drive.wording import Words
from beltsim.errors import Mistake

#: Largest drive in which other sides are tried, each at the price of a whole check.
MOST_TRIED = 30


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
    loop = _Loop(tuple(names), range(len(radius)), center, radius, side)
    overlaps = _overlaps(loop)
    if overlaps:
        return overlaps
    found = _path_faults(loop)
    if not found:
        return []
    backwards = _path_faults(loop.backwards())
    if backwards:
        found = _other_sides(loop, found)
    if not backwards or (len(backwards) < len(found) and _area(center) < 0.0):
        value = Words(f"the order {', '.join(names)}")
        allowed = "listed counter-clockwise along the belt loop; this list is clockwise: reverse it"
        return [Mistake("pulleys", value, allowed), *backwards]
    return found


def _other_sides(loop: _Loop, found: list[Mistake]) -> list[Mistake]:
    """`found`, or the one pulley whose other side alone makes the layout sound."""
    if loop.n > MOST_TRIED:
        return found
    flips = np.where(np.eye(loop.n, dtype=bool), -loop.side, loop.side)
    repairs = [j for j in range(loop.n) if not _path_faults(loop._replace(side=flips[j]))]
    named = {mistake.field for mistake in found}
    if not repairs or (len(repairs) == 1 and named == {f"pulleys[{repairs[0]}]"}):
        return found  # the one mistake names that pulley and its other side already
    said = [f"{loop.names[j]} of side {_sides(loop, j)[1]!r}" for j in repairs]
    if len(repairs) > 1:
        allowed = f"such that the belt meets every pulley: {', or '.join(said)} would do"
        return [Mistake("pulleys", Words("the sides"), allowed), *found]
    j = repairs[0]
    side, other = _sides(loop, j)
    allowed = (
        f"{other!r}, or {loop.names[j]} elsewhere: with this change alone the belt meets every "
        "pulley in the order of the list"
    )
    return [Mistake(f"pulleys[{loop.place[j]}].side", side, allowed)]


def _sides(loop: _Loop, j: int) -> tuple[str, str]:
    """The side of pulley `j`, and the other one."""
    return ("inside", "back") if loop.side[j] > 0 else ("back", "inside")


class _Loop(NamedTuple):
    """Pulleys in the order of a belt; `place` is where each stands in the list as it was given."""

    names: tuple[str, ...]
    place: Sequence[int]
    center: FloatArray
    radius: FloatArray
    side: FloatArray

    @property
    def n(self) -> int:
        return len(self.radius)

    def backwards(self) -> _Loop:
        return _Loop(
            self.names[::-1],
            self.place[::-1],
            self.center[::-1],
            self.radius[::-1],
            self.side[::-1],
        )

    def span(self, i: int) -> str:
        return f"the span {self.names[i]}-{self.names[(i + 1) % self.n]}"


def _area(center: FloatArray) -> float:
    """Area of the polygon of the centres, positive counter-clockwise."""
    return float(cross(center, np.roll(center, -1, axis=0)).sum()) / 2.0


def _overlaps(loop: _Loop) -> list[Mistake]:
    """Pairs of pulleys that are not apart."""
    found = []
    radius = loop.radius
    for i in range(loop.n):
        for j in range(i + 1, loop.n):
            distance = float(np.hypot(*(loop.center[j] - loop.center[i])))
            apart = float(radius[i] + radius[j])
            if distance > apart:
                continue
            h = abs(float(loop.side[j] * radius[j] - loop.side[i] * radius[i]))
            lost = j - i in (1, loop.n - 1) and h >= distance
            missing = "; no belt tangent exists between them" if lost else ""
            value = Words(f"{loop.names[i]} and {loop.names[j]}, {distance:.6g} m apart")
            allowed = (
                f"more than {apart:.6g} m apart: their radii are {radius[i]:.6g} m and "
                f"{radius[j]:.6g} m, they overlap{missing}"
            )
            found.append(Mistake(f"pulleys[{i}], pulleys[{j}]", value, allowed))
    return found


def _path_faults(loop: _Loop) -> list[Mistake]:
    """Missed pulleys, crossing spans and spans through pulleys, for pulleys that are apart."""
    path = trace(loop.center, loop.radius, loop.side)
    missed = _missed(loop, path)
    # the two spans of a missed pulley cross near it: one mistake, not three
    spans = [i for i in range(loop.n) if i not in missed and (i + 1) % loop.n not in missed]
    found = [_missed_mistake(loop, j, float(path.wrap[j])) for j in missed]
    found += _crossings(loop, path, spans) + _pulleys_in_the_way(loop, path, spans)
    turns = float(loop.side @ path.wrap) / (2.0 * np.pi)
    if not found and round(turns) != 1:
        value = Words(f"a belt that turns {turns:.3g} times")
        allowed = "a loop that turns once counter-clockwise; check sides and order of the pulleys"
        found.append(Mistake("pulleys", value, allowed))
    return found


def _missed(loop: _Loop, path: Trace) -> list[int]:
    """Pulleys that the belt misses.

    As many of the most wrapped as the belt has turns too many, and those wrapped by more than
    three quarters of a turn between spans that cross each other (such faults can cancel in the
    number of turns).
    """
    excess = round(float(loop.side @ path.wrap) / (2.0 * np.pi)) - 1
    suspects = [j for j in range(loop.n) if loop.side[j] * excess > 0 and path.wrap[j] > np.pi]
    suspects.sort(key=lambda j: -path.wrap[j])
    found = set(suspects[: abs(excess)])
    start, end = _span_ends(loop, path)
    for j in range(loop.n):
        crossing = _cross(start[j - 1], end[j - 1], start[j], end[j])
        if path.wrap[j] > 1.5 * np.pi and crossing:
            found.add(j)
    return sorted(found)


def _span_ends(loop: _Loop, path: Trace) -> tuple[FloatArray, FloatArray]:
    """Where the spans begin and end, (n, 2) each."""
    start = loop.center - (loop.side * loop.radius)[:, None] * path.normal
    return start, start + path.length[:, None] * path.direction


def _missed_mistake(loop: _Loop, j: int, wrap: float) -> Mistake:
    kind, other = _sides(loop, j)
    value = Words(f"{loop.names[j]}, wrapped by {np.degrees(wrap):.1f} deg")
    allowed = (
        f"touched by the belt, which misses it as a pulley of side {kind!r} at this place; "
        f"move it, or check its side ({other!r}?) and its place in the list"
    )
    return Mistake(f"pulleys[{loop.place[j]}]", value, allowed)


def _crossings(loop: _Loop, path: Trace, spans: Sequence[int]) -> list[Mistake]:
    """Pairs of `spans` that cross."""
    start, end = _span_ends(loop, path)
    allowed = "spans that do not cross; check the order and the sides of these pulleys"
    return [
        Mistake("pulleys", Words(f"{loop.span(i)} across {loop.span(j)}"), allowed)
        for i in spans
        for j in spans
        if i < j and _cross(start[i], end[i], start[j], end[j])
    ]


def _pulleys_in_the_way(loop: _Loop, path: Trace, spans: Sequence[int]) -> list[Mistake]:
    """Pulleys that one of `spans` runs through without touching them."""
    start, _ = _span_ends(loop, path)
    found = []
    for i in spans:
        for j in range(loop.n):
            if j in (i, (i + 1) % loop.n):
                continue
            offset = loop.center[j] - start[i]
            along = float(np.clip(offset @ path.direction[i], 0.0, path.length[i]))
            distance = float(np.hypot(*(offset - along * path.direction[i])))
            if distance < loop.radius[j]:
                value = Words(f"{loop.names[j]}, {distance:.6g} m from {loop.span(i)}")
                allowed = (
                    f"at least its radius {loop.radius[j]:.6g} m away: the span runs through it"
                )
                found.append(Mistake(f"pulleys[{loop.place[j]}]", value, allowed))
    return found


def _cross(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> bool:
    """Whether the segments ab and cd have a point in common."""
    along, other = b - a, d - c
    sides = cross(along, c - a) * cross(along, d - a), cross(other, a - c) * cross(other, b - c)
    return bool(max(float(s) for s in sides) < 0.0)
