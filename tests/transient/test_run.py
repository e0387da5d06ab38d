"""What `integrate` returns: samples, ends, figures, warnings, partial results."""

import os
import signal
import subprocess
import sys
import threading
import time
from itertools import pairwise

import numpy as np
import pytest
from support.problems import random_problem, random_state

from beltsim import Coulomb, FrictionProblem, HarmonicForcing, Observable, SaturatedCoulomb
from beltsim.errors import CoreError, InvalidProblemError
from beltsim.response import friction_travel
from beltsim.transient import Settings, integrate, solve_many
from beltsim.transient.driver import Driver, GrowingTable

METHODS = ("adams", "bdf", "taylor")


DRY = Coulomb(0.5)


def one_mass(friction=DRY, f=1.0, Omega=1.0, c=0.1, **more):
    forcing = HarmonicForcing(Omega, cos=[[0.0], [f]], sin=[[0.0], [0.0]])
    return FrictionProblem([[1.0]], [[c]], [[0.0]], [[4.0]], 0, forcing, friction, **more)


def linear(n=3, seed=1):
    return random_problem(seed, n).freed()


@pytest.mark.parametrize("method", METHODS)
def test_a_linear_problem_reaches_its_harmonic_response(method):
    problem = linear(seed=6)
    problem = FrictionProblem(
        problem.M, 0.2 * problem.M, problem.G, problem.K, None, problem.forcing, None
    )
    w = problem.forcing.Omega
    run = integrate(problem, 60.0, settings=Settings(method=method, rtol=1e-10))
    q = np.zeros(problem.n)
    for k, force in enumerate(problem.forcing.coefficients):
        D = problem.K + 1j * k * w * (problem.C + problem.G) - (k * w) ** 2 * problem.M
        q += np.real(np.linalg.solve(D, force))  # the run ends at a whole period
    np.testing.assert_allclose(run.final_state[: problem.n], q, atol=1e-8 * np.abs(q).max())
    assert run.initial_mode is None
    assert len(run.events) == 0
    assert run.periodic
    assert run.total_dissipated_energy == 0.0
    assert run.energy_balance_residual < 1e-8
    assert not run.friction_torque.any()


def test_the_last_period_is_sampled_at_both_ends():
    run = integrate(one_mass(), 7.25, settings=Settings(samples_per_period=40))
    period = run.problem.period
    assert len(run.t) == 41
    assert run.t[-1] == 7.25 * period
    assert run.t[0] == pytest.approx(6.25 * period, rel=1e-14)
    assert run.window == (run.t[0], run.t[-1])
    assert np.array_equal(run.q[-1], run.final_state[:1])
    assert np.array_equal(run.q_dot[-1], run.final_state[1:])


def test_all_samples_run_from_zero_to_the_end():
    run = integrate(one_mass(), 2.5, [0.3, 0.1], Settings(samples_per_period=40, keep="all"))
    assert len(run.t) == 101
    assert run.t[0] == 0.0
    assert run.q[0, 0] == 0.3
    assert run.q_dot[0, 0] == 0.1
    assert run.t[-1] == 2.5 * run.problem.period
    assert run.window[0] == pytest.approx(1.5 * run.problem.period)


def test_a_run_shorter_than_a_period_is_judged_whole():
    run = integrate(one_mass(), 0.4)
    assert run.window == (0.0, 0.4 * run.problem.period)
    assert run.period_residual is None
    assert not run.periodic
    assert run.energy_balance_residual < 1e-7


def test_events_alone_take_no_samples():
    run = integrate(one_mass(), 20.0, settings=Settings(keep="events", event_states=False))
    whole = integrate(one_mass(), 20.0)
    assert len(run.t) == len(run.q) == len(run.friction_torque) == 0
    assert run.events.q.shape == (len(run.events), 0)
    assert np.array_equal(run.events.t, whole.events.t)
    assert np.array_equal(run.events.position, whole.events.q[:, 0])
    assert np.array_equal(run.final_state, whole.final_state)
    for name in ("stick_fraction", "dissipated_energy", "stops_per_period", "period_residual"):
        assert getattr(run, name) == getattr(whole, name)


def test_samples_do_not_change_the_motion():
    few, many = (
        integrate(one_mass(), 12.0, settings=Settings(samples_per_period=n)) for n in (3, 5000)
    )
    assert few.statistics["steps"] == many.statistics["steps"]
    assert np.array_equal(few.events.t, many.events.t)
    assert np.array_equal(few.final_state, many.final_state)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", [2, 3, 11])
