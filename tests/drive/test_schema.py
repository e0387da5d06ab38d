"""What a drive file may say, and how mistakes in it are told."""

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest

from beltsim.drive import Drive, Pulley
from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import InvalidDriveError


@pytest.fixture
def data():
    tables = zhu_parker_2008().model_dump(exclude_none=True)
    return tables | {"pulleys": list(tables["pulleys"])}


def refused(data):
    """The mistakes, as {field: mistake}."""
    with pytest.raises(InvalidDriveError) as caught:
        Drive(**data)
    found = caught.value.mistakes
    assert len({str(entry) for entry in found}) == len(found), "the same mistake twice"
    assert "\n".join(str(entry) for entry in found) == str(caught.value)
    return {entry.field: entry for entry in found}


def test_every_mistake_is_told_at_once(data):
    """Values, keys, keys that depend on each other and the layout, in one message."""
    data["crank_rotation"] = "clockwise"
    data["pulleys"][1]["name"] = "1"
    data["pulleys"][2]["inertia_kg_m2"] = -1.0
    data["pulleys"][2]["center_m"] = [0.4, 0.02]
    data["belt"]["EI_N_m2"] = 0.02
    data["belt"]["EA"] = 1.0
    data["tensioner"]["static_friction_torque_N_m"] = 1.0
    del data["damping"]
    data["operating_point"] = {}
    data["excitation"]["orders"] = []
    assert set(refused(data)) == {
        "crank_rotation",
        "pulleys[1].name",
        "pulleys[2].inertia_kg_m2",
        "pulleys[1], pulleys[2]",
        "belt",
        "belt.EA",
        "tensioner.static_friction_torque_N_m",
        "damping",
        "operating_point",
        "excitation.orders",
        "excitation.speed_fluctuation",
    }


def test_wrong_entries_do_not_make_a_list_too_short(data):
    """Nor do they keep the other checks of the list from speaking."""
    del data["tensioner"], data["overrides"]
    for pulley in data["pulleys"]:
        pulley["radius_m"] = 0.0
    data["excitation"] = {"orders": [{"order": 0.3, "speed_fluctuation": 0.1}]}
    assert set(refused(data)) == {
        *(f"pulleys[{i}].radius_m" for i in range(3)),
        "tensioner",
        "excitation.orders[0].order",
    }


@pytest.mark.parametrize(
    ("path", "value", "hint"),
    [
        (("pulleys", 0, "radius_m"), 88.9, "88.9 mm would be 0.0889"),
        (("pulleys", 0, "center_m"), [552.5, 55.6], "[552.5, 55.6] mm would be [0.5525, 0.0556]"),
        (("pulleys", 0, "center_m"), [24, 3], "[24, 3] mm would be [0.024, 0.003]"),
        (("tensioner", "pivot_m"), [0.2, 63.5], "63.5 mm would be 0.0635"),
        (("overrides", "arm_length_m"), 97, "97 mm would be 0.097"),
        (("overrides", "span_lengths_m"), [154.8, 344.9, 551.8], "154.8 mm would be 0.1548"),
        (("belt", "EA_N"), 120, "120 kN would be 120000"),
        (("belt", "initial_tension_N"), 0.3, "0.3 kN would be 300"),
        (("belt", "mass_per_length_kg_m"), 102.9, "102.9 g/m would be 0.1029"),
        (("pulleys", 0, "inertia_kg_m2"), 724.8, "724.8 kg cm2 would be 0.07248"),
        (("damping", "ratio"), 5, "5 % would be 0.05"),
        (("excitation", "speed_fluctuation"), 10.0, "10 % would be 0.1"),
    ],
)
def test_a_customary_unit_is_recognised(data, path, value, hint):
    *tables, key = path
    table = data
    for part in tables:
        table = table[part]
    table[key] = value
    message = "\n".join(str(entry) for entry in refused(data).values())
    assert hint in message
    assert ".".join(str(p) for p in path if not isinstance(p, int)).split(".")[-1] in message


def test_no_hint_where_a_unit_explains_nothing(data):
    data["pulleys"][0]["radius_m"] = -0.0889
    (found,) = refused(data).values()
    assert str(found) == (
        "pulleys[0].radius_m = -0.0889: must be a number from 0.001 to 2 (pitch radius in m)"
    )


