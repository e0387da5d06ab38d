"""Every field spoilt in every way is refused by name; nothing wrong is taken in silence."""

import copy
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.layouts import drives, random_drive

from beltsim.drive import Drive, load_drive
from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import InvalidDriveError

PROFILE = settings(derandomize=True, deadline=None, max_examples=60)


def full_drive():
    """Tables that use every key but those that exclude another one used here."""
    tables = zhu_parker_2008().model_dump(exclude_none=True)
    tables["pulleys"] = list(tables["pulleys"])
    tables["tensioner"]["static_friction_torque_N_m"] = 20.0
    return tables


def other_drive():
    """The keys that exclude those of `full_drive`."""
    tables = full_drive()
    tables["belt"] |= {"EI_N_m2": 0.02}
    del tables["belt"]["epsilon"]
    tables["operating_point"] = {"rpm": 1500.0}
    tables["excitation"] = {
        "firing_order": 2.0,
        "orders": [
            {"order": 2.0, "speed_fluctuation": 0.1, "phase_deg": 10.0},
            {"order": 4.0, "angle_amplitude_deg": 0.5, "phase_deg": 10.0},
        ],
    }
    return tables


def leaves(tables, path=()):
    """Paths of all single values; numbers in lists one by one."""
    items = tables.items() if isinstance(tables, dict) else enumerate(tables)
    for key, value in items:
        if isinstance(value, dict | list | tuple):
            yield from leaves(value, (*path, key))
        else:
            yield (*path, key)


def branches(tables, path=()):
    """Paths of all tables."""
    yield path
    items = tables.items() if isinstance(tables, dict) else enumerate(tables)
    for key, value in items:
        if isinstance(value, dict) or (
            isinstance(value, list) and value and isinstance(value[0], dict)
        ):
            yield from branches(value, (*path, key))


def as_lists(tables):
    if isinstance(tables, dict):
        return {key: as_lists(value) for key, value in tables.items()}
    return [as_lists(value) for value in tables] if isinstance(tables, list | tuple) else tables


def spoilt(tables, path, value):
    """A copy of `tables` with `value` at `path`; the entry is removed for `...`."""
    result = as_lists(copy.deepcopy(tables))
    here = result
    for part in path[:-1]:
        here = here[part]
    if value is ...:
        del here[path[-1]]
    else:
        here[path[-1]] = value
    return result


def at(tables, path):
    for part in path:
        tables = tables[part]
    return tables


def words(path):
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}"
    return text.lstrip(".")


def refusal(tables):
    with pytest.raises(InvalidDriveError) as caught:
        Drive(**tables)
    assert caught.value.mistakes
    str(caught.value).encode("utf-8")
    return [mistake.field for mistake in caught.value.mistakes]


BASES = {"full": as_lists(full_drive()), "other": as_lists(other_drive())}
LEAVES = [(name, path) for name, base in BASES.items() for path in leaves(base)]
NUMBERS = [(name, path) for name, path in LEAVES if isinstance(at(BASES[name], path), float)]
BAD_NUMBERS = [
    *(math.nan, math.inf, -math.inf, 1e300, -1e300, 10**400, -(10**400), 2**70),
    *("1.0", "", True, False, [], [1.0], {}, {"value": 1.0}, b"1", 1j, None),
    *(np.array([1.0, 2.0]), np.float64("nan"), np.float64("inf"), object()),
]
MAY_BE_NEGATIVE = ("center_m", "pivot_m", "accessory_torque_N_m", "phase_deg")
MAY_BE_NEGATIVE += ("beta_1_deg", "beta_2_deg")
MAY_BE_LEFT_OUT = {
    *("accessory_torque_N_m", "static_friction_torque_N_m", "name", "firing_order", "phase_deg"),
    *("arm_length_m", "beta_1_deg", "beta_2_deg"),
}


def optional(path):
    if path[-1] == "name":
        return len(path) == 1
    # excitation.speed_fluctuation has a default, that of an order has none
    return path[-1] in MAY_BE_LEFT_OUT or path == ("excitation", "speed_fluctuation")


def test_the_bases_are_sound():
    for base in BASES.values():
        Drive(**base)
    assert len(NUMBERS) > 60


