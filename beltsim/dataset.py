r"""A response as a labelled xarray dataset.

Values keep the problem's own units, so nothing is lost to rounding. Where the problem knows its
scales, a variable says what one unit is worth: attributes `si_scale` and `si_unit` (for the
coordinates, whose units differ, they name the dataset variables that hold one entry each), and
`time_s` repeats the sample times in seconds.

Complex numbers have a trailing axis `part` (real, imag). Kinds, qualities and modes are int8 flags
with `flag_values` and `flag_meanings` as in the CF conventions. What only exists for some
responses (spectra, multipliers, states at events) is absent where it does not.

The layout carries everything `beltsim.io.load` needs to make the same `Response` again, bit for
bit, and the number `SCHEMA_VERSION`: raise it with every change an older reader would get wrong.

Depends on: nothing (the types of `response` and `problem` only).
"""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from beltsim.friction import FrictionLaw
    from beltsim.problem import FrictionProblem
    from beltsim.response import EventLog, NearGrazing, Response

#: Version of the layout below.
SCHEMA_VERSION = 1
#: What the global attribute `kind` says of a response.
KIND = "beltsim response"
#: What the variable Omega is: of a drive with several orders, not its firing frequency.
FUNDAMENTAL = "forcing fundamental, 2 pi over the forcing period"
#: Codes on disk: the position in the tuple. Append only.
EVENT_KINDS = ("stick", "reverse", "slip+", "slip-")
EVENT_QUALITIES = ("simple", "near_grazing", "multiple")
TOUCH_KINDS = ("velocity", "reaction")
NO_YES = ("no", "yes")

Variable = tuple[tuple[str, ...], Any, dict[str, Any]]
Variables = dict[str, Variable]


def to_dataset(response: Response) -> Any:
    """`response` as an `xarray.Dataset` with units, labels, inputs and version.

    Parameters
    ----------
    response : Response
        Of any solver.

    Returns
    -------
    xarray.Dataset
        Samples `q`, `q_dot` (time, coordinate) and `friction_torque` (time), the problem's
        observables by name (time), events, figures of the last period, and the problem itself:
        matrices `M`, `C`, `G`, `K`, forcing, friction law, joint, labels, scales, observables.

    Examples
    --------
    >>> import beltsim
    >>> from beltsim.transient import integrate
    >>> forcing = beltsim.HarmonicForcing(1.0, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]])
    >>> law = beltsim.Coulomb(0.2)
    >>> problem = beltsim.FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[4.0]], 0, forcing, law)
    >>> data = to_dataset(integrate(problem, periods=2))
    >>> float(data.Q_m), data.M.dims
    (0.2, ('coordinate', 'column'))
    """
    import xarray

    problem = response.problem
    si = _SI(problem)
    variables = {
        **_problem_variables(problem, si),
        **_sample_variables(response, si),
        **_event_variables(response.events, si),
        **_touch_variables(response.near_grazing, si),
        **_figure_variables(response, si),
        **_spectrum_variables(response),
    }
    for name, values in _observed(response, taken=set(variables)).items():
        variables[name] = values
    coordinates = _coordinates(response, si)
    return xarray.Dataset(variables, coordinates, _attributes(response))


