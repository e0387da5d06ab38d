"""The exact reference against closed forms and an independent integrator.

Every other reference test trusts `support.exact`; this file is why.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.exact import exact_transient, first_root
from support.problems import critical_torque, random_problem, random_state

from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem


def one_mass(m, k, friction, Omega=1.0, cos=(0.0,), sin=None):
    cos = np.array(cos, float)[:, None]
    sin = np.zeros_like(cos) if sin is None else np.array(sin, float)[:, None]
    return FrictionProblem(
        [[m]], [[0.0]], [[0.0]], [[k]], 0, HarmonicForcing(Omega, cos, sin), friction
    )


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("Q_s", [0.3, 0.5])
def test_free_coulomb_decay(sign, Q_s):
    """Extremes shrink by 2 Q/k per half cycle, every pi/w, until k |x| <= Q_s."""
    m, k, Q, x0 = 1.7, 4.3, 0.3, 1.234
    run = exact_transient(one_mass(m, k, Coulomb(Q, Q_s)), 3.0, [sign * x0, 0.0])
    half = np.pi * np.sqrt(m / k)
    extremes = x0 - 2.0 * Q / k * np.arange(1, 20)
    stop = int(np.argmax(k * np.abs(extremes) <= Q_s)) + 1
    assert run.initial_mode == ("slip-" if sign > 0 else "slip+")
    assert run.kind == ["reverse"] * (stop - 1) + ["stick"]
    assert np.allclose(run.t, half * np.arange(1, stop + 1), rtol=1e-14)
    expected = sign * extremes[:stop] * (-1.0) ** np.arange(1, stop + 1)
    assert np.allclose(run.q[:, 0], expected, rtol=0, atol=1e-14)
    assert run.final_state[0] == run.q[-1, 0]
    assert run.final_state[1] == 0.0
    assert run.torque_after[-1] == pytest.approx(-k * run.q[-1, 0], rel=1e-14)


@pytest.mark.parametrize("beta", [0.8, 1.25, 1.6])
def test_den_hartog_without_stops(beta):
    """Den Hartog's symmetric motion without stops repeats itself, turning at -+x_0 at pi j/w."""
    m, k, P, Q = 2.0, 3.0, 1.0, 0.25
    w = beta * np.sqrt(k / m)
    V = 1.0 / (1.0 - beta**2)
    U = np.sin(np.pi / beta) / (beta * (1.0 + np.cos(np.pi / beta)))
    cos_phi = np.sqrt(1.0 - (U * Q / (P * V)) ** 2) * np.sign(V)
    sin_phi = -U * Q / (P * V)
    x0 = P / k * V * cos_phi
    problem = one_mass(m, k, Coulomb(Q), w, [0.0, P * cos_phi], [0.0, -P * sin_phi])
    run = exact_transient(problem, 5.25, [x0, 0.0])
    turns = np.arange(1, 11)
    assert run.kind == ["reverse"] * 10
    assert np.allclose(run.t, turns * np.pi / w, rtol=1e-13)
    assert np.allclose(run.q[:, 0], x0 * (-1.0) ** turns, rtol=1e-13)


def dop853(problem, periods, state):
    """Events and end state by DOP853 with restarts, written from the law alone."""
    M, B, K, j, n = problem.M, problem.C + problem.G, problem.K, problem.joint, problem.n
    q_m, q_s, forcing = problem.friction.Q_m, problem.friction.Q_s, problem.forcing
    keep = np.delete(np.arange(n), j)
    end = periods * forcing.period

    def held(t, x):
        load = forcing.at(t) - B @ x[n:] - K @ x[:n]
        a = np.zeros(n)
        a[keep] = np.linalg.solve(M[np.ix_(keep, keep)], load[keep])
        return a, load[j] - M[j] @ a

    def slip(t, x, sign):
        load = forcing.at(t) - B @ x[n:] - K @ x[:n]
        load[j] -= sign * q_m
        return np.concatenate([x[n:], np.linalg.solve(M, load)])

    def stick(t, x, _):
        return np.concatenate([x[n:], held(t, x)[0]])

    def watch(function, direction):
        function.terminal, function.direction = True, direction
        return function

    x, t, events = np.array(state, float), 0.0, []
    sign = np.sign(x[n + j])
    if sign == 0.0 and abs(held(t, x)[1]) > q_s:
        sign = np.sign(held(t, x)[1])
    while True:
        if sign:
            rule, crossings = slip, [watch(lambda _, y, __: y[n + j], -sign)]
        else:
            crossings = [
                watch(lambda s, y, _: held(s, y)[1] - q_s, 1.0),
                watch(lambda s, y, _: held(s, y)[1] + q_s, -1.0),
            ]
            rule = stick
        found = solve_ivp(
            rule,
            (t, end),
            x,
            "DOP853",
            args=(sign,),
            events=crossings,
            rtol=1e-12,
            atol=1e-14,
            max_step=forcing.period / 300.0,
            first_step=1e-5,
        )
        t, x = found.t[-1], found.y[:, -1].copy()
        if found.status != 1:
            return events, x
        x[n + j] = 0.0
        H = held(t, x)[1]
        if sign == 0.0:
            sign = np.sign(H)
            kind = "slip+" if sign > 0 else "slip-"
        elif abs(H) <= q_s:
            sign, kind = 0.0, "stick"
        else:
            sign, kind = -sign, "reverse"
        events.append((t, kind))


