"""What must not change a motion: sign, units, order, time shifts, spectators, cuts."""

import numpy as np
import pytest
from support.problems import random_problem, random_state

from beltsim import Coulomb, FrictionProblem, HarmonicForcing
from beltsim.transient import Settings, integrate

TIGHT = Settings(rtol=1e-11)
SEEDS = [0, 3, 7, 12, 21]
every_seed = pytest.mark.parametrize("seed", SEEDS)


def case(seed, n=5):
    problem = random_problem(seed, n)
    return problem, random_state(seed, problem)


def forced(problem, cos, sin, friction=None, M=None, C=None, G=None, K=None, joint=None):
    return FrictionProblem(
        problem.M if M is None else M,
        problem.C if C is None else C,
        problem.G if G is None else G,
        problem.K if K is None else K,
        problem.joint if joint is None else joint,
        HarmonicForcing(problem.forcing.Omega, cos, sin),
        friction or problem.friction,
    )


def compare(one, other, state=None, t=None):
    """Event sequence and end state of two runs, 1e-9 of the largest entry."""
    assert len(one.events) == len(other.events) > 0
    scale = np.abs(one.final_state).max()
    expected = other.final_state if state is None else state
    np.testing.assert_allclose(one.final_state, expected, rtol=0, atol=1e-9 * scale)
    times = other.events.t if t is None else t
    np.testing.assert_allclose(one.events.t, times, rtol=0, atol=1e-8 * one.problem.period)


@every_seed
def test_a_flip_of_sign_flips_the_motion(seed):
    problem, y0 = case(seed)
    run = integrate(problem, 6.3, y0, TIGHT)
    flipped = integrate(
        forced(problem, -problem.forcing.cos, -problem.forcing.sin), 6.3, -y0, TIGHT
    )
    assert np.array_equal(flipped.final_state, -run.final_state)  # to the last bit
    assert np.array_equal(flipped.events.t, run.events.t)
    turned = {"slip+": "slip-", "slip-": "slip+"}
    assert [turned.get(k, k) for k in flipped.events.kind] == list(run.events.kind)


@every_seed
def test_force_and_torque_scaled_together_scale_the_motion(seed):
    problem, y0 = case(seed)
    run = integrate(problem, 6.3, y0, TIGHT)
    for factor in (2.0**20, 1e-6):
        law = Coulomb(factor * problem.friction.Q_m, factor * problem.friction.Q_s)
        scaled = forced(problem, factor * problem.forcing.cos, factor * problem.forcing.sin, law)
        again = integrate(scaled, 6.3, factor * y0, TIGHT)
        compare(run, again, again.final_state / factor)


@every_seed
def test_other_units_of_time_change_nothing(seed):
    problem, y0 = case(seed)
    run = integrate(problem, 6.3, y0, TIGHT)
    a = 1e-3  # new unit = 1000 old ones
    other = FrictionProblem(
        problem.M / a**2,
        problem.C / a,
        problem.G / a,
        problem.K,
        problem.joint,
        HarmonicForcing(problem.forcing.Omega * a, problem.forcing.cos, problem.forcing.sin),
        problem.friction,
    )
    n = problem.n
    factor = np.concatenate([np.ones(n), np.full(n, a)])
    again = integrate(other, 6.3, y0 * factor, TIGHT)
    compare(run, again, again.final_state / factor, again.events.t * a)


@every_seed
def test_a_permutation_of_the_coordinates_permutes_the_motion(seed):
    problem, y0 = case(seed)
    n = problem.n
    order = np.random.default_rng(seed).permutation(n)
    both = np.concatenate([order, n + order])
    block = np.ix_(order, order)
    shuffled = forced(
        problem,
        problem.forcing.cos[:, order],
        problem.forcing.sin[:, order],
        None,
        *(A[block] for A in (problem.M, problem.C, problem.G, problem.K)),
        joint=int(np.flatnonzero(order == problem.joint)[0]),
    )
    run = integrate(problem, 6.3, y0, TIGHT)
    again = integrate(shuffled, 6.3, y0[both], TIGHT)
    compare(again, run, run.final_state[both])


