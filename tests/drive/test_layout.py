"""Geometry of known drives, and layouts that cannot be."""

import numpy as np
import pytest
from support.layouts import with_coordinates

from beltsim.drive import Drive, load_drive
from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import InvalidDriveError

SEVEN = "examples/passenger_car_7_pulley.toml"


@pytest.fixture(scope="module")
def seven(pytestconfig):
    return load_drive(pytestconfig.rootpath / SEVEN)


def tables(drive):
    data = drive.model_dump(exclude_none=True)
    return data | {"pulleys": list(data["pulleys"])}


def loop_of(rows):
    """Tables of a drive with fixed centres, from rows of x, y, radius and side."""
    data = tables(zhu_parker_2008().changed(overrides=None))
    data["pulleys"] = [
        {
            "name": "abcdefgh"[j],
            "role": "fixed" if j else "crank",
            "side": side,
            "center_m": [x, y],
            "radius_m": radius,
            "inertia_kg_m2": 1e-3,
        }
        for j, (x, y, radius, side) in enumerate(rows)
    ]
    del data["tensioner"]
    return data


def mistakes(data):
    with pytest.raises(InvalidDriveError) as caught:
        Drive(**data)
    return caught.value.mistakes


def test_table_1_from_its_coordinates():
    layout = zhu_parker_2008().changed(overrides=None).layout
    # printed lengths have four decimals, angles two; the coordinates have four decimals
    assert layout.span_length_m == pytest.approx([0.1548, 0.3449, 0.5518], abs=5e-5)
    assert np.degrees([layout.beta_1, layout.beta_2]) == pytest.approx([135.83, 178.76], abs=5e-3)
    assert layout.arm_length_m == pytest.approx(0.0971, abs=5e-5)
    assert layout.side @ layout.wrap_rad == pytest.approx(2.0 * np.pi, abs=1e-13)
    assert layout.warnings == ()


def test_overrides_take_the_place_of_computed_figures_but_not_of_directions():
    given = zhu_parker_2008().layout
    computed = zhu_parker_2008().changed(overrides=None).layout
    assert given.span_length_m.tolist() == [0.1548, 0.3449, 0.5518]
    assert np.degrees([given.beta_1, given.beta_2]) == pytest.approx([135.79, 178.74], abs=1e-12)
    assert given.arm_length_m == 0.0970
    for name in ("direction", "normal", "wrap_rad", "arm_normal", "center_m"):
        assert np.array_equal(getattr(given, name), getattr(computed, name)), name


def test_overrides_far_from_the_coordinates_are_warned_about():
    drive = zhu_parker_2008()
    swapped = {"span_lengths_m": [0.3449, 0.1548, 0.5518], "beta_1_deg": 178.74}
    layout = drive.changed(overrides=swapped | {"arm_length_m": 0.2}).layout
    assert [text.split(" = ")[0] for text in layout.warnings] == [
        "overrides.span_lengths_m[0]",
        "overrides.span_lengths_m[1]",
        "overrides.arm_length_m",
        "overrides.beta_1_deg",
    ]
    assert "the coordinates give 0.1548 m" in layout.warnings[0]


def test_overridden_angles_may_be_given_in_any_turn():
    drive = zhu_parker_2008().changed(overrides={"beta_1_deg": 135.79 - 360.0})
    assert np.degrees(drive.layout.beta_1) == pytest.approx(135.79, abs=1e-12)
    assert drive.layout.warnings == ()


def test_seven_pulley_drive(seven):
    layout = seven.layout
    spans = [139.255, 144.146, 135.956, 150.678, 238.755, 170.988, 135.777]
    wraps = [161.020, 53.579, 196.404, 111.240, 121.291, 125.162, 79.059]
    assert layout.span_length_m * 1e3 == pytest.approx(spans, abs=5.1e-4)
    assert np.degrees(layout.wrap_rad) == pytest.approx(wraps, abs=5.1e-4)
    assert layout.belt_length_m * 1e3 == pytest.approx(1943.14, abs=5.1e-3)
    assert np.degrees([layout.beta_1, layout.beta_2]) == pytest.approx([-1.615, 77.444], abs=5.1e-4)
    assert layout.arm_length_m == pytest.approx(0.075, abs=1e-6)
    # what the belt's pull turns the arm with, which the spring torque 27.55 N m balances
    lever = layout.arm_length_m * abs(np.sin(layout.beta_1) - np.sin(layout.beta_2))
    assert lever * 1e3 == pytest.approx(75.32, abs=5.1e-3)
    assert lever * seven.belt.initial_tension_N == pytest.approx(27.55, abs=0.01)


