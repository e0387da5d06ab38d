"""The references themselves, against each other and against another exact computation."""

from __future__ import annotations

import numpy as np
import pytest
from support.exact import exact_transient
from support.problems import random_problem

from validation.analytic.den_hartog import reference as den_hartog
from validation.analytic.one_mass import one_mass
from validation.cross_method import exact_modal, peer_sundae
from validation.cross_method.steady_state import reference as collocation


def same_run(run, other, times, states):
    assert list(run.kind) == list(other.kind)
    np.testing.assert_allclose(run.t, other.t, rtol=0.0, atol=times)
    np.testing.assert_allclose(run.final_state, other.final_state, rtol=0.0, atol=states)


@pytest.mark.parametrize("seed", [0, 4, 6, 12, 31, 37, 100, 126])
def test_exact_motion_agrees_with_taylor_series(seed):
    problem = random_problem(seed)
    exact = exact_transient(problem, 8)
    assert exact.min_margin > 1e-4
    same_run(exact_modal.run(problem, 8), exact, times=1e-9, states=1e-9)


@pytest.mark.parametrize("seed", [0, 27, 130])
def test_scikit_sundae_agrees_with_exact_motion(seed):
    pytest.importorskip("sksundae")
    problem = random_problem(seed)
    same_run(peer_sundae.run(problem, 5), exact_modal.run(problem, 5), times=1e-8, states=1e-8)


def test_exact_motion_counts_its_travel():
    problem = random_problem(130)
    run = exact_modal.run(problem, 8)
    ends = np.concatenate([[0.0], run.position, [run.final_state[problem.joint]]])
    assert run.travel.sum() == pytest.approx(np.abs(np.diff(ends)).sum(), rel=1e-12)


def test_rate_is_the_slope_at_an_event_over_the_largest_value():
    k, Q, x0 = 4.0, 0.3, 1.0
    run = exact_modal.run(one_mass(k, Q, Omega=1.0), 2, [x0, 0.0])
    swings = np.abs(np.concatenate([[x0], run.position[:-1]])) - Q / k  # about each centre
    np.testing.assert_allclose(run.rate, np.sqrt(k) * swings / swings[0], rtol=1e-6)


def test_den_hartog_without_damping_is_his_first_closed_form():
    beta, f = 0.5, 0.3
    amplitude, _ = den_hartog.steady(beta, 1e-9, f)
    V = 1.0 / (1.0 - beta**2)
    U = np.sin(np.pi / beta) / (beta * (1.0 + np.cos(np.pi / beta)))
    assert amplitude == pytest.approx(np.sqrt(V**2 - (f * U) ** 2), rel=1e-6)


def test_den_hartog_refuses_a_motion_that_stops():
    with pytest.raises(ValueError, match="the motion stops"):
        den_hartog.steady(0.2, 0.05, 0.9)


def test_collocation_has_converged(monkeypatch):
    fine = collocation.solve(0.01, 6.3)
    monkeypatch.setattr(collocation, "DEGREE", 64)
    assert collocation.solve(0.01, 6.3) == pytest.approx(fine, abs=2e-11)
