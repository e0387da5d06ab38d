"""Flows without eigenvectors: defective, singular, resonant; and cells against modes."""

from __future__ import annotations

import numpy as np
import pytest
from support.exact import exact_transient
from support.problems import random_problem, random_state

from beltsim import Coulomb, FrictionProblem, HarmonicForcing, SaturatedCoulomb, event_map
from beltsim.errors import NotPeriodicError
from beltsim.event_map import flows
from beltsim.event_map.cells import CellFlow
from beltsim.event_map.changes import amplitudes
from beltsim.event_map.flows import flows_of
from beltsim.event_map.shooting import shoot


def problem_of(M, C, K, joint, force, Omega=0.8, Q=0.3, G=None):
    n = len(M)
    cos, sin = np.zeros((2, len(force), n))
    for k, row in enumerate(force):
        cos[k] = row
    sin[1:] = 0.3 * cos[1:, ::-1]
    G = np.zeros((n, n)) if G is None else G
    return FrictionProblem(M, C, G, K, joint, HarmonicForcing(Omega, cos, sin), Coulomb(Q))


def assert_same_as_reference(problem, periods=4.0, start=None, tolerance=2e-12):
    exact = exact_transient(problem, periods, start)
    run = event_map.propagate(problem, periods, start)
    assert run.events.kind.tolist() == exact.kind
    if len(exact.t):
        assert np.abs(run.events.t - exact.t).max() <= tolerance * problem.period
    size = np.abs(exact.final_state).max()
    assert np.abs(run.final_state - exact.final_state).max() <= 20.0 * tolerance * size
    assert run.energy_balance_residual <= 1e-10
    return run


GAPS = [0.0, *(sign * 10.0**-k for k in range(1, 16) for sign in (1.0, -1.0))]


@pytest.mark.parametrize("gap", GAPS)
def test_near_critical_damping(gap):
    """The eigenvectors meet as the damping passes critical; the answer must not notice."""
    damping = 2.0 * np.sqrt(3.0) * (1.0 + gap)
    one = problem_of([[1.0]], [[damping]], [[3.0]], 0, [[0.0], [4.0]])
    assert_same_as_reference(one, start=[0.7, 0.4])
    two = problem_of(
        [[1.0, 0.0], [0.0, 2.0]],
        [[damping, 0.0], [0.0, 0.1]],
        [[3.0, 0.0], [0.0, 1.0]],
        1,
        [[0.0, 0.0], [1.0, 2.0]],
    )
    assert_same_as_reference(two, start=[0.7, 0.1, 0.4, 0.3])


def test_the_limit_of_the_condition_keeps_the_accuracy():
    """Just below the limit modes are still used, and still exact to 1e-12 T."""
    used = set()
    for gap in 10.0 ** -np.arange(1.0, 12.0, 0.5):
        problem = problem_of(
            [[1.0, 0.2], [0.2, 2.0]],
            [[2.0 * (1.0 + gap), 0.1], [0.1, 0.2]],
            [[1.0, 0.0], [0.0, 1.0]],
            1,
            [[0.0, 0.0], [1.0, 2.0]],
        )
        used.add(isinstance(flows_of(problem).held, CellFlow))
        assert_same_as_reference(problem, start=[0.7, 0.1, 0.4, 0.3])
    assert used == {True, False}


def free_joint(mean=0.0):
    """A joint without a spring of its own, driven by another mass."""
    return problem_of(
        [[1.0, 0.1], [0.1, 2.0]],
        [[0.2, 0.0], [0.0, 0.0]],
        [[1.5, 0.0], [0.0, 0.0]],
        1,
        [[mean, 0.5 * mean], [1.0, 2.0]],
    )


def test_joint_without_spring():
    problem = free_joint()
    assert isinstance(flows_of(problem).free, CellFlow)
    assert_same_as_reference(problem)
    orbit = event_map.periodic(problem)
    assert orbit.period_residual <= 1e-12
    assert orbit.energy_balance_residual <= 1e-10
    exact = exact_transient(problem, 1.0, orbit.initial_state)
    assert np.abs(exact.final_state - orbit.initial_state).max() <= 1e-11


def test_joint_without_spring_under_a_mean_load_drifts():
    assert_same_as_reference(free_joint(0.1))
    with pytest.raises(NotPeriodicError, match="position drifts by"):
        event_map.periodic(free_joint(0.1))


def test_chain_that_drifts():
    """Two masses tied to each other only: transients yes; a mean load leaves no orbit."""
    K = np.array([[1.0, -1.0], [-1.0, 1.0]])
    for mean in (0.0, 0.2):
        chain = problem_of(np.diag([1.0, 2.0]), 0.05 * K, K, 1, [[mean, mean], [1.0, 0.0]], Q=0.05)
        assert isinstance(flows_of(chain).free, CellFlow)
        assert_same_as_reference(chain)
    three = np.zeros((3, 3))
    three[:2, :2] = K
    three[2, 2] = 1.0
    loose = problem_of(np.eye(3), 0.05 * three, three, 2, [[0.2, 0.2, 0.0], [1.0, 0.0, 1.0]])
    assert_same_as_reference(loose)
    with pytest.raises(NotPeriodicError, match="a mean load meets an undamped mode"):
        event_map.periodic(loose)


