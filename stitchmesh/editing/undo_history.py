# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Undo and redo of a value that never changes: the present value, earlier values, and values that were undone.

If a value is large, the history holds the steps to it instead. The present entry is then the last step; it is None at
the start, before the first step.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from stitchmesh.errors import ParameterError

T = TypeVar("T")


@dataclass(frozen=True)
class UndoHistory(Generic[T]):
    """A value or a step, with the entries to which undo and redo lead."""

    present: T
    past: tuple[T, ...] = ()
    """Earlier entries, the oldest first."""
    future: tuple[T, ...] = ()
    """Entries that were undone, the next entry to redo first."""
    what: str = ""
    """Name of what the last change has changed; empty if the next change is undone alone."""

    def do(self, entry: T, what: str = "", most: int = sys.maxsize) -> UndoHistory[T]:
        """Return the history after a change, with nothing to redo.

        Args:
            entry: the present entry after the change.
            what: name of what changes. Consecutive changes with the same name, such as those of a slider, are undone
                together. Without it, a change is undone alone.
            most: largest number of earlier entries that are kept.
        """
        if what and what == self.what:
            return UndoHistory(entry, self.past, what=what)
        return UndoHistory(entry, (*self.past, self.present)[-most:], what=what)

    def undo(self, refusal: str) -> UndoHistory[T]:
        """Return the history before the last change.

        Raises:
            ParameterError: there is no change to undo; ``refusal`` is the message.
        """
        if not self.past:
            raise ParameterError(refusal)
        return UndoHistory(self.past[-1], self.past[:-1], (self.present, *self.future))

    def redo(self, refusal: str) -> UndoHistory[T]:
        """Return the history in which the last undone change is made again.

        Raises:
            ParameterError: there is no change to redo; ``refusal`` is the message.
        """
        if not self.future:
            raise ParameterError(refusal)
        return UndoHistory(self.future[0], (*self.past, self.present), self.future[1:])


def history_of_steps(done: Sequence[T] = (), undone: Sequence[T] = ()) -> UndoHistory[T | None]:
    """Return the history of the steps that were taken, and of the steps to redo, the next one first."""
    *past, present = (None, *done)
    return UndoHistory(present, tuple(past), tuple(undone))


def steps_done(history: UndoHistory[T | None]) -> tuple[T, ...]:
    """Return the steps that lead from the start to the present."""
    return tuple(step for step in (*history.past, history.present) if step is not None)


def steps_undone(history: UndoHistory[T | None]) -> tuple[T, ...]:
    """Return the steps to redo, the next one first."""
    return tuple(step for step in history.future if step is not None)
