"""Input that cannot be used is refused with a typed error that names it."""

from __future__ import annotations

import numpy as np
import pytest

from beltsim.errors import BeltsimError, InvalidProblemError, UnsupportedLawError
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance import Settings, condense, reversals_of_series, solve, solve_many
from beltsim.problem import FrictionProblem

DRY = Coulomb(0.2)
PUSH = HarmonicForcing(0.5, [[0.0], [1.0]], [[0.0], [0.0]])


def mass(friction=DRY, K=1.0, forcing=PUSH, C=0.1) -> FrictionProblem:
    return FrictionProblem([[1.0]], [[C]], [[0.0]], [[K]], 0, forcing, friction)


@pytest.mark.parametrize("R", [0, -1, 2.5, True, "9", None])
def test_R_must_be_a_positive_integer(R) -> None:
    with pytest.raises(InvalidProblemError, match="R = "):
        solve(mass(), R)


def test_R_must_be_odd_for_the_papers_method() -> None:
    with pytest.raises(InvalidProblemError, match="odd for the saturated law"):
        solve(mass(SaturatedCoulomb(0.2, 1e-3)), 8)


def test_R_must_reach_the_forcing() -> None:
    forcing = HarmonicForcing(0.5, np.ones((4, 1)), np.zeros((4, 1)))
    with pytest.raises(InvalidProblemError, match="at least 3, the highest harmonic"):
        solve(mass(forcing=forcing), 2)


def test_too_few_samples() -> None:
    with pytest.raises(InvalidProblemError, match=r"at least 2R \+ 1 = 19"):
        solve(mass(SaturatedCoulomb(0.2, 1e-3)), 9, Settings(samples=18))


@pytest.mark.parametrize(
    "wrong",
    [
        {"harmonics": "even"},
        {"projection": "fft"},
        {"samples": 2},
        {"samples": 64.0},
        {"tolerance": 0.0},
        {"tolerance": float("nan")},
        {"newton_tolerance": 1.0},
        {"max_iterations": 0},
        {"max_refinements": -1},
        {"sigma_ladder": 1},
        {"start": "warm"},
        {"estimate": "yes"},
        {"samples_per_period": 0},
    ],
)
def test_each_setting_is_checked(wrong) -> None:
    (name,) = wrong
    with pytest.raises(InvalidProblemError, match=f"settings.{name}"):
        Settings(**wrong)


def test_all_wrong_settings_are_named_at_once() -> None:
    with pytest.raises(InvalidProblemError) as caught:
        Settings(harmonics="x", tolerance=-1.0, max_iterations=0)
    assert len(caught.value.mistakes) == 3


def test_a_higher_static_torque_is_not_supported() -> None:
    with pytest.raises(UnsupportedLawError, match=r"Q_s = 0.3 > Q_m = 0.2"):
        solve(mass(Coulomb(0.2, 0.3)))


def test_a_joint_is_needed() -> None:
    with pytest.raises(InvalidProblemError, match=r"linear\.response"):
        solve(mass().freed())


def test_a_mean_load_on_a_singular_stiffness() -> None:
    forcing = HarmonicForcing(0.5, [[1.0], [1.0]], [[0.0], [0.0]])
    with pytest.raises(InvalidProblemError, match="drift away"):
        solve(mass(K=0.0, forcing=forcing))


def test_a_singular_stiffness_without_mean_load_moves_about_zero() -> None:
    found = solve(mass(K=0.0), 9, Settings(estimate=False))
    assert found.coefficients[0, 0] == 0.0
    assert found.stops_per_period >= 0.0


@pytest.mark.parametrize("unit", [1e3, 1e6])
def test_a_regular_stiffness_in_mixed_units_is_not_taken_for_singular(unit) -> None:
    """The same two masses under a mean load, with one coordinate in units far from the other's."""
    forcing = HarmonicForcing(0.5, [[0.3, 0.2], [1.0, 0.0]], np.zeros((2, 2)))
    K = np.array([[2.0, -1.0], [-1.0, 2.0]])
    plain = FrictionProblem(np.eye(2), 0.05 * K, np.zeros((2, 2)), K, 0, forcing, DRY)
    scale = np.diag([1.0 / unit, unit])
    scaled = FrictionProblem(
        scale @ scale,
        0.05 * scale @ K @ scale,
        np.zeros((2, 2)),
        scale @ K @ scale,
        0,
        HarmonicForcing(0.5, forcing.cos @ scale, forcing.sin),
        Coulomb(DRY.Q_m / unit),
    )
    quick = Settings(estimate=False)
    expected = solve(plain, 9, quick).coefficients
    assert np.allclose(solve(scaled, 9, quick).coefficients @ scale, expected, rtol=0, atol=1e-10)


def test_an_undamped_resonance() -> None:
    forcing = HarmonicForcing(1.0, [[0.0], [1.0]], [[0.0], [0.0]])
    with pytest.raises(InvalidProblemError, match="harmonic 1"):
        solve(mass(C=0.0, forcing=forcing))


def test_odd_harmonics_alone_cannot_carry_an_even_load() -> None:
    forcing = HarmonicForcing(0.5, [[0.0], [1.0], [1.0]], np.zeros((3, 1)))
    with pytest.raises(InvalidProblemError, match=r"settings\.harmonics"):
        condense(mass(forcing=forcing), 9, "odd")


@pytest.mark.parametrize("wrong", [[[1.0]], [np.nan], ["a"], []])
def test_reversals_need_one_row_of_numbers(wrong) -> None:
    with pytest.raises(InvalidProblemError, match="coefficients"):
        reversals_of_series(wrong)


def test_a_failed_problem_leaves_its_error_in_the_list() -> None:
    found = solve_many([mass(), mass(Coulomb(0.2, 0.3))], R=9, workers=2)
    assert found[0].statistics["converged"]
    assert isinstance(found[1], BeltsimError)
    with pytest.raises(InvalidProblemError, match="workers"):
        solve_many([], workers=0)


def test_workers_do_not_change_a_bit() -> None:
    problems = [mass(Coulomb(q)) for q in (0.1, 0.2, 0.3, 0.4)]
    one = solve_many(problems, R=9, workers=1)
    two = solve_many([mass(Coulomb(q)) for q in (0.1, 0.2, 0.3, 0.4)], R=9, workers=2)
    for first, second in zip(one, two, strict=True):
        assert np.array_equal(first.coefficients, second.coefficients)
