"""Reading numbers and arrays without guessing."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from beltsim.checks import finite_array, read_only, real_number


@pytest.mark.parametrize(
    ("value", "number"),
    [
        (3, 3.0),
        (-0.5, -0.5),
        (np.float32(2.0), 2.0),
        (np.int8(-3), -3.0),
        (np.array(1.5), 1.5),
        (Fraction(1, 4), 0.25),
    ],
)
def test_numbers_are_read(value, number):
    assert real_number(value) == number
    assert type(real_number(value)) is float


@pytest.mark.parametrize(
    "value",
    [
        *(True, np.True_, "3", b"3", None, [1.0], np.array([1.0]), np.array("3"), np.array(True)),
        *(1 + 0j, np.complex128(1.0), float("nan"), -np.inf, 10**400, object()),
    ],
)
def test_everything_else_is_no_number(value):
    assert real_number(value) is None


@pytest.mark.parametrize("value", [[[1, 2]], np.zeros((1, 2), np.float32), ((0.0, 1.0),)])
def test_arrays_are_read(value):
    array = finite_array(value, ndim=2)
    assert array.dtype == np.float64
    assert array.shape == (1, 2)


@pytest.mark.parametrize(
    "value",
    [
        *([1.0, 2.0], [[1.0], [2.0, 3.0]], [["1"]], [[True]], [[1 + 1j]], [[np.nan]], [[np.inf]]),
        *([[10**400]], None, 1.0, [[None]]),
    ],
)
def test_everything_else_is_no_array(value):
    assert finite_array(value, ndim=2) is None


def test_read_only_is_a_contiguous_copy_that_nobody_writes_to():
    mine = np.asfortranarray([[1.0, 2.0], [3.0, 4.0]])
    frozen = read_only(mine)
    mine[0, 0] = 9.0
    assert frozen[0, 0] == 1.0
    assert frozen.flags.c_contiguous
    with pytest.raises(ValueError, match="read-only"):
        frozen[0, 0] = 2.0
