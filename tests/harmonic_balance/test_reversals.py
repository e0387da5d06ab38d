"""Sign changes of a series are found, not sampled."""

from __future__ import annotations

import numpy as np
import pytest

from beltsim.harmonic_balance import reversals_of_series, sign_change_angles


@pytest.mark.parametrize("seed", range(20))
def test_roots_are_those_of_a_fine_grid(seed: int) -> None:
    draw = np.random.default_rng(seed)
    R = int(draw.integers(1, 40))
    c = draw.standard_normal(R + 1) + 1j * draw.standard_normal(R + 1)
    if seed % 2:
        c[::2] = 0.0
    found = sign_change_angles(c)
    tau = np.linspace(0.0, 2.0 * np.pi, 200_001)
    v = (np.exp(1j * np.outer(tau, np.arange(R + 1))) @ np.r_[c[0].real, c[1:]]).real
    assert len(found) == np.count_nonzero(v[:-1] * v[1:] < 0.0)
    at_roots = (np.exp(1j * np.outer(found, np.arange(R + 1))) @ np.r_[c[0].real, c[1:]]).real
    assert np.abs(at_roots).max(initial=0.0) < 1e-10 * np.abs(c).sum()


def test_two_roots_closer_than_any_grid() -> None:
    # cos tau - cos 1e-5: both roots lie within 2e-5 of each other
    found = sign_change_angles([-np.cos(1e-5), 1.0])
    assert np.sort(np.minimum(found, 2.0 * np.pi - found)) == pytest.approx([1e-5, 1e-5], rel=1e-4)


def test_a_touch_is_no_sign_change() -> None:
    assert len(sign_change_angles([1.5, 1.0])) == 0
    assert len(sign_change_angles([0.0])) == 0
    assert len(sign_change_angles([1.0, 0.0])) == 0


def test_nu() -> None:
    assert reversals_of_series([0.0, 1.0]) == 0.0
    assert reversals_of_series([0.0, 0.0, 0.0, 1.0]) == 1.0
    assert reversals_of_series([0.0, 1e-9, 0.0, 0.0, 0.0, 1.0]) == 2.0