@pytest.mark.parametrize(
    ("table", "key", "nearest"),
    [
        ("belt", "initial_tension", "initial_tension_N"),
        ("tensioner", "friction_torque_Nm", "friction_torque_N_m"),
        ("operating_point", "omega", "Omega"),
        ("belt", "EI", "EI_N_m2"),
        ("belt", "ea", "EA_N"),
        ("damping", "zeta_ratio", "ratio"),
        ("excitation", "order", "orders"),
        ("overrides", "beta_1", "beta_1_deg"),
    ],
)
def test_unknown_key_names_the_nearest(data, table, key, nearest):
    data[table][key] = 1.0
    found = refused(data)[f"{table}.{key}"]
    assert f"did you mean {nearest}?" in found.allowed


def test_unknown_key_in_a_pulley_and_at_the_top(data):
    data["pulleys"][2]["radius_mm"] = data["pulleys"][2].pop("radius_m")
    data["pulley"] = []
    found = refused(data)
    assert "did you mean radius_m?" in found["pulleys[2].radius_mm"].allowed
    assert "did you mean pulleys?" in found["pulley"].allowed
    assert str(found["pulleys[2].radius_m"].value) == "missing"


def test_unlike_key_lists_the_known_ones(data):
    data["damping"]["qqq"] = 1.0
    assert refused(data)["damping.qqq"].allowed == "a known key; known here: ratio"


@pytest.mark.parametrize(
    ("table", "keys"),
    [
        ("belt", {"EI_N_m2": 0.02, "epsilon": 0.01}),
        ("operating_point", {"rpm": 1000.0, "Omega": 1.0}),
    ],
)
def test_exactly_one_of_two_keys(data, table, keys):
    first, second = keys
    rest = {key: value for key, value in data[table].items() if key not in keys}
    both = refused(data | {table: rest | keys})[table]
    assert str(both.value) == f"both {first} and {second}"
    none = refused(data | {table: rest})[table]
    assert str(none.value) == f"neither {first} nor {second}"
    assert none.allowed == f"given by exactly one of {first}, {second}"
    for key, value in keys.items():
        Drive(**data | {table: rest | {key: value}})


def test_roles_are_counted(data):
    data["pulleys"][2]["role"] = "crank"
    assert "2 (pulleys[0], pulleys[2])" in str(refused(data)["pulleys"])
    data["pulleys"][0]["role"] = data["pulleys"][2]["role"] = "fixed"
    assert str(refused(data)["pulleys"].value) == "none of role 'crank'"
    data["pulleys"][0]["role"] = "crank"
    data["pulleys"][2]["role"] = "arm"
    assert "at most one pulley of role 'arm'" in str(refused(data)["pulleys"])


def test_arm_and_tensioner_need_each_other(data):
    del data["overrides"]
    lonely = copy.deepcopy(data)
    del lonely["tensioner"]
    found = refused(lonely)
    assert set(found) == {"tensioner"}
    assert "since pulleys[1] has the role 'arm'" in found["tensioner"].allowed
    data["pulleys"][1]["role"] = "fixed"
    found = refused(data)
    assert "since there is a tensioner" in found["pulleys"].allowed


def test_overrides_of_an_absent_arm_are_refused(data):
    data["pulleys"][1]["role"] = "fixed"
    del data["tensioner"]
    assert set(refused(data)) == {
        "overrides.beta_1_deg",
        "overrides.beta_2_deg",
        "overrides.arm_length_m",
    }


def test_overrides_need_one_length_per_span(data):
    data["overrides"]["span_lengths_m"] = [0.15, 0.34]
    found = refused(data)["overrides.span_lengths_m"]
    assert (str(found.value), found.allowed) == ("2 lengths", "a list of 3, one per span")


def test_pivot_must_be_off_the_pulley(data):
    data["tensioner"]["pivot_m"] = data["pulleys"][1]["center_m"]
    assert "at least 0.001 m" in refused(data)["tensioner.pivot_m"].allowed
    data["tensioner"]["pivot_m"] = [9.0, 9.0]
    assert "at most 5 m" in refused(data)["tensioner.pivot_m"].allowed


def test_static_friction_is_at_least_the_kinetic_one(data):
    data["tensioner"]["static_friction_torque_N_m"] = 14.55
    assert Drive(**data).tensioner.static_friction_torque_N_m == 14.55
    data["tensioner"]["static_friction_torque_N_m"] = 14.54
    found = refused(data)["tensioner.static_friction_torque_N_m"]
    assert found.allowed.startswith("at least tensioner.friction_torque_N_m = 14.55")


