"""Modal damping: every mode of the free-arm system gets the same ratio."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from support.layouts import random_drive

from beltsim.errors import SteadyStateError
from beltsim.model import assemble, chain, crank
from beltsim.model.modal import damping


def test_every_mode_has_the_ratio():
    drive = random_drive(np.random.default_rng(1), 5)
    problem = assemble(drive, n_functions=6)
    squares, modes = scipy.linalg.eigh(problem.K, problem.M)
    modal = modes.T @ problem.C @ modes
    expected = 2.0 * drive.damping.ratio * np.sqrt(squares)
    assert modal == pytest.approx(np.diag(expected), abs=1e-9 * expected.max())


def test_no_ratio_no_damping():
    drive = random_drive(np.random.default_rng(1), 3).changed(damping={"ratio": 0.0})
    assert not assemble(drive, n_functions=3).C.any()


def test_a_free_crank_rolls_without_damping():
    full = crank.release(chain(random_drive(np.random.default_rng(2), 4), n_functions=4).system)
    C = damping(full.M, full.K, 0.05)
    values, vectors = np.linalg.eigh(full.K)
    assert np.abs(C @ vectors[:, 0]).max() < 1e-5 * np.abs(C).max()
    assert np.linalg.eigvalsh(C)[0] > -1e-12 * np.abs(C).max()
    assert values[0] < 1e-10 * values[-1]


def test_a_stiffness_that_buckles_is_refused():
    with pytest.raises(SteadyStateError, match=r"negative eigenvalue"):
        damping(np.eye(2), np.diag([-1.0, 2.0]), 0.05)
