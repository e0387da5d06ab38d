r"""Transverse motion of a span, averaged along it (eq. 24 of Zhu & Parker).

.. math:: \bar y_i(t)^2 = \int_0^1 y_i^2\,dx = \tfrac12 \sum_k a_{ik}^2

y is the deflection without the part that follows the arm, in span lengths.

Depends on: problem, checks, errors.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.problem import FrictionProblem


def sines_of(problem: FrictionProblem) -> tuple[NDArray[np.intp], ...]:
    """Indices of the sine coordinates of each span, read from the labels.

    Raises
    ------
    InvalidProblemError
        When the problem has no coordinate called ``span<i>.sin<k>``.
    """
    found: dict[int, list[int]] = {}
    for i, label in enumerate(problem.labels or ()):
        match = re.fullmatch(r"span(\d+)\.sin\d+", label)
        if match:
            found.setdefault(int(match[1]), []).append(i)
    if not found:
        raise InvalidProblemError(Mistake("labels", problem.labels, "those of an assembled drive"))
    return tuple(np.array(found[span]) for span in sorted(found))


def span_rms(problem: FrictionProblem, coordinate_rms: Any) -> FloatArray:
    """Root mean square over time of the averaged deflection of each span.

    Parameters
    ----------
    problem : FrictionProblem
        As assembled from a drive.
    coordinate_rms : (n,)
        Root mean squares of the coordinates; see `beltsim.metrics.rms`.

    Returns
    -------
    (ns,)
        In span lengths.

    Examples
    --------
    >>> import beltsim
    >>> from beltsim.metrics.rms import rms_of_coefficients
    >>> problem = beltsim.assemble(beltsim.presets.zhu_parker_2008(), 6.3)
    >>> free = rms_of_coefficients(beltsim.linear.response(problem))
    >>> span_rms(problem, free).shape
    (3,)
    """
    squares = np.asarray(coordinate_rms, dtype=float) ** 2
    return np.array([np.sqrt(0.5 * squares[sines].sum()) for sines in sines_of(problem)])


def span_rms_m(problem: FrictionProblem, coordinate_rms: Any) -> FloatArray:
    """`span_rms` in metres (ns,)."""
    if problem.scales is None:
        raise InvalidProblemError(Mistake("scales", None, "given, to convert to metres"))
    lengths = [problem.scales.coordinates[sines[0]] for sines in sines_of(problem)]
    found: FloatArray = span_rms(problem, coordinate_rms) * np.array(lengths)
    return found
