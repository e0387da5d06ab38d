"""Periodic orbits: closed, lawful, in energy balance, and unchanged by what must not matter."""

from __future__ import annotations

import numpy as np
import pytest
from support.exact import exact_transient
from support.problems import critical_torque, random_problem, random_state

import beltsim
from beltsim import Coulomb, FrictionProblem, HarmonicForcing, SaturatedCoulomb, event_map
from beltsim.errors import NotPeriodicError
from beltsim.event_map.motion import sampled
from beltsim.event_map.walk import walk

MANY = 20_000


def assert_lawful(problem, orbit, points):
    """h v >= 0 and |h| <= Q_s at `points` samples; h = Q_m sign(v) while slipping."""
    law = problem.friction
    end = orbit.window[1]
    t = np.linspace(0.0, end, points)
    state = np.concatenate([orbit.q[0], orbit.q_dot[0]])
    run = walk(problem, state, end / problem.period)
    _, q_dot, torque = sampled(problem, run, t)
    v = q_dot[:, problem.joint]
    size = np.abs(v).max()
    limit = max(law.Q_s, 1e-300)
    assert (np.abs(torque) <= limit * (1.0 + 1e-11)).all()
    assert (torque * v >= -1e-10 * limit * size).all()
    moving = np.abs(v) > 1e-9 * size
    assert np.allclose(np.abs(torque[moving]), law.Q_m, rtol=1e-14)


def assert_orbit(problem, orbit, points=2000):
    assert orbit.periodic
    assert orbit.period_residual <= 1e-12
    assert orbit.energy_balance_residual <= 1e-10
    assert_lawful(problem, orbit, points)
    assert np.abs(orbit.multipliers).max() <= 1.0 + 1e-9
    assert len(orbit.multipliers) == 2 * problem.n


@pytest.fixture(scope="module")
def drive():
    return beltsim.presets.zhu_parker_2008()


def test_orbits_of_the_papers_drive_on_a_grid(drive, full):
    for Omega in np.linspace(0.6, 12.0, 39 if full else 6):
        first = beltsim.assemble(drive, Omega=float(Omega), friction=Coulomb(1.0), n_functions=8)
        for Q_m in np.geomspace(0.1, 10.0, 13 if full else 4):
            problem = first.with_friction(Coulomb(float(Q_m)))
            assert_orbit(problem, event_map.periodic(problem), MANY if full else 4000)


def test_random_systems_have_no_failures(full):
    for seed in range(1000 if full else 80):
        problem = random_problem(seed, static=False)
        orbit = event_map.periodic(problem)
        assert_orbit(problem, orbit)
        locked = problem.friction.Q_m >= critical_torque(problem) * (1.0 + 1e-6)
        assert (orbit.rest_interval is not None) >= locked


def test_the_orbit_is_where_the_reference_ends():
    """A long run of code that shares nothing with the map arrives at the same motion."""
    for seed in (2, 5, 9):
        problem = random_problem(seed, n=2 + seed % 3, share=0.4, static=False)
        orbit = event_map.periodic(problem)
        exact = exact_transient(problem, 1.0, orbit.initial_state)
        size = np.abs(orbit.initial_state).max()
        assert np.abs(exact.final_state - orbit.initial_state).max() <= 1e-10 * size
        far = exact_transient(problem, 300.0)
        gap = np.abs(far.final_state[problem.n :] - orbit.q_dot[0]).max()
        assert gap <= 1e-3 * np.abs(orbit.q_dot).max()


def test_series_sum_to_the_samples():
    problem = random_problem(8, n=4, share=0.3, static=False)
    settings = event_map.Settings(harmonics=400)
    orbit = event_map.periodic(problem, settings)
    turns = np.exp(1j * np.multiply.outer(orbit.t, problem.forcing.Omega * np.arange(401)))
    assert np.allclose(
        (turns @ orbit.coefficients).real, orbit.q, atol=1e-6 * np.abs(orbit.q).max()
    )
    # the balance of each harmonic holds exactly: Z c + e h = f
    k = np.arange(401) * problem.forcing.Omega
    force = np.zeros((401, problem.n), complex)
    force[: len(problem.forcing.cos)] = problem.forcing.coefficients
    force[:, problem.joint] -= orbit.torque_coefficients
    Z = problem.K + 1j * k[:, None, None] * (problem.C + problem.G)
    Z = Z - (k**2)[:, None, None] * problem.M
    left = np.einsum("kij,kj->ki", Z, orbit.coefficients)
    assert np.abs(left - force)[:50].max() <= 1e-9 * np.abs(force).max()


