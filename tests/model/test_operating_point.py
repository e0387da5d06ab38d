"""Belt speed and fundamental at an operating point."""

from __future__ import annotations

import math

import pytest

from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import InvalidProblemError
from beltsim.model.operating_point import operate
from beltsim.model.scaling import scale

PAPER = zhu_parker_2008()


@pytest.mark.parametrize(("Omega", "s"), [(4.2, 0.355), (4.5, 0.380)])
def test_published_belt_speeds(Omega, s):
    assert operate(scale(PAPER), Omega).s == pytest.approx(s, abs=5e-4)


def test_belt_speed_in_si_is_that_of_the_crank():
    rpm = 3000.0
    point = operate(scale(PAPER), PAPER.omega(rpm))
    assert point.belt_speed_m_s == pytest.approx(rpm * 2.0 * math.pi / 60.0 * 0.0889)
    assert point.fundamental == pytest.approx(point.Omega)


def test_half_orders_lower_the_fundamental():
    drive = PAPER.changed(
        excitation={
            "speed_fluctuation": None,
            "orders": [{"order": 3.0, "angle_amplitude_deg": 1.0},
                       {"order": 0.5, "angle_amplitude_deg": 0.1}],
        }
    )  # fmt: skip
    assert operate(scale(drive), 6.0).fundamental == pytest.approx(1.0)


@pytest.mark.parametrize("Omega", [-1.0, math.nan, math.inf, "6", True, None])
def test_speeds_that_cannot_be(Omega):
    with pytest.raises(InvalidProblemError, match=r"^Omega = "):
        operate(scale(PAPER), Omega)
