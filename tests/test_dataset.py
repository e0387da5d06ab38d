"""The dataset says what everything is: units, SI values, names, flags, inputs, version."""

import numpy as np
import pytest
from support import responses

import beltsim
from beltsim.io import save


@pytest.fixture(scope="module")
def data():
    return responses.everything().to_xarray()


def test_samples_keep_problem_units_and_say_their_si_value(data):
    made = responses.everything()
    np.testing.assert_array_equal(data.q, made.q)
    arm = data.q.sel(coordinate="theta_t") * data.coordinate_si_scale.sel(coordinate="theta_t")
    np.testing.assert_array_equal(arm, made.q[:, 1])
    assert data.q.attrs["si_scale"] in data
    assert list(data.coordinate_si_unit.values) == ["m", "rad"]
    assert list(data.velocity_si_unit.values) == ["m/s", "rad/s"]
    np.testing.assert_allclose(data.velocity_si_scale, [0.1548 / 6.4914e-3, 1 / 6.4914e-3])
    assert data.friction_torque.attrs["si_scale"] == 29.1
    assert data.friction_torque.attrs["si_unit"] == "N m"
    assert data.dissipated_energy.attrs["si_unit"] == "J"
    assert data.dissipated_energy.attrs["si_scale"] == 29.1


def test_time_is_given_in_both_units(data):
    np.testing.assert_array_equal(data.time_s, data.time * 6.4914e-3)
    assert data.time_s.attrs["units"] == "s"
    assert data.time.attrs["si_scale"] == 6.4914e-3


def test_observables_are_variables_with_limits(data):
    made = responses.everything()
    span = data.tension_of_span_1
    np.testing.assert_array_equal(span, made.observe("tension of span 1"))
    assert span.attrs["long_name"] == "tension of span 1"
    assert (span.attrs["si_scale"], span.attrs["si_unit"]) == (300.0, "N")
    assert span.attrs["lower_limit"] == 0.0
    assert data.arm_angle.attrs["upper_limit"] == 0.1


def test_an_observable_cannot_displace_a_variable():
    from dataclasses import replace

    made = responses.stick_slip()
    twin = replace(made.problem.observables[0], name="q")
    odd = replace(made.problem.observables[0], name="ä/§")
    problem = replace(made.problem, observables=(twin, twin, odd))
    data = replace(made, problem=problem).to_xarray()
    np.testing.assert_array_equal(data.q, made.q)
    assert {"q_observed", "q_observed_observed", "ä"} <= set(data)


def test_events_are_int8_flags_with_meanings(data):
    for name in ("event_kind", "event_quality", "touch_kind", "periodic"):
        flags = data[name]
        assert flags.dtype == np.int8
        assert flags.attrs["flag_values"].dtype == np.int8
        assert len(flags.attrs["flag_meanings"].split()) == len(flags.attrs["flag_values"])
    meanings = data.event_kind.attrs["flag_meanings"].split()
    found = [meanings[code] for code in data.event_kind.values]
    assert found == list(responses.everything().events.kind)


def test_complex_numbers_have_a_trailing_axis(data):
    made = responses.everything()
    assert data.coefficients.dims[-1] == "part"
    assert list(data.part.values) == ["real", "imag"]
    np.testing.assert_array_equal(data.coefficients.sel(part="imag"), made.coefficients.imag)


def test_inputs_and_version_are_inside(data):
    made = responses.everything().problem
    np.testing.assert_array_equal(data.M, made.M)
    np.testing.assert_array_equal(data.forcing_sin, made.forcing.sin)
    assert float(data.Q_s) == 4.0
    assert data.attrs["friction_law"] == "Coulomb"
    assert data.attrs["beltsim_version"] == beltsim.__version__
    assert int(data.joint) == 1


def test_without_scales_nothing_pretends_to_be_si():
    data = responses.bare().to_xarray()
    assert "time_s" not in data
    assert not any("si_scale" in one.attrs for one in data.variables.values())


def test_other_readers_open_the_file_without_complaint(tmp_path):
    import xarray

    file = save(responses.everything(), tmp_path / "r.nc")
    with xarray.open_dataset(file, engine="h5netcdf") as data:
        assert data.time_s.dtype == np.float64
        assert np.isnan(data.touch_time.values[1])
        assert data.time.attrs["units"] == "1"
