"""Branches pass round their folds, keep to the solution, and fail with their history."""

from __future__ import annotations

import numpy as np
import pytest
from support.problems import random_problem

from beltsim.errors import ConvergenceError, InvalidProblemError, UnsupportedLawError
from beltsim.friction import SaturatedCoulomb
from beltsim.harmonic_balance import Settings, condense, follow, solve, trace

F, DAMPING, CUBIC = 0.3, 0.05, 1.0


def duffing(x: np.ndarray, Omega: float) -> np.ndarray:
    """One harmonic a cos + b sin of q'' + 2 d q' + q + c q^3 = F cos(Omega t)."""
    a, b = x
    stiff = 1.0 - Omega**2 + 0.75 * CUBIC * (a * a + b * b)
    return np.array(
        [stiff * a + 2.0 * DAMPING * Omega * b - F, stiff * b - 2.0 * DAMPING * Omega * a]
    )


def forcing_at(amplitude: float, Omega: float) -> float:
    """The force that gives this amplitude: the branch in closed form."""
    stiff = 1.0 - Omega**2 + 0.75 * CUBIC * amplitude**2
    return amplitude * float(np.hypot(stiff, 2.0 * DAMPING * Omega))


@pytest.mark.parametrize(("start", "direction"), [(0.3, 1), (3.0, -1)])
def test_a_duffing_branch_passes_both_folds(start: float, direction: int) -> None:
    branch = trace(
        duffing,
        [F, 0.0] if direction > 0 else [-0.04, 0.0],
        start,
        within=(0.2, 3.2),
        direction=direction,
        step=0.02,
        scale=np.ones(2),
    )
    assert len(branch.folds) == 2
    amplitudes = np.hypot(*branch.x.T)
    forces = [forcing_at(a, Omega) for a, Omega in zip(amplitudes, branch.values, strict=True)]
    assert np.abs(np.array(forces) - F).max() < 1e-7
    # the fold at the top lies where the backbone meets the limit of damping
    high = max(branch.values[fold] for fold in branch.folds)
    peak = amplitudes.max()
    assert peak == pytest.approx(F / (2.0 * DAMPING * high), rel=0.01)
    assert branch.values[-1] == pytest.approx(3.2 if direction > 0 else 0.2, rel=1e-9)
    assert branch.complete


def test_a_branch_that_ends_keeps_what_it_found() -> None:
    def broken(x: np.ndarray, p: float) -> np.ndarray:
        return np.where(p < 0.5, x - p, np.nan)

    with pytest.raises(ConvergenceError, match="could not be followed beyond 0") as caught:
        trace(broken, [0.0], 0.0, within=(0.0, 1.0), scale=np.ones(1))
    assert 0.4 < caught.value.partial.values[-1] < 0.5
    assert not caught.value.partial.complete
    with pytest.raises(ConvergenceError, match="no solution near the first point"):
        trace(lambda x, p: x**2 + 1.0, [0.5], 0.0, within=(-1.0, 1.0))


@pytest.mark.parametrize(
    "wrong",
    [{"value": 2.0, "within": (0.0, 1.0)}, {"value": 0.0, "within": (0.0, 1.0), "direction": 0}],
)
def test_wrong_limits_and_directions(wrong) -> None:
    with pytest.raises(InvalidProblemError, match=r"value|direction"):
        trace(lambda x, p: x - p, [0.0], **wrong)


def test_friction_over_its_torque_is_what_solve_finds() -> None:
    problem = random_problem(3, 3, static=False, share=0.5, harmonics=1)
    sigma = 0.3 * float(np.abs(condense(problem, 5).velocity).sum())
    Q_m = problem.friction.Q_m

    def problem_of(torque: float):
        return problem.with_friction(SaturatedCoulomb(torque, sigma))

    branch = follow(problem_of, 0.1 * Q_m, within=(0.1 * Q_m, Q_m), R=5, step=0.2)
    assert not branch.folds
    assert branch.values[-1] == pytest.approx(Q_m, rel=1e-9)
    for torque, x in zip(branch.values[::3], branch.x[::3], strict=True):
        found = solve(problem_of(float(torque)), 5, Settings(estimate=False))
        orders = condense(problem, 5).orders
        velocity = 1j * orders * problem.forcing.Omega * found.coefficients[orders, problem.joint]
        assert np.abs(x[0::2] - 1j * x[1::2] - velocity).max() < 1e-6 * np.abs(velocity).max()


def test_exact_friction_is_not_followed() -> None:
    problem = random_problem(3, 3, static=False)
    with pytest.raises(UnsupportedLawError, match="SaturatedCoulomb"):
        follow(lambda _: problem, 1.0, within=(0.0, 2.0))


def test_a_branch_cut_short_by_its_points_says_so() -> None:
    branch = trace(lambda x, p: x - p, [1.0], 1.0, within=(0.0, 9.0), most=5)
    assert len(branch) == 5
    assert not branch.complete


@pytest.mark.parametrize("step", [0.3, 0.05])
def test_folds_are_located_whatever_the_step(step: float) -> None:
    # p = x - x^3 turns back at x = -+1/sqrt(3)
    branch = trace(
        lambda x, p: x**3 - x + p,
        [-1.5],
        1.875,
        within=(-3.0, 3.0),
        direction=-1,
        step=step,
        most=2000,
    )
    turn = 2.0 / (3.0 * np.sqrt(3.0))
    assert branch.values[list(branch.folds)] == pytest.approx([-turn, turn], abs=1e-9)
    assert branch.x[list(branch.folds), 0] == pytest.approx([-(3**-0.5), 3**-0.5], abs=1e-5)


@pytest.mark.parametrize(
    ("spoilt", "name"),
    [
        ({"x": [0.0]}, "scale"),
        ({"x": [np.nan]}, "x"),
        ({"x": []}, "x"),
        ({"scale": [0.0]}, "scale"),
        ({"scale": [1.0, 1.0]}, "scale"),
        ({"value": np.nan}, "value"),
        ({"value": 2.0}, "value"),
        ({"within": (1.0, 1.0)}, "within"),
        ({"within": (0.0, np.inf)}, "within"),
        ({"direction": 0}, "direction"),
        ({"step": 0.0}, "step"),
        ({"step": -0.1}, "step"),
        ({"least_step": 0.0}, "least_step"),
        ({"least_step": 1.0}, "least_step"),
        ({"most": 0}, "most"),
        ({"most": 2.5}, "most"),
    ],
)
def test_a_branch_that_cannot_be_followed_is_refused(spoilt, name):
    given = {"x": [0.5], "value": 0.5, "within": (0.0, 1.0)} | spoilt
    with pytest.raises(InvalidProblemError, match=rf"^{name}|\n{name}| {name}"):
        trace(lambda x, p: x - p, given.pop("x"), given.pop("value"), **given)


def test_a_branch_may_start_at_zero_with_a_scale():
    line = trace(lambda x, p: x - p, [0.0], 0.0, within=(0.0, 1.0), scale=[1.0])
    assert line.complete
    assert np.allclose(line.x[:, 0], line.values, atol=1e-9)
