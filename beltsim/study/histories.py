"""`histories`: velocity of the arm and friction torque over one period, for several torques.

Depends on: model, study.methods, study.labelled, errors; drive for its type only; xarray.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from beltsim.model import assemble
from beltsim.response import Response
from beltsim.study.labelled import attributes, torque_units
from beltsim.study.methods import EventMap, Method
from beltsim.study.sweep import _grid

if TYPE_CHECKING:
    from beltsim.drive import Drive


def histories(
    drive: Drive,
    Omega: float,
    Q_m: Any,
    method: Method | None = None,
    *,
    samples: int = 2000,
    n_functions: int | Sequence[int] = 16,
    residual_flexibility: bool = True,
) -> Any:
    """Motion of the arm over one forcing period at `Omega`, for each torque of `Q_m` (nq,).

    Parameters
    ----------
    drive, Omega, method, n_functions, residual_flexibility
        As for `sweep`, at one speed.
    Q_m : (nq,)
        Finite torques.
    samples : int
        Intervals of equal length; both ends are included.

    Returns
    -------
    xarray.Dataset
        `angle`, `velocity` and `friction_torque` over (Q_m, phase), phase being time over the
        period; NaN and a reason in `failure` where there is no solution.

    Raises
    ------
    InvalidProblemError, InvalidDriveError, SteadyStateError
        For arguments that cannot be used.

    Examples
    --------
    >>> import beltsim
    >>> drive = beltsim.presets.zhu_parker_2008()
    >>> found = histories(drive, 6.3, [3.5, 6.1], samples=100, n_functions=6)
    >>> found.velocity.dims, float(found.velocity[0].max().round(3))
    (('Q_m', 'phase'), 0.353)
    """
    import xarray

    _, torques = _grid([Omega], Q_m)
    method = replace(method or EventMap(), samples_per_period=samples)
    at = assemble(drive, Omega, n_functions=n_functions, residual_flexibility=residual_flexibility)
    found = method.solve([at.with_friction(method.law(Q)) for Q in torques.tolist()])
    values = {name: np.full((len(torques), samples + 1), np.nan) for name in _TEXTS}
    for i, one in enumerate(found):
        if isinstance(one, Response):
            last = slice(-samples - 1, None)
            values["angle"][i] = one.q[last, at.joint]
            values["velocity"][i] = one.q_dot[last, at.joint]
            values["friction_torque"][i] = one.friction_torque[last]
    unit = at.scales.time_s if at.scales is not None else 1.0
    attrs = {
        "angle": {"units": "1", "si_unit": "rad", "si_scale": 1.0},
        "velocity": {"units": "1", "si_unit": "rad/s", "si_scale": 1.0 / unit},
        "friction_torque": torque_units(at),
    }
    variables: dict[str, Any] = {
        name: (("Q_m", "phase"), values[name], {"long_name": text, **attrs[name]})
        for name, text in _TEXTS.items()
    }
    reasons = ["" if isinstance(one, Response) else str(one) for one in found]
    variables["failure"] = ("Q_m", np.array(reasons, dtype=np.str_), {"long_name": "why"})
    coordinates = {
        "Q_m": (("Q_m",), torques, {"long_name": "friction torque", **torque_units(at)}),
        "phase": (
            ("phase",),
            np.linspace(0.0, 1.0, samples + 1),
            {"long_name": "time over period"},
        ),
    }
    about = {"Omega": float(Omega), "period": at.period, "method": repr(method)}
    about |= {"n_functions": str(n_functions), "residual_flexibility": int(residual_flexibility)}
    return xarray.Dataset(variables, coordinates, {**attributes(drive), **about})


_TEXTS = {
    "angle": "angle of the arm",
    "velocity": "velocity of the arm",
    "friction_torque": "friction torque of the arm",
}
