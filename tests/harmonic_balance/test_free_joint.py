"""A joint that nothing but friction holds: friction carries the mean of its reaction too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from beltsim import event_map, linear
from beltsim.errors import InvalidProblemError
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb
from beltsim.harmonic_balance import Settings, condense, solve, survey
from beltsim.harmonic_balance.set_valued import critical_bound
from beltsim.problem import FrictionProblem

BARE = Settings(estimate=False)
#: Two harmonics whose sum reaches further up (1.8) than down, and one alone.
LOPSIDED, ALONE = [[0.0], [1.0], [0.8]], [[0.0], [1.0]]


def chain(Q_m: float, cos=LOPSIDED, ground: float = 0.0, n: int = 2) -> FrictionProblem:
    """Masses in a row; only the first, the joint, may have a spring to the ground."""
    springs = np.diff(np.eye(n), axis=0)
    K = 5.0 * springs.T @ springs
    K[0, 0] += ground
    rows = np.zeros((len(cos), n))
    rows[:, 0] = np.ravel(cos)
    push = HarmonicForcing(0.7, rows, np.zeros_like(rows))
    return FrictionProblem(np.eye(n), 0.1 * np.eye(n), np.zeros((n, n)), K, 0, push, Coulomb(Q_m))


@pytest.mark.parametrize("n", [1, 2, 4])
@pytest.mark.parametrize("cos", [LOPSIDED, ALONE])
def test_it_locks_where_the_other_solvers_say(n: int, cos) -> None:
    Q_cr = linear.critical_torque(chain(1.0, cos, n=n))
    found = solve(chain(1.01 * Q_cr, cos, n=n), 9, BARE)
    exact = event_map.periodic(chain(1.01 * Q_cr, cos, n=n))
    assert found.statistics["Q_cr"] == pytest.approx(Q_cr, rel=1e-9)
    assert survey([found.problem], BARE, R=9).Q_cr[0] == found.statistics["Q_cr"]
    assert found.statistics["locked"]
    assert found.rest_interval == exact.rest_interval == (-np.inf, np.inf)
    assert np.abs(found.q[0] - exact.q[0]).max() < 1e-9
    assert np.abs(found.friction_torque - exact.friction_torque).max() < 1e-9


def test_a_spring_takes_the_mean_off_the_friction() -> None:
    free, held = chain(5.0, n=1), chain(5.0, ground=1.0, n=1)
    assert solve(free, 9, BARE).statistics["Q_cr"] == pytest.approx(1.8)
    # the sum is least where cos = -1/3.2: half of its peak-to-peak is enough
    low = -1.0 / 3.2 + 0.8 * (2.0 / 3.2**2 - 1.0)
    assert solve(held, 9, BARE).statistics["Q_cr"] == pytest.approx(0.5 * (1.8 - low))


def test_the_truncated_problem_locks_early_and_not_for_less_than_its_mean() -> None:
    free = solve(chain(5.0), 9, BARE).statistics
    held = solve(chain(5.0, ground=1e-6), 9, BARE).statistics
    assert held["Q_cr_R"] < free["Q_cr_R"] < free["Q_cr"]
    between = solve(chain(0.5 * (free["Q_cr_R"] + free["Q_cr"])), 9, BARE)
    assert between.statistics["locked"]
    assert between.rest_interval is None
    assert any("use more harmonics" in text for text in between.warnings)


def test_its_critical_torque_is_that_of_a_linear_program() -> None:
    condensed = condense(chain(5.0), 5)
    N = 600
    angle = np.outer(np.arange(6), (np.arange(N) + 0.5) * 2.0 * np.pi / N)
    rows = 2.0 / N * np.concatenate([np.cos(angle), np.sin(angle[1:])])
    wanted = np.concatenate([[0.0], condensed.reaction.real, -condensed.reaction.imag])
    equal = np.hstack([rows, np.zeros((len(rows), 1))])
    below = np.vstack([np.eye(N), -np.eye(N)])
    bounds = np.hstack([below, -np.ones((2 * N, 1))])
    cost, free = np.append(np.zeros(N), 1.0), [(None, None)] * N + [(0.0, None)]
    least = linprog(cost, bounds, np.zeros(2 * N), equal, wanted, free).fun
    assert critical_bound(condensed) == pytest.approx(least, rel=1e-3)


def test_a_motion_that_drifts_is_refused_and_a_symmetric_one_is_not() -> None:
    with pytest.raises(InvalidProblemError, match="friction has a mean torque"):
        solve(chain(0.6), 9, BARE)
    found = solve(chain(0.6, ALONE), 9, BARE)
    assert found.dissipated_energy > 0.0
    assert found.energy_balance_residual < 1e-9