def test_undamped_resonance_is_an_error_only_where_excited():
    M, K, C = np.diag([1.0, 1.0]), np.diag([0.64, 3.0]), np.diag([0.0, 0.1])
    excited = problem_of(M, C, K, 1, [[0.0, 0.0], [1.0, 1.0]], Omega=0.8)
    assert_same_as_reference(excited)
    with pytest.raises(NotPeriodicError, match=r"harmonic 1 .* frequency 0\.8"):
        event_map.periodic(excited)
    forcing = HarmonicForcing(0.8, [[0.0, 0.0], [0.0, 1.0]], np.zeros((2, 2)))
    quiet = FrictionProblem(M, C, np.zeros((2, 2)), K, 1, forcing, Coulomb(0.3))
    orbit = event_map.periodic(quiet)
    assert orbit.period_residual <= 1e-12
    assert np.abs(orbit.q[:, 0]).max() <= 1e-12 * np.abs(orbit.q).max()


@pytest.mark.parametrize(("share", "balanced"), [(0.9, False), (0.99, False), (1.01, True)])
def test_friction_balances_a_resonance_up_to_its_largest_harmonic(share, balanced):
    """Coulomb friction holds an undamped mode when 4/pi Q_m reaches the force, not below."""
    K = np.array([[3.0, -0.7], [-0.7, 1.5]])
    K *= 0.5**2 / np.linalg.eigvalsh(K)[1]
    problem = problem_of(np.eye(2), 0.0 * K, K, 1, [[0.0, 0.0], [0.0, 1.0]], Omega=0.5)
    forcing = HarmonicForcing(0.5, problem.forcing.cos, 0.0 * problem.forcing.sin)
    Q_m = share * np.pi / 4.0
    problem = FrictionProblem(problem.M, 0.0 * K, 0.0 * K, K, 1, forcing, Coulomb(Q_m))
    if balanced:
        orbit = event_map.periodic(problem)
        assert orbit.period_residual <= 1e-12
        assert orbit.energy_balance_residual <= 1e-10
        return
    with pytest.raises(NotPeriodicError, match=r"harmonic 1 .* frequency 0\.5 .*at most"):
        event_map.periodic(problem)


@pytest.fixture
def always_cells(monkeypatch):
    monkeypatch.setattr(flows, "CONDITION_LIMIT", 0.0)


def test_random_transients_in_cells(always_cells):
    for seed in range(15):
        problem = random_problem(seed, n=1 + seed % 6)
        assert isinstance(flows_of(problem).free, CellFlow)
        start = random_state(seed, problem) if seed % 2 else None
        assert_same_as_reference(problem, 3.0, start, 2e-11)


def copied(problem, friction=None):
    parts = (problem.M, problem.C, problem.G, problem.K, problem.joint, problem.forcing)
    return FrictionProblem(*parts, friction or problem.friction)


@pytest.mark.parametrize("seed", range(4))
def test_orbits_in_cells_equal_those_in_modes(seed, monkeypatch):
    problem = random_problem(seed + 30, n=2 + seed, share=0.35, static=False)
    settings = event_map.Settings(samples_per_period=20, harmonics=30)
    modes = event_map.periodic(problem, settings)
    monkeypatch.setattr(flows, "CONDITION_LIMIT", 0.0)
    cells = event_map.periodic(copied(problem), settings)
    for name in ("q", "q_dot", "friction_torque", "coefficients", "torque_coefficients"):
        a, b = getattr(modes, name), getattr(cells, name)
        assert np.abs(a - b).max() <= 1e-9 * np.abs(a).max(), name
    assert cells.dissipated_energy == pytest.approx(modes.dissipated_energy, rel=1e-10)
    assert cells.energy_balance_residual <= 1e-10
    assert np.allclose(event_map.rms(cells), event_map.rms(modes), rtol=1e-9)
    assert np.allclose(
        np.sort(np.abs(cells.multipliers)), np.sort(np.abs(modes.multipliers)), atol=1e-8
    )


def derivative(problem, x):
    """Derivative of the map over a period, at the state where a search from `x` ends."""
    into, out = amplitudes(problem)
    return out @ shoot(problem, x, 1, False, 1e-12, False).derivative @ into


@pytest.mark.parametrize("law", ["equal", "static", "saturated"])
def test_derivative_in_cells_equals_that_in_modes(law, monkeypatch):
    for seed in range(6):
        problem = random_problem(seed + 60, n=1 + seed % 4, share=0.3, static=law == "static")
        x = random_state(seed, problem)
        if law == "saturated":
            speed = np.abs(x[problem.n :]).max()
            problem = problem.with_friction(SaturatedCoulomb(problem.friction.Q_m, 0.1 * speed))
        wanted = derivative(problem, x)
        with monkeypatch.context() as patch:
            patch.setattr(flows, "CONDITION_LIMIT", 0.0)
            found = derivative(copied(problem), x)
        assert np.abs(found - wanted).max() <= 1e-8 * np.abs(wanted).max()


@pytest.mark.parametrize("share", [1e-4, 1e-6])
def test_the_creep_inside_a_narrow_band_needs_no_cells(share):
    """The slow mode of the band is no resonance with the mean: modes serve, and quickly."""
    exact = random_problem(3, static=False)
    orbit = event_map.periodic(exact)
    sigma = share * float(np.abs(orbit.q_dot[:, exact.joint]).max())
    banded = exact.with_friction(SaturatedCoulomb(exact.friction.Q_m, sigma))
    assert isinstance(flows.inner_flow(banded), flows.Flow)
    gap = np.abs(event_map.periodic(banded).q - orbit.q).max()
    assert gap < 10.0 * share * np.abs(orbit.q).max()
