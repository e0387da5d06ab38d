"""Margins of a series' events: the meaning that the other solvers give them."""

from __future__ import annotations

import numpy as np
import pytest
from support.damped import damped_problem
from support.problems import random_problem

from beltsim import event_map
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance import Pattern, Settings, solve
from beltsim.problem import FrictionProblem

BARE = Settings(estimate=False)
#: Problems of the recipe whose events a series of 21 harmonics tells apart.
SEEDS = (9001, 9002, 9005, 9007)


def patterned(problem: FrictionProblem, orbit) -> Settings:
    events = orbit.events
    return Settings(pattern=Pattern(events.kind, events.t, orbit.initial_mode), estimate=False)


def test_one_mass_has_them_in_closed_form() -> None:
    push = HarmonicForcing(0.5, cos=[[0.0], [1.0]], sin=[[0.0], [0.3]])
    for Q_s in (0.4, 0.6):
        one = FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, Coulomb(0.4, Q_s))
        found = solve(one, 15, patterned(one, event_map.periodic(one))).events
        angle = 0.5 * found.t
        reaction = np.cos(angle) + 0.3 * np.sin(angle) - found.position
        rate = 0.5 * (0.3 * np.cos(angle) - np.sin(angle))
        size = max(Q_s, np.abs(reaction).max())
        stops = (found.kind == "stick") | (found.kind == "reverse")
        expected = np.where(stops, np.abs(np.abs(reaction) - Q_s), np.abs(rate) / 0.5) / size
        assert stops.any()
        assert not stops.all()
        assert found.margin == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_located_events_have_those_of_the_exact_orbit(seed: int) -> None:
    problem = damped_problem(seed)
    orbit = event_map.periodic(problem)
    settings = patterned(problem, orbit)
    wrong = [
        np.abs(solve(problem, R, settings).events.margin - orbit.events.margin).max()
        for R in (21, 81)
    ]
    assert wrong[1] < 2e-4
    assert wrong[1] < 0.5 * wrong[0]


def test_averaged_events_approach_them() -> None:
    ratios = []
    for seed in SEEDS:
        problem = damped_problem(seed)
        orbit = event_map.periodic(problem)
        wrong = []
        for R in (21, 81):
            found = solve(problem, R, BARE).events
            assert found.kind.tolist() == orbit.events.kind.tolist()
            wrong.append(np.abs(found.margin - orbit.events.margin).max())
        ratios.append(wrong[1] / wrong[0])
    # the instants are known to O(1/R): four times the harmonics, a quarter of the error
    assert np.exp(np.mean(np.log(ratios))) == pytest.approx(0.25, rel=0.4)


def test_an_edge_of_the_band_has_the_rate_through_it() -> None:
    problem = random_problem(1, 3, static=False, share=0.3)
    peak = solve(problem, 9, BARE).statistics["velocity_peak"]
    law = SaturatedCoulomb(problem.friction.Q_m, 0.05 * peak)
    settings = Settings(projection="exact", start="set_valued", estimate=False)
    found = solve(problem.with_friction(law), 9, settings)
    spin = 1j * problem.forcing.Omega * np.arange(10)
    velocity = spin * found.coefficients[:, problem.joint]
    step = 1e-5 * problem.period
    before, after = (
        (np.exp(np.multiply.outer(found.events.t + s, spin)) @ velocity).real for s in (-step, step)
    )
    rate = np.abs(after - before) / (2.0 * step)
    size = problem.forcing.Omega * found.statistics["velocity_peak"]
    assert found.events.margin == pytest.approx(rate / size, rel=1e-6)


@pytest.mark.parametrize("seed", range(8))
def test_none_is_unknown(seed: int) -> None:
    problem = random_problem(seed, static=False)
    for law in (problem.friction, Coulomb(0.0), SaturatedCoulomb(problem.friction.Q_m, 1e-2)):
        margin = solve(problem.with_friction(law), 9, Settings(start="set_valued")).events.margin
        assert np.all(margin >= 0.0)