@pytest.mark.parametrize(("seed", "n"), [(3, 1), (8, 2), (9, 4), (6, 9)])
def test_against_dop853_with_restarts(seed, n):
    problem = random_problem(seed, n, static=bool(seed % 2))
    state = random_state(seed, problem)
    run = exact_transient(problem, 3.0, state)
    events, final = dop853(problem, 3.0, state)
    assert run.min_margin > 1e-3, "choose another seed"
    assert run.kind == [kind for _, kind in events]
    assert len(events) >= 6
    assert np.allclose(run.t, [t for t, _ in events], rtol=0, atol=1e-9 * problem.period)
    assert np.abs(run.final_state - final).max() <= 1e-9 * np.abs(final).max()


@pytest.mark.parametrize("gap", [1e-2, 1e-6, 1e-10, 1e-14])
def test_first_root_finds_close_pairs(gap):
    """Two roots at 0.3 -+ sqrt(gap) inside one cell have equal signs at both ends."""
    pair = np.array([0.09 - gap, -0.6, 1.0])
    assert first_root(pair) == pytest.approx(0.3 - np.sqrt(gap), abs=1e-8)
    assert first_root(pair + np.array([2.0 * gap, 0.0, 0.0])) is None


def test_states_between_events_lie_on_the_same_run():
    """States asked for afterwards equal those of a run that ends there."""
    problem = random_problem(11, 7)
    run = exact_transient(problem, 6.0)
    times = np.array([0.0, 0.9, 2.3, 5.99]) * problem.period
    for t, state in zip(times[1:], run.states(times)[1:], strict=True):
        shorter = exact_transient(problem, t / problem.period)
        assert np.allclose(state, shorter.final_state, rtol=0, atol=1e-12 * np.abs(state).max())


def test_locked_for_ever_has_no_event():
    """On the locked steady motion, with Q_m a tenth above the critical torque."""
    problem = random_problem(3, 6, share=1.1, static=False, harmonics=1)
    assert not problem.forcing.cos[0].any()
    keep, w = problem.others, problem.forcing.Omega
    D = problem.K + 1j * w * (problem.C + problem.G) - w**2 * problem.M
    f = problem.forcing.cos[1] - 1j * problem.forcing.sin[1]
    held = np.zeros(6, complex)
    held[keep] = np.linalg.solve(D[np.ix_(keep, keep)], f[keep])
    run = exact_transient(problem, 50.0, np.concatenate([held.real, (1j * w * held).real]))
    assert run.kind == []
    assert run.initial_mode == run.final_mode == "stick"
    assert run.touch_margin.min() == pytest.approx(0.1 / 1.1, rel=1e-6)
    assert np.allclose(run.final_state[:6], held.real, rtol=0, atol=1e-12 * np.abs(held).max())


def test_recipe_is_deterministic_and_holds_its_ranges():
    for seed in range(20):
        problem, again = random_problem(seed), random_problem(seed)
        assert np.array_equal(problem.K, again.K)
        assert problem.friction == again.friction
        assert 1 <= problem.n <= 30
        assert 1 <= problem.forcing.n_harmonics <= 5
        share = problem.friction.Q_m / critical_torque(problem)
        assert 0.02 <= share <= 1.1
        assert problem.friction.Q_s >= problem.friction.Q_m
        assert np.linalg.eigvalsh(problem.C)[0] > -1e-12
