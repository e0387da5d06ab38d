"""`critical_torques`: the friction torque that locks the arm, over speed.

Depends on: model, linear, study.labelled, errors; drive for its type only; xarray.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from beltsim import linear
from beltsim.checks import finite_array
from beltsim.errors import (
    BeltsimError,
    InvalidDriveError,
    InvalidProblemError,
    Mistake,
)
from beltsim.model import assemble
from beltsim.study.labelled import attributes, axes, torque_units

if TYPE_CHECKING:
    from beltsim.drive import Drive


def critical_torques(
    drive: Drive,
    Omega: Any,
    *,
    n_functions: int | Sequence[int] = 16,
    residual_flexibility: bool = True,
) -> Any:
    """Critical torque Q_cr (eq. 26) of `drive` over `Omega` (no,).

    Returns
    -------
    xarray.Dataset
        `Q_cr` over Omega; a speed without steady state holds NaN, and its reason in `failure`.

    Raises
    ------
    InvalidProblemError, InvalidDriveError
        For speeds or a drive that cannot be used.

    Examples
    --------
    >>> import beltsim
    >>> drive = beltsim.presets.zhu_parker_2008()
    >>> critical_torques(drive, [2.8, 6.3], n_functions=8).Q_cr.values.round(2).tolist()
    [0.49, 11.95]
    """
    import xarray

    speeds = finite_array(Omega, 1)
    if speeds is None or not len(speeds) or not (speeds > 0.0).all():
        raise InvalidProblemError(Mistake("Omega", Omega, "a list of finite numbers > 0"))
    values, reasons, known = np.full(len(speeds), np.nan), [], None
    failure: BeltsimError | None = None
    for i, speed in enumerate(speeds.tolist()):
        try:
            known = assemble(
                drive, speed, n_functions=n_functions, residual_flexibility=residual_flexibility
            )
            values[i] = linear.critical_torque(known)
            reasons.append("")
        except (InvalidDriveError, InvalidProblemError):
            raise
        except BeltsimError as error:
            failure = error
            reasons.append(str(error))
    if known is None:
        assert failure is not None
        raise failure
    text = {"long_name": "torque that keeps the arm locked (eq. 26)", **torque_units(known)}
    variables = {
        "Q_cr": (("Omega",), values, text),
        "failure": (("Omega",), np.array(reasons, dtype=np.str_), {"long_name": "why"}),
    }
    about = {"n_functions": str(n_functions), "residual_flexibility": int(residual_flexibility)}
    return xarray.Dataset(variables, axes(drive, known, speeds), {**attributes(drive), **about})
