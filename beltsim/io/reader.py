"""Reading a response back from a netCDF file, bit for bit.

A netCDF 4 file is an HDF5 file; h5py alone reads it in a twentieth of the time xarray takes.
The problem is built anew from its stored matrices and so passes the same checks as any other.

Depends on: dataset, errors, forcing, friction, problem, response.
"""

from __future__ import annotations

import json
from collections import UserDict
from pathlib import Path
from typing import Any

import numpy as np

from beltsim.dataset import (
    EVENT_KINDS,
    EVENT_QUALITIES,
    KIND,
    NO_YES,
    SCHEMA_VERSION,
    TOUCH_KINDS,
)
from beltsim.errors import ResultFileError
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, FrictionLaw, SaturatedCoulomb
from beltsim.problem import FrictionProblem, Observable, Scales
from beltsim.response import EventLog, NearGrazing, Response

#: First bytes of every HDF5 file, and so of every netCDF 4 file.
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def is_result_file(path: str | Path) -> bool:
    """Whether `path` is an HDF5 file, by its first bytes; False where it cannot be read."""
    try:
        if not Path(path).is_file():  # a pipe would make us wait
            return False
        with Path(path).open("rb") as file:
            return file.read(len(HDF5_SIGNATURE)) == HDF5_SIGNATURE
    except (OSError, ValueError):  # ValueError: a null character in the path
        return False


def load(path: str | Path) -> Response:
    """The response stored in `path` by `save`, bit for bit.

    Parameters
    ----------
    path : str or Path
        A result file.

    Returns
    -------
    Response

    Raises
    ------
    ResultFileError
        When the file is missing, is no result of beltsim, is cut short or damaged, or was written
        by a newer version in a layout this one does not know.
    """
    data = _stored(path)
    try:
        return _response(data)
    except (KeyError, ValueError, TypeError, IndexError, AttributeError) as error:
        raise ResultFileError(f"{path} is damaged: {error}") from error


def stored_inputs(path: str | Path) -> dict[str, Any]:
    """What the run stored in `path` was started with: the `inputs` given to `save`.

    Raises
    ------
    ResultFileError
        As `load`.
    """
    try:
        found = json.loads(_stored(path, values=False).attributes["inputs"])
    except (KeyError, ValueError, TypeError) as error:
        raise ResultFileError(f"{path} is damaged: no inputs in it ({error})") from error
    if not isinstance(found, dict):
        raise ResultFileError(f"{path} is damaged: its inputs are no table")
    return found


class _Stored(UserDict[str, Any]):
    """The content of a file: arrays by the names of `beltsim.dataset`, and its attributes."""

    def __init__(self, arrays: dict[str, Any], attributes: dict[str, Any]) -> None:
        super().__init__(arrays)
        self.attributes = attributes


def _stored(path: str | Path, values: bool = True) -> _Stored:
    """What is in `path`, once it is known to be ours and of a version we can read."""
    import h5py

    if not Path(path).exists():
        raise ResultFileError(f"{path}: no such file")
    if not is_result_file(path):
        raise ResultFileError(f"{path} is no result file: it is not netCDF")
    try:
        with h5py.File(path, "r") as file:
            attributes = dict(file.attrs)
            _require_known(path, attributes)
            arrays = {name: _array(file[name]) for name in file} if values else {}
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        raise ResultFileError(f"{path} is cut short or damaged: {error}") from error
    return _Stored(arrays, attributes)


def _require_known(path: str | Path, attributes: dict[str, Any]) -> None:
    if attributes.get("kind") != KIND and "beltsim_version" in attributes:
        title = attributes.get("title", "a study")
        raise ResultFileError(
            f"{path} is a table of beltsim ({title}) and holds no motion; "
            "open it with xarray.open_dataset"
        )
    if attributes.get("kind") != KIND:
        raise ResultFileError(f"{path} is no result file: netCDF, but not written by beltsim")
    version = np.ravel(attributes["schema_version"])  # netCDF has numbers as arrays of one
    if len(version) != 1 or version.dtype.kind != "i":
        raise ResultFileError(f"{path} is damaged: its schema version is {version}")
    if version[0] > SCHEMA_VERSION:
        writer = attributes.get("beltsim_version", "of unknown version")
        raise ResultFileError(
            f"{path} has layout {version[0]}, written by beltsim {writer}; this one reads layouts "
            f"up to {SCHEMA_VERSION}: install a newer beltsim"
        )


def _array(stored: Any) -> Any:
    """The values of one HDF5 dataset; text as str."""
    return (stored.asstr() if stored.dtype.kind == "O" else stored)[()]


