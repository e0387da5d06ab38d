"""Random transients against the exact motion: events, times, states.

The recipe is `support.problems`: 1 to 30 coordinates, gyroscopic, damping 0.2 to 5 %, one to five
harmonics, Q_m from 0.02 to 1.1 of the critical torque, a third with Q_s > Q_m. `--full` runs 300 of
them; by default every eighth, half from rest and half from a random state.
"""

from __future__ import annotations

import numpy as np
import pytest
from support.agreement import agreement, marked
from support.exact import exact_transient
from support.problems import random_problem, random_state

from beltsim.transient import Settings, integrate

PERIODS = 10.0
SEEDS = range(300)
#: rtol: (largest relative state error, largest error of a well-conditioned event time / T)
BOUNDS = {1e-8: (1e-6, 1e-6), 1e-10: (1e-8, 1e-9)}
#: A smaller margin may be beyond what the tolerance resolves: the sequence, or the mark.
DECIDED = 1e-5


def check(seed: int) -> int:
    """Assert the bounds for one seed; how many event times were tested."""
    problem = random_problem(seed)
    start = random_state(seed, problem) if seed % 16 >= 8 else None
    run = exact_transient(problem, PERIODS, start)
    tested = 0
    for rtol, (states, times) in BOUNDS.items():
        settings = Settings(rtol=rtol, keep="all", samples_per_period=7)
        response = integrate(problem, PERIODS, start, settings)
        found = agreement(response, run)
        what = f"seed {seed}, n {problem.n}, rtol {rtol:g}"
        assert response.initial_mode == run.initial_mode, what
        if run.min_margin < DECIDED and not found.same_sequence:
            assert marked(response, found.first_difference), what
            continue
        assert list(response.events.kind) == run.kind, what
        assert found.same_sequence, what
        assert found.state_error <= states, what
        well = found.time_errors[found.well_conditioned]
        assert well.max(initial=0.0) <= times, what
        if run.min_margin > 1e-3:
            assert len(response.near_grazing) == 0, what
        tested += len(well)
    return tested


def test_random_transients(full):
    seeds = SEEDS if full else SEEDS[::8]
    tested = [check(seed) for seed in seeds]
    assert sum(tested) > 60 * len(seeds)


@pytest.mark.parametrize("n", [1, 30])
def test_smallest_and_largest(n):
    problem = random_problem(1000 + n, n, share=0.3, harmonics=5, static=True)
    run = exact_transient(problem, PERIODS)
    assert run.min_margin > DECIDED
    found = agreement(integrate(problem, PERIODS, settings=Settings(rtol=1e-10)), run)
    assert found.same_sequence
    assert len(run.kind) > 10
    assert found.state_error <= 1e-8


@pytest.mark.parametrize("method", ["adams", "bdf", "taylor"])
def test_every_method_finds_the_same_motion(method):
    problem = random_problem(6)
    run = exact_transient(problem, 5.0)
    response = integrate(problem, 5.0, settings=Settings(rtol=1e-8, method=method))
    found = agreement(response, run)
    assert found.same_sequence
    assert len(run.kind) > 50
    assert found.state_error <= 1e-6
    assert found.time_errors[found.well_conditioned].max() <= 1e-6


def test_torques_at_events_and_between():
    """+-Q_m in slip, Q_s at a release, and the holding reaction in stick."""
    problem = random_problem(11, 6, share=0.4, static=True)
    law = problem.friction
    run = exact_transient(problem, 6.0)
    response = integrate(problem, 6.0, settings=Settings(rtol=1e-10, keep="all"))
    events = response.events
    assert {"stick", "slip+", "slip-"} <= set(run.kind)
    scale = law.Q_s
    assert np.abs(events.torque_before - run.torque_before).max() < 1e-7 * scale
    assert np.abs(events.torque_after - run.torque_after).max() < 1e-7 * scale
    assert np.array_equal(events.q[:, problem.joint], events.position)
    assert not events.q_dot[:, problem.joint].any()
    v = response.q_dot[:, problem.joint]
    moving = v != 0.0
    assert np.array_equal(response.friction_torque[moving], law.Q_m * np.sign(v[moving]))
    assert np.abs(response.friction_torque[~moving]).max() <= law.Q_s * (1.0 + 1e-9)
    acceleration = np.gradient(response.q_dot, response.t, axis=0)
    inner = slice(1, -1)
    balance = problem.forcing.at(response.t) - response.q_dot @ (problem.C + problem.G).T
    balance -= response.q @ problem.K + acceleration @ problem.M
    far = np.abs(response.t[:, None] - events.t).min(axis=1) > 0.01 * problem.period
    gap = (balance[:, problem.joint] - response.friction_torque)[inner][far[inner]]
    assert np.abs(gap).max() < 1e-2 * np.abs(problem.forcing.cos).sum()
