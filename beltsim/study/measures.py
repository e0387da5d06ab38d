"""What a study keeps of one response: figures, root mean squares, tensions, spectra.

Depends on: response, problem, linear, metrics, event_map (surveys), harmonic_balance (the count of
reversals of a series), study.methods.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from beltsim import linear
from beltsim.errors import BeltsimError
from beltsim.event_map import Survey
from beltsim.harmonic_balance import reversals_of_series
from beltsim.metrics.phase_pattern import phase_pattern
from beltsim.metrics.rms import rms_of_coefficients
from beltsim.metrics.span_rms import span_rms
from beltsim.metrics.span_tensions import (
    dynamic_tensions,
    peak_dynamic_tensions,
    steady_tensions,
    tension_harmonics,
    tensions_of,
)
from beltsim.problem import FrictionProblem
from beltsim.response import Response
from beltsim.study.methods import EventMap, HarmonicBalance, Method

#: Scalars that a study keeps under the name they have in a response.
FIGURES = {
    "dissipated_energy": "friction loss per forcing period",
    "stick_fraction": "share of the period spent sticking",
    "stops_per_period": "stops per forcing period",
    "velocity_reversals": "nu, from events (of a smoothed series: crossings of its band)",
}
#: Samples per wave of the highest harmonic when the top of a series is looked for: with a parabola
#: through the best three the height is within 1e-5 of it.
PER_WAVE = 16
#: Scalars that a study adds.
MORE = {
    "reversals_of_series": "nu, sign changes of the truncated velocity series",
    "phases_per_period": "phases (slips and sticks) per forcing period",
    "period_multiple": "period of the response in forcing periods",
    "largest_multiplier": "largest modulus of a Floquet multiplier; above 1 unstable",
    "coexisting": "1 where the arm rests and, for Q_m < Q_cr <= Q_s, may also move; else 0",
}


def measured(
    response: Response | BeltsimError, method: Method, signals: tuple[int, ...], harmonics: int
) -> Any:
    """Values of one point by name, or its error raised; `signals` are indices of coordinates."""
    if isinstance(response, BeltsimError):
        raise response
    problem, c = response.problem, response.coefficients
    multiple = float(response.statistics.get("multiple", 1))
    rms = method.rms(response)
    peak, lowest = _tensions(response)
    if isinstance(method, EventMap) and method.harmonics < problem.forcing.n_harmonics:
        peak = lowest = np.full(len(peak), np.nan)  # too short a series says nothing of tensions
    found = {name: getattr(response, name) for name in FIGURES}
    return found | {
        "dissipated_energy": response.dissipated_energy / multiple,
        "rms": rms,
        "span_rms": span_rms(problem, rms),
        "peak_dynamic_tension": peak,
        "lowest_tension": lowest,
        "reversals_of_series": _series_reversals(response, method),
        "phases_per_period": _phases(response) / multiple,
        "period_multiple": multiple,
        "largest_multiplier": _largest(response.multipliers),
        "coexisting": float(_rests(response) and _may_move(problem)),
        "phase_pattern": phase_pattern(response),
        "amplitude": _amplitudes(c, signals, harmonics),
    }


def surveyed(row: int, problem: FrictionProblem, found: Survey, harmonics: int) -> Any:
    """The same values for a row of a survey, as far as it has them; raises why there is none."""
    if row in found.failures:
        raise found.failures[row]
    spans = np.full(len(tensions_of(problem)), np.nan)
    rests = bool(found.locked[row])
    return {
        **dict.fromkeys(MORE, np.nan),
        **{name: float(getattr(found, name)[row]) for name in FIGURES},
        "rms": found.rms[row],
        "span_rms": span_rms(problem, found.rms[row]),
        "peak_dynamic_tension": spans,
        "lowest_tension": spans,
        "largest_multiplier": _largest(found.multipliers[row]),
        "coexisting": float(rests and _may_move(problem)),
        "phase_pattern": "",
        "amplitude": _amplitudes(None, (), harmonics),
    }


def measured_locked(problem: FrictionProblem, signals: tuple[int, ...], harmonics: int) -> Any:
    """The same values for an arm that is locked for good: a linear response."""
    c = linear.response(problem, locked=True)
    rms = rms_of_coefficients(c)
    lowest = _lowest(problem, _over_a_period(problem, c))
    return {
        "dissipated_energy": 0.0,
        "stick_fraction": 1.0,
        "stops_per_period": 0.0,
        "velocity_reversals": 0.0,
        "rms": rms,
        "span_rms": span_rms(problem, rms),
        "peak_dynamic_tension": peak_dynamic_tensions(problem, c),
        "lowest_tension": lowest,
        "reversals_of_series": 0.0,
        "phases_per_period": 1.0,
        "period_multiple": 1.0,
        "largest_multiplier": np.nan,
        "coexisting": 0.0,
        "phase_pattern": "0",
        "amplitude": _amplitudes(c, signals, harmonics),
    }


def _largest(multipliers: Any) -> float:
    return np.nan if multipliers is None else float(np.abs(multipliers).max(initial=0.0))


def _rests(response: Response) -> bool:
    return not len(response.events) and response.initial_mode == "stick"


def _may_move(problem: FrictionProblem) -> bool:
    """Whether the kinetic torque alone would not hold the joint, so that motion feeds itself."""
    law = problem.friction
    return law is not None and law.Q_m < linear.critical_torque(problem)


def _tensions(response: Response) -> tuple[Any, Any]:
    """Largest |P_d| and lowest tension of each span: of the series, or else over the samples."""
    problem = response.problem
    if response.coefficients is None:
        values = dynamic_tensions(response)
        return np.abs(values).max(axis=0), _lowest(problem, values)
    values = _over_a_period(problem, response.coefficients)
    size, count = np.abs(values), len(values)
    top, spans = size.argmax(axis=0), np.arange(size.shape[1])
    left, middle, right = (size[(top + k) % count, spans] for k in (-1, 0, 1))
    bend = left - 2.0 * middle + right  # the parabola through the top and its neighbours
    peak = middle - (right - left) ** 2 / (8.0 * np.where(bend < 0.0, bend, -np.inf))
    return peak, _lowest(problem, values)


def _over_a_period(problem: FrictionProblem, coefficients: Any) -> Any:
    """Samples (nt, ns) of the dynamic tensions of a series."""
    c = tension_harmonics(problem, coefficients)
    count = PER_WAVE * len(c)
    spectrum = np.zeros((count // 2 + 1, c.shape[1]), dtype=complex)
    spectrum[: len(c)] = 0.5 * count * c
    spectrum[0] *= 2.0
    return np.fft.irfft(spectrum, count, axis=0)


def _lowest(problem: FrictionProblem, values: Any) -> Any:
    return steady_tensions(problem) + values.min(axis=0)


def _series_reversals(response: Response, method: Method) -> float:
    """Reversals of the series itself; not defined for solvers that are not series."""
    if not isinstance(method, HarmonicBalance):
        return np.nan
    assert response.coefficients is not None
    joint = response.coefficients[:, response.problem.joint]
    return reversals_of_series(1j * np.arange(len(joint)) * joint)


def _phases(response: Response) -> float:
    """Events of the window, each of which begins a phase; one phase when there are none."""
    start, end = response.window
    inside = (response.events.t >= start) & (response.events.t < end)
    return max(1.0, float(np.count_nonzero(inside)))


def _amplitudes(c: Any, signals: tuple[int, ...], harmonics: int) -> Any:
    """|c_k| of the chosen coordinates (signal, harmonic), k from 0; NaN without a series."""
    found = np.full((len(signals), harmonics + 1), np.nan)
    if c is None:
        return found
    found[:] = 0.0
    rows = min(len(c), harmonics + 1)
    found[:, :rows] = np.abs(c[:rows, list(signals)].T)
    return found
