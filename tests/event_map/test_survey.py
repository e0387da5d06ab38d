"""Maps of figures: the numbers of `solve_many`, failures in place, any number of workers."""

from __future__ import annotations

import numpy as np
import pytest
from support.problems import random_problem

import beltsim
from beltsim import Coulomb, SaturatedCoulomb, event_map
from beltsim.errors import InvalidProblemError, NotPeriodicError

FIGURES = ("dissipated_energy", "stick_fraction", "velocity_reversals", "stops_per_period")


def grid(n=3, static=1.0):
    found = []
    for seed in range(8):
        problem = random_problem(seed, n=n, share=0.6, static=False)
        Q = problem.friction.Q_m
        shares = (0.1, 0.3, 0.5, 0.8, 1.0, 3.0)
        found += [problem.with_friction(Coulomb(Q * s, Q * s * static)) for s in shares]
    return found


def assert_same_figures(problems, settings=None):
    table = event_map.survey(problems, settings)
    solved = event_map.solve_many(problems, settings)
    assert len(table) == len(problems)
    for i, orbit in enumerate(solved):
        if isinstance(orbit, Exception):
            assert str(table.failures[i]) == str(orbit)
            assert np.isnan(table.rms[i]).all()
            continue
        for name in FIGURES:
            found = getattr(table, name)[i]
            assert found == pytest.approx(getattr(orbit, name), rel=1e-10, abs=1e-10), name
        assert np.allclose(table.rms[i], event_map.rms(orbit), rtol=1e-10)
        assert np.allclose(
            np.sort(np.abs(table.multipliers[i])), np.sort(np.abs(orbit.multipliers)), atol=1e-9
        )
        assert np.allclose(table.initial_state[i], orbit.initial_state, rtol=1e-10, atol=1e-13)
        assert table.locked[i] == (orbit.rest_interval is not None)
    return table


@pytest.mark.parametrize("n", [1, 3, 6])
def test_figures_are_those_of_the_responses(n):
    table = assert_same_figures(grid(n))
    assert table.locked.any()
    assert ((table.stick_fraction > 0.0) & (table.stick_fraction < 1.0)).any()


def test_figures_of_longer_periods_and_failures():
    table = assert_same_figures(grid(2, 1.6), event_map.Settings(max_multiple=2))
    assert all(isinstance(error, NotPeriodicError) for error in table.failures.values())


def test_figures_of_the_saturated_law():
    problems = []
    for seed in range(4):
        problem = random_problem(seed, n=3, share=0.5, static=False)
        speed = np.abs(event_map.periodic(problem).q_dot[:, problem.joint]).max()
        for share in (1e-2, 1e-3):
            law = SaturatedCoulomb(problem.friction.Q_m, share * speed)
            problems.append(problem.with_friction(law))
    table = assert_same_figures(problems)
    assert not table.failures
    assert not table.locked.any()


def test_several_reversals_are_counted():
    """Many stops per period: strong harmonics at a low frequency."""
    problems = [random_problem(seed, share=0.15, static=False) for seed in range(40)]
    for problem in problems:
        table = event_map.survey([problem])
        orbit = event_map.periodic(problem)
        assert table.velocity_reversals[0] == orbit.velocity_reversals
        assert table.stops_per_period[0] == orbit.stops_per_period


def test_same_bits_for_any_number_of_workers():
    one, two, five = (event_map.survey(grid(), workers=workers) for workers in (1, 2, 5))
    for other in (two, five):
        for name in (*FIGURES, "rms", "multipliers", "initial_state", "locked"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name


def test_failures_stand_in_their_place():
    problems = grid()[:2]
    bad = random_problem(9, n=3, static=False)
    K = bad.K - 1.2 * np.linalg.eigvalsh(bad.K)[-1] * np.eye(3)
    object.__setattr__(bad, "K", K)
    table = event_map.survey([problems[0], bad, problems[1]], workers=2)
    assert list(table.failures) == [1]
    assert isinstance(table.failures[1], NotPeriodicError)
    assert np.isnan(table.rms).any(axis=1).tolist() == [False, True, False]


def test_arrays_are_frozen():
    table = event_map.survey(grid()[:1])
    with pytest.raises(ValueError, match="read-only"):
        table.rms[0] = 0.0


def test_bad_input_is_refused():
    with pytest.raises(InvalidProblemError, match="all of one n"):
        event_map.survey([*grid(2)[:1], *grid(3)[:1]])
    with pytest.raises(InvalidProblemError, match="workers"):
        event_map.survey(grid()[:1], workers=0)


def test_empty_grid():
    table = event_map.survey([])
    assert len(table) == 0
    assert table.rms.shape == (0, 0)


def test_energy_of_a_longer_orbit_is_per_forcing_period():
    drive = beltsim.presets.zhu_parker_2008()
    law = beltsim.Coulomb(1.4, 8.4)
    problem = beltsim.assemble(drive, 6.3, friction=law, n_functions=6)
    settings = event_map.Settings(max_multiple=3)
    orbit = event_map.periodic(problem, settings)
    assert orbit.statistics["multiple"] == 2
    table = event_map.survey([problem], settings)
    assert table.dissipated_energy[0] == pytest.approx(0.5 * orbit.dissipated_energy, rel=1e-12)