class _SI:
    """SI attributes of each sort of quantity; empty where the problem has no scales."""

    def __init__(self, problem: FrictionProblem) -> None:
        self.scales = problem.scales
        self.joint = problem.joint

    def fixed(self, scale: float, unit: str) -> dict[str, Any]:
        return {"units": "1", "si_scale": float(scale), "si_unit": unit}

    @property
    def time(self) -> dict[str, Any]:
        return self.fixed(self.scales.time_s, "s") if self.scales else {"units": "1"}

    @property
    def torque(self) -> dict[str, Any]:
        return self.fixed(self.scales.torque_N_m, "N m") if self.scales else {"units": "1"}

    @property
    def position(self) -> dict[str, Any]:
        if self.scales is None or self.joint is None:
            return {"units": "1"}
        return self.fixed(self.scales.coordinates[self.joint], self.scales.units[self.joint])

    @property
    def energy(self) -> dict[str, Any]:
        if self.scales is None or self.joint is None:
            return {"units": "1"}
        joint_scale = float(self.scales.coordinates[self.joint])
        return self.fixed(self.scales.torque_N_m * joint_scale, "J")

    def each(self, sort: str) -> dict[str, Any]:
        """Units of a quantity with one entry per coordinate; `sort` is coordinate or velocity."""
        if self.scales is None:
            return {"units": "1"}
        return {"units": "1", "si_scale": f"{sort}_si_scale", "si_unit": f"{sort}_si_unit"}


def _coordinates(response: Response, si: _SI) -> Variables:
    labels = np.array(response.problem.labels, dtype=np.str_)
    found: Variables = {
        "time": (("time",), response.t, {"long_name": "time since the start", **si.time}),
        "coordinate": (("coordinate",), labels, {"long_name": "name of the coordinate"}),
        "column": (("column",), labels, {"long_name": "name of the coordinate, as a column"}),
        "part": (("part",), np.array(["real", "imag"]), {"long_name": "part of a complex number"}),
    }
    if si.scales is not None:
        units = si.scales.units
        rate, rates = si.scales.coordinates / si.scales.time_s, [f"{unit}/s" for unit in units]
        seconds = response.t * si.scales.time_s
        found |= {
            "time_s": (("time",), seconds, {"long_name": "time since the start", "units": "s"}),
            "coordinate_si_scale": (("coordinate",), si.scales.coordinates, {}),
            "coordinate_si_unit": (("coordinate",), np.array(units, dtype=np.str_), {}),
            "velocity_si_scale": (("coordinate",), rate, {}),
            "velocity_si_unit": (("coordinate",), np.array(rates, dtype=np.str_), {}),
        }
    return found


def _problem_variables(problem: FrictionProblem, si: _SI) -> Variables:
    square = ("coordinate", "column")
    names = {"M": "mass", "C": "damping", "G": "gyroscopic", "K": "stiffness"}
    found: Variables = {
        letter: (square, getattr(problem, letter), {"long_name": f"{name} matrix", "units": "1"})
        for letter, name in names.items()
    }
    rows, note = ("harmonic", "coordinate"), "generalised force, factor of"
    found |= {
        "Omega": ((), problem.forcing.Omega, {"long_name": FUNDAMENTAL, "units": "1"}),
        "forcing_cos": (rows, problem.forcing.cos, {"long_name": f"{note} cos(k Omega t)"}),
        "forcing_sin": (rows, problem.forcing.sin, {"long_name": f"{note} sin(k Omega t)"}),
    }
    if problem.joint is not None:
        meaning = {"long_name": "index of the coordinate that carries the friction"}
        found["joint"] = ((), np.int32(problem.joint), meaning)
    if si.scales is not None:
        found["scale_time"] = ((), si.scales.time_s, {"units": "s"})
        found["scale_torque"] = ((), si.scales.torque_N_m, {"units": "N m"})
    return found | _law_variables(problem.friction, si) | _observable_variables(problem)


def _law_variables(law: FrictionLaw | None, si: _SI) -> Variables:
    texts = {
        "Q_m": "kinetic friction torque",
        "Q_s": "static friction torque",
        "sigma": "half width of the band in which the torque is a steep line",
    }
    units = {"Q_m": si.torque, "Q_s": si.torque, "sigma": {"units": "1"}}
    return {
        name: ((), getattr(law, name), {"long_name": text, **units[name]})
        for name, text in texts.items()
        if hasattr(law, name)
    }


