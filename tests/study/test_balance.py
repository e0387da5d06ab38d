"""Harmonic balance with the pattern of events of the exact orbit, where Q_s > Q_m needs one."""

from __future__ import annotations

import numpy as np
import pytest

import beltsim
from beltsim import Coulomb, FrictionProblem, HarmonicForcing, event_map, study
from beltsim.errors import InvalidProblemError, NotPeriodicError
from tests.support.problems import random_problem

PUSH = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])
ONE = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, PUSH, Coulomb(0.4, 0.6))


def test_the_pattern_comes_from_the_exact_orbit():
    found, orbit = study.balance(ONE, 101), event_map.periodic(ONE)
    assert found.statistics["method"] == "pattern"
    assert found.statistics["pattern_from"] == "event_map"
    assert found.events.kind.tolist() == orbit.events.kind.tolist()
    np.testing.assert_allclose(found.events.t, orbit.events.t, atol=1e-5 * ONE.period)


def test_one_level_of_friction_needs_none():
    found = study.balance(ONE.with_friction(Coulomb(0.4)), 9)
    assert found.statistics["method"] == "set_valued"
    assert "pattern_from" not in found.statistics


def test_a_joint_that_may_rest_does_and_says_what_may_be_beside_it():
    law = Coulomb(0.4, 3.0)
    found = study.balance(ONE.with_friction(law), 9)
    assert found.stick_fraction == 1.0
    assert found.problem.friction == law
    assert any(text.endswith("may exist beside it") for text in found.warnings)


def test_a_longer_period_is_refused_with_what_to_try():
    problem = random_problem(33, n=1, share=0.6, static=True)
    Q_m = problem.friction.Q_m
    with pytest.raises(NotPeriodicError, match=r"no orbit of period 1 .*beltsim events"):
        study.balance(problem.with_friction(Coulomb(Q_m, 1.6 * Q_m)), 9)


def test_the_last_period_of_a_run_is_a_pattern():
    """Whatever the instant at which the run ends: phases count from a whole period."""
    orbit = event_map.periodic(ONE)
    for periods in (60.0, 60.3, 60.77):
        found = study.pattern_of(event_map.propagate(ONE, periods))
        assert found.kind == tuple(orbit.events.kind)
        assert found.initial_mode == orbit.initial_mode
        np.testing.assert_allclose(found.t, orbit.events.t, atol=1e-6 * ONE.period)
    with pytest.raises(InvalidProblemError, match="the joint rests"):
        study.pattern_of(event_map.propagate(ONE.with_friction(Coulomb(3.0)), 5.0))


def test_a_sweep_by_harmonic_balance_takes_the_static_ratio():
    drive = beltsim.presets.zhu_parker_2008()
    methods = (study.EventMap(static_ratio=1.5), study.HarmonicBalance(41, static_ratio=1.5))
    exact, found = (study.sweep(drive, [6.3], [1.0, 3.5], m, n_functions=3) for m in methods)
    assert (found.failure.values == "").all()
    np.testing.assert_allclose(found.dissipated_energy, exact.dissipated_energy, rtol=1e-3)
    assert found.phase_pattern.values.tolist() == exact.phase_pattern.values.tolist()
