"""Harmonic forcing: its series, its checks, its frozen arrays."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from beltsim.errors import BeltsimError, InvalidProblemError
from beltsim.forcing import HarmonicForcing

COS = [[0.5, 0.0], [1.0, -1.0], [0.0, 2.0]]
SIN = [[0.0, 0.0], [0.3, 0.0], [0.0, -0.7]]


def test_series_at_times_of_any_shape():
    forcing = HarmonicForcing(2.0, COS, SIN)
    t = np.array([[0.0, 0.3, 1.1], [2.0, -4.0, 50.0]])
    first = 0.5 + np.cos(2.0 * t) + 0.3 * np.sin(2.0 * t)
    second = -np.cos(2.0 * t) + 2.0 * np.cos(4.0 * t) - 0.7 * np.sin(4.0 * t)
    assert forcing.at(t).shape == (2, 3, 2)
    assert np.allclose(forcing.at(t), np.stack([first, second], axis=-1), rtol=0, atol=1e-14)
    assert forcing.at(0.3).shape == (2,)


def test_coefficients_are_those_of_the_complex_series():
    forcing = HarmonicForcing(2.0, COS, SIN)
    turn = np.exp(1j * 2.0 * 0.7 * np.arange(3))
    assert np.allclose((turn @ forcing.coefficients).real, forcing.at(0.7), rtol=0, atol=1e-15)


def test_period_and_number_of_harmonics():
    forcing = HarmonicForcing(np.float32(2.0), COS, SIN)
    assert forcing.period == np.pi
    assert forcing.n_harmonics == 2
    assert type(forcing.Omega) is float


def test_a_constant_load_and_no_coordinates_are_allowed():
    assert HarmonicForcing(1.0, [[3.0]], [[0.0]]).n_harmonics == 0
    assert HarmonicForcing(1.0, np.zeros((2, 0)), np.zeros((2, 0))).at(0.0).shape == (0,)


def test_frozen():
    cos = np.array(COS)
    forcing = HarmonicForcing(1.0, cos, SIN)
    cos[1, 0] = 7.0
    assert forcing.cos[1, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        forcing.cos[0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        forcing.sin[1, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        forcing.Omega = 2.0


@pytest.mark.parametrize("Omega", [0.0, -1.0, np.nan, np.inf, True, "1", None, 1j, [1.0]])
def test_Omega_must_be_positive(Omega):
    with pytest.raises(InvalidProblemError, match=r"forcing\.Omega = .*: must be a finite .* > 0"):
        HarmonicForcing(Omega, COS, SIN)


@pytest.mark.parametrize("name", ["cos", "sin"])
@pytest.mark.parametrize(
    "rows", [[1.0], 3.0, None, [[np.nan, 0.0]], [["x", "y"]], np.zeros((0, 2)), [[[0.0]]]]
)
def test_rows_must_be_a_finite_table(name, rows):
    data = {"cos": COS, "sin": SIN, name: rows}
    with pytest.raises(InvalidProblemError, match=rf"forcing\.{name} = "):
        HarmonicForcing(1.0, **data)


@pytest.mark.parametrize("sin", [[[0.0, 0.0]], [[0.0], [0.0], [0.0]]])
def test_cos_and_sin_must_have_one_shape(sin):
    with pytest.raises(InvalidProblemError, match=r"forcing\.sin = .*\(3, 2\), as cos"):
        HarmonicForcing(1.0, COS, sin)


def test_sin_of_the_mean_must_be_zero():
    with pytest.raises(InvalidProblemError, match=r"forcing\.sin\[0\] = .*must be zero"):
        HarmonicForcing(1.0, [[1.0]], [[1e-300]])


def test_all_mistakes_at_once_one_line_each():
    with pytest.raises(InvalidProblemError) as caught:
        HarmonicForcing(-1.0, [[np.nan, 1.0], [2.0, 3.0]], [[1.0, 0.0]])
    fields = [mistake.field for mistake in caught.value.mistakes]
    assert fields == ["forcing.Omega", "forcing.cos", "forcing.sin[0]"]
    assert len(str(caught.value).splitlines()) == 3
    assert isinstance(caught.value, BeltsimError)
    assert isinstance(caught.value, ValueError)
