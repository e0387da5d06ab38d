r"""Dynamic span tensions (eq. 28 of Zhu & Parker).

.. math:: P_{di} = \gamma_i \{[r_i\theta_i - r_{i+1}\theta_{i+1} + arm_i\theta_t]/l_i
    + \int w_x w^*_x\,dx\}

They are linear in the coordinates and the crank's angle, and an assembled problem carries them as
observables. All values in units of P0; multiply by `Observable.scale` for newtons.

Depends on: problem, response (its type only), linear, checks, errors.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray
from beltsim.errors import InvalidProblemError, Mistake
from beltsim.linear import extremes
from beltsim.problem import FrictionProblem, Observable

if TYPE_CHECKING:
    from beltsim.response import Response

_PREFIX = "tension of span "


def tensions_of(problem: FrictionProblem) -> tuple[Observable, ...]:
    """The observables of a problem that are span tensions, in the order of the spans.

    Raises
    ------
    InvalidProblemError
        When there are none.
    """
    found = tuple(seen for seen in problem.observables if seen.name.startswith(_PREFIX))
    if not found:
        names = [seen.name for seen in problem.observables]
        raise InvalidProblemError(Mistake("observables", names, "those of an assembled drive"))
    return found


def steady_tensions(problem: FrictionProblem) -> FloatArray:
    """Steady tension p_i of each span (ns,), in P0."""
    return np.array([seen.cos[0] for seen in tensions_of(problem)])


def dynamic_tensions(response: Response) -> FloatArray:
    """Dynamic tension of each span at the samples of a response: array (nt, ns), in P0."""
    problem = response.problem
    return np.stack(
        [
            seen.at(response.t, response.q, problem.forcing.Omega) - seen.cos[0]
            for seen in tensions_of(problem)
        ],
        axis=1,
    )


def tension_harmonics(problem: FrictionProblem, coefficients: Any) -> NDArray[np.complex128]:
    """Harmonics of the dynamic tensions for harmonics of the coordinates.

    Parameters
    ----------
    problem : FrictionProblem
        As assembled from a drive.
    coefficients : (R + 1, n) complex
        q(t) = Re sum_k c_k exp(i k Omega t).

    Returns
    -------
    (max(R, H) + 1, ns) complex
    """
    c = np.asarray(coefficients, dtype=complex)
    seen = tensions_of(problem)
    rows = max(len(c), *(len(item.cos) for item in seen))
    found = np.zeros((rows, len(seen)), dtype=complex)
    for i, item in enumerate(seen):
        found[: len(c), i] = c @ item.row
        found[1 : len(item.cos), i] += (item.cos - 1j * item.sin)[1:]
    return found


def peak_dynamic_tensions(problem: FrictionProblem, coefficients: Any) -> FloatArray:
    """Largest |P_d| of each span over a period (ns,), in P0; its extrema are located.

    Parameters are those of `tension_harmonics`.

    Examples
    --------
    >>> import beltsim
    >>> problem = beltsim.assemble(beltsim.presets.zhu_parker_2008(), 6.3)
    >>> free = beltsim.linear.response(problem)
    >>> peak_dynamic_tensions(problem, free).shape
    (3,)
    """
    harmonics = tension_harmonics(problem, coefficients)
    ends = np.array([extremes(column) for column in harmonics.T])
    return np.asarray(np.abs(ends).max(axis=1))
