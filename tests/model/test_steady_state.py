"""Steady states: balances, refusals, warnings, and the closed forms of a bent span."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.layouts import drives, mirrored, random_drive

from beltsim.drive.presets import zhu_parker_2008
from beltsim.errors import ConvergenceError, SteadyStateError
from beltsim.model import chain, steady_state

PAPER = zhu_parker_2008()


def state_of(drive, Omega=None):
    return chain(drive, Omega, n_functions=2).system.state


def paper(**tables):
    return PAPER.changed(**tables)


def loaded(torque, pulley=2, **tables):
    pulleys = PAPER.model_dump(exclude_none=True)["pulleys"]
    pulleys[pulley]["accessory_torque_N_m"] = torque
    return PAPER.changed(pulleys=pulleys, **tables)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(drives())
def test_belt_and_arm_are_in_balance(drive):
    """Stretch of all spans and moment on the arm, with the integrals by quadrature."""
    state = state_of(drive)
    scaled, s = state.drive, state.point.s
    nodes, weights = np.polynomial.legendre.leggauss(40)
    edges = np.concatenate([np.geomspace(1e-4, 0.5, 25)])
    edges = np.concatenate([[0.0], edges, 1.0 - edges[-2::-1], [1.0]])
    x = (edges[:-1, None] + np.diff(edges)[:, None] * 0.5 * (1.0 + nodes)).ravel()
    w = (np.diff(edges)[:, None] * 0.5 * weights).ravel()
    # the slope from the deflection itself: central difference of an analytic function
    h = 1e-6
    inside = np.clip(x, h, 1.0 - h)
    slope = (state.deflection(inside + h) - state.deflection(inside - h)) / (2.0 * h)
    bent = 0.5 * slope**2 @ w
    length = scaled.span_length
    stretch = float(length @ ((state.p - 1.0) / scaled.gamma - bent))
    assert abs(stretch - scaled.arm_stretch.sum() * state.theta_t) < 1e-6 * length.sum()
    e = scaled.arm_stretch / scaled.lever
    c = scaled.arm_chord * length / scaled.lever
    moment = float(e @ state.T + c @ (state.T * state.g))
    assert abs(scaled.k_s * state.theta_t + scaled.preload + moment) < 1e-9
    assert pytest.approx(state.p - s**2) == state.T
    jumps = state.p - np.roll(state.p, 1)
    assert jumps == pytest.approx(scaled.accessory_torque, abs=1e-13)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(st.floats(0.02, 5.0), st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), st.floats(0.2, 3.0))
def test_the_stretch_of_a_bent_span_and_its_derivative(delta, k0, k1, T):
    """b(T) and db/dT against Gauss quadrature and a complex step."""
    eps2 = delta**2 * T

    def stretch(T):
        d = np.sqrt(eps2 / T)
        nodes, weights = np.polynomial.legendre.leggauss(200)
        x, w = 0.5 * (1.0 + nodes), 0.5 * weights
        C0 = np.cosh((1.0 - x) / d) / np.sinh(1.0 / d)
        C1 = np.cosh(x / d) / np.sinh(1.0 / d)
        g = -(d**2) * (k1 - k0)
        return 0.5 * np.sum(w * (-d * k0 * C0 + d * k1 * C1 + g) ** 2)

    layer = steady_state._layer(k0, k1, eps2, T)
    size = k0**2 + k1**2 + 1e-3
    # for a wide layer the terms cancel as delta^4
    rounding = 1e-13 * max(1.0, delta) ** 4 * size
    assert layer.b == pytest.approx(stretch(T), rel=1e-9, abs=rounding)
    derivative = stretch(T + 1e-30j).imag / 1e-30
    assert layer.b_T == pytest.approx(derivative, rel=1e-9, abs=10.0 * rounding / T)


def test_the_shape_meets_its_boundary_conditions():
    state = state_of(random_drive(np.random.default_rng(1), 5))
    ends = state.deflection([0.0, 1.0])
    assert ends[:, 0] == pytest.approx(state.w_0, abs=1e-15)
    assert ends[:, 1] == pytest.approx(state.w_1, abs=1e-15)
    h = 1e-4
    k0, k1 = state.drive.curvatures
    for at, k in ((np.array([0.0, h, 2 * h, 3 * h]), k0), (1.0 - np.arange(4.0) * h, k1)):
        w = state.deflection(at)
        bend = (2.0 * w[:, 0] - 5.0 * w[:, 1] + 4.0 * w[:, 2] - w[:, 3]) / h**2
        assert bend == pytest.approx(k, rel=2e-3)


def test_a_string_is_straight():
    state = state_of(zhu_parker_2008(epsilon=0.0), 6.3)
    x = np.linspace(0.0, 1.0, 5)
    line = np.multiply.outer(state.w_0, 1.0 - x) + np.multiply.outer(state.w_1, x)
    assert state.deflection(x) == pytest.approx(line)
    assert (state.delta == 0.0).all()


def test_bending_goes_to_the_string():
    exact = state_of(zhu_parker_2008(epsilon=0.0), 6.3)
    gaps = []
    for epsilon in (1e-3, 1e-4, 1e-5):
        gaps.append(np.abs(state_of(zhu_parker_2008(epsilon=epsilon), 6.3).p - exact.p).max())
    assert gaps[2] < 1e-8
    assert gaps[0] > 50.0 * gaps[1] > 2500.0 * gaps[2]


def test_standstill_without_torque_is_the_reference_state():
    state = state_of(zhu_parker_2008(epsilon=0.0), 0.0)
    assert state.p == pytest.approx([1.0, 1.0, 1.0])
    assert abs(state.theta_t) < 1e-14


def test_accessory_torques_step_the_tension_down_along_the_travel():
    """Clockwise: the belt goes from pulley 3 to 2 to 1; 6 N m at r = 0.027 m is 222 N."""
    state = state_of(loaded(6.0), 3.0)
    p = state.p * 300.0
    assert p[1] - p[2] == pytest.approx(6.0 / 0.0270)
    assert p[0] == pytest.approx(p[1])


# --- refusals, with the span as the user lists it ---


def test_a_slack_span_is_named():
    with pytest.raises(SteadyStateError) as caught:
        state_of(loaded(20.0), 3.0)
    text = str(caught.value)
    assert text.startswith("span 3 (3 - 1) at Omega = 3 is slack: its steady tension would be -")
    assert "N (the belt runs at 13.7 m/s)" in text
    assert "belt.initial_tension_N" in text


def test_the_slack_span_is_the_same_one_seen_from_behind():
    drive = random_drive(np.random.default_rng(7), 5, "cw", arm=False)
    pulleys = drive.model_dump(exclude_none=True)["pulleys"]
    braked = next(p for p in pulleys if p["role"] == "fixed")
    braked["accessory_torque_N_m"] = 40.0 * drive.belt.initial_tension_N * braked["radius_m"]
    texts = []
    for seen in (drive.changed(pulleys=pulleys), mirrored(drive.changed(pulleys=pulleys))):
        with pytest.raises(SteadyStateError, match=r"is slack") as caught:
            state_of(seen)
        texts.append(re.match(r"span (\d) \((p\d) - (p\d)\)", str(caught.value)).groups())
    (span, first, second), (other, back, front) = texts
    assert (first, second) == (front, back)
    assert int(other) == (4 - int(span)) % 5 + 1
    names = [p["name"] for p in pulleys]
    assert names[int(span) - 1] == first


def test_a_belt_faster_than_critical_is_refused():
    drive = random_drive(np.random.default_rng(5), 4, arm=False, torques=False)
    critical = drive.Omega / state_of(drive).point.s
    assert state_of(drive, 0.99 * critical).T.min() > 0.0
    with pytest.raises(SteadyStateError, match=r"runs faster than its critical speed: .* m/s"):
        state_of(drive, 1.01 * critical)


def test_bending_does_not_hide_a_slack_span():
    """With bending the equations keep a root at a tiny tension; it must not be taken."""
    for epsilon in (0.0, 0.01, 0.2):
        with pytest.raises(SteadyStateError, match=r"is slack"):
            state_of(loaded(20.0, belt={"epsilon": epsilon}), 3.0)


def test_hardly_tight_spans_still_converge():
    """Down to a few tenths of a percent of the initial tension in the string limit."""
    low, high = 0.5, 20.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        try:
            state_of(loaded(middle), 3.0)
            low = middle
        except SteadyStateError:
            high = middle
    for share in (0.99, 0.999, 0.99999):
        state = state_of(loaded(low * share), 3.0)
        assert state.T.min() > 0.0


def test_no_convergence_is_an_error_with_its_history(monkeypatch):
    monkeypatch.setattr(steady_state, "MAX_ITERATIONS", 1)
    with pytest.raises(
        ConvergenceError, match=r"Newton stopped at residual .* iterations; .*epsilon = 0.1"
    ) as caught:
        state_of(zhu_parker_2008(epsilon=0.1), 6.3)
    assert len(caught.value.residual_history) == 1


# --- warnings: data, not refusals ---


def warnings_of(drive, Omega=6.3):
    return state_of(drive, Omega).warnings


def test_the_published_drive_is_inside_the_linear_geometry():
    assert warnings_of(PAPER) == ()


def test_steep_spans_and_large_arm_angles_carry_their_numbers():
    (steep,) = warnings_of(zhu_parker_2008(epsilon=0.05), 0.0)
    assert steep.startswith("steady slope of span 3 (3 - 1) reaches 0.631 (above 0.3)")
    _, turned = warnings_of(zhu_parker_2008(epsilon=0.1), 0.0)
    assert turned.startswith("steady arm angle 20.1 deg (beyond 5.7 deg)")


def test_an_arm_in_line_with_the_pull_is_warned_about():
    drive = PAPER.changed(overrides={"beta_1_deg": 176.0, "beta_2_deg": 178.74})
    (text,) = warnings_of(drive, 0.5)
    assert "whose moment about the pivot is only 1.39 N m, 0.048 of P0 r_t (less than 0.1)" in text
    assert "move tensioner.pivot_m" in text


@settings(derandomize=True, deadline=None, max_examples=30)
@given(st.floats(0.03, 1.0), st.floats(-6.0, 6.0), st.floats(-6.0, 6.0), st.floats(-0.5, 0.5))
def test_the_steepest_slope_is_that_of_the_shape(delta, k0, k1, chord):
    layer = steady_state._layer(k0, k1, delta**2, 1.0)
    g = chord - delta**2 * (k1 - k0)
    x = np.linspace(0.0, 1.0, 20001)
    C0 = np.cosh((1.0 - x) / delta) / np.sinh(1.0 / delta)
    C1 = np.cosh(x / delta) / np.sinh(1.0 / delta)
    slope = np.abs(g - delta * k0 * C0 + delta * k1 * C1).max()
    assert steady_state._steepest_of(layer, k0, k1, g) == pytest.approx(slope, rel=1e-5, abs=1e-9)
