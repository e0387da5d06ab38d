"""The survey says the same as the parts it is made of, in SI and in the user's order."""

from __future__ import annotations

import numpy as np
import pytest
from support.layouts import mirrored, random_drive

from beltsim import linear
from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import SteadyStateError
from beltsim.friction import Coulomb
from beltsim.metrics import survey
from beltsim.model import assemble

PAPER = zhu_parker_2008()


def test_the_published_drive():
    found = survey(PAPER, 6.3)
    assert found.rpm == pytest.approx(3089.0, abs=0.5)
    assert [span.name for span in found.spans] == [
        *("span 1 (1 - 2)", "span 2 (2 - 3)", "span 3 (3 - 1)")
    ]
    centrifugal = 0.1029 * found.belt_speed_m_s**2
    for span in found.spans:
        assert span.tension_N - span.tension_without_centrifugal_N == pytest.approx(centrifugal)
    assert [p.wrap_deg for p in found.pulleys] == pytest.approx([221.1, 42.9, 181.8], abs=0.05)
    total = np.sum([[p.hub_load_x_N, p.hub_load_y_N] for p in found.pulleys], axis=0)
    assert total == pytest.approx([0.0, 0.0], abs=1e-9)
    assert found.Q_cr == pytest.approx(11.95, abs=5e-3)
    assert found.critical_torque_N_m == pytest.approx(found.Q_cr * 29.1)
    assert found.friction_torque_N_m == pytest.approx(14.55)
    assert found.free[6].kind.dominant == "span 1"
    assert found.free[6].frequency_Hz == pytest.approx(152.8, abs=0.1)
    assert len(found.free) == len(found.locked) == 12
    assert found.warnings == ()


def test_frequencies_in_hertz_and_as_Omega():
    found, problem = survey(PAPER, 4.2, n_modes=5), assemble(PAPER, 4.2)
    for listed, locked in ((found.free, False), (found.locked, True)):
        omega = linear.frequencies(problem, locked)[:5]
        assert [mode.Omega for mode in listed] == pytest.approx(omega)
        expected = omega / (2.0 * np.pi * PAPER.time_unit_s)
        assert [mode.frequency_Hz for mode in listed] == pytest.approx(expected)
    assert found.decay_free == pytest.approx(linear.decay(problem))
    assert found.decay_locked == pytest.approx(linear.decay(problem, locked=True))


def test_seen_from_behind():
    drive = random_drive(np.random.default_rng(1), 5)
    one, two = survey(drive), survey(mirrored(drive))
    for a, b in zip(one.pulleys, two.pulleys[::-1], strict=True):
        assert a.name == b.name
        assert a.wrap_deg == pytest.approx(b.wrap_deg)
        expected = (b.hub_load_x_N, -b.hub_load_y_N)
        assert (a.hub_load_x_N, a.hub_load_y_N) == pytest.approx(expected)
        assert a.hub_load_N == pytest.approx(b.hub_load_N)
    order = (5 - 2 - np.arange(5)) % 5
    for i, span in enumerate(one.spans):
        assert span.tension_N == pytest.approx(two.spans[order[i]].tension_N)
        assert span.length_m == pytest.approx(two.spans[order[i]].length_m)
    assert one.arm_angle_rad == pytest.approx(-two.arm_angle_rad)
    assert one.spring_torque_N_m == pytest.approx(two.spring_torque_N_m)
    assert one.Q_cr == pytest.approx(two.Q_cr)


def test_fixed_centres():
    found = survey(random_drive(np.random.default_rng(2), 4, arm=False))
    assert found.locked == ()
    assert found.decay_free > 0.0
    for name in (
        *("arm_angle_rad", "spring_torque_N_m", "friction_torque_N_m", "Q_cr"),
        *("critical_torque_N_m", "decay_locked"),
    ):
        assert getattr(found, name) is None


def test_warnings_and_refusals_come_through():
    found = survey(PAPER, 6.3, friction=Coulomb(5.0))
    assert any("exceeds the spring torque" in text for text in found.warnings)
    assert found.friction_torque_N_m == pytest.approx(5.0 * 29.1)
    pulleys = PAPER.model_dump(exclude_none=True)["pulleys"]
    pulleys[2]["accessory_torque_N_m"] = 20.0
    with pytest.raises(SteadyStateError, match="is slack"):
        survey(PAPER.changed(pulleys=pulleys), 3.0)
