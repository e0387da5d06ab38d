"""The extension refuses what its C code could not survive."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from support.problems import random_problem

from beltsim import _event_map
from beltsim.event_map import binding
from beltsim.event_map.changes import changes_of
from beltsim.event_map.flows import flows_of, inner_flow
from beltsim.event_map.motion import phases_of
from beltsim.event_map.walk import walk

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


def orbit_arguments():
    """A valid call of `orbit`."""
    problem, shared = random_problem(7, n=3), arguments()
    names = ("n", "H", "m_free", "m_held", "saturated")
    names += ("free", "held", "reals", "integers", "state")
    return {name: shared[name] for name in names} | {
        "changes": changes_of(problem),
        "search": np.array([1.0, 1.0, 1e-12, 0.0, 0.0, 0.0]),
        "history": np.zeros(20),
        "image": np.zeros(6),
        "derivative": np.zeros((6, 6)),
        "multipliers": np.zeros(12),
        "event_integers": np.zeros((9, 3), dtype=np.int64),
        "event_reals": np.zeros((9, WIDTH + 6)),
        "history_capacity": 20,
        "event_capacity": 9,
    }


def modes_arguments():
    """A valid call of `modes`."""
    part = flows_of(random_problem(7, n=3)).free.part
    H = len(part.F) - 1
    return {
        "k": 3,
        "H": H,
        "Omega": part.Omega,
        "M": part.M.copy(),
        "D": part.damping,
        "K": part.K.copy(),
        "F": binding.pairs(part.F),
        "load": part.push,
        "row": part.row,
        "direct": binding.pairs(part.D),
        "d_c": 0.0,
        "packed": np.zeros(_event_map.flow_reals(6, 6, H)[1]),
    }


def changes_arguments():
    """A valid call of `changes`."""
    problem, shared = random_problem(7, n=3), arguments()
    flows = flows_of(problem)
    return {name: shared[name] for name in ("n", "H", "m_free", "m_held", "saturated")} | {
        "Omega": flows.free.Omega,
        "free": shared["free"],
        "held": shared["held"],
        "joint": problem.joint,
        "mass": flows.mass,
        "m_t": flows.m_t,
        "push": flows.push,
        "packed": np.zeros_like(changes_of(problem)),
    }


def phases_arguments():
    """The phases of one flow of a walk, and with them valid calls of what looks at them."""
    problem = random_problem(7, n=3)
    flow, run = flows_of(problem).free, walk(problem, np.zeros(6), 3.0)
    assert len(run.t) > 2
    names = ("n", "H", "m", "role", "joint", "Omega", "Q_m", "slope", "flow", "start", "end")
    names += ("length", "first_mode", "event_integers", "event_reals", "count", "state")
    return dict(zip(names, phases_of(problem, run, 0, flow, 0.0, run.end), strict=True))


def integrals_arguments():
    problem = random_problem(7, n=3)
    power = {"F": binding.pairs(problem.forcing.coefficients), "C": problem.C.copy()}
    return phases_arguments() | power | {"squares": np.zeros(3), "sums": np.zeros(4)}


def sample_arguments():
    given = {"samples": 5, "t": np.linspace(0.0, 1.0, 5)}
    return phases_arguments() | given | {"x": np.zeros((5, 6)), "torque": np.zeros(5)}


def fourier_arguments():
    orders = {"orders": 4, "first": 0, "step": 1}
    return phases_arguments() | orders | {"values": np.zeros((4, 14))}


def of_phases(work):
    """`work` with its phases spread out."""
    many = len(phases_arguments())
    return lambda *given: work(given[:many], *given[many:])


CALLS = {
    "orbit": (_event_map.orbit, orbit_arguments),
    "modes": (_event_map.modes, modes_arguments),
    "changes": (_event_map.changes, changes_arguments),
    "integrals": (of_phases(_event_map.integrals), integrals_arguments),
    "sample": (of_phases(_event_map.sample), sample_arguments),
    "fourier": (of_phases(_event_map.fourier), fourier_arguments),
}
EVERY = [
    (call, name)
    for call, (_, valid) in CALLS.items()
    for name, value in valid().items()
    if isinstance(value, np.ndarray)
]
OUTPUT = {"packed", "squares", "sums", "search", "history", "image", "derivative", "multipliers"}
OUTPUT |= {"reals", "integers", "x", "torque", "values"}


def test_valid_calls():
    status, steps, events, first, last = _event_map.orbit(*orbit_arguments().values())
    assert status == 0
    assert steps > 1
    assert events >= 2
    assert {first, last} <= {-1, 0, 1}
    status, m, condition, *_ = _event_map.modes(*modes_arguments().values())
    assert (status, m) == (0, 3)
    assert condition >= 1.0
    assert _event_map.changes(*changes_arguments().values()) == 0
    for name in ("integrals", "sample", "fourier"):
        work, valid = CALLS[name]
        assert work(*valid().values()) == 0
    assert _event_map.changes_reals(3, 4) == len(changes_of(random_problem(7, n=3)))


@pytest.mark.parametrize(("name", "buffer"), EVERY)
def test_bad_buffers_are_refused(name, buffer):
    work, valid = CALLS[name]
    array = valid()[buffer]
    other = np.int32 if array.dtype == np.int64 else np.float32
    read_only = array.copy()
    read_only.flags.writeable = False
    spoilt = [
        array.astype(other),
        array.tolist(),
        array[:-1],
        np.repeat(array, 2, axis=-1)[..., ::2],
    ]
    spoilt += [read_only] if buffer in OUTPUT else []
    for bad in spoilt:
        with pytest.raises((TypeError, ValueError, BufferError)):
            work(*{**valid(), buffer: bad}.values())


@pytest.mark.parametrize(
    ("name", "argument", "value"),
    [("orbit", "n", 0), ("orbit", "n", 30000), ("orbit", "H", -1), ("orbit", "m_free", 7),
     ("orbit", "history_capacity", 0), ("orbit", "event_capacity", -1), ("modes", "k", -1),
     ("modes", "k", 4), ("modes", "H", -1), ("modes", "Omega", 0.0), ("changes", "n", 0),
     ("changes", "joint", 3), ("changes", "Omega", -1.0), ("changes", "m_held", 3),
     ("integrals", "n", 0), ("integrals", "m", 7), ("integrals", "m", -1), ("integrals", "H", -1),
     ("integrals", "Omega", 0.0), ("integrals", "role", 3), ("integrals", "joint", -1),
     ("integrals", "count", -1), ("integrals", "count", 10**12), ("sample", "samples", -1),
     ("sample", "samples", 10**12), ("sample", "n", 0), ("fourier", "orders", -1),
     ("fourier", "first", 2), ("fourier", "step", 0), ("fourier", "H", -1)],
)  # fmt: skip
def test_sizes_of_these_out_of_range_are_refused(name, argument, value):
    work, valid = CALLS[name]
    with pytest.raises((ValueError, OverflowError)):
        work(*{**valid(), argument: value}.values())


@pytest.mark.parametrize("periods", [0.0, -1.0, np.nan, 1e9])
def test_periods_of_a_search_out_of_range_are_refused(periods):
    spoilt = orbit_arguments()
    spoilt["search"][0] = periods
    with pytest.raises(ValueError, match="periods"):
        _event_map.orbit(*spoilt.values())


def test_more_amplitudes_than_the_state_has_are_refused():
    """Six complex modes of six reals would write beyond the derivative."""
    flow = flows_of(random_problem(7, n=3)).free
    spoilt = orbit_arguments()
    inputs, reals = _event_map.flow_reals(flow.N, 6, len(flow.P) - 1)
    packed = np.zeros(reals)
    packed[6:12] = 1.0  # imaginary parts of the exponents
    spoilt.update(m_free=6, free=packed)
    assert inputs > 12
    with pytest.raises(ValueError, match="one of each pair"):
        _event_map.orbit(*spoilt.values())


def test_routines_must_be_those_of_scipy():
    capsules = binding.lapack.__pyx_capi__
    names = ("dgeev", "dgesv", "zgesv")
    for spoilt in range(3):
        for bad in (None, capsules["dgeev" if spoilt else "dgesv"]):
            given = [bad if i == spoilt else capsules[name] for i, name in enumerate(names)]
            with pytest.raises(TypeError, match="routine"):
                _event_map.use_lapack(*given)
    _event_map.use_lapack(*(capsules[name] for name in names))
