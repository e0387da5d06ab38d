"""Periodic orbits of one undamped mass by the event map."""

import numpy as np

from beltsim import event_map
from validation.analytic.den_hartog_stops.reference import CASES, events
from validation.analytic.one_mass import one_mass
from validation.row import Row

TIME = "time over the forcing period"


def compute() -> list[Row]:
    rows = []
    for beta, f in CASES:
        problem = one_mass(k=1.0, Q=f, P=1.0, Omega=beta)
        orbit = event_map.periodic(problem)
        expected = events(beta, f)
        where = f"beta = {beta}, f = {f}"
        kinds = orbit.events.kind.tolist()
        different = sum(a != b[0] for a, b in zip(kinds, expected, strict=False))
        rows.append(Row(f"events, {where}", len(kinds), len(expected)))
        rows.append(Row(f"events that differ, {where}", different, 0))
        if len(kinds) == len(expected):
            times = np.array([each[1] for each in expected])
            places = np.array([each[2] for each in expected])
            found = orbit.events.t / problem.period
            rows.append(Row(f"times, {where}", found, times, times, TIME, TIME))
            found = orbit.events.position
            rows.append(Row(f"places, {where}", found, places, times, TIME, "place over P/k"))
    return rows
