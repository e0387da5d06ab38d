"""The saturated law: band edges are located, and the limit of a narrow band is the exact law."""

from itertools import pairwise

import numpy as np
import pytest

from beltsim import Coulomb, FrictionProblem, HarmonicForcing, SaturatedCoulomb
from beltsim.transient import Settings, integrate


def one_mass(friction, f=1.0, Omega=1.0, c=0.1):
    forcing = HarmonicForcing(Omega, cos=[[0.0], [f]], sin=[[0.0], [0.0]])
    return FrictionProblem([[1.0]], [[c]], [[0.0]], [[4.0]], 0, forcing, friction)


@pytest.mark.parametrize("method", ["adams", "bdf", "taylor"])
def test_edges_of_the_band_are_events_at_exactly_sigma(method):
    sigma = 1e-2
    run = integrate(one_mass(SaturatedCoulomb(0.5, sigma)), 10.0, settings=Settings(method=method))
    assert len(run.events) >= 40
    assert set(run.events.kind) == {"stick", "slip+", "slip-"}
    assert np.array_equal(np.abs(run.events.q_dot[:, 0]), np.full(len(run.events), sigma))
    modes = [run.initial_mode, *run.events.modes_after(run.initial_mode)]
    assert "stick" in modes[::2] or "stick" in modes[1::2]
    assert all("stick" in pair for pair in pairwise(modes))
    sides = np.sign(run.events.q_dot[:, 0])
    for kind, side in zip(run.events.kind, sides, strict=True):
        assert kind in {"stick", "slip+" if side > 0 else "slip-"}


def test_methods_agree():
    problem = one_mass(SaturatedCoulomb(0.5, 1e-3))
    runs = [
        integrate(problem, 8.0, settings=Settings(method=m, rtol=1e-9))
        for m in ("adams", "bdf", "taylor")
    ]
    for run in runs[:2]:
        assert list(run.events.kind) == list(runs[2].events.kind)
        np.testing.assert_allclose(run.final_state, runs[2].final_state, atol=1e-7)
        np.testing.assert_allclose(run.events.t, runs[2].events.t, atol=1e-5)


def test_a_linear_band_that_is_never_left_is_a_damper():
    problem = one_mass(SaturatedCoulomb(0.5, 100.0))
    damper = one_mass(Coulomb(0.5), c=0.1 + 0.5 / 100.0).freed()
    run, linear = integrate(problem, 5.0), integrate(damper, 5.0)
    assert len(run.events) == 0
    assert run.initial_mode == "stick"
    np.testing.assert_allclose(run.final_state, linear.final_state, atol=1e-7)


def test_the_error_of_the_band_falls_with_sigma():
    """O(sigma): slope one against the set-valued law."""
    exact = integrate(one_mass(Coulomb(0.5)), 12.0, settings=Settings(rtol=1e-11))
    errors = []
    for sigma in (1e-2, 1e-3, 1e-4):
        run = integrate(one_mass(SaturatedCoulomb(0.5, sigma)), 12.0, settings=Settings(rtol=1e-9))
        errors.append(np.abs(run.q - exact.q).max())
    slopes = np.diff(np.log10(errors)) / -1.0
    assert np.all(np.abs(slopes - 1.0) < 0.15)


def test_the_band_of_1e_6_at_rtol_1e_6_is_not_stepped_over():
    """Solvers that smooth sgn step over it, 1 % off without a word; here edges are located."""
    exact = integrate(one_mass(Coulomb(0.5)), 6.0, settings=Settings(rtol=1e-11))
    run = integrate(one_mass(SaturatedCoulomb(0.5, 1e-6)), 6.0, settings=Settings(rtol=1e-6))
    assert np.abs(run.q - exact.q).max() < 1e-5 * np.abs(exact.q).max()
    assert any("narrow" in text for text in run.warnings)


@pytest.mark.parametrize("method", ["bdf", "taylor"])
def test_the_energy_balance_closes(method):
    run = integrate(
        one_mass(SaturatedCoulomb(0.5, 1e-3)), 7.4, settings=Settings(method=method, rtol=1e-9)
    )
    assert run.energy_balance_residual < 1e-7
    assert run.total_dissipated_energy > run.dissipated_energy > 0.0


def test_the_torque_is_the_line_inside_the_band():
    sigma = 0.05
    run = integrate(one_mass(SaturatedCoulomb(0.5, sigma)), 5.0)
    expected = 0.5 * np.clip(run.q_dot[:, 0] / sigma, -1.0, 1.0)
    np.testing.assert_allclose(run.friction_torque, expected, atol=1e-8)


@pytest.mark.parametrize(
    ("v", "f", "mode"),
    [
        (0.0, 1.0, "stick"),
        (0.02, 1.0, "slip+"),
        (-0.02, 1.0, "slip-"),
        (0.009, 1.0, "stick"),
        (0.01, 3.0, "slip+"),
        (0.01, -3.0, "stick"),
        (-0.01, -3.0, "slip-"),
    ],
)
def test_the_start_mode_follows_the_velocity_and_on_the_edge_the_acceleration(v, f, mode):
    run = integrate(one_mass(SaturatedCoulomb(0.5, 0.01), f=f), 1e-5, [0.0, v])
    assert run.initial_mode == mode
    assert len(run.events) == 0


@pytest.mark.parametrize("sigma", [1e-2, 1e-4, 1e-6])
def test_plain_crossings_of_a_narrow_band_are_not_near_grazing(sigma):
    # within the band the velocity is of the size of sigma, far below its peak
    chain = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
    push = HarmonicForcing(1.7, cos=[[0.0] * 3, [1.0, 0.0, 0.3]], sin=np.zeros((2, 3)))
    law = SaturatedCoulomb(0.15, sigma)
    problem = FrictionProblem(np.eye(3), 0.04 * np.eye(3), 0 * chain, chain, 2, push, law)
    run = integrate(problem, 20.0)
    assert len(run.events) > 40
    assert (run.events.quality == "simple").all()
    assert not len(run.near_grazing)