def _observable_variables(problem: FrictionProblem) -> Variables:
    """The definitions of the observables; series are padded with zeros to the longest."""
    seen = problem.observables
    if not seen:
        return {}
    terms = np.array([len(one.cos) for one in seen], dtype=np.int32)
    series = {name: np.zeros((len(seen), terms.max())) for name in ("cos", "sin")}
    for i, one in enumerate(seen):
        series["cos"][i, : terms[i]], series["sin"][i, : terms[i]] = one.cos, one.sin
    one_each = ("observable",)
    return {
        "observable_name": (one_each, np.array([one.name for one in seen], dtype=np.str_), {}),
        "observable_row": (("observable", "coordinate"), np.array([one.row for one in seen]), {}),
        "observable_cos": (("observable", "observable_harmonic"), series["cos"], {}),
        "observable_sin": (("observable", "observable_harmonic"), series["sin"], {}),
        "observable_terms": (one_each, terms, {"long_name": "length of its series, unpadded"}),
        "observable_lower": (one_each, np.array([one.lower for one in seen]), {}),
        "observable_upper": (one_each, np.array([one.upper for one in seen]), {}),
        "observable_si_scale": (one_each, np.array([one.scale for one in seen]), {}),
        "observable_si_unit": (one_each, np.array([one.unit for one in seen], dtype=np.str_), {}),
    }


def _observed(response: Response, taken: set[str]) -> Variables:
    """Each observable at the samples, as a variable of its own."""
    found: Variables = {}
    for one in response.problem.observables:
        name = re.sub(r"\W+", "_", one.name).strip("_") or "observable"
        while name in taken:
            name += "_observed"
        taken.add(name)
        with np.errstate(over="ignore", invalid="ignore"):  # samples beyond all bounds stay so
            values = one.at(response.t, response.q, response.problem.forcing.Omega)
        limits = {"lower_limit": float(one.lower), "upper_limit": float(one.upper)}
        units = {"units": "1", "si_scale": float(one.scale), "si_unit": one.unit}
        found[name] = (("time",), values, {"long_name": one.name, **units, **limits})
    return found


def _sample_variables(response: Response, si: _SI) -> Variables:
    n, samples, one = response.problem.n, ("time", "coordinate"), ("coordinate",)
    position, velocity = si.each("coordinate"), si.each("velocity")
    first, last = response.initial_state, response.final_state
    torque = {"long_name": "friction torque of the joint", **si.torque}
    return {
        "q": (samples, response.q, {"long_name": "coordinates", **position}),
        "q_dot": (samples, response.q_dot, {"long_name": "velocities", **velocity}),
        "friction_torque": (("time",), response.friction_torque, torque),
        "initial_q": (one, first[:n], {"long_name": "coordinates at the start", **position}),
        "initial_q_dot": (one, first[n:], {"long_name": "velocities at the start", **velocity}),
        "final_q": (one, last[:n], {"long_name": "coordinates at the end", **position}),
        "final_q_dot": (one, last[n:], {"long_name": "velocities at the end", **velocity}),
    }


def _event_variables(events: EventLog, si: _SI) -> Variables:
    each, states = ("event",), ("event", "coordinate")
    torque = "friction torque just"
    found: Variables = {
        "event_time": (each, events.t, {"long_name": "time of the event", **si.time}),
        "event_kind": _flags("event", events.kind, EVENT_KINDS),
        "event_quality": _flags("event", events.quality, EVENT_QUALITIES),
        "event_position": (each, events.position, {"long_name": "joint coordinate", **si.position}),
        "event_torque_before": (
            each,
            events.torque_before,
            {"long_name": f"{torque} before", **si.torque},
        ),
        "event_torque_after": (
            each,
            events.torque_after,
            {"long_name": f"{torque} after", **si.torque},
        ),
        "event_margin": (
            each,
            events.margin,
            {"long_name": "relative distance to the other outcome", "units": "1"},
        ),
    }
    if events.q.shape[1]:
        found["event_q"] = (states, events.q, {"long_name": "coordinates", **si.each("coordinate")})
        found["event_q_dot"] = (
            states,
            events.q_dot,
            {"long_name": "velocities", **si.each("velocity")},
        )
    return found


