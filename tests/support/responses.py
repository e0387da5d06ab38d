"""Responses made by hand, without any solver: for what stands behind the solvers.

`stick_slip` is a plausible motion whose figures are consistent with its events; `everything` fills
every optional field.
"""

from __future__ import annotations

import numpy as np

from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb, SaturatedCoulomb
from beltsim.problem import FrictionProblem, Observable, Scales
from beltsim.response import EventLog, NearGrazing, Response, Window, figures

OMEGA = 6.3
STICK = 0.12  # share of the period spent at rest at each end of the travel


def problem(friction=None, scales=True, observables=True):
    """Two coordinates, the joint last, in the units of a small drive."""
    seen = (
        Observable("tension of span 1", [120.0, -0.5], [0.9, 0.01], [0.0, 0.02], lower=0.0,
                   scale=300.0, unit="N"),
        Observable("arm angle", [0.0, 1.0], [0.02], [0.0], -0.1, 0.1, unit="rad"),
    )  # fmt: skip
    return FrictionProblem(
        M=[[1.0, 0.1], [0.1, 2.0]],
        C=[[0.3, 0.0], [0.0, 0.1]],
        G=[[0.0, 0.7], [-0.7, 0.0]],
        K=[[9.0, 0.4], [0.4, 3.0]],
        joint=1,
        forcing=HarmonicForcing(OMEGA, [[0.1, 0.0], [1.0, 0.5]], [[0.0, 0.0], [0.3, -0.2]]),
        friction=friction or Coulomb(3.5, 4.0),
        labels=("span1.sin1", "theta_t"),
        scales=Scales(6.4914e-3, 29.1, [0.1548, 1.0], ("m", "rad")) if scales else None,
        observables=seen if observables else (),
        warnings=("the friction torque is above the spring torque",),
    )


def stick_slip(periods=2, per_period=500, amplitude=0.02, friction=None, **changes):
    """An arm that swings between two rests: slip+ stick slip- stick in every period."""
    what = problem(friction)
    period, law = what.period, what.friction
    moving = (0.5 - STICK) * period
    t = np.linspace(0.0, periods * period, periods * per_period + 1)
    phase = t % period
    half = np.where(phase < 0.5 * period, 0, 1)
    inside = phase - 0.5 * period * half
    slips = (inside > 0.0) & (inside < moving)
    sign = 1.0 - 2.0 * half
    angle = np.where(inside < moving, -np.cos(np.pi * inside / moving), 1.0) * sign * amplitude
    speed = np.where(slips, np.sin(np.pi * inside / moving) * np.pi / moving, 0.0)
    speed *= sign * amplitude
    held = law.Q_m * sign * (1.0 - 2.0 * (inside - moving) / (0.5 * period - moving))
    torque = np.where(inside < moving, law.Q_m * sign, held)
    other = 0.003 * np.sin(OMEGA * t)
    q = np.column_stack([other, angle])
    q_dot = np.column_stack([0.003 * OMEGA * np.cos(OMEGA * t), speed])
    events = _events(periods, period, moving, law.Q_m, amplitude)
    initial, final = np.concatenate([q[0], q_dot[0]]), np.concatenate([q[-1], q_dot[-1]])
    window = Window(t[-1] - period, t[-1], initial, final, 0.3, 0.1)
    fields = {
        "problem": what, "t": t, "q": q, "q_dot": q_dot, "friction_torque": torque,
        "initial_state": initial, "final_state": final, "initial_mode": "slip+",
        "events": events, "near_grazing": NearGrazing.empty(), "window": window[:2],
        "periodic": True, "total_dissipated_energy": 2.2,
        "statistics": {"steps": 17230, "method": "adams", "seconds": 0.1},
        **figures(what, events, "slip+", window)._asdict(),
    }  # fmt: skip
    return Response(**(fields | changes))


