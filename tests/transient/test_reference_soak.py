"""Long runs: memory in proportion to the events kept, no drift of phase. `--full`: 1e6 events."""

from __future__ import annotations

import gc
import os
from pathlib import Path

import numpy as np
import pytest
from support.exact import exact_transient

from beltsim.forcing import HarmonicForcing
from beltsim.friction import Coulomb
from beltsim.problem import FrictionProblem
from beltsim.transient import Settings, integrate

EVENTS_PER_PERIOD = 4
#: Bytes that one event may take, without states.
EVENT_BYTES = 400


def stick_slip_mass():
    """Slips and sticks once each way in every period."""
    forcing = HarmonicForcing(1.1, [[0.0], [1.0]], [[0.0], [0.3]])
    return FrictionProblem([[1.0]], [[0.1]], [[0.0]], [[6.0]], 0, forcing, Coulomb(0.7))


def resident_bytes() -> int:
    pages = Path("/proc/self/statm").read_text().split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads /proc")
def test_many_events_in_one_process(full):
    runs, periods = (5, 50_000) if full else (3, 600)
    problem = stick_slip_mass()
    short = exact_transient(problem, 60.0)
    expected = short.t[-EVENTS_PER_PERIOD:] / problem.period - 59.0
    settings = Settings(keep="events", event_states=False)
    before = 0
    for i in range(runs):
        response = integrate(problem, periods, settings=settings)
        count = len(response.events)
        assert count >= EVENTS_PER_PERIOD * (periods - 20)
        late = response.events.t[-EVENTS_PER_PERIOD:] / problem.period - (periods - 1)
        assert np.abs(late - expected).max() < 1e-9
        assert response.velocity_reversals == 0.0
        assert response.stops_per_period == pytest.approx(2.0, rel=1e-9)
        assert response.energy_balance_residual < 1e-8
        del response, late
        gc.collect()
        if i == 0:
            before = resident_bytes()
    # What one run needed is free again, or used again by the next.
    assert resident_bytes() - before < max(EVENT_BYTES * count, 2**20)


def test_a_log_without_states_is_small():
    problem = stick_slip_mass()
    settings = Settings(keep="events", event_states=False)
    events = integrate(problem, 300.0, settings=settings).events
    assert events.q.shape == (len(events), 0)
    names = ("t", "kind", "q", "q_dot", "position", "torque_before", "torque_after", "quality")
    size = sum(getattr(events, name).nbytes for name in (*names, "margin"))
    assert size < EVENT_BYTES * len(events)
