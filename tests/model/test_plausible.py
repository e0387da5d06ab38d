"""Warnings about numbers that look like another unit, and none about sound drives."""

import numpy as np
import pytest

from beltsim import assemble, load_drive
from beltsim.drive.presets import zhu_parker_2008
from beltsim.metrics import survey
from beltsim.model.plausible import plausibility_warnings, windup_deg

PAPER = zhu_parker_2008()
DRIVES = ("zhu_parker_2008", "passenger_car_7_pulley")


@pytest.mark.parametrize("name", DRIVES)
def test_sound_drives_are_plausible(name, pytestconfig):
    drive = load_drive(pytestconfig.rootpath / "examples" / f"{name}.toml")
    assert plausibility_warnings(drive) == ()
    assert 10.0 < windup_deg(drive) < 90.0


def test_a_rate_per_degree_is_doubted_with_both_numbers():
    drive = PAPER.changed(tensioner={"spring_rate_N_m_per_rad": 0.493})
    (text,) = plausibility_warnings(drive)
    assert text.startswith("tensioner.spring_rate_N_m_per_rad = 0.493 is wound up by 2284 deg")
    assert "19.65 N m" in text
    assert "28.25 N m/rad" in text
    assert text in assemble(drive).warnings
    assert survey(drive).spring_windup_deg == pytest.approx(2284, abs=1)


def test_an_inertia_in_another_unit_is_doubted():
    pulleys = [pulley.model_dump() for pulley in PAPER.pulleys]
    pulleys[2]["inertia_kg_m2"] = 2.92  # meant in kg cm2
    (text,) = plausibility_warnings(PAPER.changed(pulleys=pulleys))
    assert text.startswith(
        "pulleys[2].inertia_kg_m2 = 2.92 on a radius of 0.027 m moves like 4005 kg"
    )
    assert "0.000292 kg m2" in text
    pulleys[2]["inertia_kg_m2"], pulleys[0]["inertia_kg_m2"] = 0.000292, 100.0
    assert plausibility_warnings(PAPER.changed(pulleys=pulleys)) == ()  # the crank is prescribed


def test_an_arm_lighter_than_its_pulley_is_doubted():
    (text,) = plausibility_warnings(PAPER.changed(tensioner={"arm_inertia_kg_m2": 1e-5}))
    assert text.startswith("tensioner.arm_inertia_kg_m2 = 1e-05 is less than its pulley alone")
    assert "at least J/r2 = 0.143 kg at 0.097 m gives 0.00134 kg m2" in text


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"tensioner": {"spring_rate_N_m_per_rad": 1618.0}}, "wind-up of only 0.7 deg"),
        ({"belt": {"EA_N": 2000.0}}, "is a stretch of 15 %"),
        ({"belt": {"EA_N": 1.2e8}}, "is a stretch of 0.00025 %"),
        ({"belt": {"mass_per_length_kg_m": 10.3}}, "it would be 0.0103 kg/m"),
    ],
)
def test_numbers_in_other_units_are_doubted(tables, words):
    assert words in " ".join(plausibility_warnings(PAPER.changed(**tables)))


def test_a_pulley_that_weighs_nothing_is_doubted():
    pulleys = [pulley.model_dump() for pulley in PAPER.pulleys]
    pulleys[2]["inertia_kg_m2"] = 2.92e-8
    (text,) = plausibility_warnings(PAPER.changed(pulleys=pulleys))
    assert "pulleys[2].inertia_kg_m2 = 2.92e-08 on a radius of 0.027 m is that of a ring" in text


def test_an_arm_without_room_is_doubted(pytestconfig):
    """The pivot in the alternator; an arm of a millimetre; a crank pulley that the arm meets."""
    drive = load_drive(pytestconfig.rootpath / "examples" / "passenger_car_7_pulley.toml")

    def said(**tables):
        return " ".join(plausibility_warnings(drive.changed(**tables)))

    (x, y), (px, py) = drive.pulleys[6].center_m, drive.tensioner.pivot_m
    alternator = {"pivot_m": drive.pulleys[5].center_m, "arm_inertia_kg_m2": 0.1}
    assert "lies inside pulleys[5] (ALT), 0 m from" in said(tensioner=alternator)
    assert "is 1 mm from the centre" in said(tensioner={"pivot_m": (x + 0.001, y)})
    pulleys = [pulley.model_dump() for pulley in drive.pulleys]
    pulleys[0]["radius_m"] = 0.135
    text = said(pulleys=pulleys)
    assert "the arm's pulley touches pulleys[0] (CRK) once the arm turns by" in text
    turn = np.radians(float(text.partition("turns by ")[2].split()[0]))
    arm = complex(x - px, y - py)
    gaps = [abs(complex(px, py) + arm * np.exp(1j * a)) - 0.1736 for a in (turn, -turn)]
    assert min(gaps) == pytest.approx(0.0, abs=1e-4)  # two digits of the angle are printed