def test_locked_joint_rests_anywhere_in_its_interval():
    problem = random_problem(4, n=6, share=1.4, static=False)
    orbit = event_map.periodic(problem)
    low, high = orbit.rest_interval
    assert orbit.q[0, problem.joint] == pytest.approx(0.5 * (low + high), rel=1e-12)
    assert orbit.stick_fraction == 1.0
    assert len(orbit.events) == 0
    for place in (low + 1e-9 * (high - low), high - 1e-9 * (high - low)):
        shifted = event_map.locked.at_rest(problem, place)
        assert len(event_map.propagate(problem, 2.0, shifted).events) == 0
    for place in (low - 0.01 * (high - low), high + 0.01 * (high - low)):
        shifted = event_map.locked.at_rest(problem, place)
        assert len(event_map.propagate(problem, 2.0, shifted).events) > 0


def test_critical_torque_is_that_of_the_recipe():
    for seed in range(20):
        problem = random_problem(seed, static=False)
        found = event_map.locked.locked(problem).Q_m_cr
        assert found == pytest.approx(critical_torque(problem), rel=1e-5)


def test_any_two_motions_approach():
    """Q_s = Q_m: the distance in the energy norm never grows."""
    for seed in range(25):
        problem = random_problem(seed, static=False)
        draw = random_state(seed, problem), random_state(seed + 1000, problem)
        settings = event_map.Settings(samples_per_period=60, keep="all")
        a, b = (event_map.propagate(problem, 3.0, x, settings) for x in draw)
        q, v = a.q - b.q, a.q_dot - b.q_dot
        energy = np.einsum("ti,ij,tj->t", q, problem.K, q)
        energy += np.einsum("ti,ij,tj->t", v, problem.M, v)
        assert (np.diff(energy) <= 1e-11 * energy[0]).all()


def changed(problem, **parts):
    names = ("M", "C", "G", "K", "joint", "forcing", "friction")
    return FrictionProblem(**{name: parts.get(name, getattr(problem, name)) for name in names})


@pytest.mark.parametrize("seed", range(8))
def test_what_must_not_matter(seed):
    """Sign, scale, order of coordinates, an uncoupled coordinate, time shift: to 1e-9."""
    problem = random_problem(seed, static=False, share=0.2 + 0.05 * seed)
    n, forcing, Q_m = problem.n, problem.forcing, problem.friction.Q_m
    orbit = event_map.periodic(problem)
    x, size = orbit.initial_state, np.abs(orbit.initial_state).max()

    def state_of(other):
        return event_map.periodic(other).initial_state

    flipped = HarmonicForcing(forcing.Omega, -forcing.cos, -forcing.sin)
    assert np.abs(state_of(changed(problem, forcing=flipped)) + x).max() <= 1e-9 * size
    scaled = HarmonicForcing(forcing.Omega, 37.0 * forcing.cos, 37.0 * forcing.sin)
    other = changed(problem, forcing=scaled, friction=Coulomb(37.0 * Q_m))
    assert np.abs(state_of(other) / 37.0 - x).max() <= 1e-9 * size

    order = np.random.default_rng(seed).permutation(n)
    moved = {name: getattr(problem, name)[np.ix_(order, order)] for name in "MCGK"}
    joint = int(np.flatnonzero(order == problem.joint)[0])
    force = HarmonicForcing(forcing.Omega, forcing.cos[:, order], forcing.sin[:, order])
    found = state_of(changed(problem, **moved, joint=joint, forcing=force))
    assert np.abs(found - x[np.concatenate([order, n + order])]).max() <= 1e-9 * size

    more = {name: np.zeros((n + 1, n + 1)) for name in "MCGK"}
    for name, value in zip("MCGK", (2.0, 0.3, 0.0, 5.0), strict=True):
        more[name][:n, :n], more[name][n, n] = getattr(problem, name), value
    wide = [np.pad(part, ((0, 0), (0, 1))) for part in (forcing.cos, forcing.sin)]
    extra = changed(problem, **more, forcing=HarmonicForcing(forcing.Omega, *wide))
    found = state_of(extra)
    assert np.abs(np.delete(found, [n, 2 * n + 1]) - x).max() <= 1e-9 * size

    t = 0.3 * problem.period
    turn = np.exp(1j * forcing.Omega * t * np.arange(len(forcing.cos)))[:, None]
    later = forcing.coefficients * turn
    sin = -later.imag
    sin[0] = 0.0
    found = state_of(changed(problem, forcing=HarmonicForcing(forcing.Omega, later.real, sin)))
    wanted = event_map.propagate(problem, 0.3, x).final_state
    assert np.abs(found - wanted).max() <= 1e-9 * size


