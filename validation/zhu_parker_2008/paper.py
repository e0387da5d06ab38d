"""The paper's drive, in the paper's short sine series and converged.

Depends on: beltsim.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import beltsim
from beltsim.metrics.resonances import Resonance, resonances

#: The paper's own series, and the default of beltsim: 16 functions per span with the residual
#: flexibility, which is within 0.15 % of 80 functions for Omega up to 12.
SERIES: dict[str, dict[str, Any]] = {
    "N = (4, 5, 5)": {"n_functions": (4, 5, 5), "residual_flexibility": False},
    "converged": {"n_functions": 16, "residual_flexibility": True},
}
SHORT, CONVERGED = SERIES
#: Pulleys and arm together carry at least this share of a pulley mode's kinetic energy.
PULLEY_SHARE = 0.4


def problem(Omega: float, series: str = SHORT, Q_m: float = 0.0, **preset: float) -> Any:
    """The friction problem of the paper's drive; `preset`: epsilon, zeta, mu, alpha."""
    drive = beltsim.presets.zhu_parker_2008(**preset)
    return beltsim.assemble(drive, Omega, friction=beltsim.Coulomb(Q_m), **SERIES[series])


def critical_torque(Omega: float, series: str = SHORT, **preset: float) -> float:
    """Q_cr of the paper's drive."""
    return beltsim.linear.critical_torque(problem(Omega, series, **preset))


def by_kind(
    series: str, low: float, high: float, locked: bool = False
) -> dict[str, list[Resonance]]:
    """Resonances in [low, high] by rising Omega: ``pulley`` modes and modes of ``span 1, 2, 3``."""
    drive = beltsim.presets.zhu_parker_2008()
    found = resonances(drive, low, high, locked=locked, **SERIES[series])
    kinds: dict[str, list[Resonance]] = {}
    for item in found:
        at = problem(item.Omega, series)
        shape = beltsim.linear.modes(at, locked).shapes[item.number - 1]
        kinds.setdefault(_kind(at, shape), []).append(item)
    return kinds


def _kind(at: Any, shape: np.ndarray) -> str:
    """``pulley`` or the span that carries the mode, from its kinetic energy."""
    energy = np.real(np.conj(shape) * (at.M @ shape))
    energy /= energy.sum()
    turning = sum(e for e, label in zip(energy, at.labels, strict=True) if label[:5] == "theta")
    if turning >= PULLEY_SHARE:
        return "pulley"
    spans = {f"span {i}": 0.0 for i in (1, 2, 3)}
    for share, label in zip(energy, at.labels, strict=True):
        if label.startswith("span"):
            spans[f"span {label[4]}"] += share
    return max(spans, key=lambda name: spans[name])


def first_crossing(f: Callable[[float], float], level: float, grid: np.ndarray) -> float:
    """First x on `grid` where f reaches `level` from below, refined."""
    from scipy.optimize import brentq

    before = f(float(grid[0]))
    for left, right in zip(grid[:-1].tolist(), grid[1:].tolist(), strict=True):
        after = f(right)
        if before < level <= after:
            return float(brentq(lambda x: f(x) - level, left, right, xtol=1e-10))
        before = after
    raise ValueError(f"{level} is not reached between {grid[0]} and {grid[-1]}")


def peak(f: Callable[[float], float], grid: np.ndarray) -> tuple[float, float]:
    """Place and height of the largest maximum of f on `grid`, refined."""
    from scipy.optimize import minimize_scalar

    values = [f(x) for x in grid.tolist()]
    i = int(np.argmax(values))
    left, right = grid[max(i - 1, 0)], grid[min(i + 1, len(grid) - 1)]
    best = minimize_scalar(lambda x: -f(x), bounds=(left, right), options={"xatol": 1e-8})
    return float(best.x), float(-best.fun)
