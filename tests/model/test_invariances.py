"""The same machine seen in other ways gives the same numbers."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.layouts import drives, mirrored, random_drive, renumbered, rescaled, shifted, turned

from beltsim import linear
from beltsim.metrics.hub_loads import hub_load_harmonics, newtons, steady_hub_loads
from beltsim.metrics.rms import rms_of_coefficients
from beltsim.metrics.span_rms import span_rms
from beltsim.metrics.span_tensions import peak_dynamic_tensions, steady_tensions
from beltsim.model import assemble, chain

SAME = 1e-10
N = 5


def facts(drive):
    """What does not depend on the view: by span and by pulley, as the user lists them."""
    problem, driven = assemble(drive, n_functions=N), chain(drive, n_functions=N)
    free = linear.response(problem)
    by_pulley = {
        label: np.abs(free[:, i])
        for i, label in enumerate(problem.labels)
        if label.startswith("theta_") and label != "theta_t"
    }
    steady, dynamic = steady_hub_loads(driven.system.state), hub_load_harmonics(driven, free)
    found = {
        "frequencies": linear.frequencies(problem),
        "decay": linear.decay(problem),
        "pulleys": by_pulley,
        "spans": {
            "tensions": steady_tensions(problem),
            "peaks": peak_dynamic_tensions(problem, free),
            "rms": span_rms(problem, rms_of_coefficients(free)),
        },
        "hubs": {
            "steady": np.hypot(*steady.T),
            # |F|^2 integrated over a period: the same in every view
            "dynamic": np.sqrt(np.sum(np.abs(dynamic) ** 2, axis=(0, 2))),
        },
    }
    if problem.joint is not None:
        found["locked"] = linear.frequencies(problem, locked=True)
        found["Q_cr"] = linear.critical_torque(problem)
        found["arm"] = np.abs(free[:, -1])
    return found


def same(one, other):
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            same(one[key], other[key])
        return
    one, other = np.asarray(one), np.asarray(other)
    assert np.abs(one - other).max() <= SAME * np.abs(one).max()


def in_order(found, spans, hubs):
    """Facts with spans and pulleys taken in another order."""
    return found | {
        "spans": {key: value[spans] for key, value in found["spans"].items()},
        "hubs": {key: value[hubs] for key, value in found["hubs"].items()},
    }


@settings(derandomize=True, deadline=None, max_examples=25)
@given(drives(), st.floats(-3.0, 3.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_rotation_and_translation(drive, angle, dx, dy):
    expected = facts(drive)
    same(expected, facts(turned(drive, angle)))
    same(expected, facts(shifted(drive, dx, dy)))


@settings(derandomize=True, deadline=None, max_examples=25)
@given(drives(), st.integers(1, 7))
def test_renumbering(drive, first):
    n = len(drive.pulleys)
    order = np.roll(np.arange(n), -(first % n))
    same(in_order(facts(drive), order, order), facts(renumbered(drive, first % n)))


@settings(derandomize=True, deadline=None, max_examples=25)
@given(drives())
def test_mirror_with_travel_reversed(drive):
    n = len(drive.pulleys)
    spans = (n - 2 - np.arange(n)) % n
    same(in_order(facts(drive), spans, np.arange(n)[::-1]), facts(mirrored(drive)))


def test_mirror_without_reversing_the_travel_is_another_machine():
    drive = random_drive(np.random.default_rng(3), 4)
    other = mirrored(drive).changed(crank_rotation=drive.crank_rotation)
    one, two = assemble(drive, n_functions=N), assemble(other, n_functions=N)
    assert abs(linear.critical_torque(one) / linear.critical_torque(two) - 1.0) > 1e-4


@settings(derandomize=True, deadline=None, max_examples=25)
@given(drives(), *[st.floats(0.4, 2.5)] * 3)
def test_units(drive, length, mass, time):
    """Lengths in one and a half metres, and so on: dimensionless results stay."""
    other = rescaled(drive, length, mass, time)
    same(facts(drive), facts(other))
    one, two = chain(drive), chain(other)
    loads = [newtons(c, steady_hub_loads(c.system.state)) for c in (one, two)]
    same(loads[0] * mass * length / time**2, loads[1])
    same(one.drive.time_s * time, two.drive.time_s)


@pytest.mark.parametrize("arm", [True, False])
def test_hub_loads_turn_and_mirror_with_the_drive(arm):
    drive = random_drive(np.random.default_rng(11), 5, arm=arm)

    def both(drive):
        driven = chain(drive, n_functions=N)
        free = linear.response(assemble(drive, n_functions=N))
        return steady_hub_loads(driven.system.state), hub_load_harmonics(driven, free)

    steady, dynamic = both(drive)
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    for found, expected in zip(both(turned(drive, angle)), (steady, dynamic), strict=True):
        same(expected @ turn.T, found)
    flip = np.array([1.0, -1.0])
    for found, expected in zip(both(mirrored(drive)), (steady, dynamic), strict=True):
        same(expected[..., ::-1, :] * flip, found)


def test_mirrored_coordinates_map_back():
    """theta_t turns around, sines go from the other end, pulleys keep their sense."""
    drive = random_drive(np.random.default_rng(12), 4, "cw")
    one, two = assemble(drive, n_functions=N), assemble(mirrored(drive), n_functions=N)
    free, other = linear.response(one), linear.response(two)
    at = {label: i for i, label in enumerate(two.labels)}
    for i, label in enumerate(one.labels):
        if label == "theta_t":
            expected = -free[:, i]
        elif label.startswith("theta_"):
            expected = free[:, i]
        else:
            continue
        assert np.abs(other[:, at[label]] - expected).max() <= SAME * np.abs(free).max()
    n = len(drive.pulleys)
    for span in range(n):
        for k in range(1, N + 1):
            i = one.labels.index(f"span{span + 1}.sin{k}")
            j = at[f"span{(n - 2 - span) % n + 1}.sin{k}"]
            expected = free[:, i] * (1.0 if k % 2 else -1.0)
            assert np.abs(other[:, j] - expected).max() <= SAME * np.abs(free).max()