def _touch_variables(touches: NearGrazing, si: _SI) -> Variables:
    note = "how close it came, over the largest value of the same quantity"
    return {
        "touch_time": (("touch",), touches.t, {"long_name": "time of a near touch", **si.time}),
        "touch_margin": (("touch",), touches.margin, {"long_name": note, "units": "1"}),
        "touch_kind": _flags("touch", touches.kind, TOUCH_KINDS),
    }


def _figure_variables(response: Response, si: _SI) -> Variables:
    one = {"units": "1"}
    texts: dict[str, tuple[str, dict[str, Any]]] = {
        "stick_fraction": ("share of the window spent sticking", one),
        "dissipated_energy": ("friction loss in the window", si.energy),
        "velocity_reversals": ("velocity reversals nu", one),
        "stops_per_period": ("stops per forcing period", one),
        "energy_balance_residual": ("gap in the energy balance, relative", one),
        "period_residual": ("change of the state over the window, relative", one),
        "total_dissipated_energy": ("friction loss of the whole run", si.energy),
    }
    found: Variables = {
        name: ((), np.float64(getattr(response, name)), {"long_name": text, **units})
        for name, (text, units) in texts.items()
        if getattr(response, name) is not None
    }
    found["periodic"] = _flags(None, NO_YES[bool(response.periodic)], NO_YES)
    window = {"long_name": "start and end of the window of the figures", **si.time}
    found["window"] = (("bound",), np.array(response.window, dtype=np.float64), window)
    if response.rest_interval is not None:
        rest = {"long_name": "lowest and highest rest position of the joint", **si.position}
        found["rest_interval"] = (("bound",), np.array(response.rest_interval, np.float64), rest)
    return found


def _spectrum_variables(response: Response) -> Variables:
    dims = {
        "coefficients": ("series_harmonic", "coordinate", "part"),
        "torque_coefficients": ("series_harmonic", "part"),
        "multipliers": ("multiplier", "part"),
    }
    return {
        name: (axes, _parts(getattr(response, name)), {"units": "1"})
        for name, axes in dims.items()
        if getattr(response, name) is not None
    }


def _parts(values: Any) -> Any:
    """Complex `values` with a trailing axis of length 2."""
    values = np.asarray(values, dtype=np.complex128)
    return np.stack([values.real, values.imag], axis=-1)


def _flags(dim: str | None, names: Any, meanings: tuple[str, ...]) -> Variable:
    """Names as int8 codes, with the attributes that explain them."""
    codes = np.array([meanings.index(str(name)) for name in np.atleast_1d(names)], dtype=np.int8)
    explained = {
        "flag_values": np.arange(len(meanings), dtype=np.int8),
        "flag_meanings": " ".join(meanings),
    }
    return ((dim,), codes, explained) if dim else ((), codes[0], explained)


def _attributes(response: Response) -> dict[str, Any]:
    import beltsim

    problem = response.problem
    found: dict[str, Any] = {
        "title": "motion of a linear system with a dry-friction joint",
        "Conventions": "CF-1.11",
        "kind": KIND,
        "schema_version": SCHEMA_VERSION,
        "beltsim_version": beltsim.__version__,
        "friction_law": type(problem.friction).__name__ if problem.friction else "none",
        "warnings": json.dumps(list(response.warnings), ensure_ascii=False),
        "problem_warnings": json.dumps(list(problem.warnings), ensure_ascii=False),
        "statistics": json.dumps(dict(response.statistics), default=_plain),
    }
    if response.initial_mode is not None:
        found["initial_mode"] = response.initial_mode
    return found


def _plain(value: Any) -> Any:
    """NumPy numbers and arrays as what JSON knows."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"a statistic must be a number or text, not {type(value).__name__}")
