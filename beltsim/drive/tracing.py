r"""The belt's path round the pulleys: spans, directions and wrap angles in closed form.

Pulleys are listed counter-clockwise along the loop; span `i` runs from pulley `i` to the next.
`side` is +1 for a pulley inside the loop and -1 where the belt's back runs on it. With centres
`c`, radii `r` and :math:`d_i = c_{i+1} - c_i`

.. math:: h_i = side_{i+1} r_{i+1} - side_i r_i, \qquad l_i = \sqrt{|d_i|^2 - h_i^2}

and the unit vector `u_i` along the span is `d_i` turned by :math:`-\mathrm{atan2}(h_i, l_i)`. The
normal `v_i` is `u_i` turned by +90 degrees, into the loop. The wrap of pulley `j` is the angle
from :math:`u_{j-1}` to :math:`u_j`, times `side_j`, in [0, 2 pi).

Depends on: checks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from beltsim.checks import FloatArray

#: A wrap closer than this to a full turn is a pulley that is just touched, rad.
TOUCH = 1e-9


class Trace(NamedTuple):
    """Spans and wraps of a loop of `n` pulleys.

    `length` (n,) m, `direction` and `normal` (n, 2) unit vectors of the spans, `wrap` (n,) rad.
    Entries of a span without tangent are NaN.
    """

    length: FloatArray
    direction: FloatArray
    normal: FloatArray
    wrap: FloatArray


def turned(vectors: FloatArray) -> FloatArray:
    """`vectors` (..., 2) turned by +90 degrees."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Out-of-plane component of the product of plane vectors (..., 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def trace(center: FloatArray, radius: FloatArray, side: FloatArray) -> Trace:
    """Closed-form path of the belt round `n` pulleys.

    Parameters
    ----------
    center : (n, 2) centres, m.
    radius : (n,) pitch radii, m.
    side : (n,) +1 inside the loop, -1 on the belt's back.

    Returns
    -------
    Trace

    Examples
    --------
    Two equal pulleys 0.3 m apart:

    >>> import numpy as np
    >>> path = trace(np.array([[0.3, 0.0], [0.0, 0.0]]), np.full(2, 0.05), np.ones(2))
    >>> path.length.tolist(), np.degrees(path.wrap).tolist()
    ([0.3, 0.3], [180.0, 180.0])
    """
    reach = np.roll(center, -1, axis=0) - center
    signed = side * radius
    h = np.roll(signed, -1) - signed
    square = (reach**2).sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        length = np.sqrt(square - h**2)
        # `reach` turned by -atan2(h, length), without a trigonometric function
        direction = (length[:, None] * reach - h[:, None] * turned(reach)) / square[:, None]
        before = np.roll(direction, 1, axis=0)
        turn = np.arctan2(cross(before, direction), (before * direction).sum(axis=1))
        wrap = np.mod(side * turn, 2.0 * np.pi)
        wrap = np.where(2.0 * np.pi - wrap < TOUCH, 0.0, wrap)
    return Trace(length, direction, turned(direction), wrap)
