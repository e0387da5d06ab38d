"""The names that are stable from 0.1, their arguments and their defaults."""

from __future__ import annotations

import dataclasses
import importlib
import inspect

import pytest

import beltsim

SIGNATURES = {
    "FrictionProblem": "M C G K joint forcing friction labels=None scales=None",
    "HarmonicForcing": "Omega cos sin",
    "Coulomb": "Q_m Q_s=None",
    "SaturatedCoulomb": "Q_m sigma",
    "transient.integrate": "problem periods=100.0 initial_state=None settings=None",
    "transient.solve_many": "problems settings=None workers=None",
    "event_map.propagate": "problem periods=100.0 initial_state=None settings=None",
    "event_map.periodic": "problem settings=None",
    "event_map.solve_many": "problems settings=None workers=None",
    "linear.critical_torque": "problem",
    "linear.modes": "problem locked=False",
    "presets.zhu_parker_2008": "epsilon=0.01 zeta=0.05 mu=0.1 alpha=3",
    "load_drive": "path",
    "load": "path",
    "assemble": "drive Omega=None rpm=None friction=None n_functions=16 residual_flexibility=True",
}
RESPONSE = (
    "t q q_dot friction_torque initial_state final_state initial_mode events coefficients "
    "torque_coefficients multipliers periodic period_residual rest_interval near_grazing warnings "
    "statistics stick_fraction dissipated_energy velocity_reversals stops_per_period "
    "energy_balance_residual total_dissipated_energy "
)
EVENT_LOG = "t kind q q_dot torque_before torque_after quality margin "
TRANSIENT_SETTINGS = "rtol atol method samples_per_period keep max_steps max_events max_seconds "
ERRORS = (
    "BeltsimError InvalidDriveError InvalidProblemError SteadyStateError ConvergenceError "
    "NotPeriodicError UnsupportedLawError CoreError StudyError "
)


def named(path):
    found = beltsim
    for part in path.split("."):
        found = getattr(found, part)
    return found


def spelt(function) -> list[str]:
    """Parameters as name or name=default."""
    parameters = inspect.signature(function).parameters.values()
    empty = inspect.Parameter.empty
    return [p.name if p.default is empty else f"{p.name}={p.default!r}" for p in parameters]


@pytest.mark.parametrize("path", SIGNATURES)
def test_signatures(path):
    """The first parameters are as published; later ones must be optional."""
    promised = SIGNATURES[path].split()
    found = spelt(named(path))
    assert found[: len(promised)] == promised
    assert all("=" in parameter for parameter in found[len(promised) :])


def test_assemble_takes_rpm_and_the_rest_by_name_only():
    parameters = inspect.signature(beltsim.assemble).parameters
    by_name = [n for n, p in parameters.items() if p.kind is inspect.Parameter.KEYWORD_ONLY]
    assert by_name == ["rpm", "friction", "n_functions", "residual_flexibility"]


def test_every_name_listed_exists_and_the_rest_does_not():
    for name in beltsim.__all__:
        assert getattr(beltsim, name) is not None
    assert set(dir(beltsim)) == set(beltsim.__all__)
    with pytest.raises(AttributeError, match="no attribute 'belts'"):
        _ = beltsim.belts


def test_fields_of_a_response():
    names = {field.name for field in dataclasses.fields(beltsim.Response)}
    assert set(RESPONSE.split()) <= names
    assert callable(beltsim.Response.to_xarray)


def test_fields_of_an_event_log():
    names = {field.name for field in dataclasses.fields(beltsim.EventLog)}
    assert set(EVENT_LOG.split()) <= names


def test_settings_of_the_transient():
    settings = beltsim.transient.Settings
    names = {field.name for field in dataclasses.fields(settings)}
    assert set(TRANSIENT_SETTINGS.split()) <= names
    assert settings().rtol == 1e-8
    with pytest.raises(dataclasses.FrozenInstanceError):
        settings().rtol = 1e-3


def test_errors_have_one_base():
    errors = importlib.import_module("beltsim.errors")
    for name in ERRORS.split():
        assert issubclass(getattr(errors, name), errors.BeltsimError)
    assert issubclass(errors.InvalidProblemError, ValueError)
