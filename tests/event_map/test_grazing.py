"""Near grazing: the same events as the reference, or a mark that says it could be otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from support.exact import exact_transient
from support.grazing import OFFSETS, PERIODS, stored_cases

from beltsim import event_map


def marked(run):
    return len(run.near_grazing) > 0 or bool((run.events.quality != "simple").any())


def test_events_near_grazing_equal_the_reference(full):
    cases = stored_cases(100 if full else 12)
    offsets = OFFSETS if full else OFFSETS[1::3]
    compared = same = 0
    for case in cases:
        like = exact_transient(case.at(0.0), 0.01)
        for offset in offsets:
            problem = case.at(offset)
            exact = exact_transient(problem, PERIODS, like=like)
            run = event_map.propagate(problem, PERIODS)
            compared += 1
            if run.events.kind.tolist() == exact.kind:
                same += 1
            else:
                assert abs(offset) <= 1e-9, (case.seed, offset)
                assert marked(run), (case.seed, offset)
    assert same >= 0.97 * compared


def test_a_touch_closer_than_the_mark_is_reported():
    """At offsets of 1e-10 the touch itself, or the event pair it became, carries the mark."""
    for case in stored_cases(12):
        for offset in (1e-10, -1e-10):
            assert marked(event_map.propagate(case.at(offset), PERIODS)), (case.seed, offset)


def test_far_from_grazing_there_are_no_marks():
    for case in stored_cases(4):
        problem = case.at(1e-2)
        exact = exact_transient(problem, PERIODS)
        run = event_map.propagate(problem, PERIODS)
        assert exact.min_margin > 1e-6
        assert not marked(run)
        assert np.isfinite(run.events.margin).all()


@pytest.mark.parametrize("settings", [{"keep": "events"}, {"samples_per_period": 1}])
def test_marks_do_not_depend_on_what_is_kept(settings):
    for case in stored_cases(12):
        for offset in (1e-10, -1e-10):
            problem = case.at(offset)
            wanted = event_map.propagate(problem, PERIODS)
            found = event_map.propagate(problem, PERIODS, settings=event_map.Settings(**settings))
            assert np.array_equal(found.near_grazing.t, wanted.near_grazing.t), (case.seed, offset)
            assert found.events.quality.tolist() == wanted.events.quality.tolist()
