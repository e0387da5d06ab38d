"""The compiled kernels against plain NumPy, and against themselves without compilation."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from support.problems import random_problem

from beltsim.harmonic_balance import Settings, _kernels, _switching, condense, set_valued
from beltsim.harmonic_balance.cells import of_bounds, refined, uniform
from beltsim.harmonic_balance.condensation import System, _by_kernel, _by_lapack


@pytest.mark.parametrize("m", [1, 2, 7, 64, 66, 150])  # in blocks of 64 columns
def test_factors_solve_as_lapack_does(m: int) -> None:
    draw = np.random.default_rng(m)
    a, b = draw.standard_normal((m, m)), draw.standard_normal(m)
    factors, pivots, x = a.copy(), np.empty(m, np.int64), b.copy()
    _kernels.factorise(factors, pivots)
    _kernels.substitute(factors, pivots, x)
    assert np.abs(x - np.linalg.solve(a, b)).max() < 1e-10


def test_mobility_acts_as_a_complex_factor() -> None:
    A = np.array([0.3 + 2.0j, 1.0 - 0.5j])
    torque = np.array([1.0 - 2.0j, 0.5 + 3.0j])  # c - i s
    pairs = np.array([1.0, 2.0, 0.5, -3.0])
    _kernels.apply_mobility(A, pairs)
    moved = A * torque
    assert pairs == pytest.approx([moved[0].real, -moved[0].imag, moved[1].real, -moved[1].imag])


def splitting(table, weight, mobility, free, rounds=40_000):
    """The same problem by forward-backward-forward splitting: plain NumPy, globally convergent."""
    a = np.zeros((2 * len(mobility),) * 2)
    for k, value in enumerate(mobility):
        rows = slice(2 * k, 2 * k + 2)
        a[rows, rows] = [[value.real, value.imag], [-value.imag, value.real]]
    matrix = table @ a @ (table.T * weight)
    v_free = table @ free
    step = 0.9 / np.linalg.norm(matrix, 2)
    h = np.zeros(len(weight))
    for _ in range(rounds):
        slope = v_free - matrix @ h
        middle = np.clip(h + step * slope, -1.0, 1.0)
        h = middle + step * (v_free - matrix @ middle - slope)
    return v_free - matrix @ middle


@pytest.mark.parametrize("seed", range(3))
def test_interior_point_finds_what_a_splitting_finds(seed: int) -> None:
    problem = random_problem(seed, 3, static=False, share=0.4, harmonics=1)
    condensed = condense(problem, 5)
    cells = uniform(5, condensed.half_wave, 24)
    size = np.abs(condensed.velocity).max()
    free = np.stack([condensed.velocity.real, -condensed.velocity.imag], 1).ravel() / size
    mobility = condensed.mobility * problem.friction.Q_m / size
    arguments = (cells.table, cells.weight, mobility, free)
    h, v, residuals = _kernels.interior_point(*arguments, 0.0, 1e-10, 60)
    assert residuals.min() < 1e-8
    assert np.abs(h).max() <= 1.0
    assert np.abs(v - splitting(*arguments)).max() < 1e-5


def test_cells_integrate_exactly() -> None:
    bounds = np.sort(np.r_[0.0, np.random.default_rng(1).uniform(0.0, 2 * np.pi, 9), 2 * np.pi])
    cells = of_bounds(bounds, np.arange(1, 6), 1)
    h = np.random.default_rng(2).standard_normal(10)
    tau = (np.arange(400_000) + 0.5) * 2.0 * np.pi / 400_000
    torque = h[np.searchsorted(bounds, tau) - 1]
    expected = [2.0 * np.mean(torque * np.exp(-1j * r * tau)) for r in range(1, 6)]
    assert cells.coefficients(h) == pytest.approx(np.array(expected), abs=1e-4)
    assert cells.mean(h) == pytest.approx(torque.mean(), abs=1e-4)


def test_cutting_cells_keeps_the_torque() -> None:
    cells = uniform(3, True, 16)
    h = np.array([1.0, 1.0, 0.3, -1.0, -1.0, -1.0, -1.0, -1.0])
    finer = refined(cells, h, 1.0, 4)
    same = h[np.searchsorted(cells.bounds, 0.5 * (finer.bounds[1:] + finer.bounds[:-1])) - 1]
    assert len(same) > len(h)
    assert finer.coefficients(same) == pytest.approx(cells.coefficients(h), abs=1e-14)


def test_without_compilation_the_numbers_are_the_same() -> None:
    code = (
        "import numpy as np; from beltsim.harmonic_balance import _kernels as k;"
        "t = (np.arange(12) + .5)*np.pi/12; table = np.stack([np.cos(t), np.sin(t),"
        " np.cos(3*t), np.sin(3*t)], 1); w = np.full(12, 1/6);"
        "h, v, r = k.interior_point(table, w, np.array([.5+.3j, .2-.4j]),"
        " np.array([1., .2, .1, 0.]), 0., 1e-9, 50); print(repr(h.tolist()));"
        "print(float(k.least_bound(table, w, np.array([1., 0., .2, .1]), 1e-9, 50)[1]))"
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
        lines = run.stdout.splitlines()
        found.append(np.r_[json.loads(lines[0]), float(lines[1])])
    assert found[0] == pytest.approx(found[1], abs=1e-9)


@pytest.mark.parametrize("n", [1, 2, 7, 11])
def test_both_eliminations_agree(n: int) -> None:
    problem = random_problem(n, n)
    draw = np.random.default_rng(n)
    system = System(
        problem.M,
        problem.C,
        problem.G,
        problem.K,
        n // 2,
        0.37,
        np.array([1, 3, 7, 14, 110]),
        draw.standard_normal((8, n)),
        draw.standard_normal((8, n)),
    )
    own, lapack = _by_kernel(system), _by_lapack(system)
    for one, other in zip(own[:5], lapack[:5], strict=True):
        assert np.abs(one - other).max() <= 1e-12 * np.abs(other).max()
    assert own[5] == lapack[5] == -1


def test_both_eliminations_refuse_a_resonance() -> None:
    one, zero, load = np.eye(1), np.zeros((1, 1)), np.ones((3, 1))
    system = System(one, zero, zero, one, 0, 0.5, np.array([1, 2]), load, zero.repeat(3, axis=0))
    assert _by_kernel(system)[5] == _by_lapack(system)[5] == 1


@pytest.mark.parametrize("n", [1, 6])
def test_coordinates_solve_the_equation_of_motion(n: int) -> None:
    problem = random_problem(n, n, static=False, harmonics=2)
    condensed = condense(problem, 5)
    torque = np.arange(1.0, 1.0 + len(condensed.orders)) * (0.3 - 0.2j)
    found = condensed.coordinates(torque)
    force, power = problem.forcing.coefficients, 0.0
    for r, q, h in zip(condensed.orders, found.series, torque, strict=True):
        w = r * condensed.Omega
        left = (problem.K + 1j * w * (problem.C + problem.G) - w * w * problem.M) @ q
        left -= force[r] if r < len(force) else 0.0
        left[problem.joint] += h
        assert np.abs(left).max() < 1e-12 * np.abs(problem.K).max() * np.abs(q).max()
        power += 0.5 * (h * np.conj(1j * w * q[problem.joint])).real
    assert found.squares == pytest.approx(0.5 * np.sum(np.abs(found.series) ** 2, axis=0))
    assert found.power == pytest.approx(power)
    assert found.residual < 1e-12


def test_what_does_not_balance_shows() -> None:
    condensed = condense(random_problem(3, 4, static=False, harmonics=1), 3)
    unit = condensed.unit.copy()
    unit[-1, 0] *= 1.0 + 1e-4
    torque = np.full(len(condensed.orders), 1.0 + 0.0j)
    assert 1e-8 < replace(condensed, unit=unit).coordinates(torque).residual < 1e-2
    unit[-1, 0] = np.nan
    assert replace(condensed, unit=unit).coordinates(torque).residual == np.inf


def test_harmonics_of_instants_are_fourier_integrals() -> None:
    for images, edges, orders in (
        (1, np.array([0.3, 1.0, 2.5, 6.0]), np.arange(1, 6)),
        (2, np.array([0.4, 0.9, 2.2]), np.arange(1, 8, 2)),
    ):
        count, N = len(edges), 400_000
        tau = (np.arange(N) + 0.5) * 2.0 * np.pi / N
        turned = np.mod(tau, 2.0 * np.pi / images)
        h = (-1.0) ** np.searchsorted(edges, turned)
        if images == 2:
            h = np.where(tau > np.pi, -h, h)
        pairs = np.empty(2 * len(orders))
        table = np.empty((count, len(pairs)))
        _switching.torque_of(edges, count, 1.0, orders, images, table, pairs)
        expected = [2.0 * np.mean(h * np.exp(-1j * r * tau)) for r in orders]
        assert pairs[0::2] - 1j * pairs[1::2] == pytest.approx(np.array(expected), abs=1e-4)


@pytest.mark.parametrize("images", [1, 2])
def test_instants_are_read_from_cells_of_any_widths(images: int) -> None:
    for seed in range(20):
        draw = np.random.default_rng(seed)
        period, N = 2.0 * np.pi / images, 40
        inner = np.sort(draw.uniform(0.0, period, N - 1))
        bounds = np.concatenate([[0.0], inner, [period]])
        places = np.sort(draw.choice(np.arange(0, N - 1, 3), 6 + (images == 2), replace=False))
        instants = bounds[places] + draw.uniform(0.1, 0.9, len(places)) * np.diff(bounds)[places]
        h = (-1.0) ** np.searchsorted(instants, 0.5 * (bounds[1:] + bounds[:-1]))
        before = (-1.0) ** np.arange(len(places))
        share = (instants - bounds[places]) / np.diff(bounds)[places]
        h[places] = before * (2.0 * share - 1.0)  # the average of both sides
        edges = np.empty(2 * N + 2)
        weight = images * np.diff(bounds) / np.pi
        count, sign = _switching.of_cells(h, weight, images, edges)
        assert edges[:count] == pytest.approx(instants, abs=1e-12)
        assert sign == 1.0


def test_the_path_in_cells_is_complementary() -> None:
    problem = random_problem(4, 5, static=False, share=0.5, harmonics=2)
    condensed = condense(problem, 9)
    count = 2 * 2 * len(condensed.turns) + 1
    cells = uniform(9, condensed.half_wave, count * condensed.images)
    size = np.abs(condensed.velocity).max()
    free = np.conj(condensed.velocity / size).view(float)
    mobility = condensed.mobility * (problem.friction.Q_m / size)
    h, pivots = _switching.path(
        cells.table, cells.weight, condensed.images, mobility, free, 12 * count
    )
    assert 0 < pivots < 12 * count
    moved = cells.table.T @ (cells.weight * h)
    _kernels.apply_mobility(mobility, moved)
    y = cells.table @ (free - moved)
    sticking = np.abs(h) < 1.0
    assert np.abs(h).max() <= 1.0
    assert sticking.any()
    assert np.abs(y[sticking]).max() < 1e-9
    assert (y * h)[~sticking].min() > -1e-9


@pytest.mark.parametrize(("seed", "R"), [(20, 41), (96, 41), (100, 41), (1, 25)])
def test_a_long_path_gives_way_and_the_instants_still_settle(seed: int, R: int) -> None:
    problem = random_problem(seed, 4, static=False, share=0.85)
    condensed, Q_m = condense(problem, R), problem.friction.Q_m
    count = 4 * len(condensed.turns) * condensed.images + (2 - condensed.images)
    cells = uniform(int(condensed.turns[-1]), condensed.half_wave, count)
    _, mobility, free = _switching.scaled(condensed.mobility, condensed.velocity, Q_m)
    N = len(cells.table)
    _, pivots = _switching.path(cells.table, cells.weight, condensed.images, mobility, free, 2 * N)
    assert pivots == 2 * N
    found = set_valued.solve(condensed, Q_m, Settings())
    assert found.exact
    assert found.gap < 1e-9
    other = set_valued._in_cells(condensed, Q_m, Settings(tolerance=1e-7))
    assert np.abs(found.velocity - other.velocity).max() < 1e-3 * np.abs(found.velocity).max()


def test_misfit_is_what_numpy_finds() -> None:
    draw = np.random.default_rng(5)
    grid = uniform(4, False, 100, True).table
    x, bounds = draw.standard_normal(8), np.array([0.0, 1.0, 2.5, 2.0 * np.pi])
    levels = np.array([1.0, -1.0, 1.0])
    v = grid @ x
    tau = (np.arange(100) + 0.5) * 2.0 * np.pi / 100
    h = levels[np.searchsorted(bounds, tau, side="right") - 1]
    moving, missing = _kernels.misfit(grid, x, bounds, levels)
    assert moving == pytest.approx(np.abs(v).mean(), rel=1e-12)
    assert missing == pytest.approx(np.mean(np.abs(v) - h * v), rel=1e-12)