def _response(data: _Stored) -> Response:
    problem = _problem(data)
    names = ("stick_fraction", "dissipated_energy", "velocity_reversals", "stops_per_period")
    figures: dict[str, Any] = {name: float(data[name]) for name in names}
    figures["energy_balance_residual"] = float(data["energy_balance_residual"])
    for name in ("period_residual", "total_dissipated_energy"):
        figures[name] = float(data[name]) if name in data else None
    for name in ("coefficients", "torque_coefficients", "multipliers"):
        figures[name] = _complex(data[name]) if name in data else None
    return Response(
        problem=problem,
        t=data["time"],
        q=data["q"],
        q_dot=data["q_dot"],
        friction_torque=data["friction_torque"],
        initial_state=np.concatenate([data["initial_q"], data["initial_q_dot"]]),
        final_state=np.concatenate([data["final_q"], data["final_q_dot"]]),
        initial_mode=data.attributes.get("initial_mode"),
        events=_events(data),
        near_grazing=NearGrazing(
            data["touch_time"],
            data["touch_margin"],
            _names(data["touch_kind"], TOUCH_KINDS),
        ),
        window=_pair(data["window"]),
        periodic=bool(NO_YES.index(str(_names(data["periodic"], NO_YES)))),
        rest_interval=_pair(data["rest_interval"]) if "rest_interval" in data else None,
        warnings=tuple(json.loads(data.attributes["warnings"])),
        statistics=json.loads(data.attributes["statistics"]),
        **figures,
    )


def _problem(data: _Stored) -> FrictionProblem:
    omega, rows = (
        float(data["Omega"]),
        (data["forcing_cos"], data["forcing_sin"]),
    )
    scales = None
    if "scale_time" in data:
        scales = Scales(
            float(data["scale_time"]),
            float(data["scale_torque"]),
            data["coordinate_si_scale"],
            _texts(data["coordinate_si_unit"]),
        )
    return FrictionProblem(
        **{letter: data[letter] for letter in "MCGK"},
        joint=int(data["joint"]) if "joint" in data else None,
        forcing=HarmonicForcing(omega, *rows),
        friction=_law(data),
        labels=_texts(data["coordinate"]),
        scales=scales,
        observables=tuple(_observables(data)),
        warnings=tuple(json.loads(data.attributes["problem_warnings"])),
    )


def _law(data: _Stored) -> FrictionLaw | None:
    name = data.attributes["friction_law"]
    if name == "none":
        return None
    if name == "Coulomb":
        return Coulomb(float(data["Q_m"]), float(data["Q_s"]))
    if name == "SaturatedCoulomb":
        return SaturatedCoulomb(float(data["Q_m"]), float(data["sigma"]))
    raise ValueError(f"unknown friction law {name!r}")


def _observables(data: _Stored) -> list[Observable]:
    if "observable_name" not in data:
        return []
    names, units = _texts(data["observable_name"]), _texts(data["observable_si_unit"])
    return [
        Observable(
            name=names[i],
            row=data["observable_row"][i],
            cos=data["observable_cos"][i, :length],
            sin=data["observable_sin"][i, :length],
            lower=float(data["observable_lower"][i]),
            upper=float(data["observable_upper"][i]),
            scale=float(data["observable_si_scale"][i]),
            unit=units[i],
        )
        for i, length in enumerate(data["observable_terms"])
    ]


def _events(data: _Stored) -> EventLog:
    none = np.zeros((len(data["event_time"]), 0))
    return EventLog(
        t=data["event_time"],
        kind=_names(data["event_kind"], EVENT_KINDS),
        q=data.get("event_q", none),
        q_dot=data.get("event_q_dot", none),
        position=data["event_position"],
        torque_before=data["event_torque_before"],
        torque_after=data["event_torque_after"],
        quality=_names(data["event_quality"], EVENT_QUALITIES),
        margin=data["event_margin"],
    )


def _names(codes: Any, meanings: tuple[str, ...]) -> Any:
    """Flag codes back to their names; a negative code is no name."""
    if np.any(codes < 0):
        raise ValueError(f"unknown code {np.min(codes)} where one of {', '.join(meanings)} stands")
    return np.array(meanings, dtype=np.str_)[codes]


def _complex(parts: Any) -> Any:
    """The complex array whose real and imaginary parts lie along the last axis."""
    values = np.empty(parts.shape[:-1], dtype=np.complex128)
    values.real, values.imag = parts[..., 0], parts[..., 1]  # keeps the signs of zeros
    return values


def _texts(values: Any) -> tuple[str, ...]:
    return tuple(str(text) for text in values)


def _pair(values: Any) -> tuple[float, float]:
    low, high = (float(value) for value in values)
    return low, high
