"""`survey`: the figures of `solve`, many at a time."""

from __future__ import annotations

import numpy as np
import pytest
from support.problems import random_problem

from beltsim.errors import InvalidProblemError, UnsupportedLawError
from beltsim.friction import Coulomb
from beltsim.harmonic_balance import Settings, solve, survey
from beltsim.metrics.rms import rms


def grid_of(seed: int) -> list:
    problem = random_problem(seed, 4, static=False, share=1.0)
    Q_cr = problem.friction.Q_m
    return [problem.with_friction(Coulomb(share * Q_cr)) for share in (0.0, 0.2, 0.7, 1.3)]


@pytest.mark.parametrize("seed", range(3))
def test_a_row_is_what_solve_finds(seed: int) -> None:
    problems = grid_of(seed)
    found = survey(problems, R=9, workers=1)
    assert found.converged.all()
    assert not found.failures
    for i, problem in enumerate(problems):
        one = solve(problem, 9, Settings(estimate=False))
        assert found.rms[i] == pytest.approx(rms(one), rel=1e-12, abs=1e-14)
        assert found.dissipated_energy[i] == pytest.approx(one.dissipated_energy, rel=1e-12)
        assert found.Q_cr[i] == one.statistics["Q_cr"]
        assert found.Q_cr_R[i] == one.statistics["Q_cr_R"]
        assert found.gap[i] == one.statistics["complementarity_gap"]
        assert found.locked[i] == one.statistics["locked"]


def test_workers_do_not_change_a_bit() -> None:
    one, two = (survey(grid_of(0) + grid_of(1), R=9, workers=count) for count in (1, 2))
    for name in ("rms", "dissipated_energy", "Q_cr", "Q_cr_R", "gap", "locked", "converged"):
        assert np.array_equal(getattr(one, name), getattr(two, name))


def test_a_failure_keeps_its_reason_and_leaves_a_hole() -> None:
    problems = grid_of(0)
    problems[1] = problems[1].with_friction(Coulomb(0.1, 0.2))
    found = survey(problems, R=9)
    assert isinstance(found.failures[1], UnsupportedLawError)
    assert found.converged.tolist() == [True, False, True, True]
    assert np.isnan(found.rms[1]).all()
    assert np.isfinite(np.delete(found.rms, 1, axis=0)).all()


def test_problems_must_be_of_one_size() -> None:
    with pytest.raises(InvalidProblemError, match="all of one n"):
        survey([random_problem(1, 2, static=False), random_problem(1, 3, static=False)])
    assert len(survey([])) == 0


def test_the_table_is_read_only() -> None:
    found = survey(grid_of(0), R=9)
    with pytest.raises(ValueError, match="read-only"):
        found.rms[0, 0] = 1.0
