"""Runs of the saturated law against its exact piecewise-linear solution."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.agreement import agreement
from support.exact import exact_transient
from support.problems import random_problem
from support.saturated import saturated_transient

from beltsim.friction import SaturatedCoulomb
from beltsim.transient import Settings, integrate


def saturated_problem(seed, n, share):
    """A problem of the recipe whose band is `share` of the largest joint velocity."""
    problem = random_problem(seed, n, share=0.3, static=False)
    peak = exact_transient(problem, 3.0).v_peak
    return problem.with_friction(SaturatedCoulomb(problem.friction.Q_m, share * peak))


@pytest.mark.parametrize(("seed", "n"), [(2, 1), (10, 2), (6, 5)])
def test_the_reference_against_dop853(seed, n):
    """The law is continuous: no events are needed, only small steps."""
    problem = saturated_problem(seed, n, 0.1)
    law, joint = problem.friction, problem.joint
    inverse = np.linalg.inv(problem.M)

    def rule(t, x):
        load = problem.forcing.at(t) - (problem.C + problem.G) @ x[n:] - problem.K @ x[:n]
        load[joint] -= law.Q_m * np.clip(x[n + joint] / law.sigma, -1.0, 1.0)
        return np.concatenate([x[n:], inverse @ load])

    run = saturated_transient(problem, 2.0)
    T = problem.period
    found = solve_ivp(rule, (0.0, 2.0 * T), np.zeros(2 * n), "DOP853", rtol=1e-12, atol=1e-14)
    assert len(run.kind) >= 4
    assert np.abs(found.y[:, -1] - run.final_state).max() < 1e-9 * np.abs(run.final_state).max()


@pytest.mark.parametrize(("rtol", "states", "times"), [(1e-8, 1e-6, 1e-6), (1e-10, 1e-8, 1e-9)])
@pytest.mark.parametrize(("seed", "n"), [(2, 1), (10, 2), (8, 5), (9, 17), (3, 30)])
@pytest.mark.parametrize("share", [0.1, 3e-3])
def test_runs_agree_with_the_exact_zones(seed, n, share, rtol, states, times):
    problem = saturated_problem(seed, n, share)
    run = saturated_transient(problem, 3.0)
    assert run.min_margin > 1e-4, "choose another seed"
    settings = Settings(rtol=rtol, keep="all", samples_per_period=50)
    response = integrate(problem, 3.0, settings=settings)
    found = agreement(response, run)
    assert list(response.events.kind) == run.kind
    assert found.same_sequence
    assert found.state_error <= states
    assert found.time_errors[found.well_conditioned].max(initial=0.0) <= times


def test_the_saturated_law_tends_to_the_coulomb_law():
    """The difference of the end states falls in proportion to the width of the band."""
    problem = random_problem(10, 2, share=0.3, static=False)
    exact = exact_transient(problem, 3.0)
    gaps = []
    for share in (1e-2, 1e-3):
        law = SaturatedCoulomb(problem.friction.Q_m, share * exact.v_peak)
        run = saturated_transient(problem.with_friction(law), 3.0)
        gaps.append(np.abs(run.final_state - exact.final_state).max())
    assert np.log10(gaps[0] / gaps[1]) == pytest.approx(1.0, abs=0.1)