@pytest.mark.parametrize(
    ("base", "path"), NUMBERS, ids=lambda x: x if isinstance(x, str) else words(x)
)
def test_spoilt_number_is_refused_by_name(base, path):
    for value in BAD_NUMBERS:
        if value is None and (optional(path) or isinstance(path[-1], str)):
            continue  # the same as leaving the key out, which has its own test
        fields = refusal(spoilt(BASES[base], path, value))
        assert words(path) in fields, (value, fields)
    if not any(key in path for key in MAY_BE_NEGATIVE):
        value = -at(BASES[base], path)
        assert words(path) in refusal(spoilt(BASES[base], path, value))


@pytest.mark.parametrize(
    ("base", "path"), LEAVES, ids=lambda x: x if isinstance(x, str) else words(x)
)
def test_missing_entry_is_refused_by_name(base, path):
    for value in (..., None):
        tables = spoilt(BASES[base], path, value)
        if optional(path):
            if value is ...:
                Drive(**tables)
            continue
        fields = refusal(tables)
        table, key = words(path[:-1]), words(path)
        exclusive = {"epsilon", "EI_N_m2", "rpm", "Omega", "speed_fluctuation"}
        exclusive |= {"angle_amplitude_deg"}
        # of two keys that exclude each other the table is named; of a point or list, the list
        named = table if path[-1] in exclusive or isinstance(path[-1], int) else key
        assert {named, key} & set(fields), fields


TEXTS = [(name, path) for name, path in LEAVES if isinstance(at(BASES[name], path), str)]


@pytest.mark.parametrize(
    ("base", "path"), TEXTS, ids=lambda x: x if isinstance(x, str) else words(x)
)
def test_spoilt_text_is_refused_by_name(base, path):
    for value in (1.0, True, [], {}, b"cw", "a\x00b", "\n", "\ud800", "x" * 10_000, ["cw"]):
        fields = refusal(spoilt(BASES[base], path, value))
        assert words(path) in fields, (value, fields)


TABLES = [(name, path) for name, base in BASES.items() for path in branches(base)]


@pytest.mark.parametrize(
    ("base", "path"), TABLES, ids=lambda x: x if isinstance(x, str) else words(x)
)
def test_extra_keys_and_spoilt_tables_are_refused_by_name(base, path):
    here = at(BASES[base], path)
    if isinstance(here, dict):
        for key in ("surplus", "", " ", "a.b", "\x00", "radius_m ", "__class__", "self", "cls"):
            fields = refusal(spoilt(BASES[base], (*path, key), 1.0))
            assert any(field.startswith(words(path)) for field in fields)
            assert len(fields) == 1
    for value in ("text", 1.0, True, math.nan, [1.0], [[]], object()):
        if path:
            fields = refusal(spoilt(BASES[base], path, value))
            assert any(field.startswith(words(path)) for field in fields), (value, fields)


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=10),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4)
    ),
    max_leaves=8,
)


SOUND = [random_drive(np.random.default_rng(seed)) for seed in range(6)]


@settings(PROFILE, max_examples=150)
@given(st.sampled_from(SOUND), st.data())
def test_random_spoiling_never_ends_in_another_error(drive, data):
    """Any values at any places: a sound drive, or the one error that names places."""
    tables = as_lists(drive.model_dump(exclude_none=True))
    for _ in range(data.draw(st.integers(1, 4))):
        places = list(leaves(tables)) + [path for path in branches(tables) if path]
        path = data.draw(st.sampled_from(places))
        try:
            tables = spoilt(tables, path, data.draw(st.just(...) | ANYTHING))
        except (KeyError, IndexError, TypeError):
            continue
        if not tables:
            break
    found = None
    try:
        drive = Drive(**tables)
    except InvalidDriveError as error:
        found = error
    if found is not None:
        assert found.mistakes
        assert all(mistake.field for mistake in found.mistakes)
        assert str(found)
        return
    assert np.isfinite(drive.layout.span_length_m).all()
    assert abs(drive.layout.side @ drive.layout.wrap_rad - 2.0 * np.pi) < 1e-9
    assert drive.Omega > 0.0


@PROFILE
@given(drives())
def test_written_drives_read_back_equal(tmp_path_factory, drive):
    path = tmp_path_factory.getbasetemp() / "round_trip.toml"
    path.write_text(drive.to_toml(), encoding="utf-8")
    assert load_drive(path) == drive


@PROFILE
@given(st.binary(max_size=200), st.sampled_from([".toml", ".json"]))
def test_any_bytes_end_in_the_one_error(tmp_path_factory, content, suffix):
    path = tmp_path_factory.getbasetemp() / f"bytes{suffix}"
    path.write_bytes(content)
    with pytest.raises(InvalidDriveError):
        load_drive(path)
