"""Linear algebra of a friction problem, on systems without any belt."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from support.problems import critical_torque, random_problem

from beltsim import linear
from beltsim.errors import InvalidProblemError
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem, Scales

seeds = st.integers(0, 10_000)
sizes = st.integers(2, 12)


def rest(n):
    return HarmonicForcing(1.0, np.zeros((1, n)), np.zeros((1, n)))


def one_mass(K=4.0, C=0.1, cos=(0.0, 1.0), sin=(0.0, 0.0), Omega=1.0):
    forcing = HarmonicForcing(Omega, np.array([cos]).T, np.array([sin]).T)
    return FrictionProblem([[1.0]], [[C]], [[0.0]], [[K]], 0, forcing, Coulomb(1.0))


# --- modes ---


@settings(max_examples=30)
@given(seeds, sizes, st.booleans())
def test_modes_solve_the_gyroscopic_eigenproblem(seed, n, locked):
    problem = random_problem(seed, n)
    found = linear.modes(problem, locked)
    keep = problem.others if locked else np.arange(n)
    assert found.shapes.shape == (len(keep), n)
    assert (np.diff(found.frequencies) >= 0.0).all()
    grid = np.ix_(keep, keep)
    for omega, shape in zip(found.frequencies, found.shapes, strict=True):
        phi = shape[keep]
        dynamic = -(omega**2) * problem.M[grid] + 1j * omega * problem.G[grid] + problem.K[grid]
        size = omega**2 * np.abs(problem.M).sum() + np.abs(problem.K).sum()
        assert np.abs(dynamic @ phi).max() < 1e-11 * size
        assert np.abs(shape).max() == pytest.approx(1.0)
        assert np.abs(shape - 1.0).min() < 1e-12
    if locked:
        assert not found.shapes[:, problem.joint].any()


@settings(max_examples=20)
@given(seeds, sizes)
def test_frequencies_are_those_of_a_general_solver(seed, n):
    problem = random_problem(seed, n)
    right = np.linalg.solve(problem.M, np.hstack([problem.K, problem.G]))
    first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-right]])
    expected = np.sort(scipy.linalg.eigvals(first_order).imag)[n:]
    assert linear.frequencies(problem) == pytest.approx(expected, rel=1e-9)
    assert linear.modes(problem).frequencies == pytest.approx(expected, rel=1e-9)


def test_locked_modes_are_those_of_the_locked_problem():
    problem = random_problem(3, 6)
    expected = linear.frequencies(problem.locked())
    assert linear.frequencies(problem, locked=True) == pytest.approx(expected, rel=1e-12)


def test_a_rigid_mode_has_frequency_zero():
    K = np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    free = FrictionProblem(np.eye(3), 0 * K, 0 * K, K, None, rest(3), None)
    found = linear.modes(free)
    assert found.frequencies == pytest.approx([0.0, 1.0, np.sqrt(3.0)], abs=1e-12)
    assert np.abs(found.shapes[0]) == pytest.approx([1.0, 1.0, 1.0])


def test_an_indefinite_stiffness_is_refused_with_its_eigenvalue():
    G = np.array([[0.0, 5.0], [-5.0, 0.0]])  # gyroscopically stabilised: stable all the same
    problem = FrictionProblem(np.eye(2), 0 * G, G, -np.eye(2), None, rest(2), None)
    for function in (linear.modes, linear.frequencies):
        with pytest.raises(InvalidProblemError, match=r"smallest eigenvalue of K = -1\.0"):
            function(problem)
    assert abs(linear.decay(problem)) < 1e-9
    falling = FrictionProblem(np.eye(2), 0 * G, 0 * G, -np.eye(2), None, rest(2), None)
    assert linear.decay(falling) == pytest.approx(-2.0 * np.pi)


def test_frozen():
    found = linear.modes(random_problem(0, 3))
    for array in (found.frequencies, found.shapes):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize(
    "function", [linear.modes, linear.frequencies, linear.response, linear.decay]
)
def test_only_a_joint_can_be_locked(function):
    free = random_problem(0, 3).freed()
    with pytest.raises(InvalidProblemError, match="joint = None"):
        function(free, locked=True)
    with pytest.raises(InvalidProblemError, match="joint = None"):
        linear.critical_torque(free)


def test_nothing_left_to_move():
    mass = one_mass()
    assert len(linear.modes(mass, locked=True).frequencies) == 0
    assert len(linear.frequencies(mass, locked=True)) == 0
    assert linear.decay(mass, locked=True) == np.inf
    assert not linear.response(mass, locked=True).any()


def test_hertz():
    scaled = FrictionProblem(
        [[1.0]], [[0.1]], [[0.0]], [[4.0]], None, rest(1), None,
        scales=Scales(1e-3, 1.0, [1.0], ("rad",)),
    )  # fmt: skip
    assert linear.hertz(scaled, 2.0) == pytest.approx(2.0 / (2.0 * np.pi * 1e-3))
    with pytest.raises(InvalidProblemError, match="scales = None"):
        linear.hertz(one_mass(), 2.0)


# --- response and reaction ---


@settings(max_examples=25)
@given(seeds, sizes, st.booleans())
def test_the_response_solves_the_equations_of_motion(seed, n, locked):
    problem = random_problem(seed, n)
    c = linear.response(problem, locked)
    keep = problem.others if locked else np.arange(n)
    Omega = problem.forcing.Omega
    k = np.arange(len(c))
    t = np.linspace(0.0, problem.period, 13)
    wave = np.exp(1j * Omega * np.multiply.outer(t, k))
    q = (wave @ c).real
    q_dot = (wave @ (1j * k[:, None] * Omega * c)).real
    q_ddot = (wave @ (-((k[:, None] * Omega) ** 2) * c)).real
    left = q_ddot @ problem.M + q_dot @ (problem.C + problem.G).T + q @ problem.K
    gap = (problem.forcing.at(t) - left)[:, keep]
    assert np.abs(gap).max() < 1e-9 * np.abs(left).max()
    if locked:
        held = (wave @ linear.reaction(problem)).real
        expected = (problem.forcing.at(t) - left)[:, problem.joint]
        assert held == pytest.approx(expected, abs=1e-9 * np.abs(left).max())
        assert not c[:, problem.joint].any()


@settings(max_examples=25)
@given(seeds, st.integers(2, 8))
def test_critical_torque_is_half_the_peak_to_peak(seed, n):
    problem = random_problem(seed, n)
    reaction = linear.reaction(problem)
    tau = np.linspace(0.0, 2.0 * np.pi, 20001)
    values = (np.exp(1j * np.multiply.outer(tau, np.arange(len(reaction)))) @ reaction).real
    found, sampled = linear.critical_torque(problem), 0.5 * (values.max() - values.min())
    assert sampled <= found * (1.0 + 1e-12) + 1e-300
    assert found == pytest.approx(sampled, rel=1e-5)
    assert found == pytest.approx(critical_torque(problem), rel=2e-5)  # it samples


def test_the_mean_of_the_reaction_does_not_count():
    one, two = one_mass(cos=(0.0, 2.0)), one_mass(cos=(50.0, 2.0))
    assert linear.critical_torque(one) == pytest.approx(2.0)
    assert linear.critical_torque(two) == pytest.approx(2.0)


def test_a_resonance_without_damping_names_its_harmonic():
    mass = one_mass(K=4.0, C=0.0, cos=(0.0, 1.0, 1.0), sin=(0.0,) * 3, Omega=1.0)
    with pytest.raises(InvalidProblemError, match=r"harmonic 2 of the forcing = 2\.0"):
        linear.response(mass.freed())
    quiet = one_mass(K=4.0, C=0.0, cos=(0.0, 1.0, 0.0), sin=(0.0,) * 3, Omega=1.0)
    assert linear.response(quiet.freed())[1, 0] == pytest.approx(1.0 / 3.0)
    damped = one_mass(K=4.0, C=0.1, cos=(0.0, 1.0, 1.0), sin=(0.0,) * 3, Omega=1.0)
    assert linear.response(damped.freed())[2, 0] == pytest.approx(1.0 / 0.2j)


def test_a_constant_force_on_a_rigid_mode_is_refused():
    drifting = one_mass(K=0.0, cos=(1.0, 0.0))
    with pytest.raises(InvalidProblemError, match="harmonic 0 of the forcing"):
        linear.response(drifting.freed())


@settings(max_examples=40)
@given(seeds, st.integers(1, 12), st.integers(1, 4))
def test_extremes_are_those_of_the_series(seed, H, step):
    rng = np.random.default_rng(seed)
    c = np.zeros(H * step + 1, dtype=complex)
    c[::step] = rng.normal(size=H + 1) + 1j * rng.normal(size=H + 1)
    c[0] = c[0].real
    k = np.arange(len(c))
    tau = np.linspace(0.0, 2.0 * np.pi, 4000 * step)
    values = (np.exp(1j * np.multiply.outer(tau, k)) @ c).real
    low, high = linear.extremes(c)
    size = np.abs(c).sum()
    curvature = 0.5 * (k**2 @ np.abs(c)) * (tau[1] - tau[0]) ** 2
    assert values.min() - curvature <= low <= values.min() + 1e-12 * size
    assert values.max() - 1e-12 * size <= high <= values.max() + curvature


def test_extremes_of_flat_and_degenerate_series():
    assert linear.extremes(np.array([2.0 + 0j])) == (2.0, 2.0)
    assert linear.extremes(np.array([1.0, 0.0, 3.0j])) == (-2.0, 4.0)
    # cos tau - cos(2 tau)/4 has a maximum of fourth order at 0
    low, high = linear.extremes(np.array([0.0, 1.0, -0.25], dtype=complex))
    assert high == pytest.approx(0.75, abs=1e-12)
    assert low == pytest.approx(-1.25, abs=1e-12)


def test_extremes_with_negligible_harmonics():
    """A smooth periodic motion has harmonics down to underflow; they must not spoil the roots."""
    k = np.arange(41)
    c = 10.0 ** (-8.0 * k) * np.exp(1j * k**2)
    c[0] = 0.0
    first = linear.extremes(c[:4])
    assert linear.extremes(c) == pytest.approx(first, rel=1e-14)
    assert first == pytest.approx((-1e-8, 1e-8), rel=1e-6)


# --- decay ---


def test_decay_of_one_mass():
    assert linear.decay(one_mass(C=0.1)) == pytest.approx(0.05 * 2.0 * np.pi)
    assert linear.decay(one_mass(C=0.0)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("locked", [False, True])
def test_decay_bounds_what_is_left_of_a_start(locked):
    """Over many periods the motion falls by exp(-decay) per period."""
    problem = random_problem(5, 4)
    keep = problem.others if locked else np.arange(4)
    grid = np.ix_(keep, keep)
    n = len(keep)
    right = np.linalg.solve(
        problem.M[grid], np.hstack([problem.K[grid], (problem.C + problem.G)[grid]])
    )
    first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-right]])
    start = np.random.default_rng(0).normal(size=2 * n)
    sizes_at = [
        np.linalg.norm(scipy.linalg.expm(first_order * problem.period * x) @ start)
        for x in (400.0, 500.0)
    ]
    rate = np.log(sizes_at[0] / sizes_at[1]) / 100.0
    assert linear.decay(problem, locked) == pytest.approx(rate, rel=0.05)
