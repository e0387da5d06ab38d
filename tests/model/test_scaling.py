"""Scales of the published drive, frames, and the crank's Fourier rows."""

from __future__ import annotations

import gc
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.layouts import random_drive

from beltsim.drive.presets import zhu_parker_2008
from beltsim.model import scaling
from beltsim.model.scaling import Frame, scale

PAPER = zhu_parker_2008()


def test_numbers_of_the_published_drive():
    """By hand from Table 1: l = 0.3505 m, P0 = 300 N, rho = 0.1029 kg/m, r_t = 0.0970 m."""
    found = scale(PAPER)
    assert found.length_m == pytest.approx(0.3505)
    assert found.time_s == pytest.approx(6.4914e-3, rel=1e-5)
    assert found.gamma == 400.0
    assert found.epsilon == pytest.approx(0.01)
    assert found.k_s == pytest.approx(28.25 / (300.0 * 0.0970))
    assert found.m_t == pytest.approx(0.001165 / (0.1029 * 0.0970 * 0.3505**2))
    assert found.m[0] == pytest.approx(0.07248 / (0.1029 * 0.0889 * 0.3505**2))
    assert found.preload == pytest.approx(0.6753, abs=5e-5)
    assert found.torque_N_m == pytest.approx(29.1)
    assert found.mu == pytest.approx((np.array([0.1548, 0.3449, 0.5518]) / 0.3505) ** 2)
    assert found.eps2 == pytest.approx(1e-4 / found.mu)
    k0, k1 = found.curvatures
    assert k0 == pytest.approx([0.1548 / 0.0889, -0.3449 / 0.0452, 0.5518 / 0.0270])
    assert k1 == pytest.approx([-0.1548 / 0.0452, 0.3449 / 0.0270, 0.5518 / 0.0889])
    A0, A1 = found.arm_deflections
    assert pytest.approx([0.0970 / 0.1548 * np.cos(np.radians(135.79)), 0.0, 0.0]) == A1
    assert pytest.approx([0.0, 0.0970 / 0.3449 * np.cos(np.radians(178.74)), 0.0]) == A0


def test_the_result_is_kept_with_its_drive_and_frozen():
    drive = random_drive(np.random.default_rng(0), 3)
    found = scale(drive)
    assert scale(drive) is found
    assert scale(drive.changed()) is not found
    with pytest.raises(ValueError, match=r"read-only"):
        found.radius[0] = 1.0
    kept = len(scaling._SCALED)
    del drive
    gc.collect()
    assert len(scaling._SCALED) < kept


@given(st.integers(2, 12), st.booleans())
@settings(derandomize=True, deadline=None)
def test_frames_undo_themselves(n, mirrored):
    frame = Frame(n, mirrored)
    index = np.arange(n)
    assert np.array_equal(frame.pulleys[frame.pulleys], index)
    assert np.array_equal(frame.spans[frame.spans], index)
    for span in range(n):  # the ends of a span stay its ends
        ends = {span, (span + 1) % n}
        canonical = int(frame.spans[span])
        mapped = {int(frame.pulleys[j]) for j in ends}
        assert mapped == {canonical, (canonical + 1) % n}


def test_sine_signs():
    x = np.linspace(0.0, 1.0, 11)
    for k, sign in zip((1, 2, 3, 4), Frame(3, True).sine_signs([1, 2, 3, 4]), strict=True):
        assert np.allclose(np.sin(k * np.pi * (1.0 - x)), sign * np.sin(k * np.pi * x))
    assert (Frame(3, False).sine_signs([1, 2, 3]) == 1.0).all()


@pytest.mark.parametrize("travel", ["cw", "ccw"])
def test_spans_are_named_as_the_user_lists_them(travel):
    drive = random_drive(np.random.default_rng(1), 4, travel)
    found = scale(drive)
    names = [found.span_name(i) for i in found.frame.spans.tolist()]
    ring = [p.name for p in drive.pulleys]
    pairs = pairwise([*ring, ring[0]])
    assert names == [f"span {i} ({a} - {b})" for i, (a, b) in enumerate(pairs, start=1)]


def test_accessories_take_power_and_the_crank_closes_the_loop():
    drive = random_drive(np.random.default_rng(2), 5, "cw")
    found = scale(drive)
    others = np.arange(5) != found.crank
    assert (found.accessory_torque[others] <= 0.0).all()
    assert found.accessory_torque[found.crank] > 0.0
    assert abs(found.accessory_torque.sum()) < 1e-15
    given_torques = np.array([p.accessory_torque_N_m for p in drive.pulleys])
    radius = np.array([p.radius_m for p in drive.pulleys])
    expected = -given_torques / (drive.belt.initial_tension_N * radius)
    assert found.accessory_torque[others] == pytest.approx(expected[others])


def with_orders(*orders, firing_order=2.0):
    return PAPER.changed(
        excitation={
            "firing_order": firing_order,
            "speed_fluctuation": None,
            "orders": list(orders),
        }
    )


@pytest.mark.parametrize(
    ("orders", "fundamental", "rows"),
    [
        ((3.0,), 3.0, 1),
        ((2.0, 4.0), 2.0, 2),
        ((2.0, 3.0), 1.0, 3),
        ((0.5, 2.0), 0.5, 4),
        ((1.5, 4.5), 1.5, 3),
    ],
)
def test_the_fundamental_is_the_greatest_common_divisor(orders, fundamental, rows):
    found = scale(with_orders(*({"order": o, "angle_amplitude_deg": 1.0} for o in orders)))
    assert found.fundamental_order == fundamental
    assert found.crank_sin.shape == (rows + 1,)
    filled = np.flatnonzero(found.crank_sin)
    assert filled * fundamental == pytest.approx(sorted(orders))


def test_the_crank_moves_as_its_orders_say():
    drive = with_orders(
        {"order": 2.0, "angle_amplitude_deg": 1.5, "phase_deg": 30.0},
        {"order": 3.5, "speed_fluctuation": 0.04, "phase_deg": -100.0},
        {"order": 1.0, "angle_amplitude_deg": 0.5},
    )
    found = scale(drive)
    turn = np.linspace(0.0, 4.0 * np.pi, 41)
    expected = (
        np.radians(1.5) * np.sin(2.0 * turn + np.radians(30.0))
        + 0.04 / 3.5 * np.sin(3.5 * turn - np.radians(100.0))
        + np.radians(0.5) * np.sin(turn)
    )
    k = np.arange(len(found.crank_cos)) * found.fundamental_order
    angles = np.multiply.outer(turn, k)
    series = np.cos(angles) @ found.crank_cos + np.sin(angles) @ found.crank_sin
    assert series == pytest.approx(expected, abs=1e-14)


def test_without_a_tensioner_torques_are_measured_with_the_mean_span():
    drive = random_drive(np.random.default_rng(3), 4, arm=False)
    found = scale(drive)
    assert found.arm is None
    assert found.preload == 0.0
    assert found.torque_N_m == pytest.approx(
        drive.belt.initial_tension_N * drive.mean_span_length_m
    )