def test_arrays_are_read_only(seven):
    with pytest.raises(ValueError, match="read-only"):
        seven.layout.span_length_m[0] = 1.0
    assert seven.layout is seven.layout


def test_drive_without_tensioner_has_no_arm(seven):
    data = tables(seven)
    data["pulleys"][6]["role"] = "fixed"
    del data["tensioner"]
    layout = Drive(**data).layout
    assert (layout.arm, layout.pivot_m, layout.arm_length_m) == (None, None, None)
    assert (layout.arm_normal, layout.beta_1, layout.beta_2) == (None, None, None)
    assert layout.mirrored().arm is None
    assert np.array_equal(layout.span_length_m, seven.layout.span_length_m)


def test_small_wrap_is_warned_about():
    data = tables(zhu_parker_2008().changed(overrides=None))
    # raise pulley 2 until the belt just touches it
    data["pulleys"][1]["center_m"] = [0.3477, 0.14]
    layout = Drive(**data).layout
    assert 0.0 < np.degrees(layout.wrap_rad[1]) < 5.0
    assert len(layout.warnings) == 1
    assert "touches pulley 2 on" in layout.warnings[0]


def test_pulley_exactly_on_the_line_is_touched_not_missed():
    rows = [(0.6, 0.0, 0.05, "inside"), (0.3, 0.1, 0.05, "back"), (0.0, 0.0, 0.05, "inside")]
    layout = Drive(**loop_of(rows)).layout
    assert layout.wrap_rad[1] == pytest.approx(0.0, abs=1e-9)
    assert "touches pulley b on 0.00 deg" in layout.warnings[0]


def test_overlapping_pulleys_are_named_with_their_distance(seven):
    data = tables(seven)
    data["pulleys"][5]["center_m"] = [-0.219, 0.273]
    (found,) = mistakes(data)
    assert found.field == "pulleys[4], pulleys[5]"
    assert str(found.value) == "PS and ALT, 0.09 m apart"
    assert "more than 0.0947 m apart: their radii are 0.065 m and 0.0297 m" in found.allowed
    assert "no belt tangent" not in found.allowed


def test_missing_tangent_is_named(seven):
    data = tables(seven)
    data["pulleys"][1] |= {"center_m": [0.02, 0.0], "side": "inside"}
    (found,) = mistakes(data)
    assert found.field == "pulleys[0], pulleys[1]"
    assert "no belt tangent exists between them" in found.allowed
    # the same distance between pulleys that are no neighbours needs no tangent
    data = tables(seven)
    data["pulleys"][3]["center_m"] = [0.01, 0.0]
    (found,) = mistakes(data)
    assert found.field == "pulleys[0], pulleys[3]"
    assert "no belt tangent" not in found.allowed


@pytest.mark.parametrize("first", range(7))
def test_clockwise_list_is_told_to_be_reversed(seven, first):
    order = np.roll(np.arange(7)[::-1], first).tolist()
    with pytest.raises(InvalidDriveError, match="this list is clockwise: reverse it") as caught:
        with_coordinates(seven, lambda x: x, order)
    assert len(caught.value.mistakes) == 1


def test_clockwise_list_with_another_fault_tells_both(seven):
    data = tables(seven)
    data["pulleys"][3]["center_m"] = [0.015, 0.5]
    data["pulleys"].reverse()
    first, second = mistakes(data)
    assert "reverse it" in first.allowed
    assert second.field == "pulleys[3]"  # its place in the list as given
    assert str(second.value).startswith("WP, wrapped by")


@pytest.mark.parametrize(
    ("row", "change", "word"),
    [
        (3, {"center_m": [0.015, 0.5]}, "'back'"),
        (3, {"side": "inside"}, "'inside'"),
        (6, {"side": "inside"}, "'inside'"),
        (1, {"center_m": [0.3, 0.05]}, "'back'"),
    ],
)
def test_missed_pulley_is_named(seven, row, change, word):
    data = tables(seven)
    data["pulleys"][row] |= change
    (found,) = mistakes(data)
    assert found.field == f"pulleys[{row}]"
    assert "which misses it as a pulley of side " + word in found.allowed