def test_the_energy_balance_closes(method, seed):
    problem = random_problem(seed, 5)
    state = random_state(seed, problem)
    run = integrate(problem, 8.3, state, Settings(method=method, rtol=1e-10))
    assert run.energy_balance_residual < 2e-8
    assert run.total_dissipated_energy == pytest.approx(
        problem.friction.Q_m
        * friction_travel(
            run.events,
            run.initial_mode,
            0.0,
            8.3 * problem.period,
            (state[problem.joint], run.final_state[problem.joint]),
        )
    )


def test_the_torque_follows_the_mode():
    run = integrate(one_mass(), 30.0, settings=Settings(keep="all"))
    assert np.abs(run.friction_torque).max() <= 0.5
    modes = [run.initial_mode, *run.events.modes_after(run.initial_mode)]
    index = np.searchsorted(run.events.t, run.t)
    for t_index in range(0, len(run.t), 37):
        mode = modes[index[t_index]]
        if mode == "stick":
            held = np.cos(run.t[t_index]) - 4.0 * run.q[t_index, 0]
            assert run.friction_torque[t_index] == pytest.approx(held, abs=1e-9)
            assert run.q_dot[t_index, 0] == 0.0
        else:
            assert run.friction_torque[t_index] == (0.5 if mode == "slip+" else -0.5)


def test_events_hold_exact_zeros_and_are_in_order():
    problem = random_problem(7, 24)
    run = integrate(problem, 20.0)
    assert len(run.events) > 10
    assert not run.events.q_dot[:, problem.joint].any()
    assert np.all(np.diff(run.events.t) > 0.0)
    assert np.array_equal(run.events.position, run.events.q[:, problem.joint])
    law = problem.friction
    leaves = np.char.startswith(run.events.kind, "slip")
    assert np.all(np.abs(run.events.torque_before[leaves]) == law.Q_s)
    assert np.all(np.abs(run.events.torque_after[leaves]) == law.Q_m)
    assert np.all(np.abs(run.events.torque_after[run.events.kind == "stick"]) <= law.Q_s)
    assert np.all(run.events.margin >= 0.0)
    assert np.all(run.events.margin[~leaves] <= 1.0)


def test_progress_is_told_and_ends_at_one():
    seen = []
    integrate(random_problem(3, 30), 40.0, progress=seen.append)
    assert len(seen) >= 2
    assert seen[-1] == 1.0
    assert all(0.0 <= a <= b <= 1.0 for a, b in pairwise(seen))


def test_crossed_limits_become_warnings():
    watched = [
        Observable("tension", [1.0], [1.0, 0.0], [0.0, 0.0], lower=0.9, scale=300.0, unit="N"),
        Observable("angle", [1.0], [0.0, 0.0], [0.0, 0.0], upper=0.2),
        Observable("quiet", [1.0], [0.0, 0.0], [0.0, 0.0], lower=-9.0, upper=9.0),
    ]
    problem = one_mass(observables=watched, warnings=("from upstream",))
    run = integrate(problem, 20.0)
    assert run.warnings[0] == "from upstream"
    q = run.q[:, 0]
    low, high = 300.0 * (1.0 + q.min()), q.max()
    assert run.warnings[1] == (
        f"tension falls below 270 N 1 time in the last period, lowest {low:.6g} N"
    )
    assert run.warnings[2].startswith("angle exceeds 0.2 ")
    assert run.warnings[2].endswith(f"highest {high:.6g}")
    assert len(run.warnings) == 3


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"problem": 3}, "problem"),
        ({"periods": 0.0}, "periods"),
        ({"periods": -1.0}, "periods"),
        ({"periods": np.inf}, "periods"),
        ({"periods": True}, "periods"),
        ({"periods": "10"}, "periods"),
        ({"initial_state": [1.0]}, "initial_state"),
        ({"initial_state": [np.nan, 0.0]}, "initial_state"),
        ({"initial_state": [[0.0, 0.0]]}, "initial_state"),
        ({"initial_state": "rest"}, "initial_state"),
        ({"settings": {"rtol": 1e-8}}, "settings"),
        ({"settings": Settings(keep="all", samples_per_period=10**12)}, "settings"),
    ],
)
def test_bad_arguments_are_named(arguments, field):
    given = {"problem": one_mass(), "periods": 3.0} | arguments
    with pytest.raises(InvalidProblemError, match=f"^{field}"):
        integrate(**given)


