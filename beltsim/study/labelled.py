"""Measures on a grid as a labelled dataset, with units and what a unit is worth in SI.

Values are dimensionless, as in the paper. Attribute `si_scale` and `si_unit` convert; for the
coordinates, whose units differ, the variables `coordinate_si_scale` and `coordinate_si_unit` do.

Depends on: problem, errors, study.measures; xarray.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

import beltsim
from beltsim.checks import FloatArray
from beltsim.metrics.span_rms import sines_of
from beltsim.metrics.span_tensions import tensions_of
from beltsim.problem import FrictionProblem
from beltsim.study.measures import FIGURES, MORE

if TYPE_CHECKING:
    from beltsim.drive import Drive

#: What the global attribute `kind` says of a study.
KIND = "beltsim study"


def labelled(
    drive: Drive,
    problem: FrictionProblem,
    speeds: FloatArray,
    torques: tuple[FloatArray, bool],
    values: Any,
    spectra: tuple[tuple[str, ...], int],
    about: dict[str, Any],
) -> Any:
    """The dataset of `values` (no, nq), whose entries are dicts of measures or errors.

    `problem` is any one of the grid: it lends labels and scales. `torques` are (nq,) and whether
    they are shares of the critical torque; `spectra` are labels and the highest harmonic.
    """
    import xarray

    signals, harmonics = spectra
    second = "share" if torques[1] else "Q_m"

    def gathered(name: str, *shape: int) -> FloatArray:
        found = np.full((*values.shape, *shape), np.nan)
        for place, one in np.ndenumerate(values):
            if isinstance(one, dict):
                found[place] = one[name]
        return found

    grid, spans = ("Omega", second), len(sines_of(problem))
    joint_torque = problem.scales.torque_N_m if problem.scales else 1.0
    energy = _si(problem, joint_torque * _joint_scale(problem), "J")
    variables: dict[str, Any] = {
        name: (grid, gathered(name), {"long_name": text, "units": "1"})
        for name, text in {**FIGURES, **MORE}.items()
    }
    variables["dissipated_energy"][2].update(energy)
    variables["rms"] = (
        (*grid, "coordinate"),
        gathered("rms", problem.n),
        {"long_name": "root mean square over a period", "units": "1"},
    )
    variables["span_rms"] = (
        (*grid, "span"),
        gathered("span_rms", spans),
        {"long_name": "root mean square of the deflection averaged along the span (eq. 24)"},
    )
    newtons = tensions_of(problem)[0].scale
    variables["peak_dynamic_tension"] = (
        (*grid, "span"),
        gathered("peak_dynamic_tension", spans),
        {"long_name": "largest dynamic tension (eq. 28)", **_si(problem, newtons, "N")},
    )
    variables["lowest_tension"] = (
        (*grid, "span"),
        gathered("lowest_tension", spans),
        {"long_name": "lowest tension, steady and dynamic", **_si(problem, newtons, "N")},
    )
    if signals:
        variables["amplitude"] = (
            (*grid, "signal", "harmonic"),
            gathered("amplitude", len(signals), harmonics + 1),
            {"long_name": "amplitude of a harmonic", "units": "1"},
        )
    if second == "share":
        variables["Q_m"] = (grid, gathered("Q_m"), _torque_text(problem, "Q_m"))
    texts = {"phase_pattern": "modes of a period: + and - slip, 0 stick", "failure": "why"}
    variables["phase_pattern"] = (grid, _texts(values, "phase_pattern"), {})
    variables["failure"] = (grid, _texts(values, None), {})
    for name, text in texts.items():
        variables[name][2]["long_name"] = text
    coordinates = {
        **axes(drive, problem, speeds),
        second: ((second,), torques[0], _torque_text(problem, second)),
        "coordinate": (("coordinate",), np.array(problem.labels, dtype=np.str_), {}),
        "span": (("span",), np.arange(1, spans + 1, dtype=np.int32), {}),
    }
    if problem.scales is not None:
        units = np.array(problem.scales.units, dtype=np.str_)
        coordinates["coordinate_si_scale"] = (("coordinate",), problem.scales.coordinates, {})
        coordinates["coordinate_si_unit"] = (("coordinate",), units, {})
        lengths = [problem.scales.coordinates[sines[0]] for sines in sines_of(problem)]
        coordinates["span_length_m"] = (("span",), np.array(lengths), {"units": "m"})
    if signals:
        coordinates["signal"] = (("signal",), np.array(signals, dtype=np.str_), {})
        coordinates["harmonic"] = (("harmonic",), np.arange(harmonics + 1, dtype=np.int32), {})
    return xarray.Dataset(variables, coordinates, {**attributes(drive), **about})


def _torque_text(problem: FrictionProblem, name: str) -> dict[str, Any]:
    if name == "share":
        return {"long_name": "friction torque over the critical torque", "units": "1"}
    return {"long_name": "friction torque", **torque_units(problem)}


def axes(drive: Drive, problem: FrictionProblem, speeds: FloatArray) -> dict[str, Any]:
    """The speed as a coordinate, dimensionless and in rpm."""
    rpm = np.array([drive.rpm(speed) for speed in speeds.tolist()])
    rate = _si(problem, 1.0 / problem.scales.time_s if problem.scales else 1.0, "rad/s")
    return {
        "Omega": (("Omega",), speeds, {"long_name": "firing frequency", **rate}),
        "crank_speed": (("Omega",), rpm, {"long_name": "crank speed", "units": "rpm"}),
    }


def torque_units(problem: FrictionProblem) -> dict[str, Any]:
    """Attributes of a friction torque."""
    return _si(problem, problem.scales.torque_N_m if problem.scales else 1.0, "N m")


def attributes(drive: Drive) -> dict[str, Any]:
    """Global attributes: what made this, and from which drive."""
    return {
        "kind": KIND,
        "beltsim_version": beltsim.__version__,
        "drive": drive.name,
        "drive_json": drive.model_dump_json(exclude_none=True),
    }


def _si(problem: FrictionProblem, scale: float, unit: str) -> dict[str, Any]:
    known = {"si_scale": float(scale), "si_unit": unit} if problem.scales is not None else {}
    return {"units": "1", **known}


def _joint_scale(problem: FrictionProblem) -> float:
    if problem.scales is None or problem.joint is None:
        return 1.0
    return float(problem.scales.coordinates[problem.joint])


def _texts(values: Any, name: str | None) -> Any:
    """A text per point: a measure, or (None) the reason of a failure."""
    found = np.full(values.shape, "", dtype=object)
    for place, one in np.ndenumerate(values):
        if isinstance(one, dict):
            found[place] = one[name] if name else ""
        elif name is None:
            found[place] = str(one)
    return found.astype(np.str_)
