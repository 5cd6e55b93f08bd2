# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Undo and redo return each earlier value, whether the history holds values or steps."""

from __future__ import annotations

from functools import reduce

import pytest

from stitchmesh.editing.undo_history import UndoHistory, history_of_steps, steps_done, steps_undone
from stitchmesh.errors import ParameterError


def counted(last: int) -> UndoHistory[int]:
    """The history of the numbers up to the last one."""
    return reduce(UndoHistory.do, range(1, last + 1), UndoHistory(0))


def test_undo_and_redo_return_each_value():
    back = counted(4)
    for value in (3, 2, 1, 0):
        back = back.undo("none")
        assert back.present == value
    for value in (1, 2, 3, 4):
        back = back.redo("none")
        assert back.present == value
    assert back == counted(4)


def test_a_change_forgets_what_was_undone():
    changed = counted(3).undo("none").do(9)
    assert changed.future == () and changed.undo("none").present == 2


def test_nothing_to_undo_or_redo_is_refused_with_the_words_of_the_caller():
    with pytest.raises(ParameterError, match="no step to undo"):
        UndoHistory(0).undo("no step to undo")
    with pytest.raises(ParameterError, match="no step to redo"):
        counted(3).redo("no step to redo")


def test_changes_of_one_thing_that_follow_each_other_are_undone_together():
    moved = UndoHistory(0).do(1, "width").do(2, "width").do(3, "height").do(4, "width")
    assert moved.past == (0, 2, 3)
    back = moved.undo("none").undo("none")
    assert back.present == 2
    assert back.do(5, "width").past == (0, 2), "a change after undo is a step of its own"
    assert UndoHistory(0).do(1).do(2).past == (0, 1), "changes without a name are undone alone"


def test_only_the_newest_values_are_kept():
    kept = UndoHistory(0)
    for value in range(1, 9):
        kept = kept.do(value, most=3)
    assert kept.past == (5, 6, 7)


def test_a_history_of_steps_begins_before_the_first_step():
    start: UndoHistory[str | None] = history_of_steps()
    knitted = start.do("cast on").do("knit").do("knit").undo("none")
    assert knitted == history_of_steps(["cast on", "knit"], ["knit"])
    assert steps_done(knitted) == ("cast on", "knit") and steps_undone(knitted) == ("knit",)
    unravelled = knitted.undo("none").undo("none")
    assert steps_done(unravelled) == () and steps_undone(unravelled) == ("cast on", "knit", "knit")
    assert unravelled.present is None and not unravelled.past
