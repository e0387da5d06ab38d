"""The boundary to C: what does not fit is refused before C sees it."""

import threading
from pathlib import Path

import numpy as np
import pytest

from beltsim import _core

INPUTS = ("M", "C", "G", "K", "f_cos", "f_sin", "atol", "y0")


def numbers(**changed):
    given = {
        "n": 2,
        "joint": 1,
        "law": 1,
        "method": 0,
        "Omega": 1.3,
        "Q_m": 0.6,
        "Q_s": 0.6,
        "sigma": 1.0,
        "rtol": 1e-9,
        "max_steps": 10**8,
        "max_events": 10**6,
        "events_per_period": 1e3,
        "grazing": 1e-5,
        "window_start": 0.0,
    }
    return list((given | changed).values())


def arrays(**changed):
    given = {
        "M": np.array([[2.0, 0.3], [0.3, 1.0]]),
        "C": np.array([[0.2, 0.05], [0.05, 0.1]]),
        "G": np.array([[0.0, 0.4], [-0.4, 0.0]]),
        "K": np.array([[9.0, -2.0], [-2.0, 5.0]]),
        "f_cos": np.array([[0.0, 0.0], [1.0, 0.0]]),
        "f_sin": np.array([[0.0, 0.0], [0.0, 0.7]]),
        "atol": np.full(4, 1e-11),
        "y0": np.array([0.5, 0.0, 0.0, 0.0]),
    }
    return list((given | changed).values())


def core(**changed):
    return _core.Core(*numbers(), *arrays(**changed))


def outputs(**changed):
    given = {
        "counts": np.zeros(3, np.int64),
        "sample_t": np.linspace(0.0, 1.0, 5),
        "sample_state": np.empty((5, 4)),
        "sample_torque": np.empty(5),
        "event_values": np.empty((8, _core.EVENT_VALUES)),
        "event_codes": np.empty((8, 2), np.int32),
        "event_states": np.empty((8, 4)),
        "touch_values": np.empty((8, _core.TOUCH_VALUES)),
    }
    return list((given | changed).values())


def read_only(array):
    array.flags.writeable = False
    return array


def test_the_module_is_the_limited_api_one():
    assert Path(_core.__file__).name == "_core.abi3.so"
    assert _core.sundials_version.split(".")[0] in {"6", "7"}


def test_sound_buffers_pass():
    out = outputs()
    assert core().run(1.0, 10.0, *out) == 0
    assert out[0][0] == 5
    assert np.all(np.isfinite(out[2]))


@pytest.mark.parametrize("name", INPUTS)
@pytest.mark.parametrize(
    ("spoil", "error"),
    [
        (lambda a: a.astype(np.float32), TypeError),
        (lambda a: a.astype(np.int64), TypeError),
        (lambda a: a.astype(complex), TypeError),
        (lambda a: a.astype(">f8"), TypeError),
        (lambda a: a.tolist(), TypeError),
        (lambda a: None, TypeError),
        (lambda a: a[:-1], ValueError),
        (lambda a: np.concatenate([a, a]), ValueError),
        (lambda a: a[None], ValueError),
        (lambda a: np.repeat(a, 2, axis=-1)[..., ::2], ValueError),
        (lambda a: a[..., ::-1], ValueError),
    ],
    ids=[
        "float32",
        "int64",
        "complex",
        "swapped",
        "list",
        "None",
        "short",
        "long",
        "deep",
        "strided",
        "reversed",
    ],
)
def test_inputs_are_checked(name, spoil, error):
    good = dict(zip(INPUTS, arrays(), strict=True))[name]
    spoilt = spoil(good)
    if name == "f_cos" and getattr(spoilt, "shape", None) in {(1, 2), (4, 2)}:
        error = ValueError  # another number of harmonics: f_sin no longer fits
    with pytest.raises(error, match=r"^(f_sin|" + name + "): must"):
        core(**{name: spoilt})


def test_a_column_major_matrix_is_refused():
    with pytest.raises(ValueError, match="K: must be C-contiguous"):
        core(K=np.asfortranarray([[9.0, -2.0], [-2.0, 5.0]]))


@pytest.mark.parametrize("n", [0, -3, 20001])
def test_a_size_out_of_range_is_refused(n):
    with pytest.raises(ValueError, match=f"n = {n}: must be 1 to 20000"):
        _core.Core(*numbers(n=n), *arrays())


