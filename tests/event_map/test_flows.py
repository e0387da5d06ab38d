"""Flows in modes, made in C with SciPy's LAPACK, against NumPy on the same matrices."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from support.problems import random_problem

from beltsim import Coulomb, FrictionProblem, HarmonicForcing, SaturatedCoulomb
from beltsim.errors import CoreError
from beltsim.event_map.changes import amplitudes, changes_of
from beltsim.event_map.flows import Flow, flows_of, inner_flow
from beltsim.event_map.motion import fourier, sampled
from beltsim.event_map.status import require_ok
from beltsim.event_map.walk import walk


def relative(found, wanted):
    return np.abs(found - wanted).max(initial=0.0) / max(np.abs(wanted).max(initial=0.0), 1e-300)


@pytest.mark.parametrize("seed", range(12))
def test_modes_diagonalise_their_system(seed):
    problem = random_problem(seed, n=1 + seed % 7)
    for flow in (flows_of(problem).free, flows_of(problem).held):
        assert isinstance(flow, Flow)
        A, V, W, values = flow.part.A, flow.V, flow.W, flow.exponents
        assert relative(A @ V, V * values) < 1e-12
        assert relative((V @ W).real, np.eye(flow.N)) < 1e-12
        assert (values.imag >= 0.0).all()
        both = np.concatenate([values, values[values.imag > 0.0].conj()])
        wanted = np.linalg.eigvals(A)
        assert relative(np.sort_complex(both), np.sort_complex(wanted)) < 1e-11


@pytest.mark.parametrize("seed", range(12))
def test_forced_responses_solve_their_equations(seed):
    problem = random_problem(seed, n=1 + seed % 7)
    for flow in (flows_of(problem).free, flows_of(problem).held):
        part, k = flow.part, flow.N // 2
        for h, force in enumerate(part.F):
            w = h * part.Omega
            Z = part.K + 1j * w * part.damping - w**2 * part.M
            assert relative(flow.P[h, :k], np.linalg.solve(Z, force)) < 1e-11
            assert relative(flow.P[h, k:], 1j * w * flow.P[h, :k]) < 1e-15
        assert relative(part.K @ flow.X_c[:k], part.push) < 1e-11
        assert not flow.X_c[k:].any()


def test_the_condition_is_that_of_the_eigenvalues():
    """The largest 1/|cos| between left and right eigenvectors, in units of energy."""
    problem = random_problem(5, n=4)
    flow = flows_of(problem).free
    part = flow.part
    mass = np.diag(part.M)
    scale = np.sqrt(np.concatenate([np.maximum(np.diag(part.K), part.Omega**2 * mass), mass]))
    values, right = np.linalg.eig(part.A * scale[:, None] / scale)
    left = np.linalg.inv(right)
    wanted = np.linalg.norm(right, axis=0) * np.linalg.norm(left, axis=1)
    assert flow.condition == pytest.approx(wanted.max(), rel=1e-9)
    assert len(values) == 2 * flow.m


@pytest.mark.parametrize("law", ["coulomb", "saturated"])
@pytest.mark.parametrize("seed", range(6))
def test_changes_carry_states_between_the_flows(seed, law):
    problem = random_problem(seed, n=2 + seed % 4)
    n, j = problem.n, problem.joint
    if law == "saturated":
        problem = problem.with_friction(SaturatedCoulomb(problem.friction.Q_m, 0.1))
    flows, inner, (into, out) = flows_of(problem), inner_flow(problem), amplitudes(problem)
    N, Nh = 2 * n, inner.N
    assert relative(into @ out, np.eye(N)) < 1e-12
    sizes = [N * N, N * N, Nh * N, N * Nh, N, N, N, Nh, N, N, Nh]
    parts = np.split(changes_of(problem), np.cumsum(sizes))
    stick, release = parts[2].reshape(Nh, N), parts[3].reshape(N, Nh)
    x = np.random.default_rng(seed).standard_normal(N)
    if law == "saturated":
        assert relative(release @ (stick @ (into @ x)), into @ x) < 1e-11
        return
    x[n + j] = 0.0  # held at its place and let go again, nothing is lost
    place, position = parts[4], parts[6]
    again = release @ (stick @ (into @ x)) + position * (place @ (into @ x))
    assert place @ (into @ x) == pytest.approx(x[j], abs=1e-11)
    assert relative(out @ again, x) < 1e-10
    push, mass = parts[8], parts[11][1]
    unit = np.eye(n)[j]
    assert relative(out @ push, np.concatenate([0.0 * unit, np.linalg.solve(problem.M, unit)])) < (
        1e-10
    )
    assert mass == pytest.approx(1.0 / np.linalg.inv(problem.M)[j, j], rel=1e-10)
    assert flows.mass == mass


@pytest.mark.parametrize("law", ["coulomb", "static", "saturated"])
def test_fourier_integrals_are_those_of_the_samples(law):
    """Gauss points within each phase, so that kinks do not matter."""
    problem = random_problem(11, n=3, static=law == "static")
    if law == "saturated":
        problem = problem.with_friction(SaturatedCoulomb(problem.friction.Q_m, 0.05))
    run = walk(problem, np.zeros(6), 1.0)
    coefficients, torque = fourier(problem, run, run.end, 9)
    edges = np.concatenate([[0.0], run.t, [run.end]])
    points, weights = np.polynomial.legendre.leggauss(60)
    assert len(run.t) > 1
    total = np.zeros((10, 4), complex)
    for a, b in pairwise(edges):
        t = a + 0.5 * (points + 1.0) * (b - a)
        q, _, h = sampled(problem, run, t)
        turns = np.exp(-1j * problem.forcing.Omega * np.outer(np.arange(10), t))
        total += (turns * weights * 0.5 * (b - a)) @ np.column_stack([q, h])
    total *= 2.0 / problem.period
    total[0] *= 0.5
    assert relative(coefficients, total[:, :3]) < 1e-12
    assert relative(torque, total[:, 3]) < 1e-12


def test_samples_at_events_and_ends_are_the_states_there():
    """Every phase owns its start, the last one its end too, whatever the rounding of the times."""
    for seed in range(60):
        problem = random_problem(seed, n=1 + seed % 3)
        run = walk(problem, np.zeros(2 * problem.n), 1.0 + 0.37 * (seed % 5))
        t = np.concatenate([[0.0], run.t, [run.end]])
        q, q_dot, _ = sampled(problem, run, t)
        x = np.column_stack([q, q_dot])
        gaps = x - np.vstack([run.states(), run.final_state])
        assert np.abs(gaps).max() <= 1e-12 * np.abs(x).max()


def test_a_failed_call_names_its_reason():
    require_ok(0)
    with pytest.raises(CoreError, match="no eigenvalues") as error:
        require_ok(-4)
    assert error.value.status == "BM_NO_MODES"


def test_one_mass_held_has_no_modes():
    push = HarmonicForcing(1.0, [[0.0], [1.0]], [[0.0], [0.0]])
    one = FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[4.0]], 0, push, Coulomb(0.2))
    held = flows_of(one).held
    assert (held.m, held.N, held.condition) == (0, 0, 1.0)