@every_seed
def test_an_uncoupled_spectator_changes_nothing(seed):
    problem, y0 = case(seed)
    n = problem.n

    def grown(A, corner):
        out = np.zeros((n + 1, n + 1))
        out[:n, :n], out[n, n] = A, corner
        return out

    wider = forced(
        problem,
        np.pad(problem.forcing.cos, ((0, 0), (0, 1))),
        np.pad(problem.forcing.sin, ((0, 0), (0, 1))),
        None,
        grown(problem.M, 2.0),
        grown(problem.C, 0.1),
        grown(problem.G, 0.0),
        grown(problem.K, 30.0),
    )
    start = np.concatenate([y0[:n], [0.3], y0[n:], [-0.2]])
    run = integrate(problem, 6.3, y0, TIGHT)
    again = integrate(wider, 6.3, start, TIGHT)
    keep = np.r_[0:n, n + 1 : 2 * n + 1]
    compare(run, again, again.final_state[keep])


@every_seed
def test_a_run_cut_at_whole_periods_goes_on_the_same(seed):
    problem, y0 = case(seed)
    run = integrate(problem, 7.0, y0, TIGHT)
    first = integrate(problem, 3.0, y0, TIGHT)
    second = integrate(problem, 4.0, first.final_state, TIGHT)
    scale = np.abs(run.final_state).max()
    np.testing.assert_allclose(second.final_state, run.final_state, rtol=0, atol=1e-9 * scale)
    times = np.concatenate([first.events.t, second.events.t + 3.0 * problem.period])
    np.testing.assert_allclose(times, run.events.t, rtol=0, atol=1e-8 * problem.period)


@every_seed
def test_a_run_cut_at_any_time_goes_on_the_same(seed):
    """The second part sees the forcing from its own zero of time."""
    problem, y0 = case(seed)
    cut = 2.0 + np.random.default_rng(seed).random()
    k = np.arange(len(problem.forcing.cos))[:, None]
    angle = 2.0 * np.pi * cut * k
    c, s = problem.forcing.cos, problem.forcing.sin
    later = forced(
        problem,
        c * np.cos(angle) + s * np.sin(angle),
        np.where(k == 0, 0.0, s * np.cos(angle) - c * np.sin(angle)),
    )
    run = integrate(problem, 6.0, y0, TIGHT)
    first = integrate(problem, cut, y0, TIGHT)
    second = integrate(later, 6.0 - cut, first.final_state, TIGHT)
    scale = np.abs(run.final_state).max()
    np.testing.assert_allclose(second.final_state, run.final_state, rtol=0, atol=1e-9 * scale)


@every_seed
def test_a_rerun_gives_the_same_bits(seed):
    problem, y0 = case(seed)
    run, again = (integrate(problem, 3.0, y0) for _ in range(2))
    assert np.array_equal(run.final_state, again.final_state)
    assert np.array_equal(run.events.t, again.events.t)
    assert run.statistics == again.statistics


@every_seed
def test_two_motions_contract_in_energy(seed):
    """Q_s = Q_m, C >= 0: the energy of the difference of any two motions never grows."""
    problem, _ = case(seed)
    problem = problem.with_friction(Coulomb(problem.friction.Q_m))
    settings = Settings(rtol=1e-11, keep="all", samples_per_period=50)
    one, other = (
        integrate(problem, 6.0, random_state(s, problem), settings) for s in (seed, seed + 1000)
    )
    dq, dv = one.q - other.q, one.q_dot - other.q_dot
    energy = 0.5 * (
        np.einsum("ti,ij,tj->t", dv, problem.M, dv) + np.einsum("ti,ij,tj->t", dq, problem.K, dq)
    )
    assert np.diff(energy).max() < 1e-9 * energy[0]
