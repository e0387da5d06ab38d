"""The deliberate errors of validation/mutations.toml can still be made, and each was caught."""

from __future__ import annotations

import ast

import pytest

from validation.case import find
from validation.mutations import BEGIN, END, PAGE, ROOT, Mutation, load, main, mutated, table

MUTATIONS = load()


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda one: one.name)
def test_each_can_be_made(mutation):
    text = (ROOT / mutation.file).read_text()
    changed = mutated(mutation, text)
    assert changed != text
    if mutation.file.endswith(".py"):
        ast.parse(changed)


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda one: one.name)
def test_each_was_caught_by_cases_that_exist(mutation):
    assert mutation.caught_by
    assert set(mutation.caught_by) <= set(find(ROOT / "validation"))


def test_there_are_ten_in_model_balance_and_both_event_machines():
    assert len(MUTATIONS) >= 10
    assert len({one.name for one in MUTATIONS}) == len(MUTATIONS)
    for part in ("beltsim/model", "beltsim/harmonic_balance", "csrc/core", "csrc/event_map"):
        assert any(one.file.startswith(part) for one in MUTATIONS)


def test_the_page_shows_them():
    text = PAGE.read_text()
    assert text.partition(BEGIN)[2].partition(END)[0] == table(MUTATIONS)


def test_what_does_not_stand_there_once_is_refused():
    one = Mutation("toy", "toy", "toy.py", old="a", new="b")
    for text in ("", "aa"):
        with pytest.raises(ValueError, match="times"):
            mutated(one, text)


def test_unknown_names(capsys):
    assert main(["no such error"]) == 2
    assert "gyroscopic terms" in capsys.readouterr().err
