"""Errors and verdicts: what agrees, what does not, and what an explanation may cover."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from validation.case import Case, Explained, Override
from validation.compare import compare, failed
from validation.row import Row

CASE = Case(
    name="toy/case",
    folder=Path("nowhere"),
    title="A toy",
    claim="one is one",
    source="arithmetic",
    kind="exact",
    quantity="a number",
    metric="value",
    tolerance=0.1,
    tolerance_reason="chosen for the test",
    runtime="quick",
    expected_verdict="agrees",
    explanation="",
    explained=(),
    overrides=(),
    time_limit_s=60.0,
)
EXPLAINED = replace(
    CASE,
    expected_verdict="disagrees-explained",
    explanation="the reference is a misprint",
    explained=(Explained("a", got=2.0, within=0.01),),
)


@pytest.mark.parametrize(
    ("metric", "got", "expected", "error"),
    [
        ("value", 1.25, 1.0, 0.25),
        ("relative", 5.0, 4.0, 0.25),
        ("max", [1.0, 2.0, 3.5], [1.0, 2.0, 3.0], 0.5),
        ("rms", [3.0, 4.0], [3.0, 0.0], 4.0 / 3.0),
        ("count", 3, 5, 2.0),
        ("at_most", 1.0, 0.75, 0.25),
        ("at_most", 0.5, 0.75, 0.0),
    ],
)
def test_error_of_each_metric(metric, got, expected, error):
    result = compare(replace(CASE, metric=metric), [("a", got, expected)])
    assert result.rows[0].error == pytest.approx(error, abs=1e-15)


def test_error_equal_to_the_tolerance_agrees_and_beyond_it_disagrees():
    just, beyond = replace(CASE, tolerance=0.25), replace(CASE, tolerance=0.2499)
    assert compare(just, [("a", 1.25, 1.0)]).verdict == "agrees"
    assert compare(beyond, [("a", 1.25, 1.0)]).verdict == "disagrees"


@pytest.mark.parametrize("got", [np.nan, np.inf, -np.inf])
def test_a_number_that_is_none_never_agrees(got):
    for case in (CASE, replace(CASE, metric="max"), replace(CASE, metric="relative")):
        result = compare(case, [("a", got, 1.0)])
        assert result.verdict == "disagrees"
        assert not result.passed


def test_nan_in_an_array_is_its_worst_entry():
    row = compare(replace(CASE, metric="max"), [("a", [1.0, np.nan], [1.0, 1.0])]).rows[0]
    assert np.isnan(row.got)
    assert row.verdict == "disagrees"


def test_a_case_is_as_good_as_its_worst_row():
    result = compare(CASE, [("a", 1.0, 1.0), ("b", 2.0, 1.0), ("c", 1.0, 1.0)])
    assert [row.verdict for row in result.rows] == ["agrees", "disagrees", "agrees"]
    assert result.verdict == "disagrees"
    assert not result.passed


def test_an_explained_row_that_disagrees_by_the_recorded_number_passes():
    result = compare(EXPLAINED, [("a", 2.005, 1.0)])
    assert result.verdict == "disagrees-explained"
    assert result.flags == ()
    assert result.passed


def test_an_explained_row_that_suddenly_agrees_is_flagged():
    result = compare(EXPLAINED, [("a", 1.0, 1.0)])
    assert result.verdict == "agrees"
    assert "now agrees" in result.flags[0]
    assert not result.passed


def test_an_explained_row_that_disagrees_by_another_number_is_flagged():
    result = compare(EXPLAINED, [("a", 2.02, 1.0)])
    assert result.verdict == "disagrees"
    assert "explained for 2 +- 0.01, now 2.02" in result.flags[0]
    assert not result.passed


def test_an_explanation_covers_its_own_row_only():
    result = compare(EXPLAINED, [("a", 2.0, 1.0), ("b", 2.0, 1.0)])
    assert [row.verdict for row in result.rows] == ["disagrees-explained", "disagrees"]
    assert not result.passed


def test_an_override_changes_one_row():
    case = replace(CASE, overrides=(Override("b", 0.5, "read from a picture", "relative"),))
    result = compare(case, [("a", 1.05, 1.0), ("b", 5.6, 4.0)])
    assert [row.verdict for row in result.rows] == ["agrees", "agrees"]
    assert result.rows[1].error == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        ([], "no rows"),
        ([("a", 1.0, 1.0), ("a", 1.0, 1.0)], "more than one row is named 'a'"),
        ([("a", [1.0, 2.0], [1.0])], r"got \(2,\), expected \(1,\)"),
        ([("a", 1.0, np.nan)], "reference is not finite"),
        ([("a", [1.0], [1.0])], "compares single numbers"),
        ([("a",)], "missing"),
        (None, "not iterable"),
        ([("a", "one", 1.0)], "could not convert"),
    ],
)
def test_rows_that_cannot_be_compared_fail_with_the_reason(rows, reason):
    result = compare(CASE, rows)
    assert result.verdict == "failed"
    assert not result.passed
    with pytest.raises(ValueError, match=reason):
        raise ValueError(result.failure)


def test_whole_numbers_only_for_counts_and_no_relative_error_of_zero():
    assert "whole numbers" in compare(replace(CASE, metric="count"), [("a", 1.5, 1)]).failure
    assert "not zero" in compare(replace(CASE, metric="relative"), [("a", 1.5, 0.0)]).failure
    assert "not zero" in compare(replace(CASE, metric="rms"), [("a", [1.0], [0.0])]).failure


def test_settings_for_a_row_that_does_not_come_fail_the_case():
    assert "'a'" in compare(EXPLAINED, [("another", 2.0, 1.0)]).failure


def test_curves_are_kept_for_pictures():
    case = replace(CASE, metric="max")
    row = compare(case, [Row("a", [1.0, 2.0], [1.0, 2.05], x=[0.0, 0.5])]).rows[0]
    assert row.curves == {"got": [1.0, 2.0], "expected": [1.0, 2.05], "x": [0.0, 0.5]}
    assert (row.got, row.expected, row.entries) == (2.0, 2.05, 2)


def test_a_failed_case_has_not_passed():
    assert not failed(CASE, "boom").passed