def test_saturated_law_converges_to_the_exact_one():
    """The orbit differs by O(sigma)."""
    problem = random_problem(12, n=3, share=0.4, static=False)
    exact = event_map.periodic(problem)
    v = np.abs(exact.q_dot[:, problem.joint]).max()
    gaps = []
    for sigma in (1e-2, 1e-3, 1e-4):
        law = SaturatedCoulomb(problem.friction.Q_m, sigma * v)
        orbit = event_map.periodic(problem.with_friction(law))
        assert orbit.period_residual <= 1e-12
        assert orbit.energy_balance_residual <= 1e-10
        gaps.append(np.sqrt(np.mean((orbit.q - exact.q) ** 2)))
    slopes = np.diff(np.log10(gaps))
    assert np.allclose(slopes, -1.0, atol=0.1)


def test_unstable_linear_part_is_named():
    problem = random_problem(1, n=3)
    lowest = np.linalg.eigvalsh(problem.K)[0]
    K = problem.K - 1.5 * lowest * np.eye(3) * 3.0
    with pytest.raises(NotPeriodicError, match=r"eigenvalue .* positive real part"):
        event_map.periodic(changed(problem, K=K))


def test_motion_without_a_short_period_is_not_called_periodic():
    """Q_s > Q_m: either an orbit that the reference confirms, or a refusal."""
    refused = 0
    for seed in range(20):
        problem = random_problem(seed, n=1 + seed % 4, share=0.5, static=True)
        try:
            orbit = event_map.periodic(problem, event_map.Settings(max_multiple=3))
        except NotPeriodicError:
            refused += 1
            continue
        periods = orbit.statistics["multiple"]
        again = exact_transient(problem, float(periods), orbit.initial_state)
        size = np.abs(orbit.initial_state).max()
        assert np.abs(again.final_state - orbit.initial_state).max() <= 1e-8 * size
    assert refused < 20


def sticky(seed):
    """Q_s = 1.6 Q_m: periods of two and three forcing periods occur."""
    problem = random_problem(seed, n=1 + seed % 3, share=0.3 + 0.1 * (seed % 5), static=True)
    return problem.with_friction(Coulomb(problem.friction.Q_m, 1.6 * problem.friction.Q_m))


@pytest.mark.parametrize(("seed", "multiple"), [(33, 2), (41, 2), (128, 3)])
def test_longer_periods_are_found_on_request_only(seed, multiple):
    problem = sticky(seed)
    with pytest.raises(NotPeriodicError, match=r"no orbit of period 1 .* max_multiple \(1 now\)"):
        event_map.periodic(problem)
    orbit = event_map.periodic(problem, event_map.Settings(max_multiple=3))
    assert orbit.statistics["multiple"] == multiple
    assert orbit.window == (0.0, pytest.approx(multiple * problem.period, rel=1e-14))
    assert orbit.coefficients is None
    size = np.abs(orbit.initial_state).max()
    early = event_map.propagate(problem, 1.0, orbit.initial_state).final_state
    assert np.abs(early - orbit.initial_state).max() > 1e-3 * size
    exact = exact_transient(problem, float(multiple), orbit.initial_state)
    assert np.abs(exact.final_state - orbit.initial_state).max() <= 1e-10 * size
    assert exact.kind == orbit.events.kind.tolist()
    assert orbit.energy_balance_residual <= 1e-10


def test_unstable_orbits_carry_a_warning():
    orbit = event_map.periodic(sticky(163), event_map.Settings(max_multiple=3))
    assert np.abs(orbit.multipliers).max() > 1.1
    assert any("unstable" in text for text in orbit.warnings)


def test_symmetric_problem_with_an_orbit_that_is_not():
    """Q_s = 3 Q_m: half a period later the motion is not the mirror image."""
    push = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
    problem = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.25, 0.75))
    orbit = event_map.periodic(problem)
    assert not orbit.statistics["half_wave"]
    half = event_map.propagate(problem, 0.5, orbit.initial_state).final_state
    assert np.abs(half + orbit.initial_state).max() > 0.1
    exact = exact_transient(problem, 1.0, orbit.initial_state)
    assert np.abs(exact.final_state - orbit.initial_state).max() <= 1e-12
    settings = event_map.Settings(samples_per_period=4000)
    fine = event_map.periodic(problem, settings)
    wanted = np.sqrt(np.trapezoid(fine.q[:, 0] ** 2, fine.t) / problem.period)
    assert event_map.rms(fine)[0] == pytest.approx(wanted, rel=1e-6)