def test_the_one_side_that_spoils_its_neighbours_is_named():
    """Crank, AC, ALT, idler, WP, arm: the idler's wrong side shows at other pulleys as well."""
    rows = [
        (0.0, 0.0, 0.080, "inside"),
        (0.24, 0.03, 0.060, "inside"),
        (0.22, 0.28, 0.029, "inside"),
        (0.11, 0.335, 0.035, "back"),
        (0.0, 0.27, 0.055, "inside"),
        (-0.085, 0.14, 0.038, "back"),
    ]
    assert Drive(**loop_of(rows)).layout.n == 6
    for j, (*place, side) in enumerate(rows[:5]):
        other = "back" if side == "inside" else "inside"
        wrong = [*rows[:j], (*place, other), *rows[j + 1 :]]
        if j != 3:  # the belt meets the idler from inside as well
            found = mistakes(loop_of(wrong))
            assert [entry.field for entry in found] == ONE_SIDE[j]
            assert "'inside'" in found[0].allowed


#: What is told when one pulley of the drive above is on the wrong side.
ONE_SIDE = {
    0: ["pulleys", "pulleys[0]", "pulleys[5]"],  # either of two would do, and is said first
    1: ["pulleys[1]"],  # named alone, with its other side, by what the belt misses
    2: ["pulleys[2].side"],
    4: ["pulleys[4].side"],
}


def test_span_through_a_foreign_pulley_is_named(seven):
    data = tables(seven)
    data["pulleys"][1], data["pulleys"][2] = data["pulleys"][2], data["pulleys"][1]
    (found,) = mistakes(data)
    assert found.field == "pulleys[2]"
    assert str(found.value) == "IDR, 0.0367094 m from the span CRK-AC"
    assert "the span runs through it" in found.allowed


def test_missed_pulleys_are_named_when_the_turns_cancel():
    rows = [
        (0.189, -0.112, 0.046, "inside"),
        (0.076, 0.258, 0.032, "inside"),
        (0.031, 0.107, 0.031, "inside"),
        (-0.147, 0.030, 0.079, "inside"),
        (-0.366, -0.037, 0.085, "back"),
        (0.060, -0.354, 0.066, "inside"),
        (0.228, -0.261, 0.074, "back"),
    ]
    found = mistakes(loop_of(rows))
    assert [entry.field for entry in found] == ["pulleys[2]", "pulleys[4]"]
    assert all("which misses it" in entry.allowed for entry in found)


def test_crossing_spans_are_named_when_the_belt_turns_once():
    rows = [
        (0.264, 0.125, 0.086, "inside"),
        (0.056, 0.108, 0.045, "inside"),
        (-0.256, -0.343, 0.040, "inside"),
        (-0.167, -0.124, 0.083, "back"),
    ]
    found = mistakes(loop_of(rows))
    assert [str(entry.value) for entry in found] == [
        "the span b-c across the span c-d",
        "the span b-c across the span d-a",
        "d, 0.00929619 m from the span b-c",
    ]


def test_crossed_belt_is_refused():
    rows = [(0.4, 0.0, 0.05, "inside"), (0.0, 0.0, 0.05, "back")]
    (found,) = mistakes(loop_of(rows))
    assert found.field == "pulleys[1]"
    assert "which misses it as a pulley of side 'back'" in found.allowed
    assert Drive(**loop_of([rows[0], (0.0, 0.0, 0.05, "inside")])).layout.n == 2


def test_loop_of_back_sides_only_is_refused():
    rows = [
        (0.244, 0.378, 0.033, "back"),
        (-0.095, 0.163, 0.043, "back"),
        (-0.388, 0.022, 0.033, "back"),
    ]
    (found,) = mistakes(loop_of(rows))
    assert "a belt that turns -1 times" in str(found)


def test_mirroring_twice_gives_the_layout_back():
    for drive in (zhu_parker_2008(), zhu_parker_2008().changed(overrides=None)):
        layout = drive.layout
        again = layout.mirrored().mirrored()
        for name in layout.__dataclass_fields__:
            got, expected = getattr(again, name), getattr(layout, name)
            if name in ("beta_1", "beta_2"):
                assert got == pytest.approx(expected, abs=1e-15)
            else:
                assert np.array_equal(got, expected), name


def test_mirroring_carries_overrides_with_their_spans():
    layout = zhu_parker_2008().layout.mirrored()
    assert layout.names == ("3", "2", "1")
    assert (layout.crank, layout.arm, layout.travel) == (2, 1, "ccw")
    # spans 3-2, 2-1, 1-3
    assert layout.span_length_m.tolist() == [0.3449, 0.1548, 0.5518]
    angles = np.degrees([layout.beta_1, layout.beta_2])
    assert angles == pytest.approx([180.0 - 178.74, 180.0 - 135.79], abs=1e-12)
    assert layout.arm_length_m == 0.0970