def _events(periods, period, moving, Q_m, amplitude):
    times, kinds, places, before, after = [], [], [], [], []
    for k in range(periods):
        for sign, start in ((1.0, 0.0), (-1.0, 0.5 * period)):
            times += [k * period + start + moving, k * period + start + 0.5 * period]
            kinds += ["stick", "slip-" if sign > 0 else "slip+"]
            places += [sign * amplitude] * 2
            before += [sign * Q_m, -sign * Q_m]
            after += [sign * Q_m, -sign * Q_m]
    count = len(times)
    states = np.column_stack([np.linspace(0.0, 1e-3, count), places])
    rates = np.column_stack([np.full(count, 0.25), np.zeros(count)])
    quality = np.array(["simple"] * (count - 1) + ["near_grazing"])
    margins = np.geomspace(1e-9, 0.5, count)
    return EventLog(times, kinds, states, rates, places, before, after, quality, margins)


def everything():
    """Every optional field filled, with values that are easily lost: NaN, inf, -0, subnormals."""
    odd = np.array([-0.0, np.nan, np.inf, 5e-324, 1.0 / 3.0])
    coefficients = np.array([[0.1 - 0.0j, 1j], [complex(-0.0, np.nan), 1 / 3 + 2j]])
    return stick_slip(
        coefficients=coefficients,
        torque_coefficients=np.array([complex(np.inf, -0.0), 2.0]),
        multipliers=np.exp(1j * np.arange(4)),
        rest_interval=(-0.1, 1.0 / 3.0),
        near_grazing=NearGrazing(odd[:2], odd[3:], np.array(["velocity", "reaction"])),
        period_residual=5e-324,
        warnings=("slack: span 3, t = 0.2 s", "Ärger mit „Anführung“\nund Zeilen"),
        statistics={"a": 1, "b": 0.1, "c": "text", "d": float("inf"), "e": 2**60},
    )


def bare():
    """No joint, no scales, no observables, no samples, no events."""
    linear = problem(scales=False, observables=False).freed()
    none = np.zeros((0, 2))
    return Response(
        linear, np.zeros(0), none, none, np.zeros(0), np.zeros(4), np.ones(4), None,
        EventLog.empty(2), NearGrazing.empty(), (0.0, 0.5), 0.0, 0.0, 0.0, 0.0, 1e-9, None, False,
    )  # fmt: skip


def saturated():
    """A response of the saturated law, whose events kept no states."""
    made = stick_slip(periods=1, friction=SaturatedCoulomb(3.5, 1e-4))
    old = made.events
    none = np.zeros((len(old), 0))
    log = EventLog(old.t, old.kind, none, none, old.position, old.torque_before, old.torque_after,
                   old.quality, old.margin)  # fmt: skip
    return stick_slip(periods=1, friction=SaturatedCoulomb(3.5, 1e-4), events=log)


def fields(thing):
    """All that `thing` holds, flattened: names to scalars, texts or arrays."""
    found = {}
    for name, value in vars(thing).items():
        if isinstance(value, tuple) and value and hasattr(value[0], "row"):
            for i, one in enumerate(value):
                found |= {f"{name}[{i}].{k}": v for k, v in fields(one).items()}
        elif hasattr(value, "__dataclass_fields__"):
            found[f"{name}:type"] = type(value).__name__
            found |= {f"{name}.{k}": v for k, v in fields(value).items()}
        else:
            found[name] = value
    return found


def assert_same(one, other):
    """`one` and `other` hold the same bits in every field."""
    ours, theirs = fields(one), fields(other)
    for held in (ours, theirs):  # what a problem has worked out is no part of what it says
        for name in ("problem.others", "problem.shared"):
            held.pop(name, None)
    assert sorted(ours) == sorted(theirs)
    for name, value in ours.items():
        found = theirs[name]
        if isinstance(value, np.ndarray) and value.dtype.kind in "fc":
            assert value.dtype == found.dtype, name
            assert value.shape == found.shape, name
            assert value.tobytes() == found.tobytes(), name
        elif isinstance(value, np.ndarray):
            assert value.tolist() == found.tolist(), name
        elif isinstance(value, float):
            assert np.float64(value).tobytes() == np.float64(found).tobytes(), name
        else:
            assert dict(value) == found if name == "statistics" else value == found, name
            assert type(value) is type(found) or name == "statistics", name
