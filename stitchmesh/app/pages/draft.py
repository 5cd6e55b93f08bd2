# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A value that a user prepares on a page, with its earlier values for undo."""

from __future__ import annotations

from typing import Generic, TypeVar

from stitchmesh.errors import ParameterError

T = TypeVar("T")


class Draft(Generic[T]):
    """A value that changes, and its earlier values."""

    def __init__(self, value: T, words: str) -> None:
        """Start with a value; ``words`` say what it is, for messages."""
        self.value = value
        self._words = words
        self._done: list[T] = []
        self._undone: list[T] = []
        self._last = ""

    def change(self, value: T, what: str = "") -> None:
        """Take another value; ``undo`` returns to the present one.

        Args:
            value: the value.
            what: what changes; changes of the same thing that follow each other, as a slider makes them, are undone
                together. Without it, a change is undone alone.
        """
        if value == self.value:
            return
        if not what or what != self._last or self._undone:
            self._done.append(self.value)
        self._undone.clear()
        self.value, self._last = value, what

    def undo(self) -> None:
        """Return to the value before the last change.

        Raises:
            ParameterError: there is none.
        """
        self._step(self._done, self._undone, "undo")

    def redo(self) -> None:
        """Make the change again that was undone last.

        Raises:
            ParameterError: there is none.
        """
        self._step(self._undone, self._done, "redo")

    def _step(self, source: list[T], target: list[T], what: str) -> None:
        if not source:
            raise ParameterError(f"{what}: there is no change of {self._words} to {what}")
        target.append(self.value)
        self.value, self._last = source.pop(), ""
