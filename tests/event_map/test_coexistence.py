"""Q_s > Q_m: a locked joint and a moving one may both be periodic; which is returned, and how.

And what friction can hold where nothing else does.
"""

from pathlib import Path

import numpy as np
import pytest

import beltsim
from beltsim import (
    Coulomb,
    FrictionProblem,
    HarmonicForcing,
    SaturatedCoulomb,
    event_map,
    linear,
    transient,
)
from beltsim.errors import CoreError, NotPeriodicError
from beltsim.event_map.locked import locked

EXAMPLES = Path(__file__).parents[2] / "examples"
MIXED = Coulomb(0.7, 1.05)  # Q_cr = 1 lies between


def one_mass(law, Omega=0.8, K=1.0, C=0.05, mean=0.0):
    push = HarmonicForcing(Omega, cos=[[mean], [1.0]], sin=[[0.0], [0.0]])
    return FrictionProblem([[1.0]], [[C]], [[0.0]], [[K]], 0, push, law)


def moving_state(problem):
    return transient.integrate(problem, 400, initial_state=[0.0, 2.0])


def test_a_guess_on_the_moving_orbit_finds_it():
    problem = one_mass(MIXED)
    run = moving_state(problem)
    orbit = event_map.periodic(problem, guess=run.final_state)
    assert run.stick_fraction < 0.1
    assert orbit.stick_fraction == pytest.approx(run.stick_fraction, abs=1e-8)
    assert orbit.dissipated_energy == pytest.approx(run.dissipated_energy, rel=1e-8)
    assert not orbit.warnings


def test_without_a_guess_the_joint_rests_and_a_warning_names_the_other():
    orbit = event_map.periodic(one_mass(MIXED))
    assert orbit.stick_fraction == 1.0
    assert any("moving orbit may exist" in text and "Q_cr = 1" in text for text in orbit.warnings)


@pytest.mark.parametrize("law", [Coulomb(1.05), Coulomb(1.02, 1.3)])
def test_no_warning_where_every_motion_comes_to_rest(law):
    problem = one_mass(law)
    assert not event_map.periodic(problem).warnings
    run = moving_state(problem)  # creeps towards its rest interval, by less each period
    assert run.stick_fraction > 0.98
    assert run.dissipated_energy < 1e-4 * run.total_dissipated_energy


def test_a_guess_that_comes_to_rest_gives_the_locked_orbit():
    assert event_map.periodic(one_mass(MIXED), guess=[0.0, 0.0]).stick_fraction == 1.0


def passenger_car():
    """At 600 rpm an orbit with four events and one with eight, both stable."""
    drive = beltsim.load_drive(EXAMPLES / "passenger_car_7_pulley.toml")
    return beltsim.assemble(drive, rpm=600.0, n_functions=4)


def test_without_a_guess_the_orbit_is_the_one_that_a_run_from_rest_approaches():
    problem = passenger_car()
    run = event_map.propagate(problem, 400)
    orbit = event_map.periodic(problem)
    assert run.period_residual < 1e-10
    assert orbit.events.kind.tolist() == run.events.kind[run.events.t > run.window[0]].tolist()
    assert orbit.dissipated_energy == pytest.approx(run.dissipated_energy, rel=1e-8)
    assert event_map.survey([problem]).dissipated_energy == pytest.approx(run.dissipated_energy)


def test_a_guess_finds_the_other_stable_orbit():
    problem = passenger_car()
    orbit = event_map.periodic(problem)
    law = Coulomb(1.1 * problem.friction.Q_m)  # unique, and close to the other
    guess = event_map.periodic(problem.with_friction(law)).initial_state
    other = event_map.periodic(problem, guess=guess)
    assert len(other.events) == 4
    assert len(orbit.events) == 8
    for one in (orbit, other):
        assert np.abs(one.multipliers).max() < 0.99
        assert one.period_residual < 1e-12


def test_neighbours_in_a_grid_do_not_decide_between_orbits():
    problem = one_mass(Coulomb(0.6, 0.99))
    alone = event_map.periodic(problem.with_friction(MIXED))
    both = event_map.solve_many([problem, problem.with_friction(MIXED)])
    assert both[0].stick_fraction < 1.0
    assert np.array_equal(both[1].q, alone.q)
    table = event_map.survey([problem, problem.with_friction(MIXED)])
    assert table.locked.tolist() == [False, True]


def test_a_joint_that_nothing_holds_locks_when_friction_carries_the_mean_too():
    problem = one_mass(Coulomb(3.01), K=0.0, mean=2.0)
    assert linear.critical_torque(problem) == pytest.approx(3.0)
    assert locked(problem).Q_m_cr == pytest.approx(3.0)
    assert event_map.periodic(problem).rest_interval == (-np.inf, np.inf)
    run = transient.integrate(problem, 30)
    assert run.stick_fraction == 1.0
    assert transient.integrate(problem.with_friction(Coulomb(2.9)), 30).stick_fraction < 1.0


def test_critical_torque_of_a_chain_that_nothing_holds():
    K = np.array([[1.0, -1.0], [-1.0, 1.0]])
    push = HarmonicForcing(0.7, cos=[[0.5, 0.0], [0.0, 1.0]], sin=np.zeros((2, 2)))
    chain = FrictionProblem(np.eye(2), 0.1 * K, 0.0 * K, K, 1, push, Coulomb(2.0))
    assert linear.critical_torque(chain) == pytest.approx(1.5)
    assert locked(chain).Q_m_cr == pytest.approx(1.5)


def test_undamped_resonance_needs_the_friction_that_its_first_harmonic_can_give():
    # a square wave of height Q has the first harmonic 4 Q/pi; a force of 1 must be met by it
    least = np.pi / 4.0
    for share in (0.3, 0.999):
        with pytest.raises(NotPeriodicError, match=r"friction holds at most .* of the 1 there"):
            event_map.periodic(one_mass(Coulomb(share * least), Omega=1.0, C=0.0))
    orbit = event_map.periodic(one_mass(Coulomb(1.01 * least), Omega=1.0, C=0.0))
    assert orbit.period_residual < 1e-12


def test_a_band_below_rounding_says_so():
    # rounding of O(1) velocities, times the rate Q/sigma of the band, is the joint's acceleration
    K = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
    push = HarmonicForcing(0.9, cos=[[0.0] * 3, [1.0, 0.0, 0.3]], sin=np.zeros((2, 3)))
    problem = FrictionProblem(np.eye(3), 0.04 * np.eye(3), 0 * K, K, 2, push, Coulomb(1.0))
    Q_m = 0.4 * linear.critical_torque(problem)
    narrow = problem.with_friction(SaturatedCoulomb(Q_m, 1e-12))
    with pytest.raises(CoreError, match=r"sigma = 1e-12 is too narrow .*Coulomb"):
        event_map.propagate(narrow, 100)
    wide = event_map.propagate(problem.with_friction(SaturatedCoulomb(Q_m, 1e-6)), 100)
    assert len(wide.events) > 200
