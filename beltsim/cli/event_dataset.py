"""The event study of `beltsim events` as a labelled dataset.

Depends on: response, problem, errors; cli.events; xarray.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

import beltsim
from beltsim.errors import BeltsimError
from beltsim.problem import FrictionProblem
from beltsim.response import EVENT_KINDS, Response

#: Figures of an orbit that are stored under their own name, and what they are.
FIGURES = {
    "stick_fraction": "share of the period spent sticking",
    "dissipated_energy": "friction loss of the whole orbit, units of torque",
    "velocity_reversals": "nu",
    "stops_per_period": "stops per forcing period",
    "period_residual": "how far the orbit is from closed",
    "energy_balance_residual": "gap of the energy balance, relative",
}


def dataset(
    problem: FrictionProblem, found: list[tuple[float, Response | BeltsimError]], Q_cr: float
) -> Any:
    """Figures, multipliers and padded event lists over Q_m; a failed orbit is NaN and a reason."""
    orbits = [one if isinstance(one, Response) else None for _, one in found]
    most = max([len(orbit.events) for orbit in orbits if orbit is not None], default=0)
    times = np.full((len(found), most), np.nan)
    kinds = np.full((len(found), most), -1, dtype=np.int8)
    multipliers = np.full((len(found), 2 * problem.n), np.nan)
    for i, orbit in enumerate(orbits):
        if orbit is None:
            continue
        count = len(orbit.events)
        times[i, :count] = orbit.events.t / problem.period
        kinds[i, :count] = [EVENT_KINDS.index(kind) for kind in orbit.events.kind]
        multipliers[i] = np.sort(np.abs(np.asarray(orbit.multipliers)))[::-1]
    figures = {
        name: ("Q_m", _column(orbits, name), {"long_name": text}) for name, text in FIGURES.items()
    }
    reasons = [str(one) if not isinstance(one, Response) else "" for _, one in found]
    names = " ".join(EVENT_KINDS)
    multiple = [1 if one is None else int(one.statistics.get("multiple", 1)) for one in orbits]
    about_multiple = {"long_name": "period of the orbit in forcing periods"}
    variables = {
        **figures,
        "period_multiple": ("Q_m", np.array(multiple, dtype=np.int32), about_multiple),
        "event_time": (("Q_m", "event"), times, {"long_name": "time over forcing period"}),
        "event_kind": (("Q_m", "event"), kinds, {"flag_meanings": names, "missing": -1}),
        "multiplier": (("Q_m", "mode"), multipliers, {"long_name": "modulus, largest first"}),
        "failure": ("Q_m", np.array(reasons, dtype=np.str_)),
    }
    coordinates: dict[str, Any] = {"Q_m": [Q for Q, _ in found]}
    if problem.scales is not None:
        torque = np.array([Q for Q, _ in found]) * problem.scales.torque_N_m
        coordinates["friction_torque"] = ("Q_m", torque, {"units": "N m"})
    about = {
        "title": "periodic motions over the friction torque",
        "beltsim_version": beltsim.__version__,
        "Omega": problem.forcing.Omega,
        "Omega_long_name": "fundamental of the forcing, 2 pi over its period",
        "Q_m_cr": Q_cr,
    }
    return xr.Dataset(variables, coordinates, about)


def _column(orbits: list[Response | None], name: str) -> Any:
    values = [np.nan if orbit is None else getattr(orbit, name) for orbit in orbits]
    return np.array(values, dtype=float)
