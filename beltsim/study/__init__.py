"""Parameter studies: a drive and a grid in, one labelled dataset out.

`sweep` covers grids of speed and friction torque with any solver, `critical_torques` the torque
that locks the arm over speed, `histories` the motion of the arm over one period. Points that fail
are kept with their reason. `combined` puts datasets of several methods side by side, and
`beltsim.io.save_dataset` writes them. `balance` is harmonic balance that fetches the pattern of
events, which Q_s > Q_m needs, from the exact orbit.

Depends on: drive, model, metrics, linear and all solvers; xarray.
"""

from __future__ import annotations

from beltsim.study.balance import balance, pattern_of
from beltsim.study.combined import combined
from beltsim.study.histories import histories
from beltsim.study.locking import critical_torques
from beltsim.study.methods import EventMap, HarmonicBalance, Method, Transient
from beltsim.study.sweep import sweep

__all__ = [
    "EventMap",
    "HarmonicBalance",
    "Method",
    "Transient",
    "balance",
    "combined",
    "critical_torques",
    "histories",
    "pattern_of",
    "sweep",
]