def test_crank_takes_no_accessory_torque(data):
    data["pulleys"][0]["accessory_torque_N_m"] = 1.0
    found = refused(data)["pulleys[0].accessory_torque_N_m"]
    assert "its torque follows from the others" in found.allowed


def test_belt_must_be_stiffer_than_its_tension(data):
    data["belt"] |= {"EA_N": 1200.0, "initial_tension_N": 3000.0}
    assert "above belt.initial_tension_N = 3000" in refused(data)["belt.EA_N"].allowed


def test_names_must_differ_and_be_visible(data):
    data["pulleys"][2]["name"] = "1"
    assert "pulleys[0] has this one" in refused(data)["pulleys[2].name"].allowed
    for name in ("", " ", "a\n", "\t", "a\x00b", " a", "x" * 61):
        data["pulleys"][2]["name"] = name
        assert set(refused(data)) == {"pulleys[2].name"}, repr(name)
    data["pulleys"][2]["name"] = "Wasserpumpe 2 (\u00f8 120)"
    assert Drive(**data).layout.names[2] == "Wasserpumpe 2 (\u00f8 120)"


def test_pulleys_are_numbered_from_zero_to_a_hundred(data):
    data["pulleys"] = data["pulleys"] * 40
    assert "a list of 2 to 100 tables" in refused(data)["pulleys"].allowed
    data["pulleys"] = data["pulleys"][:1]
    assert "a list of 2 to 100 tables" in refused(data)["pulleys"].allowed


def test_integers_are_numbers_and_become_floats(data):
    data["damping"]["ratio"] = 0
    data["tensioner"]["friction_torque_N_m"] = 7
    drive = Drive(**data)
    assert drive.damping.ratio == 0.0
    assert isinstance(drive.tensioner.friction_torque_N_m, float)


# --- excitation ----------------------------------------------------------------------------


def test_one_order_is_the_default(data):
    del data["excitation"]
    drive = Drive(**data)
    assert drive.excitation.firing_order == 3.0
    assert drive.orders == ((3.0, 0.10 / 3.0, 0.0),)


def test_orders_are_resolved_to_angles(data):
    data["excitation"] = {
        "firing_order": 2,
        "orders": [
            {"order": 2, "speed_fluctuation": 0.04},
            {"order": 0.5, "angle_amplitude_deg": 1.0, "phase_deg": 90.0},
        ],
    }
    drive = Drive(**data)
    assert drive.excitation.speed_fluctuation is None
    assert drive.orders[0] == (2.0, 0.02, 0.0)
    assert drive.orders[1] == pytest.approx((0.5, np.pi / 180.0, np.pi / 2.0))


def test_orders_take_the_place_of_the_single_fluctuation(data):
    data["excitation"]["orders"] = [{"order": 2, "speed_fluctuation": 0.04}]
    found = refused(data)
    assert set(found) == {"excitation.speed_fluctuation"}
    assert (
        "left out where excitation.orders is given" in found["excitation.speed_fluctuation"].allowed
    )


def test_mistakes_in_orders(data):
    data["excitation"] = {
        "firing_order": 1.25,
        "orders": [
            {"order": 2, "speed_fluctuation": 0.04, "angle_amplitude_deg": 1.0},
            {"order": 2.0, "speed_fluctuation": 0.04},
            {"order": 0.7, "speed_fluctuation": 0.04},
            {"order": 1},
            {"speed_fluctuation": 1.5},
            7,
        ],
    }
    found = refused(data)
    assert set(found) == {
        "excitation.firing_order",
        "excitation.orders[0]",
        "excitation.orders[1].order",
        "excitation.orders[2].order",
        "excitation.orders[3]",
        "excitation.orders[4].order",
        "excitation.orders[4].speed_fluctuation",
        "excitation.orders[5]",
    }
    assert "excitation.orders[0] has it already" in found["excitation.orders[1].order"].allowed
    assert "a multiple of 0.5" in found["excitation.orders[2].order"].allowed
    assert "a table with the keys order" in found["excitation.orders[5]"].allowed


def test_orders_are_exact_halves(data):
    data["excitation"]["firing_order"] = 3.0 + 1e-12
    assert set(refused(data)) == {"excitation.firing_order"}


# --- derived quantities --------------------------------------------------------------------


