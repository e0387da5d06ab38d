"""One test per discrepancy that the exact reference has found."""

from __future__ import annotations

import numpy as np
import pytest
from support.agreement import agreement
from support.exact import exact_transient

from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem
from beltsim.transient import Settings, integrate


def one_mass(m, c, cos, sin, friction):
    forcing = HarmonicForcing(1.0, np.array(cos)[:, None], np.array(sin)[:, None])
    return FrictionProblem([[m]], [[c]], [[0.0]], [[1.0]], 0, forcing, friction)


def test_a_high_harmonic_makes_many_events_and_that_is_no_chatter():
    """Harmonic 12 alone: four events in each of its periods, 48 in one of the fundamental."""
    problem = one_mass(1.0, 0.1, np.eye(13)[12], np.zeros(13), Coulomb(0.6))
    run = exact_transient(problem, 3.0)
    found = agreement(integrate(problem, 3.0), run)
    assert len(run.kind) > 3 * 40
    assert found.same_sequence
    assert found.state_error < 1e-6


@pytest.mark.parametrize("method", ["adams", "bdf", "taylor"])
@pytest.mark.parametrize("m", [1e-6, 1e-7])
def test_first_steps_that_are_tiny_against_the_time(m, method):
    """A light joint let go with Q_s > Q_m at rtol 1e-12: steps below 1e-9 of the time reached."""
    problem = one_mass(m, 1e-3 * np.sqrt(m), [0.0, 0.0], [0.0, 1.0], Coulomb(0.3, 0.6))
    run = exact_transient(problem, 0.6)
    response = integrate(problem, 0.6, settings=Settings(rtol=1e-12, method=method))
    found = agreement(response, run)
    assert len(run.kind) == 4
    assert found.same_sequence
    assert found.time_errors.max() < 1e-9
