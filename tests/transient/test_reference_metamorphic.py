"""Runs that must agree because they are the same motion seen in another way: 1e-9 at rtol 1e-11."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from support.exact import exact_transient
from support.problems import random_problem, random_state

from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem
from beltsim.transient import Settings, integrate, solve_many

SETTINGS = Settings(rtol=1e-11, samples_per_period=40, keep="all")
PERIODS = 4.0
TOLERANCE = 1e-9
OTHER_SIGN = {"slip+": "slip-", "slip-": "slip+"}
#: Problems whose event sequence is decided by a margin above 1e-3, found by scanning the recipe.
SEEDS = (1, 2, 3, 4, 6, 11, 13, 16, 19, 20, 29, 32)


@cache
def case(seed):
    problem = random_problem(seed)
    start = random_state(seed, problem) if seed % 2 else np.zeros(2 * problem.n)
    return problem, start, integrate(problem, PERIODS, start, SETTINGS)


def assert_same(response, q, q_dot, kinds, times):
    """Samples within TOLERANCE of their size, events alike and within TOLERANCE periods."""
    for found, expected in ((response.q, q), (response.q_dot, q_dot)):
        assert np.abs(found - expected).max() <= TOLERANCE * np.abs(expected).max()
    assert list(response.events.kind) == list(kinds)
    if len(times):
        assert np.abs(response.events.t - times).max() <= TOLERANCE * response.problem.period


def rotated(forcing, time):
    """The forcing seen from `time`."""
    angle = forcing.Omega * time * np.arange(len(forcing.cos))[:, None]
    cos = forcing.cos * np.cos(angle) + forcing.sin * np.sin(angle)
    sin = forcing.sin * np.cos(angle) - forcing.cos * np.sin(angle)
    sin[0] = 0.0
    return HarmonicForcing(forcing.Omega, cos, sin)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_cases_are_decided(seed):
    problem, start, response = case(seed)
    run = exact_transient(problem, PERIODS, start)
    assert run.min_margin > 1e-3
    assert list(response.events.kind) == run.kind


@pytest.mark.parametrize("seed", SEEDS)
def test_sign_flip(seed):
    problem, start, response = case(seed)
    forcing = problem.forcing
    mirrored = dataclasses.replace(
        problem, forcing=HarmonicForcing(forcing.Omega, -forcing.cos, -forcing.sin)
    )
    flipped = integrate(mirrored, PERIODS, -start, SETTINGS)
    kinds = [OTHER_SIGN.get(kind, kind) for kind in response.events.kind]
    assert_same(flipped, -response.q, -response.q_dot, kinds, response.events.t)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("factor", [1e-6, 3.7])
def test_scaling_of_force_torque_and_state(seed, factor):
    problem, start, response = case(seed)
    forcing, law = problem.forcing, problem.friction
    scaled = dataclasses.replace(
        problem,
        forcing=HarmonicForcing(forcing.Omega, factor * forcing.cos, factor * forcing.sin),
        friction=Coulomb(factor * law.Q_m, factor * law.Q_s),
    )
    found = integrate(scaled, PERIODS, factor * start, SETTINGS)
    events = response.events
    assert_same(found, factor * response.q, factor * response.q_dot, events.kind, events.t)


@pytest.mark.parametrize("seed", SEEDS)
def test_permutation_of_the_coordinates(seed):
    problem, start, response = case(seed)
    n = problem.n
    order = np.random.default_rng(seed).permutation(n)
    swap = np.ix_(order, order)
    forcing = problem.forcing
    permuted = FrictionProblem(
        *(getattr(problem, name)[swap] for name in "MCGK"),
        int(np.flatnonzero(order == problem.joint)[0]),
        HarmonicForcing(forcing.Omega, forcing.cos[:, order], forcing.sin[:, order]),
        problem.friction,
    )
    begin = np.concatenate([start[:n][order], start[n:][order]])
    found = integrate(permuted, PERIODS, begin, SETTINGS)
    events = response.events
    assert_same(found, response.q[:, order], response.q_dot[:, order], events.kind, events.t)


@pytest.mark.parametrize("seed", SEEDS)
def test_an_uncoupled_oscillator_changes_nothing(seed):
    problem, start, response = case(seed)
    n, forcing = problem.n, problem.forcing
    size = float(np.abs(forcing.cos).max())

    def bordered(A, corner):
        larger = np.zeros((n + 1, n + 1))
        larger[:n, :n], larger[n, n] = A, corner
        return larger

    extra = np.zeros((len(forcing.cos), 1))
    extra[1] = 0.3 * size
    larger = FrictionProblem(
        *(bordered(problem.M, 0.7), bordered(problem.C, 0.05), bordered(problem.G, 0.0)),
        bordered(problem.K, 2.3),
        problem.joint,
        HarmonicForcing(
            forcing.Omega,
            np.hstack([forcing.cos, extra]),
            np.hstack([forcing.sin, np.zeros_like(extra)]),
        ),
        problem.friction,
    )
    found = integrate(larger, PERIODS, np.insert(start, [n, 2 * n], 0.0), SETTINGS)
    events = response.events
    kept = dataclasses.replace(found, q=found.q[:, :n], q_dot=found.q_dot[:, :n])
    assert_same(kept, response.q, response.q_dot, events.kind, events.t)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_run_split_at_any_time(seed):
    """The second part starts from the state reached, with the forcing seen from there."""
    problem, start, response = case(seed)
    share = np.random.default_rng(seed).uniform(0.2, 0.8)
    first = integrate(problem, share * PERIODS, start, SETTINGS)
    split = share * PERIODS * problem.period
    later = dataclasses.replace(problem, forcing=rotated(problem.forcing, split))
    second = integrate(later, (1.0 - share) * PERIODS, first.final_state, SETTINGS)
    whole = response.final_state
    n = problem.n
    for part in (slice(0, n), slice(n, 2 * n)):
        gap = np.abs(second.final_state[part] - whole[part]).max()
        assert gap <= TOLERANCE * np.abs(whole[part]).max()
    kinds = [*first.events.kind, *second.events.kind]
    times = np.concatenate([first.events.t, second.events.t + split])
    assert kinds == list(response.events.kind)
    assert np.abs(times - response.events.t).max(initial=0.0) <= TOLERANCE * problem.period


@pytest.mark.parametrize("seed", SEEDS)
def test_a_run_begun_a_period_later(seed):
    """After whole periods the forcing is the same again."""
    problem, start, response = case(seed)
    first = integrate(problem, 1.0, start, SETTINGS)
    second = integrate(problem, PERIODS - 1.0, first.final_state, SETTINGS)
    behind = response.events.t > problem.period
    times = response.events.t[behind] - problem.period
    late = response.t >= problem.period * (1.0 - 1e-12)
    assert_same(second, response.q[late], response.q_dot[late], response.events.kind[behind], times)


def test_the_same_bits_on_rerun_and_for_any_number_of_workers():
    problems = [case(seed)[0] for seed in SEEDS]
    once = [integrate(problem, 5.0) for problem in problems]
    for workers in (1, 2, 5):
        again = solve_many(problems, workers=workers, periods=5.0)
        for first, second in zip(once, again, strict=True):
            assert np.array_equal(first.events.t, second.events.t)
            assert np.array_equal(first.q, second.q)
            assert np.array_equal(first.final_state, second.final_state)