def test_a_problem_without_coordinates_is_refused():
    with pytest.raises(InvalidProblemError, match=r"problem\.n = 0: must be at least 1"):
        integrate(one_mass().locked(), 3.0)


@pytest.mark.parametrize(
    ("settings", "status"),
    [
        (Settings(max_steps=500), "BS_TOO_MANY_STEPS"),
        (Settings(max_events=7), "BS_TOO_MANY_EVENTS"),
        (Settings(max_seconds=1e-3), "BS_OUT_OF_TIME"),
    ],
)
def test_a_budget_stops_the_run_with_what_it_has(settings, status):
    with pytest.raises(CoreError, match=status) as caught:
        integrate(one_mass(), 1e5, settings=settings)
    error = caught.value
    assert error.status == status
    assert error.mode in {"slip+", "slip-", "stick"}
    part = error.partial
    assert error.time == part.window[1] > 0.0
    assert error.last_event == (part.events.t[-1], part.events.kind[-1])
    assert f"last event {part.events.kind[-1]}" in str(error)
    assert np.isnan(part.energy_balance_residual)
    assert np.all(np.isfinite(part.final_state))
    assert part.total_dissipated_energy > 0.0
    if status == "BS_TOO_MANY_EVENTS":
        assert len(part.events) == 7


def test_a_partial_response_agrees_with_the_whole_one():
    with pytest.raises(CoreError) as caught:
        integrate(one_mass(), 50.0, settings=Settings(keep="all", max_steps=900))
    part = caught.value.partial
    whole = integrate(one_mass(), 50.0, settings=Settings(keep="all"))
    n, m = len(part.events), len(part.t)
    assert 0 < n < len(whole.events)
    assert 0 < m < len(whole.t)
    assert np.array_equal(part.events.t, whole.events.t[:n])
    assert np.array_equal(part.q, whole.q[:m])


def look_often(monkeypatch, seconds):
    monkeypatch.setattr("beltsim.transient.driver.SLICE_SECONDS", seconds)
    monkeypatch.setattr("beltsim.transient.driver.FIRST_LOOK_SECONDS", 0.0)
    monkeypatch.setattr("beltsim.transient.driver.LOOK_SECONDS", 0.0)


def test_samples_of_a_run_that_stops_early_are_those_of_its_motion(monkeypatch):
    """Taken on the way; without a hole, since slices are shorter than what is kept."""
    look_often(monkeypatch, 1e-5)
    with pytest.raises(CoreError) as caught:
        integrate(one_mass(), 1e4, settings=Settings(max_steps=20_000))
    part, T = caught.value.partial, one_mass().period
    assert part.statistics["complete"] == 0
    assert 100 < len(part.t) <= Settings().samples_per_period + 1
    assert part.t[-1] <= part.window[1]
    assert part.window[1] - part.t[-1] < 0.02 * T
    np.testing.assert_allclose(np.diff(part.t), np.diff(part.t)[0], rtol=1e-6)
    periods = int(part.window[1] / T)
    whole = integrate(one_mass(), float(periods), settings=Settings(keep="all"))
    at = [np.interp(part.t[part.t < periods * T], whole.t, row) for row in whole.q.T]
    np.testing.assert_allclose(part.q[part.t < periods * T].T, at, atol=1e-4)


def test_a_stretch_is_sampled_ahead_but_never_into_the_last_one():
    """Far behind the last stretch a new one begins; close behind, half of it is kept; near the end
    only what is left is taken."""
    driver = Driver(one_mass(), Settings(), np.zeros(2), 100.0, 90.0, np.linspace(90.0, 100.0, 11))
    rec = driver.recording
    assert rec.look_ahead(20.0)
    np.testing.assert_allclose(rec.sample_t[:11], np.arange(21.0, 32.0))
    assert not rec.look_ahead(25.0)  # the stretch is not complete
    rec.counts[0] = 11
    assert rec.look_ahead(31.5)
    np.testing.assert_allclose(rec.sample_t[:11], np.arange(27.0, 38.0))
    assert rec.sampled(False) == slice(0, 5)
    rec.counts[0] = 11
    assert rec.look_ahead(85.0)
    assert rec.sampled(False) == slice(7, 7)
    np.testing.assert_allclose(rec.sample_t[7:12], np.arange(86.0, 91.0))
    rec.counts[0] = 11
    assert not rec.look_ahead(89.5)
    assert rec.sampled(False) == slice(7, 11)
    assert rec.sampled(True) == slice(11, 11)


