"""Near-grazing transients: the exact sequence, or the mark; never a silent miss.

A hundred problems whose event sequence changes at a grazing torque Q_g (57 in the reaction, 43 in
the velocity of the joint), with Q_m = Q_g (1 + offset) for offsets of 1e-2 to 1e-10 of both signs.
`--full` runs all 1800; by default every twentieth problem.
"""

from __future__ import annotations

from collections import Counter

import pytest
from support.agreement import agreement, marked
from support.exact import exact_transient
from support.grazing import OFFSETS, PERIODS, stored_cases

from beltsim.transient import Settings, integrate

RTOL = 1e-8
#: Margins beyond this are resolved at RTOL: errors of whole runs reach some ten RTOL.
RESOLVED = 1e-6


def outcome(problem, run) -> str:
    """``same`` or ``marked``; fails on anything else."""
    response = integrate(problem, PERIODS, settings=Settings(rtol=RTOL))
    found = agreement(response, run)
    if found.same_sequence:
        return "same"
    assert found.first_difference is not None
    assert marked(response, found.first_difference), (
        f"silent miss at t = {found.first_difference}: "
        f"{len(response.events)} events, exact {len(run.kind)}"
    )
    assert any("near grazing" in text for text in response.warnings) or (
        found.first_difference <= response.window[0]
    )
    return "marked"


def test_the_sequence_or_the_mark(full):
    cases = stored_cases() if full else stored_cases()[4::20]
    count: Counter[str] = Counter()
    for case in cases:
        like = exact_transient(case.problem, 0.01)
        for offset in OFFSETS:
            problem = case.at(offset)
            run = exact_transient(problem, PERIODS, like=like)
            found = outcome(problem, run)
            count[found] += 1
            if abs(offset) >= RESOLVED:
                assert found == "same", f"seed {case.seed}, offset {offset:g}"
    assert count["same"] > 0.8 * count.total()


def test_the_stored_torques_graze():
    """On the two sides of Q_g the sequences differ, already at an offset of 1e-10."""
    cases = stored_cases()
    assert len(cases) == 100
    kinds = Counter(case.kind for case in cases)
    assert min(kinds["reaction"], kinds["velocity"]) >= 40
    for case in cases[::10]:
        low, high = (exact_transient(case.at(d), PERIODS) for d in (-1e-10, 1e-10))
        assert low.kind != high.kind
        closest = min(low.min_margin, high.min_margin)
        assert closest < 1e-4


@pytest.mark.parametrize("offset", [1e-3, -1e-3])
def test_a_plain_margin_carries_no_mark(offset):
    """At 1e-3 of the grazing torque everything is decided, and the response says nothing."""
    case = next(c for c in stored_cases() if c.kind == "velocity" and c.problem.n > 5)
    response = integrate(case.at(offset), PERIODS)
    assert not marked(response, case.t)