def test_arguments_that_c_refuses_are_named():
    with pytest.raises(RuntimeError, match="BS_BAD_INPUT"):
        _core.Core(*numbers(joint=2), *arrays())
    with pytest.raises(RuntimeError, match="BS_NOT_DEFINITE"):
        core(M=np.array([[1.0, 2.0], [2.0, 1.0]]))
    with pytest.raises(TypeError, match="keyword"):
        _core.Core(*numbers(), *arrays(), extra=1)
    with pytest.raises(TypeError):
        _core.Core(1, 2, 3)


@pytest.mark.parametrize(
    ("name", "value", "error"),
    [
        ("counts", np.zeros(3, np.int32), TypeError),
        ("counts", np.zeros(2, np.int64), ValueError),
        ("counts", np.array([0, 9, 0]), ValueError),
        ("counts", np.array([0, -1, 0]), ValueError),
        ("counts", np.array([6, 0, 0]), ValueError),
        ("counts", np.array([0, 0, 9]), ValueError),
        ("sample_t", np.zeros(5, np.float32), TypeError),
        ("sample_state", np.empty((4, 4)), ValueError),
        ("sample_state", np.empty((5, 3)), ValueError),
        ("sample_state", read_only(np.empty((5, 4))), ValueError),
        ("sample_state", np.empty((5, 8))[:, ::2], ValueError),
        ("sample_torque", np.empty(4), ValueError),
        ("sample_torque", read_only(np.empty(5)), ValueError),
        ("event_values", np.empty((8, 6)), ValueError),
        ("event_values", np.empty((0, 7)), ValueError),
        ("event_values", b"bytes", TypeError),
        ("event_codes", np.empty((8, 2), np.int64), TypeError),
        ("event_codes", np.empty((7, 2), np.int32), ValueError),
        ("event_states", np.empty((7, 4)), ValueError),
        ("touch_values", np.empty((8, 4)), ValueError),
        ("touch_values", read_only(np.empty((8, 3))), ValueError),
    ],
)
def test_outputs_are_checked(name, value, error):
    with pytest.raises(error):
        core().run(1.0, 1.0, *outputs(**{name: value}))


@pytest.mark.parametrize("t_stop", [-1.0, np.nan, np.inf])
def test_the_stop_time_is_checked(t_stop):
    with pytest.raises(ValueError, match="t_stop"):
        core().run(t_stop, 1.0, *outputs())


def test_states_need_a_buffer_of_their_size():
    for method in ("state", "window_state"):
        with pytest.raises(ValueError, match="shape"):
            getattr(core(), method)(np.empty(3))
        with pytest.raises(ValueError, match="writable"):
            getattr(core(), method)(read_only(np.empty(4)))


def test_every_status_has_a_name():
    names = {_core.status_name(code) for code in range(-22, 4)}
    assert len(names) == 26
    assert all(name.startswith("BS_") for name in names)
    assert "BS_UNKNOWN" not in names
    assert _core.status_name(-99) == "BS_UNKNOWN"
    assert all(len(_core.status_text(code)) > 3 for code in range(-22, 4))


def test_a_core_in_use_refuses_another_thread():
    shared = core()
    room = outputs(
        event_values=np.empty((10**5, _core.EVENT_VALUES)),
        event_codes=np.empty((10**5, 2), np.int32),
        event_states=None,
    )
    thread = threading.Thread(target=shared.run, args=(1e9, 2.0, *room))
    thread.start()
    refusals = set()
    while thread.is_alive():
        try:
            shared.summary()
        except RuntimeError as error:
            refusals.add(str(error))
            shared.cancel()
    thread.join()
    assert refusals == {"this Core is running in another thread"}
    assert shared.summary()["t"] > 0.0


def test_the_lock_is_released_while_c_runs():
    """Another thread counts on while this one is in C."""
    ticks = [0]
    stop = threading.Event()

    def count():
        while not stop.is_set():
            ticks[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    locked = _core.Core(*numbers(Q_m=50.0, Q_s=50.0), *arrays())
    before = ticks[0]
    assert locked.run(1e9, 0.2, *outputs()) == 3  # the slice is over
    during = ticks[0] - before
    stop.set()
    thread.join()
    assert during > 100
