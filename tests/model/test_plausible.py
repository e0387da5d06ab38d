"""Warnings about numbers that look like another unit, and none about sound drives."""

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
