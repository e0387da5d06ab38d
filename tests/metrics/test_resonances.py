"""Resonances along the operating line."""

from __future__ import annotations

import numpy as np
import pytest
from support.layouts import random_drive

from beltsim import linear
from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import InvalidProblemError, SteadyStateError
from beltsim.metrics import resonances
from beltsim.metrics.mode_kind import mode_kind
from beltsim.model import assemble


@pytest.mark.parametrize("locked", [False, True])
def test_the_firing_frequency_is_a_natural_frequency(locked):
    drive = random_drive(np.random.default_rng(1), 4)
    low, high = 0.8 * drive.Omega, 1.3 * drive.Omega
    found = resonances(drive, low, high, locked=locked, n_functions=4)
    assert found
    assert [item.Omega for item in found] == sorted(item.Omega for item in found)
    for item in found:
        problem = assemble(drive, item.Omega, n_functions=4)
        at = linear.frequencies(problem, locked)
        assert at[item.number - 1] == pytest.approx(item.Omega, rel=1e-9)
        assert low <= item.Omega <= high
        assert item.rpm == pytest.approx(drive.rpm(item.Omega))


def test_none_is_missed():
    """As many crossings as frequencies change side between the ends (here all fall with speed)."""
    drive = zhu_parker_2008()
    ends = [
        np.count_nonzero(linear.frequencies(assemble(drive, Omega, n_functions=6)) > Omega)
        for Omega in (1.0, 10.0)
    ]
    found = resonances(drive, 1.0, 10.0, n_functions=6)
    assert len(found) == ends[0] - ends[1]


@pytest.mark.parametrize("bad", [(0.0, 1.0), (2.0, 1.0), (-1.0, 1.0)])
def test_ranges_that_cannot_be(bad):
    with pytest.raises(InvalidProblemError, match="low, high"):
        resonances(zhu_parker_2008(), *bad)


def test_a_range_beyond_the_critical_speed_says_so():
    drive = random_drive(np.random.default_rng(5), 4, arm=False)
    with pytest.raises(SteadyStateError):
        resonances(drive, drive.Omega, 30.0 * drive.Omega, n_functions=2)


def test_shares_of_the_kinetic_energy():
    problem = assemble(zhu_parker_2008(), 6.3, n_functions=4)
    shape = np.zeros(problem.n, dtype=complex)
    shape[problem.labels.index("span2.sin3")] = 1.0
    kind = mode_kind(problem, shape)
    assert (kind.type, kind.dominant, kind.coordinate) == ("span", "span 2", "span2.sin3")
    assert kind.share == pytest.approx(1.0)
    shape[problem.labels.index("span2.sin3")] = 0.0
    shape[problem.labels.index("theta_3")] = 1j
    kind = mode_kind(problem, shape)
    assert (kind.type, kind.dominant, kind.coordinate) == ("rotation", "pulley 3", "theta_3")
    arm = np.zeros(problem.n)
    arm[-1] = 1.0
    assert mode_kind(problem, arm).dominant == "arm"
