r"""What moves in a mode: shares of kinetic energy, by span, pulley and arm.

The share of coordinate i is :math:`\mathrm{Re}\,\bar\phi_i (M\phi)_i / \bar\phi^T M \phi`; those of
one span's sines are added. Shares sum to one.

Depends on: problem, checks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from beltsim.problem import FrictionProblem


@dataclass(frozen=True)
class ModeKind:
    """What moves in a mode.

    Parameters
    ----------
    type : str
        ``"rotation"`` when pulleys and arm hold at least half of the kinetic energy, else
        ``"span"``.
    dominant : str
        The part with the largest share: ``span <i>``, ``pulley <name>`` or ``arm``.
    share : float
        Its share of the kinetic energy.
    coordinate : str
        Label of the coordinate with the largest share.
    """

    type: str
    dominant: str
    share: float
    coordinate: str


def mode_kind(problem: FrictionProblem, shape: Any) -> ModeKind:
    """Kind of the mode with complex shape `shape` (n,) of an assembled problem.

    Examples
    --------
    >>> import beltsim
    >>> problem = beltsim.assemble(beltsim.presets.zhu_parker_2008(), 6.3)
    >>> mode_kind(problem, beltsim.linear.modes(problem).shapes[0]).type
    'span'
    """
    phi = np.asarray(shape)
    energy = (np.conj(phi) * (problem.M @ phi)).real
    energy = energy / energy.sum()
    labels = problem.labels or ()
    shares: dict[str, float] = {}
    for label, share in zip(labels, energy.tolist(), strict=True):
        part = _part(label)
        shares[part] = shares.get(part, 0.0) + share
    dominant = max(shares, key=lambda part: shares[part])
    spans = sum(share for part, share in shares.items() if part.startswith("span "))
    return ModeKind(
        type="span" if spans > 0.5 else "rotation",
        dominant=dominant,
        share=shares[dominant],
        coordinate=labels[int(np.argmax(energy))],
    )


def _part(label: str) -> str:
    """Part of the drive that a coordinate belongs to, from its label."""
    if label == "theta_t":
        return "arm"
    if label.startswith("theta_"):
        return f"pulley {label.removeprefix('theta_')}"
    return f"span {label.partition('.')[0].removeprefix('span')}"
