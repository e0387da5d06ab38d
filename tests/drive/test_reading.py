"""Drive files: what is read, and what is refused before or while parsing."""

import json
import os
import sys
import time
import tomllib

import pytest

import beltsim
from beltsim.drive import Drive, json_schema, load_drive, template
from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import InvalidDriveError


@pytest.fixture
def write(tmp_path):
    def write(content, name="drive.toml"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def test_toml_and_json_give_the_same_drive(write):
    drive = zhu_parker_2008()
    data = drive.model_dump(exclude_none=True)
    assert load_drive(write(drive.to_toml())) == drive
    assert load_drive(write(json.dumps(data), "drive.json")) == drive
    assert load_drive(str(write(json.dumps(drive.model_dump()), "DRIVE.JSON"))) == drive
    assert beltsim.load_drive is load_drive


def test_windows_files_are_read(write):
    text = zhu_parker_2008().to_toml().replace("\n", "\r\n")
    assert load_drive(write(b"\xef\xbb\xbf" + text.encode())) == zhu_parker_2008()


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.toml", "name = 'x'\nbelt = = 1\n", "at line 2"),
        ("a.toml", "[belt]\nEA_N = 1\nEA_N = 2\n", "line 3"),
        ("a.toml", "name = '", "at"),
        ("a.toml", "x = " + "1" * 5000, "4300 digits"),
        ("a.json", '{"name": "x",\n "belt": }', "line 2"),
        ("a.json", '{"name": "x", "name": "y"}', "key 'name' is given twice"),
        ("a.json", "", "Expecting value"),
        ("a.toml", "x = " + "[" * 100_000, "nested too deep"),
        ("a.json", "[" * 400_000, "nested too deep"),
        ("a.toml", b"name = '\xff'", "line 1 is not UTF-8 text (byte 0xff)"),
        ("a.toml", b"# ok\n\xfe\xff", "line 2 is not UTF-8 text (byte 0xfe)"),
        ("a.toml", "\x00" * 10, "a.toml: no drive file but binary data"),
        ("a.png", b"\x89PNG\r\n\x1a\n", "no drive file but a PNG picture"),
        ("a.nc", "no netCDF", "whose name ends in .nc: it is no netCDF file either"),
        ("a.toml", "name = 'x'".encode("utf-16"), "UTF-16 text; save it as UTF-8"),
    ],
)
def test_syntax_errors_name_file_and_place(write, name, content, message):
    path = write(content, name)
    with pytest.raises(InvalidDriveError) as caught:
        load_drive(path)
    assert str(caught.value).startswith(str(path))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_file_folder_and_others(tmp_path):
    with pytest.raises(InvalidDriveError, match="no such file"):
        load_drive(tmp_path / "none.toml")
    with pytest.raises(InvalidDriveError, match="a folder; name the drive file in it"):
        load_drive(tmp_path)
    with pytest.raises(InvalidDriveError, match="cannot be read"):
        load_drive("a\x00b.toml")
    with pytest.raises(InvalidDriveError, match="cannot be read"):
        load_drive("x" * 5000)
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidDriveError, match="cannot be read"):
        load_drive(tmp_path / "file" / "drive.toml")


@pytest.mark.skipif(sys.platform == "win32", reason="no pipes in the file system")
def test_pipes_and_devices_are_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    for path in (tmp_path / "pipe.toml", "/dev/zero"):
        with pytest.raises(InvalidDriveError, match="not a regular file"):
            load_drive(path)


@pytest.mark.skipif(sys.platform == "win32", reason="sparse files")
def test_a_huge_file_is_refused_unread(tmp_path):
    path = tmp_path / "huge.toml"
    with path.open("wb") as stream:
        stream.truncate(2**30)
    with pytest.raises(InvalidDriveError, match="1073741824 bytes; a drive file has at most"):
        load_drive(path)


def test_the_limit_is_a_million_bytes(write):
    text = template()
    filler = "\n#" + "x" * (1_000_000 - len(text.encode()) - 2)
    assert load_drive(write(text + filler)).layout.n == 4
    with pytest.raises(InvalidDriveError, match="1000001 bytes"):
        load_drive(write(text + filler + "x"))


def test_mistakes_reach_the_caller_with_their_paths(write):
    with pytest.raises(InvalidDriveError) as caught:
        load_drive(write("name = 'x'\n[belt]\nEA_N = inf\n"))
    fields = {mistake.field for mistake in caught.value.mistakes}
    expected = {"belt.EA_N", "belt.initial_tension_N", "pulleys", "crank_rotation", "damping"}
    assert fields >= expected
    for content in ("[1, 2]", "5", "null", '"text"', "NaN"):
        with pytest.raises(InvalidDriveError, match="must be a table"):
            load_drive(write(content, "a.json"))


@pytest.mark.parametrize(
    "content",
    [
        "belt = 0x" + "f" * 100_000,
        "[belt]\nEA_N = 0x" + "f" * 100_000,
        "pulleys = [0x" + "f" * 100_000 + "]",
        ".".join("a" * 3000) + " = 1",
        "belt." + ".".join("a" * 3000) + " = 1",
        '"\\u0000\\n" = 1',
        "'" + "k" * 5000 + "' = 1",
        "pulleys = 1979-05-27\n[belt]\nEA_N = 07:32:00",
    ],
)
def test_monsters_are_refused_in_words(write, content):
    with pytest.raises(InvalidDriveError) as caught:
        load_drive(write(content))
    text = str(caught.value)
    assert len(text) < 5000
    assert all(line.isprintable() for line in text.split("\n"))


