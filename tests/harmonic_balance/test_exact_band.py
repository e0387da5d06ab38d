"""The saturated law without samples: located edges, closed integrals, and what they converge to."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from support.damped import damped_problem
from support.problems import random_problem

import beltsim
from beltsim.errors import ConvergenceError, InvalidProblemError
from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.harmonic_balance import (
    Settings,
    _bands,
    condense,
    follow,
    reversals_of_series,
    saturated,
    sign_change_angles,
    solve,
    survey,
)
from beltsim.harmonic_balance.saturated import balance_of
from beltsim.problem import FrictionProblem

EXACT = Settings(projection="exact", start="set_valued", estimate=False)
LADDER = Settings(projection="exact", sigma_ladder=True, estimate=False)


def banded(problem: FrictionProblem, share: float, R: int = 11) -> FrictionProblem:
    """The problem with a band of so much of the largest velocity that R harmonics allow."""
    largest = float(np.abs(condense(problem, R).velocity).sum())
    return problem.with_friction(SaturatedCoulomb(problem.friction.Q_m, share * largest))


def drawn(seed: int, orders) -> np.ndarray:
    """Pairs of a velocity whose harmonics decay as those of a Coulomb joint."""
    draw = np.random.default_rng(seed)
    return draw.standard_normal(2 * len(orders)) / np.repeat(orders, 2) ** draw.uniform(0.5, 2.0)


def edges(x, orders, images, sigma) -> tuple[np.ndarray, np.ndarray]:
    """Edges and levels of the zones."""
    bounds, levels = np.empty(12 * orders[-1] + 16), np.empty(12 * orders[-1] + 16)
    count = _bands.zones(x, orders, images, sigma, bounds, levels)
    return bounds[1:count], levels[:count]


@pytest.mark.parametrize("sigma", [2.0, 0.3, 0.02])
@pytest.mark.parametrize(("images", "highest"), [(1, 1), (1, 6), (2, 1), (2, 9)])
def test_integrals_are_those_of_a_fine_sum(images, highest, sigma) -> None:
    orders = np.arange(1, highest + 1, images)
    x = drawn(highest, orders)
    N = 200_000
    angle = np.multiply.outer(2.0 * np.pi * (np.arange(N) + 0.5) / N, orders)
    table = np.stack([np.cos(angle), np.sin(angle)], axis=2).reshape(N, -1)
    level = table @ x / sigma
    h, rows = np.clip(level, -1.0, 1.0), table[np.abs(level) < 1.0]
    pairs, slope, mean = _bands.projected(x, orders, images, sigma)
    assert pairs == pytest.approx(2.0 / N * (table.T @ h), abs=1e-7)
    assert mean == pytest.approx(h.mean(), abs=1e-7)
    expected = 2.0 / N / sigma * (rows.T @ rows)
    assert np.abs(slope - expected).max() < 1e-3 * max(np.abs(expected).max(), 1e-9)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("harmonics", ["auto", "all"])
def test_jacobian_is_the_derivative_of_the_residual(seed: int, harmonics: str) -> None:
    problem = banded(random_problem(seed, 4, static=False, share=0.3), (0.3, 0.01)[seed % 2], 9)
    settings = Settings(harmonics, projection="exact")
    condensed = condense(problem, 9, harmonics)
    balance = balance_of(condensed, problem.friction, settings)
    sigma = problem.friction.sigma
    x = drawn(seed, condensed.orders) * 3.0 * sigma
    step = 1e-6 * sigma
    columns = [
        (balance.residual(x + step * e) - balance.residual(x - step * e)) / (2.0 * step)
        for e in np.eye(len(x))
    ]
    expected = np.array(columns).T
    assert np.abs(balance.jacobian(x) - expected).max() < 1e-6 * np.abs(expected).max()


@pytest.mark.parametrize("seed", range(12))
def test_edges_are_the_roots_of_the_series(seed: int) -> None:
    images = 1 + seed % 2
    orders = np.arange(1, 2 * (seed + 1) + 1, images)
    x = drawn(seed, orders)
    series = np.zeros(orders[-1] + 1, dtype=complex)
    series[orders] = x[0::2] - 1j * x[1::2]
    for share in (0.9, 0.3, 0.01, 1e-6):
        sigma = share * np.abs(series).sum()
        expected = []
        for sign in (1.0, -1.0):
            shifted = series.copy()
            shifted[0] = sign * sigma
            expected += sign_change_angles(shifted).tolist()
        wanted = np.sort(expected)
        found, levels = edges(x, orders, images, sigma)
        assert found == pytest.approx(wanted[wanted < 2.0 * np.pi / images], abs=1e-9)
        assert np.all(np.abs(np.diff(levels)) == 1.0)


@pytest.mark.parametrize("past", [1e-2, 1e-5, 1e-8, 1e-11])
def test_two_edges_around_a_touch_are_found_however_close(past: float) -> None:
    for seed in range(20):
        orders = np.arange(1, 14)
        x = drawn(seed, orders)
        tau = np.linspace(0.0, 2.0 * np.pi, 4001)
        values = [_bands.derivatives(t, orders, x)[0] for t in tau]
        top = tau[np.argmax(values)]
        for _ in range(6):
            _, slope, bend = _bands.derivatives(top, orders, x)
            top -= slope / bend
        peak, _, bend = _bands.derivatives(top, orders, x)
        found, _ = edges(x, orders, 1, peak * (1.0 - past))
        apart = np.abs((found - top + np.pi) % (2.0 * np.pi) - np.pi)
        half = np.sqrt(2.0 * peak * past / -bend)
        assert np.sort(apart)[:2] == pytest.approx([half, half], rel=0.2)
        above, _ = edges(x, orders, 1, peak * (1.0 + past))
        assert np.abs((above - top + np.pi) % (2.0 * np.pi) - np.pi).min(initial=9.0) > 2.0 * half


def test_sampling_converges_to_it_with_the_square_of_the_step() -> None:
    counts = np.array([96, 192, 384, 768, 1536, 3072])
    logs = np.zeros(len(counts))
    for seed in range(8000, 8008):  # where edges lie between samples is chance: pool many
        problem = banded(damped_problem(seed), 0.05)
        exact = solve(problem, 11, EXACT).coefficients[1:]
        for i, count in enumerate(counts):
            for more in (0, 1, 5):
                near = Settings(samples=int(count) + more, start="set_valued", estimate=False)
                wrong = solve(problem, 11, near).coefficients[1:] - exact
                logs[i] += np.log(np.abs(wrong).max() / np.abs(exact).max()) / 24.0
    assert np.polyfit(np.log(counts), logs, 1)[0] == pytest.approx(-2.0, abs=0.2)
    assert np.exp(logs[-1]) < 3e-6


@pytest.mark.parametrize("seed", range(8000, 8010))
def test_it_approaches_exact_friction_as_the_band_narrows(seed: int) -> None:
    """At most with the band; with its square once it is below the ripples of the series.

    A ramp between -sigma and sigma has the harmonics of a jump at its middle, but for terms in the
    square of its width.
    """
    problem = damped_problem(seed)
    exact = solve(problem, 11, Settings(estimate=False)).coefficients[1:]
    shares, errors = np.array([1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]), []
    for share in shares:
        wrong = solve(banded(problem, share), 11, EXACT).coefficients[1:] - exact
        errors.append(np.abs(wrong).max() / np.abs(exact).max())
    assert np.all(errors <= 6.0 * shares)
    assert np.log10(errors[-2] / errors[-1]) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize(("start", "count"), [(EXACT, 40), (LADDER, 8)])
def test_no_failure_on_random_problems(start: Settings, count: int) -> None:
    for seed in range(count):
        problem = damped_problem(seed)
        for R, share in ((11, 1e-3), (21, 1e-4), (9, 1e-6)):
            found = solve(banded(problem, share, R), R, start)
            assert found.statistics["projection"] == "exact"
            assert found.statistics["balance_residual"] < 1e-8
            assert found.energy_balance_residual < 1e-8


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("harmonics", ["auto", "all"])
def test_samples_that_know_nothing_of_edges_agree(seed: int, harmonics: str) -> None:
    problem = banded(random_problem(seed, 5, static=False, share=0.4), 1e-3, 9)
    found = solve(problem, 9, Settings(harmonics, "exact", start="set_valued", estimate=False))
    k, N = np.arange(10), 100_000
    velocity = 1j * k * problem.forcing.Omega * found.coefficients[:, problem.joint]
    angle = 2.0 * np.pi * (np.arange(N) + 0.5) / N
    wave = np.exp(1j * np.multiply.outer(angle, k))
    law = problem.friction
    h = law.Q_m * np.clip((wave @ velocity).real / law.sigma, -1.0, 1.0)
    expected = 2.0 / N * (h @ np.conj(wave))
    expected[0] *= 0.5
    kept = condense(problem, 9, harmonics).orders
    assert found.torque_coefficients[kept] == pytest.approx(expected[kept], abs=1e-5 * law.Q_m)
    assert found.torque_coefficients[0] == pytest.approx(expected[0], abs=1e-5 * law.Q_m)


def test_symmetry_is_used_only_when_it_holds() -> None:
    one = banded(random_problem(3, 4, static=False, harmonics=1, share=0.5), 1e-2, 9)
    odd, every = solve(one, 9, EXACT), solve(one, 9, Settings("all", "exact", estimate=False))
    assert odd.statistics["half_wave"]
    assert not every.statistics["half_wave"]
    # the velocity is unique, so it has the symmetry that was not asked for
    assert np.abs(odd.coefficients - every.coefficients).max() < 1e-8
    mixed = banded(random_problem(3, 4, static=False, harmonics=2, share=0.5), 1e-2, 9)
    found = solve(mixed, 9, EXACT)
    assert not found.statistics["half_wave"]
    assert abs(found.torque_coefficients[0]) > 1e-6  # even harmonics bring a mean torque


def test_half_orders_and_a_common_divisor() -> None:
    def pushed(rows, Omega):
        push = HarmonicForcing(Omega, np.zeros((len(rows), 1)), np.array(rows)[:, None])
        law = SaturatedCoulomb(0.4, 1e-3)
        return FrictionProblem([[1.0]], [[0.02]], [[0.0]], [[1.0]], 0, push, law)

    halves = solve(pushed([0.0, 0.0, 1.0, 0.4], 0.25), 17, EXACT)  # orders 1 and 1.5
    assert halves.statistics["divisor"] == 1
    assert halves.energy_balance_residual < 1e-10
    assert np.abs(halves.coefficients[1:, 0]).min() > 0.0
    two, one = (
        solve(pushed([0.0, 0.0, 1.0], 0.25), 19, EXACT),
        solve(pushed([0.0, 1.0], 0.5), 9, EXACT),
    )
    assert two.coefficients[:19:2, 0] == pytest.approx(one.coefficients[:, 0], abs=1e-12)
    assert not two.coefficients[1::2].any()


def test_reversals_do_not_depend_on_samples() -> None:
    drive = beltsim.presets.zhu_parker_2008()
    problem = beltsim.assemble(drive, Omega=6.3, n_functions=(4, 5, 5), residual_flexibility=False)

    def counts(settings):
        found = []
        for Q_m in (1.0, 3.5, 6.1, 8.5):
            law = SaturatedCoulomb(Q_m, 1e-4)
            response = solve(problem.with_friction(law), 11, settings)
            velocity = 1j * np.arange(12) * response.coefficients[:, problem.joint]
            found.append(reversals_of_series(velocity))
        return found

    many = Settings(samples=4096, sigma_ladder=True, estimate=False)
    assert counts(EXACT) == counts(LADDER) == counts(many)


def test_nothing_is_sampled_so_no_number_of_samples_is_taken() -> None:
    with pytest.raises(InvalidProblemError, match="nothing is sampled"):
        Settings(projection="exact", samples=512)


def test_no_friction_and_a_wide_band_are_linear() -> None:
    problem = random_problem(2, 4, static=False)
    expected = beltsim.linear.response(problem)
    free = solve(problem.with_friction(SaturatedCoulomb(0.0, 1e-4)), 9, EXACT)
    size = np.abs(expected).max()
    assert np.abs(free.coefficients[: len(expected)] - expected).max() < 1e-10 * size
    wide, joint = 1e3, problem.joint
    viscous = problem.C.copy()
    viscous[joint, joint] += problem.friction.Q_m / wide
    damped = FrictionProblem(
        problem.M, viscous, problem.G, problem.K, joint, problem.forcing, Coulomb(0.0)
    )
    expected = beltsim.linear.response(damped)
    law = SaturatedCoulomb(problem.friction.Q_m, wide)
    found = solve(problem.with_friction(law), 9, EXACT)
    assert np.abs(found.coefficients[: len(expected)] - expected).max() < 1e-10 * size


def test_the_estimate_maps_and_branches_take_it_too() -> None:
    problem = banded(damped_problem(8001), 1e-2)
    found = solve(problem, 11, Settings(projection="exact", start="set_valued"))
    assert found.statistics["error_estimate"] > 0.0
    table = survey([problem], EXACT, R=11)
    assert table.dissipated_energy[0] == pytest.approx(found.dissipated_energy, rel=1e-9)
    law = problem.friction
    branch = follow(
        lambda Q: problem.with_friction(SaturatedCoulomb(Q, law.sigma)),
        law.Q_m,
        R=5,
        settings=EXACT,
        within=(0.9 * law.Q_m, 1.1 * law.Q_m),
        most=5,
    )
    direct = solve(problem.with_friction(SaturatedCoulomb(branch.values[-1], law.sigma)), 5, EXACT)
    velocity = 1j * problem.forcing.Omega * direct.coefficients[1, problem.joint]
    assert abs(branch.x[-1][0] - 1j * branch.x[-1][1] - velocity) < 1e-6 * abs(velocity)


def test_without_compilation_the_numbers_are_the_same() -> None:
    code = (
        "import numpy as np; from beltsim.harmonic_balance import _bands as b;"
        "x = np.array([.5, .1, -.2, .3, .05, -.1]);"
        "p, s, m = b.projected(x, np.arange(1, 4), 1, .2);"
        "print(np.r_[p, s.ravel(), m].tolist())"
    )
    found = []
    for disabled in ("0", "1"):
        environment = {**os.environ, "NUMBA_DISABLE_JIT": disabled}
        run = subprocess.run(
            [sys.executable, "-c", code],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        )
        found.append(json.loads(run.stdout))
    assert found[0] == pytest.approx(found[1], abs=1e-14)


def test_a_wrong_closed_form_is_not_taken_for_converged(monkeypatch):
    """Half of the torque balances as well; the samples tell."""
    problem = random_problem(2, 3, static=False, share=0.4)
    law = SaturatedCoulomb(problem.friction.Q_m, 1e-2)
    banded, settings = problem.with_friction(law), Settings(projection="exact", estimate=False)
    assert solve(banded, 9, settings).statistics["complementarity_gap"] < 0.02
    true = saturated._exact

    def half(*given):
        found = true(*given)
        return found._replace(pairs=0.5 * found.pairs, slope=0.5 * found.slope)

    monkeypatch.setattr(saturated, "_exact", half)
    with pytest.raises(ConvergenceError, match="from its samples"):
        solve(banded, 9, settings)


def test_too_few_samples_are_told_by_the_closed_form():
    problem = random_problem(2, 3, static=False, share=0.4)
    banded = problem.with_friction(SaturatedCoulomb(problem.friction.Q_m, 1e-3))
    few = solve(banded, 5, Settings(samples=11, start="set_valued", estimate=False))
    many = solve(banded, 5, Settings(samples=1024, start="set_valued", estimate=False))
    assert few.statistics["complementarity_gap"] > 0.05
    assert any("too few samples" in text for text in few.warnings)
    assert many.statistics["complementarity_gap"] < 0.01
    assert not any("too few samples" in text for text in many.warnings)
