"""What is stored comes back bit for bit, for every shape a response can take."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from support import responses

import beltsim
from beltsim import response as response_module
from beltsim.dataset import EVENT_KINDS, EVENT_QUALITIES
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.io import load, save, stored_inputs
from beltsim.transient import integrate

MADE = {
    "stick_slip": responses.stick_slip,
    "everything": responses.everything,
    "bare": responses.bare,
    "saturated": responses.saturated,
}


@pytest.mark.parametrize("make", MADE.values(), ids=MADE.keys())
def test_round_trip_is_exact(make, tmp_path):
    made = make()
    back = load(save(made, tmp_path / "result.nc"))
    responses.assert_same(made, back)
    assert not back.q.flags.writeable


def test_the_comparison_sees_a_single_bit(tmp_path):
    made = responses.stick_slip()
    other = made.q.copy()
    other[3, 1] = np.nextafter(other[3, 1], 1.0)
    with pytest.raises(AssertionError, match="q"):
        responses.assert_same(made, replace(made, q=other))


odd_floats = st.floats(allow_nan=True, allow_infinity=True, width=64)


@settings(derandomize=True, deadline=None, max_examples=8, phases=[Phase.generate])
@given(
    q=arrays(np.float64, (7, 2), elements=odd_floats),
    torque=arrays(np.float64, (7,), elements=odd_floats),
    coefficients=arrays(np.complex128, (3, 2), elements=st.complex_numbers()),
    warnings=st.lists(st.text(st.characters(codec="utf-8"))),
    Q_m=st.floats(0.0, 1e300),
    n_events=st.integers(0, 5),
)
def test_round_trip_of_random_numbers(
    q, torque, coefficients, warnings, Q_m, n_events, tmp_path_factory
):
    made = responses.stick_slip(
        t=np.arange(7.0),
        q=q,
        q_dot=-q,
        friction_torque=torque,
        coefficients=coefficients,
        warnings=tuple(warnings),
    )
    old = made.events
    cut = {
        name: getattr(old, name)[:n_events]
        for name in vars(old)
    }  # fmt: skip
    problem = made.problem.with_friction(Coulomb(Q_m))
    made = replace(made, events=type(old)(**cut), problem=problem)
    folder = tmp_path_factory.mktemp("random")
    responses.assert_same(made, load(save(made, folder / "r.nc")))


def test_a_second_save_gives_the_same_dataset(tmp_path):
    made = responses.everything()
    again = load(save(made, tmp_path / "one.nc"))
    assert again.to_xarray().identical(made.to_xarray())


def test_inputs_come_back(tmp_path):
    given_ = {"drive": "name = 'Ω'\n" * 20_000, "arguments": {"periods": 100.0, "rpm": None}}
    file = save(responses.stick_slip(), tmp_path / "r.nc", given_)
    assert stored_inputs(file) == given_
    assert stored_inputs(save(responses.bare(), tmp_path / "b.nc")) == {}


def test_the_package_offers_load():
    assert beltsim.load is load


def test_codes_on_disk_match_the_names_in_memory():
    assert EVENT_KINDS == response_module.EVENT_KINDS
    assert EVENT_QUALITIES == response_module.EVENT_QUALITIES


@pytest.mark.parametrize("law", [Coulomb(3.5, 3.8), SaturatedCoulomb(3.5, 1e-2)])
def test_round_trip_of_a_computed_run(law, tmp_path):
    problem = beltsim.assemble(
        beltsim.presets.zhu_parker_2008(), 6.3, friction=law, n_functions=[2, 1, 3]
    )
    made = integrate(problem, 3.0)
    assert len(made.events) > 0
    assert made.warnings
    responses.assert_same(made, load(save(made, tmp_path / "r.nc")))