def test_a_file_full_of_mistakes_is_refused_soon(write):
    """Words for some, a number for the rest."""
    keys = "\n".join(f"k{i} = 1" for i in range(20_000))
    before = time.perf_counter()
    with pytest.raises(InvalidDriveError) as caught:
        load_drive(write(template() + "[belt.x]\n" + keys))
    assert len(caught.value.mistakes) == 1
    with pytest.raises(InvalidDriveError, match="19500 further mistakes") as caught:
        load_drive(write(keys + "\n" + template()))
    assert len(caught.value.mistakes) == 501
    with pytest.raises(InvalidDriveError, match="further mistakes") as caught:
        load_drive(write("[[pulleys]]\n" * 8_000))
    # 1 s on a machine at rest; the bound is for a search that grows with the square
    assert time.perf_counter() - before < 20.0


def test_lone_surrogates_are_refused(write):
    """They are legal in JSON but not in text: printing them would fail."""
    for content in ('{"name": "\\ud800"}', '{"\\ud800": 1}', '{"belt": {"\\udfff": 1}}'):
        with pytest.raises(InvalidDriveError) as caught:
            load_drive(write(content, "a.json"))
        str(caught.value).encode("utf-8")


# --- writing -------------------------------------------------------------------------------


def test_examples_are_sound(pytestconfig):
    folder = pytestconfig.rootpath / "examples"
    files = sorted(folder.glob("*.toml"))
    assert {"zhu_parker_2008.toml", "passenger_car_7_pulley.toml"} <= {p.name for p in files}
    for path in files:
        drive = load_drive(path)
        assert drive.layout.warnings == ()
        assert Drive.model_validate(tomllib.loads(drive.to_toml())) == drive


def test_the_paper_s_file_is_the_preset(pytestconfig):
    drive = load_drive(pytestconfig.rootpath / "examples" / "zhu_parker_2008.toml")
    assert drive == zhu_parker_2008()
    # the friction chosen is Q_m = 0.5 in units of P0 r_t
    unit = drive.belt.initial_tension_N * drive.layout.arm_length_m
    assert drive.tensioner.friction_torque_N_m / unit == pytest.approx(0.5, rel=1e-12)


def test_passenger_car_loads_are_powers_at_the_operating_point(pytestconfig):
    drive = load_drive(pytestconfig.rootpath / "examples" / "passenger_car_7_pulley.toml")
    crank, speed = drive.pulleys[0], drive.operating_point.rpm * 3.141592653589793 / 30.0
    powers = {
        p.name: p.accessory_torque_N_m * speed * crank.radius_m / p.radius_m for p in drive.pulleys
    }
    assert powers == pytest.approx(
        {"CRK": 0, "IDR": 10, "AC": 1600, "WP": 50, "PS": 400, "ALT": 1900, "TEN": 0}, rel=1e-3
    )
    tensioner = drive.tensioner
    assert tensioner.static_friction_torque_N_m == pytest.approx(
        1.2 * tensioner.friction_torque_N_m
    )


def test_template_loads_and_explains_every_key(write):
    drive = load_drive(write(template()))
    assert drive.layout.warnings == ()
    assert drive.tensioner is not None
    schema = json_schema()
    tables = [schema, *schema["$defs"].values()]
    keys = {key for table in tables for key in table["properties"]}
    assert len(keys) > 30
    for key in sorted(keys):
        shown = (f"\n{key} = ", f"\n# {key} = ", f"[{key}]", f".{key}]")
        assert any(mark in template() for mark in shown), key


def test_template_with_its_optional_keys_loads_too(write):
    """The lines that are commented out are right as well."""
    lines = []
    for line in template().splitlines():
        key = line.removeprefix("# ").split(" ")[0]
        optional = line.startswith("# [") or (line.startswith("# ") and " = " in line)
        if line.startswith("speed_fluctuation") or key in ("epsilon", "Omega"):
            continue
        lines.append(line.removeprefix("# ") if optional else line)
    drive = load_drive(write("\n".join(lines)))
    assert [order.order for order in drive.orders] == [2.0, 4.0]
    assert drive.overrides.span_lengths_m is not None
    assert drive.layout.warnings == ()  # the overrides shown are those of the coordinates


def test_json_schema_is_that_of_the_file():
    schema = json_schema()
    assert schema["$schema"].endswith("2020-12/schema")
    pulley = schema["$defs"]["Pulley"]
    assert pulley["additionalProperties"] is False
    assert pulley["properties"]["radius_m"] == {
        "description": "a number from 0.001 to 2 (pitch radius in m)",
        "maximum": 2.0,
        "minimum": 0.001,
        "type": "number",
    }
    assert pulley["properties"]["side"]["enum"] == ["inside", "back"]
    assert schema["$defs"]["Belt"]["oneOf"][1] == {"required": ["epsilon"]}
    json.dumps(schema, allow_nan=False)
