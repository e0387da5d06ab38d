"""Grids of orbits: order, failures in place, the same bits for any number of workers."""

from __future__ import annotations

import numpy as np
import pytest
from support.problems import random_problem

from beltsim import Coulomb, FrictionProblem, event_map, linear
from beltsim.errors import InvalidProblemError, NotPeriodicError

SETTINGS = event_map.Settings(samples_per_period=1, harmonics=0)


def grid():
    found = []
    for seed in range(5):
        problem = random_problem(seed, n=3, share=0.6, static=False)
        Q = problem.friction.Q_m
        found += [problem.with_friction(Coulomb(Q * s)) for s in (0.3, 0.5, 0.8, 1.0, 3.0)]
    return found


def test_same_bits_for_any_number_of_workers():
    runs = [event_map.solve_many(grid(), SETTINGS, workers) for workers in (1, 2, 5)]
    for one, two, five in zip(*runs, strict=True):
        for other in (two, five):
            assert np.array_equal(one.initial_state, other.initial_state)
            assert np.array_equal(one.multipliers, other.multipliers)
            assert one.dissipated_energy == other.dissipated_energy


def test_each_orbit_is_that_of_its_own_search():
    """Warm starts change nothing but the way."""
    problems = grid()
    for problem, orbit in zip(problems, event_map.solve_many(problems, SETTINGS), strict=True):
        alone = event_map.periodic(problem, SETTINGS)
        assert orbit.problem is problem
        size = np.abs(alone.initial_state).max()
        assert np.abs(orbit.initial_state - alone.initial_state).max() <= 1e-9 * size
        assert orbit.events.kind.tolist() == alone.events.kind.tolist()
        assert orbit.stick_fraction == pytest.approx(alone.stick_fraction, abs=1e-9)


def test_failures_stand_in_their_place():
    problems = grid()[:3]
    bad = random_problem(9, n=3, static=False)
    K = bad.K - 1.2 * np.linalg.eigvalsh(bad.K)[-1] * np.eye(3)
    object.__setattr__(bad, "K", K)
    found = event_map.solve_many([problems[0], bad, *problems[1:]], SETTINGS, 2)
    assert [isinstance(each, Exception) for each in found] == [False, True, False, False]
    assert isinstance(found[1], NotPeriodicError)


@pytest.mark.parametrize("workers", [0, -1, 1.5, True])
def test_bad_workers_are_refused(workers):
    with pytest.raises(InvalidProblemError, match="workers"):
        event_map.solve_many([], workers=workers)


def test_empty_grid():
    assert event_map.solve_many([]) == []


def test_locked_joints_of_one_system_share_their_motion_only():
    """Each keeps its own law and rest interval, and equals what a fresh problem gives."""
    problem = random_problem(4, n=3, static=False)
    Q_cr = linear.critical_torque(problem)
    problems = [problem.with_friction(Coulomb(Q_cr * share)) for share in (1.2, 1.5, 3.0)]
    found = event_map.solve_many(problems, workers=1)
    for one, orbit in zip(problems, found, strict=True):
        fresh = FrictionProblem(one.M, one.C, one.G, one.K, one.joint, one.forcing, one.friction)
        alone = event_map.periodic(fresh)
        assert orbit.problem is one
        assert orbit.rest_interval == alone.rest_interval
        assert np.array_equal(orbit.q, alone.q)
        assert np.array_equal(orbit.friction_torque, alone.friction_torque)
        assert orbit.warnings == alone.warnings
    assert found[0].rest_interval != found[1].rest_interval
