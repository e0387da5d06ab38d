r"""The crank: prescribed and moved to the right-hand side, or left free.

A prescribed crank :math:`\theta_c(t)` loses its row; its column becomes forcing,

.. math:: f = -(M_{\cdot c}\ddot\theta_c + G_{\cdot c}\dot\theta_c + K_{\cdot c}\theta_c)

without a damping term; its first two parts are zero, since the crank meets the rest of the drive
only through the stretch of its spans. A free crank keeps its row and is not forced.

This is also where canonical coordinates turn into the user's: spans and pulleys in the order of the
drive file, x along the user's spans, theta_t counter-clockwise in the user's view, arm last.

Depends on: model.scaling, model.galerkin, model.modal, checks.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from beltsim.checks import FloatArray, read_only
from beltsim.model.galerkin import Basis, LinearSystem
from beltsim.model.modal import MassFactor, mass_factor
from beltsim.model.scaling import DimensionlessDrive


@dataclass(frozen=True, eq=False)
class Coordinates:
    """The user's coordinates, and where each stands among the canonical ones.

    Parameters
    ----------
    index : (n,) of int
        Canonical coordinate of each of the user's.
    sign : (n,)
        -1 where the user's coordinate is the canonical one turned around.
    crank : int
        Canonical coordinate of the crank.
    labels : tuple of str
        ``span1.sin1`` ..., ``theta_<pulley>`` ..., ``theta_t``; spans counted from 1.
    scale : (n,)
        SI value of one unit.
    units : tuple of str
    M : (n, n)
        Mass matrix; like the next, the same at every speed.
    G_per_s : (n, n)
        Gyroscopic matrix of unit belt speed.
    """

    index: NDArray[np.intp]
    sign: FloatArray
    crank: int
    labels: tuple[str, ...]
    scale: FloatArray
    units: tuple[str, ...]
    M: FloatArray
    G_per_s: FloatArray

    @cached_property
    def mass_factor(self) -> MassFactor:
        """Cholesky factor of M, for the modal damping of every speed."""
        return mass_factor(self.M)

    def turned(self, matrix: FloatArray) -> FloatArray:
        """A canonical matrix in the user's coordinates."""
        found = matrix[self.index[:, None], self.index]
        if (self.sign < 0.0).any():
            found *= self.sign[:, None] * self.sign
        return found


@dataclass(frozen=True, eq=False)
class DrivenSystem:
    """The linear system as the user sees it, forced by its crank; no damping yet.

    Parameters
    ----------
    system : LinearSystem
    coordinates : Coordinates
    M, G, K : (n, n)
    cos, sin : (H + 1, n)
        Forcing rows over the fundamental of the operating point.
    tension_rows : (ns, n)
        Dynamic tension of each of the user's spans, per coordinate.
    tension_cos, tension_sin : (ns, H + 1)
        Part of the tension that follows the crank directly; the steady tension is not in it.
    """

    system: LinearSystem
    coordinates: Coordinates
    M: FloatArray
    G: FloatArray
    K: FloatArray
    cos: FloatArray
    sin: FloatArray
    tension_rows: FloatArray
    tension_cos: FloatArray
    tension_sin: FloatArray

    @property
    def drive(self) -> DimensionlessDrive:
        """The drive this is a system of."""
        return self.system.drive


def prescribe(system: LinearSystem) -> DrivenSystem:
    """The system with its crank prescribed: row deleted, column turned into forcing.

    Parameters
    ----------
    system : LinearSystem

    Returns
    -------
    DrivenSystem
        Without the crank's coordinate; the arm, if there is one, is last.
    """
    point = system.state.point
    found = coordinates_of(system, crank_free=False)
    a, b = point.crank_cos, point.crank_sin
    # The crank's column of M and G couples to nothing else: it only stretches the spans.
    column = found.sign * system.K[found.index, found.crank]
    spans = system.drive.frame.spans
    tension = system.tension_rows[spans, found.crank]
    return _reordered(
        system,
        found,
        cos=-np.multiply.outer(a, column),
        sin=-np.multiply.outer(b, column),
        tension_cos=np.multiply.outer(tension, a),
        tension_sin=np.multiply.outer(tension, b),
    )


def release(system: LinearSystem) -> DrivenSystem:
    """The system with its crank free to turn: nothing deleted, no forcing.

    Its stiffness has one zero mode, all r_j theta_j equal.
    """
    found = coordinates_of(system, crank_free=True)
    none, spans = np.zeros((1, len(found.index))), np.zeros((system.drive.n, 1))
    return _reordered(system, found, none, none, spans, spans)


def _reordered(
    system: LinearSystem,
    found: Coordinates,
    cos: FloatArray,
    sin: FloatArray,
    tension_cos: FloatArray,
    tension_sin: FloatArray,
) -> DrivenSystem:
    spans = system.drive.frame.spans
    return DrivenSystem(
        system=system,
        coordinates=found,
        M=found.M,
        G=system.state.point.s * found.G_per_s,
        K=found.turned(system.K),
        cos=cos,
        sin=sin,
        tension_rows=system.tension_rows[spans[:, None], found.index] * found.sign,
        tension_cos=tension_cos,
        tension_sin=tension_sin,
    )


#: The user's coordinates for a basis, by whether the crank is free.
_KNOWN: weakref.WeakKeyDictionary[Basis, dict[bool, Coordinates]] = weakref.WeakKeyDictionary()


def coordinates_of(system: LinearSystem, crank_free: bool) -> Coordinates:
    """The user's coordinates of a system; built once per basis."""
    known = _KNOWN.setdefault(system.basis, {})
    if crank_free not in known:
        known[crank_free] = _coordinates(system.drive, system.basis, crank_free)
    return known[crank_free]


def _coordinates(drive: DimensionlessDrive, basis: Basis, crank_free: bool) -> Coordinates:
    frame, P = drive.frame, basis.n_sines
    index: list[int] = []
    sign: list[float] = []
    labels: list[str] = []
    scale: list[float] = []
    for number, span in enumerate(frame.spans, start=1):
        k = np.arange(1, basis.counts[span] + 1)
        index += (basis.starts[span] + k - 1).tolist()
        sign += frame.sine_signs(k).tolist()
        labels += [f"span{number}.sin{wave}" for wave in k]
        scale += [float(drive.span_length[span]) * drive.length_m] * len(k)
    pulleys = [j for j in frame.pulleys.tolist() if crank_free or j != drive.crank]
    index += [P + j for j in pulleys]
    # a pulley called "t" must not pass for the arm
    names = ["t (pulley)" if drive.names[j] == "t" else drive.names[j] for j in pulleys]
    labels += [f"theta_{name}" for name in names]
    sign += [1.0] * len(pulleys)
    if drive.arm is not None:
        index.append(P + drive.n)
        labels.append("theta_t")
        sign.append(frame.sign)
    n_angles = len(index) - P
    picked, turn = np.array(index), np.array(sign)
    both = np.multiply.outer(turn, turn)
    return Coordinates(
        index=picked,
        sign=turn,
        crank=P + drive.crank,
        labels=tuple(labels),
        scale=read_only(scale + [1.0] * n_angles),
        units=("m",) * P + ("rad",) * n_angles,
        M=read_only(basis.M[np.ix_(picked, picked)] * both),
        G_per_s=read_only(basis.G_per_s[np.ix_(picked, picked)] * both),
    )
