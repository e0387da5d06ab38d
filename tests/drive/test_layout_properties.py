"""What holds for the geometry of any sound drive, and of any loop whatsoever."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support.layouts import (
    drives,
    mirrored,
    random_drive,
    renumbered,
    rescaled,
    shifted,
    smallest_string_tension,
    turned,
)

from beltsim.drive.faults import layout_faults
from beltsim.drive.presets import zhu_parker_2008
from beltsim.drive.tracing import cross, trace

PROFILE = settings(derandomize=True, deadline=None, max_examples=40)
TWO_PI = 2.0 * np.pi


def angle_gap(a, b):
    """Difference of two angles, brought next to zero."""
    return (a - b + np.pi) % TWO_PI - np.pi


def agree(a, b, tolerance=1e-10):
    """Same lengths, wraps and alignment angles."""
    assert a.span_length_m == pytest.approx(b.span_length_m, rel=tolerance, abs=0)
    assert a.wrap_rad == pytest.approx(b.wrap_rad, abs=tolerance)
    assert (a.arm, a.crank, a.travel) == (b.arm, b.crank, b.travel)
    if a.arm is not None:
        assert a.arm_length_m == pytest.approx(b.arm_length_m, rel=tolerance)
        assert angle_gap(a.beta_1, b.beta_1) == pytest.approx(0.0, abs=tolerance)
        assert angle_gap(a.beta_2, b.beta_2) == pytest.approx(0.0, abs=tolerance)


@PROFILE
@given(drives())
def test_spans_are_tangents_on_the_right_sides(drive):
    """The defining conditions, checked point by point; they have one solution only."""
    layout = drive.layout
    begin, end = layout.span_start_m, layout.span_end_m
    assert end - begin == pytest.approx(layout.span_length_m[:, None] * layout.direction, abs=1e-14)
    for points, center, radius, side in (
        (begin, layout.center_m, layout.radius_m, layout.side),
        (
            end,
            np.roll(layout.center_m, -1, axis=0),
            np.roll(layout.radius_m, -1),
            np.roll(layout.side, -1),
        ),
    ):
        arm = points - center
        assert np.hypot(*arm.T) == pytest.approx(radius, rel=1e-13)
        assert (arm * layout.direction).sum(axis=1) == pytest.approx(0.0, abs=1e-14)
        # the belt runs round inside pulleys counter-clockwise in the sense of the list
        assert np.array_equal(np.sign(cross(arm, layout.direction)), side)
    assert layout.side @ layout.wrap_rad == pytest.approx(TWO_PI, abs=1e-12)


@PROFILE
@given(drives())
def test_alignment_angles_follow_their_definition(drive):
    layout = drive.layout
    arm = layout.center_m[layout.arm] - layout.pivot_m
    assert layout.arm_normal @ arm == pytest.approx(0.0, abs=1e-15)
    assert cross(arm, layout.arm_normal) == pytest.approx(layout.arm_length_m, rel=1e-13)
    for span, beta in ((layout.arm - 1, layout.beta_1), (layout.arm, layout.beta_2)):
        u, v = layout.direction[span], layout.normal[span]
        assert layout.arm_normal @ u == pytest.approx(-np.sin(beta), abs=1e-14)
        assert layout.arm_normal @ v == pytest.approx(np.cos(beta), abs=1e-14)


@PROFILE
@given(drives(), st.floats(-7.0, 7.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_turning_and_shifting_change_nothing(drive, angle, dx, dy):
    agree(turned(drive, angle).layout, drive.layout)
    agree(shifted(drive, dx, dy).layout, drive.layout)


@PROFILE
@given(drives(), st.integers(1, 7))
def test_renumbering_rolls_the_lists(drive, first):
    first %= len(drive.pulleys)
    layout, other = drive.layout, renumbered(drive, first).layout
    n = layout.n
    assert (other.crank, other.arm) == ((layout.crank - first) % n, (layout.arm - first) % n)
    for name in ("span_length_m", "wrap_rad", "direction", "normal"):
        expected = np.roll(getattr(layout, name), -first, axis=0)
        assert getattr(other, name) == pytest.approx(expected, abs=1e-14), name
    assert (other.beta_1, other.beta_2) == (layout.beta_1, layout.beta_2)


@PROFILE
@given(drives())
def test_mirrored_layout_is_that_of_the_mirrored_coordinates(drive):
    fast, fresh = drive.layout.mirrored(), mirrored(drive).layout
    agree(fast, fresh)
    assert fast.names == fresh.names
    arrays = ("radius_m", "inertia_kg_m2", "side", "accessory_torque_N_m", "center_m", "direction")
    for name in (*arrays, "normal", "arm_normal", "pivot_m"):
        assert getattr(fast, name) == pytest.approx(getattr(fresh, name), abs=1e-13), name
    agree(fast.mirrored(), drive.layout, tolerance=1e-14)


@PROFILE
@given(drives(), *[st.floats(0.5, 1.7)] * 3)
def test_units_change_nothing(drive, length, mass, time):
    other = rescaled(drive, length, mass, time)
    a, b = other.layout, drive.layout
    assert a.span_length_m == pytest.approx(length * b.span_length_m, rel=1e-12)
    assert a.wrap_rad == pytest.approx(b.wrap_rad, abs=1e-12)
    assert (a.beta_1, a.beta_2) == pytest.approx((b.beta_1, b.beta_2), abs=1e-12)
    assert other.time_unit_s == pytest.approx(time * drive.time_unit_s, rel=1e-12)
    assert other.rpm(1.0) * time == pytest.approx(drive.rpm(1.0), rel=1e-12)
    force = mass * length / time**2
    assert other.bending_stiffness_N_m2 == pytest.approx(
        force * length**2 * drive.bending_stiffness_N_m2, rel=1e-12
    )


@PROFILE
@given(drives(n_pulleys=5, arm_side="inside"))
def test_belt_length_is_the_perimeter_of_the_hull_without_back_pulleys(drive):
    layout = drive.layout
    assume((layout.side > 0).all())
    # Cauchy: the perimeter of a convex curve is the integral of its support function
    directions = np.linspace(0.0, TWO_PI, 20000, endpoint=False)
    unit = np.stack([np.cos(directions), np.sin(directions)])
    support = (layout.center_m @ unit + layout.radius_m[:, None]).max(axis=0)
    # the support function has kinks, so the rule is of second order: (2 pi / 20000)^2 = 1e-7
    assert layout.belt_length_m == pytest.approx(support.mean() * TWO_PI, rel=1e-6)


@PROFILE
@given(drives(torques=True))
def test_random_drives_keep_what_they_promise(drive):
    assert np.degrees(drive.layout.wrap_rad).min() > 10.0
    assert smallest_string_tension(drive) >= 0.3
    lever = np.sin(drive.layout.beta_1) - np.sin(drive.layout.beta_2)
    assert abs(lever) >= 0.2 - 1e-12
    assert drive.layout.warnings == ()
    assert {p.role for p in drive.pulleys} >= {"crank", "arm"}


def test_random_drives_cover_what_they_should():
    rng = np.random.default_rng(1)
    drawn = [random_drive(rng) for _ in range(120)]
    assert {len(d.pulleys) for d in drawn} == set(range(3, 9))
    assert {d.crank_rotation for d in drawn} == {"cw", "ccw"}
    assert {float(d.layout.side[d.layout.arm]) for d in drawn} == {1.0, -1.0}
    assert {float(d.layout.side[d.layout.crank]) for d in drawn} == {1.0, -1.0}
    apart = {(d.layout.crank - d.layout.arm) % d.layout.n for d in drawn}
    assert {1, 2, 3} <= apart
    fixed = random_drive(rng, arm=False)
    assert fixed.tensioner is None
    assert fixed.layout.arm is None


def test_random_drives_repeat():
    first, second = (random_drive(np.random.default_rng(5)) for _ in range(2))
    assert first == second
    assert first != random_drive(np.random.default_rng(6))


def sampled_belt(center, radius, side):
    """Points along the belt, arcs in steps of at most 2.5 deg."""
    path = trace(center, radius, side)
    points = []
    for j in range(len(radius)):
        steps = int(np.ceil(path.wrap[j] / np.radians(2.5))) + 1
        turn = side[j] * np.linspace(0.0, path.wrap[j], steps)
        x, y = -side[j] * radius[j] * path.normal[j - 1]
        arc = [np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y]
        points.append(center[j] + np.stack(arc, axis=1))
    return np.concatenate(points)


def is_simple_and_counter_clockwise(points):
    a, b = points[:, None], np.roll(points, -1, axis=0)[:, None]
    c, d = points[None], np.roll(points, -1, axis=0)[None]
    across = (cross(b - a, c - a) * cross(b - a, d - a) < 0) & (
        cross(d - c, a - c) * cross(d - c, b - c) < 0
    )
    return not across.any() and cross(points, np.roll(points, -1, axis=0)).sum() > 0


def enters_a_pulley(points, center, radius):
    """Whether the belt comes closer to a centre than the radius (less the error of a chord)."""
    reach = np.roll(points, -1, axis=0) - points
    square = np.maximum((reach**2).sum(axis=1), 1e-30)
    for c, r in zip(center, radius, strict=True):
        along = np.clip(((c - points) * reach).sum(axis=1) / square, 0.0, 1.0)
        near = points + along[:, None] * reach
        if np.hypot(*(near - c).T).min() < r * np.cos(np.radians(1.25)) - 1e-12:
            return True
    return False


@pytest.mark.parametrize("seed", range(6))
def test_a_layout_is_refused_exactly_when_its_drawn_belt_is_impossible(seed):
    """Against a belt drawn point by point and tested for crossings by brute force."""
    rng = np.random.default_rng(seed)
    verdicts = {True: 0, False: 0}
    while sum(verdicts.values()) < 40:
        n = int(rng.integers(2, 8))
        radius, side = rng.uniform(0.03, 0.09, n), rng.choice([1.0, 1.0, 1.0, -1.0], n)
        angle = TWO_PI * (np.arange(n) + rng.uniform(-0.5, 0.5, n)) / n
        center = rng.uniform(0.15, 0.5, n)[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)
        gaps = np.hypot(*(center[:, None] - center[None]).T) - radius - radius[:, None]
        if gaps[~np.eye(n, dtype=bool)].min() <= 0.0:
            continue
        points = sampled_belt(center, radius, side)
        possible = is_simple_and_counter_clockwise(points)
        possible = possible and not enters_a_pulley(points, center, radius)
        found = layout_faults([str(j) for j in range(n)], center, radius, side)
        assert possible == (not found), (center, radius, side, found)
        verdicts[possible] += 1
    assert min(verdicts.values()) >= 3


def test_two_equal_pulleys():
    path = trace(np.array([[1.0, 0.0], [0.0, 0.0]]), np.full(2, 0.2), np.ones(2))
    assert path.length.tolist() == [1.0, 1.0]
    assert path.direction.tolist() == [[-1.0, 0.0], [1.0, 0.0]]
    assert path.wrap == pytest.approx([np.pi, np.pi])


def test_preset_agrees_with_its_mirror_image():
    drive = zhu_parker_2008().changed(overrides=None)
    agree(drive.layout.mirrored(), mirrored(drive).layout)
