"""The extension refuses what its C code could not survive."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from support.problems import random_problem

from beltsim import _event_map
from beltsim.event_map.flows import flows_of, inner_flow

WIDTH = 6


def arguments(capacity=50):
    """A valid call of `propagate`, as a dict that tests spoil."""
    problem = random_problem(7, n=3)
    flows, inner = flows_of(problem), inner_flow(problem)
    law = problem.friction
    reals = np.array([problem.forcing.Omega, law.Q_m, law.Q_s, 1e4, 0.0, law.Q_s, 0.0])
    return {
        "n": problem.n,
        "H": len(problem.forcing.cos) - 1,
        "m_free": flows.free.m,
        "m_held": inner.m,
        "saturated": 0,
        "free": flows.free.packed,
        "held": inner.packed,
        "reals": reals,
        "integers": np.array([problem.joint, 0, 0, 0, 0, 0], dtype=np.int64),
        "state": np.zeros(2 * problem.n),
        "event_integers": np.zeros((capacity, 3), dtype=np.int64),
        "event_reals": np.zeros((capacity, WIDTH + 2 * problem.n)),
        "capacity": capacity,
        "count": 0,
        "end_periods": 3,
        "end_time": 0.0,
    }


def call(**changes):
    return _event_map.propagate(*{**arguments(), **changes}.values())


def test_valid_call_and_full_buffer():
    status, count = call()
    assert status == 0
    assert count > 4
    few = arguments(capacity=2)
    assert _event_map.propagate(*few.values()) == (1, 2)


BUFFERS = ("free", "held", "reals", "integers", "state", "event_integers", "event_reals")
WRITTEN = BUFFERS[2:]


@pytest.mark.parametrize("name", BUFFERS)
def test_wrong_type_is_refused(name):
    array = arguments()[name]
    other = np.int32 if array.dtype == np.int64 else np.float32
    with pytest.raises(TypeError, match=f"{name}: format"):
        call(**{name: array.astype(other)})
    with pytest.raises(TypeError):
        call(**{name: array.tolist()})
    with pytest.raises(TypeError):
        call(**{name: None})


@pytest.mark.parametrize("name", BUFFERS)
def test_short_buffer_is_refused(name):
    array = arguments()[name]
    with pytest.raises(ValueError, match=f"{name}: .* items, must be at least"):
        call(**{name: array[:-1]})


@pytest.mark.parametrize("name", BUFFERS)
def test_strided_buffer_is_refused(name):
    array = arguments()[name]
    with pytest.raises((BufferError, ValueError)):
        call(**{name: np.repeat(array, 2, axis=-1)[..., ::2]})


@pytest.mark.parametrize("name", WRITTEN)
def test_read_only_buffer_is_refused(name):
    array = arguments()[name].copy()
    array.flags.writeable = False
    with pytest.raises((BufferError, ValueError)):
        call(**{name: array})


@pytest.mark.parametrize(
    ("name", "value"),
    [("n", 0), ("n", -1), ("n", 30000), ("H", -1), ("H", 10**6), ("m_free", 7), ("m_free", -2),
     ("m_held", 9), ("capacity", 0), ("capacity", 10**12), ("count", -1), ("count", 51)],
)  # fmt: skip
def test_sizes_out_of_range_are_refused(name, value):
    with pytest.raises((ValueError, OverflowError)):
        call(**{name: value})


def test_joint_and_frequency_out_of_range_are_refused():
    for joint in (-1, 3):
        integers = arguments()["integers"]
        integers[0] = joint
        with pytest.raises(ValueError, match="joint out of range"):
            call(integers=integers)
    for Omega in (0.0, -1.0, np.nan):
        reals = arguments()["reals"]
        reals[0] = Omega
        with pytest.raises(ValueError, match="Omega"):
            call(reals=reals)


def test_state_that_is_not_finite_ends_with_a_status():
    for value in (np.nan, np.inf):
        status, _ = call(state=np.full(6, value))
        assert status == -3


def test_too_many_events_end_with_a_status():
    reals = arguments()["reals"]
    reals[3] = 1.0
    status, _ = call(reals=reals, end_periods=50)
    assert status == -2


def test_threads_do_not_disturb_each_other():
    wanted = arguments(capacity=5000)
    wanted["end_periods"] = 200
    _event_map.propagate(*wanted.values())
    runs = []

    def work():
        mine = arguments(capacity=5000)
        mine["end_periods"] = 200
        _event_map.propagate(*mine.values())
        runs.append(mine["state"])

    threads = [threading.Thread(target=work) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(runs) == 6
    assert all(np.array_equal(state, wanted["state"]) for state in runs)
