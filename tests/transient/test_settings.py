"""Settings, tolerances from the reference energy, and the budget of events."""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from support.problems import random_problem

from beltsim import Coulomb, FrictionProblem, HarmonicForcing, SaturatedCoulomb
from beltsim.errors import InvalidProblemError
from beltsim.event_map import propagate
from beltsim.transient import Settings, integrate
from beltsim.transient.settings import default_atol, events_per_period, reference_energy

DRY = Coulomb(0.2)


def one_mass(f=1.0, c=0.1, k=4.0, friction=DRY):
    forcing = HarmonicForcing(1.0, cos=[[0.0], [f]], sin=[[0.0], [0.0]])
    return FrictionProblem([[1.0]], [[c]], [[0.0]], [[k]], 0, forcing, friction)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("rtol", 1e-15),
        ("rtol", 0.1),
        ("rtol", float("nan")),
        ("rtol", True),
        ("rtol", "1e-8"),
        ("atol", 0.0),
        ("atol", -1.0),
        ("atol", [1.0, np.nan]),
        ("atol", []),
        ("atol", [[1.0, 1.0]]),
        ("method", "euler"),
        ("keep", "some"),
        ("samples_per_period", 0),
        ("samples_per_period", 2.5),
        ("max_steps", 0),
        ("max_steps", True),
        ("max_events", -1),
        ("max_seconds", 0.0),
        ("max_seconds", float("nan")),
        ("event_states", 1),
    ],
)
def test_a_bad_setting_is_named(name, value):
    with pytest.raises(InvalidProblemError, match=rf"^settings\.{name} = "):
        Settings(**{name: value})


def test_all_bad_settings_are_named_at_once():
    with pytest.raises(InvalidProblemError) as caught:
        Settings(rtol=1.0, method="x", keep="y", max_steps=0)
    assert [m.field.split(".")[1] for m in caught.value.mistakes] == [
        "rtol",
        "method",
        "keep",
        "max_steps",
    ]


def test_atol_of_the_wrong_length_is_named_with_the_problem():
    with pytest.raises(
        InvalidProblemError, match=r"settings\.atol = \(3,\): must be of shape \(2,"
    ):
        Settings(atol=[1.0, 1.0, 1.0]).atol_for(one_mass(), np.zeros(2), 1.0)


def test_atol_may_be_a_number_or_an_array():
    problem = one_mass()
    assert Settings(atol=1e-9).atol_for(problem, np.zeros(2), 1.0).tolist() == [1e-9, 1e-9]
    assert Settings(atol=[1e-9, 2e-9]).atol_for(problem, np.zeros(2), 1.0).tolist() == [1e-9, 2e-9]


def test_auto_takes_bdf_for_the_saturated_law():
    assert Settings().method_for(one_mass()) == "adams"
    assert Settings().method_for(one_mass().freed()) == "adams"
    assert Settings().method_for(one_mass(friction=SaturatedCoulomb(0.2, 1e-3))) == "bdf"
    assert Settings(method="taylor").method_for(one_mass()) == "taylor"


def test_auto_takes_bdf_where_damping_is_stiff():
    light = replace(one_mass(), M=[[1e-9]], C=[[1.0]])
    assert Settings().method_for(light) == "bdf"
    assert Settings(method="adams").method_for(light) == "adams"
    budget = Settings(max_steps=10_000)
    run = integrate(light, periods=2.0, settings=budget)
    exact = propagate(light, periods=2.0)
    assert run.events.kind.tolist() == exact.events.kind.tolist()
    assert np.abs(run.events.t - exact.events.t).max() < 1e-7 * light.period


def test_a_state_that_overflows_the_energy_warns_nobody():
    problem = one_mass()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert math.isfinite(reference_energy(problem, np.array([1e300, 0.0]), 1.0))


def test_the_energy_is_that_of_the_larger_linear_response():
    problem = one_mass(f=2.0)
    amplitude = abs(2.0 / (4.0 - 1.0 + 0.1j))
    expected = 0.5 * (4.0 + 1.0) * amplitude**2
    assert reference_energy(problem, np.zeros(2), 1e3) == pytest.approx(expected, rel=1e-12)
    start = np.array([0.5, 2.0])
    assert reference_energy(problem, start, 1e3) == pytest.approx(expected + 2.5, rel=1e-12)


def test_the_energy_stays_finite_at_an_undamped_resonance():
    forcing = HarmonicForcing(2.0, cos=[[0.0], [1.0]], sin=[[0.0], [0.0]])
    problem = FrictionProblem([[1.0]], [[0.0]], [[0.0]], [[4.0]], 0, forcing, Coulomb(0.2))
    assert reference_energy(problem, np.zeros(2), 10.0) == pytest.approx(50.0)


def test_without_any_load_the_friction_sets_the_scale():
    problem = one_mass(f=0.0)
    assert reference_energy(problem, np.zeros(2), 1.0) == pytest.approx(0.2**2 / 4.0)
    assert reference_energy(problem.freed(), np.zeros(2), 1.0) == 1.0


def test_atol_falls_back_to_the_velocity_without_stiffness():
    problem = one_mass(k=0.0)
    atol = default_atol(problem, np.zeros(2), 10.0, 1e-8)
    assert atol[0] == atol[1] / problem.forcing.Omega
    assert np.all(atol > 0.0)


def test_atol_scales_with_force_and_with_units():
    problem = random_problem(5, 6)
    y0 = np.zeros(12)
    atol = default_atol(problem, y0, 10.0, 1e-8)
    forcing = HarmonicForcing(
        problem.forcing.Omega, 4.0 * problem.forcing.cos, 4.0 * problem.forcing.sin
    )
    matrices = (problem.M, problem.C, problem.G, problem.K)
    stronger = FrictionProblem(
        *matrices, problem.joint, forcing, Coulomb(4.0 * problem.friction.Q_m)
    )
    assert np.array_equal(default_atol(stronger, y0, 10.0, 1e-8), 4.0 * atol)
    d = 2.0 ** np.arange(-3, 3)  # other units of the coordinates
    scaled = FrictionProblem(
        *(d[:, None] * A * d for A in matrices),
        problem.joint,
        HarmonicForcing(problem.forcing.Omega, problem.forcing.cos * d, problem.forcing.sin * d),
        problem.friction,
    )
    again = default_atol(scaled, y0, 10.0, 1e-8) * np.tile(d, 2)
    np.testing.assert_allclose(again, atol, rtol=1e-10)


def test_the_budget_of_events_grows_with_the_fastest_mode():
    for seed in range(5):
        problem = random_problem(seed, 8)
        eigen = np.linalg.eigvals(
            np.block(
                [
                    [np.zeros((8, 8)), np.eye(8)],
                    [
                        -np.linalg.solve(problem.M, problem.K),
                        -np.linalg.solve(problem.M, problem.G),
                    ],
                ]
            )
        )
        needed = 20.0 + 8.0 * np.abs(eigen).max() / problem.forcing.Omega
        assert needed <= events_per_period(problem) < 10.0 * needed


def test_one_step_is_held_to_a_share_but_never_below_rounding():
    problem = one_mass()
    assert Settings().step_share(problem) == 0.01
    assert Settings(rtol=1e-14).step_share(problem) == 1.0
    assert Settings(rtol=1e-13).step_share(problem) == pytest.approx(0.1)
    assert Settings(method="taylor").step_share(problem) == 1.0
