"""The assembled problem: names, scales, observables, friction, warnings, errors and cost."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.layouts import random_drive

import beltsim
from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import InvalidProblemError
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.model import assemble, chain

PAPER = zhu_parker_2008()


def test_coordinates_of_the_published_drive():
    problem = beltsim.assemble(PAPER, 6.3, n_functions=[1, 2, 1])
    assert problem.labels == (
        *("span1.sin1", "span2.sin1", "span2.sin2", "span3.sin1"),
        *("theta_2", "theta_3", "theta_t"),
    )
    assert problem.joint == 6
    scales = problem.scales
    assert scales.coordinates == pytest.approx([0.1548, 0.3449, 0.3449, 0.5518, 1.0, 1.0, 1.0])
    assert scales.units == ("m",) * 4 + ("rad",) * 3
    assert scales.time_s == pytest.approx(PAPER.time_unit_s)
    assert scales.torque_N_m == pytest.approx(300.0 * 0.0970)


def test_sixteen_sines_unless_told_otherwise():
    assert assemble(PAPER, 6.3).n == 3 * 16 + 3


def test_operating_points():
    own, by_Omega = assemble(PAPER), assemble(PAPER, 6.3)
    by_rpm = assemble(PAPER, rpm=PAPER.rpm(6.3))
    assert np.array_equal(own.K, by_Omega.K)
    assert by_rpm.forcing.Omega == pytest.approx(6.3)
    assert own.forcing.Omega == pytest.approx(6.3)


def test_the_drives_own_friction():
    assert assemble(PAPER, 6.3).friction == Coulomb(14.55 / 29.1, 14.55 / 29.1)
    drive = PAPER.changed(tensioner={"friction_torque_N_m": 3.0, "static_friction_torque_N_m": 4.0})
    assert assemble(drive, 6.3).friction == Coulomb(3.0 / 29.1, 4.0 / 29.1)
    law = SaturatedCoulomb(0.3, 1e-4)
    assert assemble(PAPER, 6.3, friction=law).friction is law


@pytest.mark.parametrize("travel", ["cw", "ccw"])
def test_observables(travel):
    drive = random_drive(np.random.default_rng(1), 4, travel)
    problem, state = assemble(drive, n_functions=3), chain(drive, n_functions=3).system.state
    names = [seen.name for seen in problem.observables]
    assert names == [*(f"tension of span {i}" for i in (1, 2, 3, 4)), "arm angle"]
    for i, seen in enumerate(problem.observables[:4]):
        assert seen.cos[0] == state.p[state.drive.frame.spans[i]]
        assert (seen.lower, seen.upper) == (0.0, math.inf)
        assert seen.unit == "N"
        assert seen.scale == pytest.approx(drive.belt.initial_tension_N)
    angle = problem.observables[-1]
    at_rest = angle.at(np.zeros(1), np.zeros((1, problem.n)), 1.0)
    assert at_rest[0] == pytest.approx(state.drive.frame.sign * state.theta_t)
    moved = angle.at(np.zeros(1), np.eye(problem.n)[-1:], 1.0)
    assert moved - at_rest == pytest.approx([1.0])
    assert (angle.lower, angle.upper, angle.unit) == (-0.1, 0.1, "rad")


def test_the_arm_turns_towards_more_tension_on_the_same_side_for_both_travels():
    """At rest the sense of travel means nothing: signs of the user's frame agree."""
    one = random_drive(np.random.default_rng(2), 4, "cw", torques=False)
    two = one.changed(crank_rotation="ccw")
    angles, tensions = [], []
    for drive in (one, two):
        problem = assemble(drive, 1e-6, n_functions=3)
        angles.append(problem.observables[-1].cos[0])
        tensions.append([seen.row[-1] for seen in problem.observables[:4]])
    assert angles[0] == pytest.approx(angles[1], rel=1e-6)
    assert tensions[0] == pytest.approx(tensions[1], rel=1e-6)


@pytest.mark.parametrize("travel", ["cw", "ccw"])
def test_fixed_centres_have_no_joint(travel):
    drive = random_drive(np.random.default_rng(3), 4, travel, arm=False)
    problem = assemble(drive, n_functions=3)
    assert problem.joint is None
    assert problem.friction is None
    assert problem.n == 4 * 3 + 3
    assert "theta_t" not in problem.labels
    assert len(problem.observables) == 4
    with pytest.raises(InvalidProblemError, match=r"friction = .*None, since joint is None"):
        assemble(drive, n_functions=3, friction=Coulomb(1.0))


def test_two_pulleys_are_a_drive():
    pulleys = [
        {"name": "a", "role": "crank", "side": "inside", "center_m": [0.0, 0.0],
         "radius_m": 0.05, "inertia_kg_m2": 0.01},
        {"name": "b", "role": "fixed", "side": "inside", "center_m": [-0.4, 0.0],
         "radius_m": 0.03, "inertia_kg_m2": 0.001},
    ]  # fmt: skip
    drive = PAPER.model_dump(exclude_none=True) | {"pulleys": pulleys, "name": "two"}
    for key in ("tensioner", "overrides"):
        del drive[key]
    problem = assemble(beltsim.Drive(**drive), 2.0, n_functions=4)
    # both spans stretch and relax with the driven pulley: its own torsional frequency
    rows = np.array([seen.row[-1] for seen in problem.observables])
    assert rows[0] == pytest.approx(-rows[1], rel=1e-6)
    assert problem.K[-1, -1] > 0.0


# --- what is wrong, by name and number ---


@pytest.mark.parametrize("Omega", [0.0, -2.0, math.nan, "6.3", True])
def test_firing_frequencies_that_cannot_be(Omega):
    with pytest.raises(InvalidProblemError, match=r"^Omega = .*a finite number > 0"):
        assemble(PAPER, Omega)


@pytest.mark.parametrize("rpm", [0.0, -10.0, math.inf, "800", True])
def test_crank_speeds_that_cannot_be(rpm):
    with pytest.raises(InvalidProblemError, match=r"^rpm = .*a finite number > 0"):
        assemble(PAPER, rpm=rpm)


def test_two_operating_points_at_once():
    with pytest.raises(InvalidProblemError, match=r"rpm = 900.0: must be left out"):
        assemble(PAPER, 6.3, rpm=900.0)


def test_friction_must_be_a_law():
    with pytest.raises(InvalidProblemError, match=r"friction = 0.5"):
        assemble(PAPER, 6.3, friction=0.5)


@pytest.mark.parametrize(("Q_m", "expected"), [(0.67, 0), (0.69, 1)])
def test_friction_above_the_spring_torque_is_warned_about(Q_m, expected):
    found = assemble(PAPER, 6.3, friction=Coulomb(Q_m)).warnings
    assert len(found) == expected
    if expected:
        assert found[0].startswith(
            "friction torque 20.08 N m (Q_m = 0.69) exceeds the spring torque 19.65 N m (0.6753)"
        )


def test_warnings_of_the_steady_state_reach_the_problem():
    problem = assemble(zhu_parker_2008(epsilon=0.05), 6.3)
    assert any(text.startswith("steady slope of span 3") for text in problem.warnings)


def test_a_path_is_no_drive():
    with pytest.raises(InvalidProblemError, match=r"a Drive: beltsim.load_drive\('six.toml'\)"):
        assemble("six.toml")