def test_samples_on_the_way_change_nothing(monkeypatch):
    """Slices so short that the last period begins within one of them, or between two."""
    whole = integrate(one_mass(), 20.3)
    look_often(monkeypatch, 1e-5)
    sliced = integrate(one_mass(), 20.3)
    assert np.array_equal(whole.t, sliced.t)
    assert np.array_equal(whole.q, sliced.q)
    assert whole.statistics["complete"] == 1


def test_a_motion_that_grows_without_bound_is_an_error():
    rest = HarmonicForcing(1.0, cos=[[0.0]], sin=[[0.0]])
    runaway = FrictionProblem([[1.0]], [[0.0]], [[0.0]], [[-100.0]], None, rest, None)
    for method in METHODS:
        with pytest.raises(CoreError, match="BS_NOT_FINITE"):
            integrate(runaway, 1e4, [1.0, 0.0], Settings(method=method))


@pytest.mark.parametrize(
    ("fault", "status", "text"),
    [
        ((-3, 900, 0, 0), "BS_ERROR_TEST", "SUNDIALS -3: injected code -3"),
        ((-20, 900, 0, 0), "BS_NO_MEMORY", "SUNDIALS -20"),
        ((0, 0, 900, 0), "BS_NOT_FINITE", "no longer finite"),
        ((0, 0, 0, 300), "BS_NOT_FINITE", "no longer finite"),
    ],
)
def test_a_fault_in_the_core_is_an_error_with_time_mode_and_last_event(fault, status, text):
    problem = one_mass()
    sample_t = np.linspace(0.0, 1.0, 3)
    driver = Driver(problem, Settings(), np.zeros(2), 100.0, 90.0, sample_t)
    driver.core.inject(*fault)
    with pytest.raises(CoreError, match=text) as caught:
        driver.run(None)
    error = caught.value
    assert error.status == status
    assert 0.0 < error.time < 100.0
    assert error.mode in {"slip+", "slip-", "stick"}
    assert error.last_event is not None
    assert error.last_event[0] <= error.time
    # SUNDIALS 7 adds words of its own to what the core noticed first, SUNDIALS 6 does not
    assert error.solver_text or fault[0] == 0


INTERRUPTED = """
import sys, time
sys.path.insert(0, "tests")
from support.problems import random_problem
from beltsim.transient import Settings, integrate
print("ready", flush=True)
try:
    integrate(random_problem(3, 30), 1e7, settings=Settings(keep="events", method=sys.argv[1]))
except KeyboardInterrupt as stop:
    part = stop.partial
    print(len(part.events), part.window[1], flush=True)
    again = integrate(random_problem(1, 2), 3.0)
    print("usable", len(again.t), flush=True)
"""


@pytest.mark.parametrize("method", ["adams", "taylor"])
def test_ctrl_c_returns_within_a_second_with_what_there_is(method):
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED, method], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.7)
    sent = time.monotonic()
    process.send_signal(signal.SIGINT)
    stuck = threading.Timer(60.0, process.kill)  # or the next line would be waited for in vain
    stuck.start()
    events, reached = process.stdout.readline().split()
    stuck.cancel()
    assert time.monotonic() - sent < 1.0
    assert int(events) > 0
    assert float(reached) > 0.0
    assert process.stdout.readline() == "usable 501\n"
    assert process.wait(10) == 0
    process.stdout.close()


MANY_INTERRUPTED = """
import sys
sys.path.insert(0, "tests")
from support.problems import random_problem
from beltsim.transient import Settings, solve_many
print("ready", flush=True)
try:
    problems = [random_problem(seed, 30) for seed in range(6)]
    solve_many(problems, Settings(keep="events"), 2, periods=1e7)
except KeyboardInterrupt:
    print("stopped", flush=True)
"""


def test_ctrl_c_stops_all_runs_of_a_grid():
    process = subprocess.Popen(
        [sys.executable, "-c", MANY_INTERRUPTED], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.7)
    process.send_signal(signal.SIGINT)
    stuck = threading.Timer(30.0, process.kill)
    stuck.start()
    assert process.stdout.readline() == "stopped\n"
    assert process.wait(30) == 0
    stuck.cancel()
    process.stdout.close()


