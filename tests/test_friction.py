"""Friction laws: their numbers and what they refuse."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from beltsim.errors import InvalidProblemError
from beltsim.friction import Coulomb, SaturatedCoulomb

NO_NUMBERS = [np.nan, np.inf, -np.inf, True, "1", None, 1j, [1.0]]


def test_static_level_defaults_to_the_kinetic_one():
    assert Coulomb(0.5) == Coulomb(0.5, 0.5)
    assert Coulomb(0.0).Q_s == 0.0
    assert Coulomb(1, 2).Q_s == 2.0
    assert type(Coulomb(1).Q_m) is float


@pytest.mark.parametrize("Q_m", [-1e-300, -2.0, *NO_NUMBERS])
@pytest.mark.parametrize("law", [Coulomb, lambda Q_m: SaturatedCoulomb(Q_m, 1e-3)])
def test_kinetic_level_must_not_be_negative(law, Q_m):
    with pytest.raises(InvalidProblemError, match=r"friction\.Q_m = .*: must be .* >= 0"):
        law(Q_m)


@pytest.mark.parametrize("Q_s", [np.nextafter(0.5, 0.0), -1.0, np.nan, np.inf, True, "1", 1j])
def test_static_level_must_not_lie_below_the_kinetic_one(Q_s):
    with pytest.raises(InvalidProblemError, match=r"friction\.Q_s = .* >= Q_m = 0\.5"):
        Coulomb(0.5, Q_s)


@pytest.mark.parametrize("sigma", [0.0, -1e-6, *NO_NUMBERS])
def test_band_must_have_a_width(sigma):
    with pytest.raises(InvalidProblemError, match=r"friction\.sigma = .*: must be .* > 0"):
        SaturatedCoulomb(0.5, sigma)


def test_all_mistakes_at_once():
    with pytest.raises(InvalidProblemError) as caught:
        SaturatedCoulomb(-1.0, 0.0)
    assert [m.field for m in caught.value.mistakes] == ["friction.Q_m", "friction.sigma"]
    assert [m.value for m in caught.value.mistakes] == [-1.0, 0.0]


@pytest.mark.parametrize("law", [Coulomb(1.0), SaturatedCoulomb(1.0, 0.1)])
def test_frozen(law):
    with pytest.raises(dataclasses.FrozenInstanceError):
        law.Q_m = 2.0