def test_scales_of_table_1():
    drive = zhu_parker_2008()
    assert drive.mean_span_length_m == pytest.approx((0.1548 + 0.3449 + 0.5518) / 3.0, rel=1e-15)
    assert drive.time_unit_s == pytest.approx(6.4914e-3, abs=5e-8)
    assert drive.rpm(12.0) == pytest.approx(5884.0, abs=0.5)
    assert drive.omega(drive.rpm(6.3)) == pytest.approx(6.3, rel=1e-15)
    assert drive.bending_stiffness_N_m2 == pytest.approx(0.0037, abs=2e-5)


def test_operating_point_either_way():
    drive = zhu_parker_2008()
    assert drive.Omega == 6.3
    other = drive.changed(operating_point={"rpm": drive.rpm(6.3), "Omega": None})
    assert other.operating_point.Omega is None
    assert other.Omega == pytest.approx(6.3, rel=1e-15)
    stiff = drive.changed(belt={"epsilon": None, "EI_N_m2": 0.02})
    assert stiff.bending_stiffness_N_m2 == 0.02


# --- a drive as a value --------------------------------------------------------------------


def test_drives_are_frozen_values():
    drive = zhu_parker_2008()
    with pytest.raises(ValueError, match="frozen"):
        drive.name = "x"
    with pytest.raises(ValueError, match="frozen"):
        drive.belt.EA_N = 1.0
    assert drive == zhu_parker_2008()
    assert hash(drive) == hash(zhu_parker_2008())
    assert drive.layout.n == 3
    assert pickle.loads(pickle.dumps(drive)) == drive == copy.deepcopy(drive)


def test_changed_copies_are_checked_and_laid_out_anew():
    drive = zhu_parker_2008()
    assert drive.layout.travel == "cw"
    assert drive.changed(crank_rotation="ccw").layout.travel == "ccw"
    assert drive.model_copy(update={"crank_rotation": "ccw"}).layout.travel == "ccw"
    assert drive.model_copy() == drive
    for wrong in (
        lambda: drive.changed(damping={"ratio": 2.0}),
        lambda: drive.changed(damping=None),
        lambda: drive.changed(dampng={"ratio": 0.1}),
        lambda: drive.model_copy(update={"damping": {"ratio": 2.0}}),
        lambda: zhu_parker_2008(zeta=-1.0),
        lambda: zhu_parker_2008(epsilon=float("nan")),
        lambda: zhu_parker_2008(mu="much"),
        lambda: zhu_parker_2008(alpha=0.3),
    ):
        with pytest.raises(InvalidDriveError):
            wrong()
    assert drive.changed(overrides=None).overrides is None


def test_models_are_taken_in_place_of_tables(data):
    drive = Drive(**data)
    parts = {name: getattr(drive, name) for name in Drive.model_fields}
    assert Drive(**parts) == drive
    crank = parts["pulleys"][0].model_copy(update={"accessory_torque_N_m": 5.0})
    assert isinstance(crank, Pulley)
    found = refused(parts | {"pulleys": (crank, *parts["pulleys"][1:])})
    assert set(found) == {"pulleys[0].accessory_torque_N_m"}


def test_models_are_checked_again(data):
    drive = Drive(**data)
    wrong = drive.belt.model_copy(update={"EA_N": -1.0})
    assert set(refused(data | {"belt": wrong})) == {"belt.EA_N"}


@pytest.mark.parametrize("value", [None, 5, "x", [], [("name", "x")], {1: 2}])
def test_validate_takes_a_table(value):
    with pytest.raises(InvalidDriveError, match=r"drive = .*: must be a table"):
        Drive.model_validate(value)


def test_validate_takes_a_drive():
    drive = zhu_parker_2008()
    assert Drive.model_validate(drive) is drive


def test_importing_drives_loads_nothing_heavy():
    code = "import sys, beltsim.drive; print(*sorted(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(run.stdout.split())
    assert {"numpy", "pydantic"} <= loaded
    assert not loaded & {"scipy", "xarray", "matplotlib", "tqdm", "tomli_w", "pandas", "numba"}


def test_its_text_is_one_short_line(data):
    drive = Drive(**data)
    assert repr(drive) == str(drive)
    assert repr(drive) == (
        "<Drive 'Zhu & Parker 2008, Table 1': 3 pulleys (1, 2, 3), with tensioner, Omega = 6.3>"
    )
    assert repr(drive.layout).startswith("<Layout: 3 pulleys, spans 154.8, 344.9, 551.8 mm")