def test_the_same_bits_again_and_on_any_number_of_threads():
    problems = [random_problem(seed) for seed in range(8)]
    alone = [integrate(problem, 6.0) for problem in problems]
    for workers in (1, 2, 5):
        for one, other in zip(
            alone, solve_many(problems, workers=workers, periods=6.0), strict=True
        ):
            assert np.array_equal(one.final_state, other.final_state)
            assert np.array_equal(one.events.t, other.events.t)
            assert np.array_equal(one.q, other.q)


def test_solve_many_keeps_failures_in_their_place():
    settings = Settings(max_events=3)
    runs = solve_many([one_mass(Coulomb(9.0)), one_mass(), one_mass(Coulomb(9.0))], settings)
    assert [isinstance(run, CoreError) for run in runs] == [False, True, False]
    assert runs[1].partial is not None


@pytest.mark.parametrize("workers", [0, -1, True, 2.5, "2"])
def test_a_bad_number_of_workers_is_named(workers):
    with pytest.raises(InvalidProblemError, match=r"^workers"):
        solve_many([one_mass()], workers=workers)


def test_two_runs_share_no_state_across_threads():
    results = {}

    def work(name, problem):
        results[name] = integrate(problem, 20.0)

    pair = {"a": random_problem(3, 12), "b": random_problem(4, 12)}
    threads = [threading.Thread(target=work, args=item) for item in pair.items()]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for name, problem in pair.items():
        assert np.array_equal(results[name].final_state, integrate(problem, 20.0).final_state)


def test_events_beyond_the_buffer_are_all_kept():
    run = integrate(one_mass(Coulomb(0.02)), 700.0, settings=Settings(method="taylor"))
    assert len(run.events) > 1200  # the shared buffer holds 512
    assert np.all(np.diff(run.events.t) > 0.0)


def test_a_long_run_of_events_takes_less_than_a_kilobyte_each():
    problem = random_problem(3, 27)
    settings = Settings(keep="events", method="taylor")
    run = integrate(problem, 300.0, settings=settings)
    log = run.events
    arrays = [getattr(log, name) for name in log.__dataclass_fields__]
    assert len(log) > 300
    assert sum(array.nbytes for array in arrays) < 1000 * len(log)


def test_the_growing_table_keeps_everything():
    table = GrowingTable(2, np.float64)
    blocks = [np.full((k, 2), float(k)) for k in range(1, 60)]
    for block in blocks:
        table.append(block)
    assert np.array_equal(table.rows, np.concatenate(blocks))


def test_a_missing_core_is_one_clear_error(monkeypatch):
    monkeypatch.setitem(sys.modules, "beltsim._core", None)
    import beltsim

    monkeypatch.delattr(beltsim, "_core", raising=False)
    with pytest.raises(CoreError, match="libsundials-dev") as caught:
        integrate(one_mass(), 1.0)
    assert caught.value.status == "BS_NOT_BUILT"


def test_saturated_runs_tell_when_the_band_is_narrow_or_wide():
    narrow = integrate(one_mass(SaturatedCoulomb(0.2, 1e-6)), 3.0, settings=Settings(rtol=1e-6))
    assert any("narrow against the velocity error" in text for text in narrow.warnings)
    wide = integrate(one_mass(SaturatedCoulomb(0.2, 0.5)), 3.0)
    assert any("is wide against" in text for text in wide.warnings)
    sound = integrate(one_mass(SaturatedCoulomb(0.2, 1e-3)), 3.0)
    assert not any("band" in text for text in sound.warnings)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs POSIX")
def test_importing_beltsim_loads_no_core():
    code = "import sys, beltsim; sys.exit('beltsim._core' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_solve_many_refuses_once_what_would_spoil_every_run():
    pair = [one_mass(), one_mass()]
    with pytest.raises(InvalidProblemError, match=r"periods = -1: must be") as caught:
        solve_many(pair, settings="fast", workers=0, periods=-1)
    assert [m.field for m in caught.value.mistakes] == ["settings", "periods", "workers"]
    with pytest.raises(InvalidProblemError, match=r"problems = .*a sequence of FrictionProblem"):
        solve_many(one_mass())
