# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the user prepares on the page Rows: sizes and marks with undo, the chosen point, and a line that is begun."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from stitchmesh.app.pages.rows.mark_edits import Marks, with_line
from stitchmesh.app.project.shaping import Point, Shaping, shaping_of, shaping_table
from stitchmesh.editing.undo_history import UndoHistory
from stitchmesh.errors import ParameterError
from stitchmesh.shaping.marks import TimeMark


class RowsSession:
    """A shaping that changes, with what is chosen of it."""

    def __init__(self, shaping: Shaping) -> None:
        """Start with a shaping, in which nothing is chosen."""
        self._history = UndoHistory(shaping)
        self.chosen: int | None = None
        """Number of the chosen mark; None if none is chosen."""
        self.point = 0
        """Number of the chosen point of the chosen mark."""
        self.line: tuple[Point, ...] = ()
        """Points of a line that is begun."""
        self.on_change: Callable[[], object] = lambda: None
        """Called after each change of the shaping."""
        self.on_choice: Callable[[], object] = lambda: None
        """Called after another mark is chosen, or a line goes on."""

    @classmethod
    def of_settings(cls, settings: dict[str, Any], otherwise: Shaping) -> RowsSession:
        """Return the session that a project has kept; one that starts with another shaping if it has kept none."""
        return cls(shaping_of(settings["draft"]) if "draft" in settings else otherwise)

    @property
    def shaping(self) -> Shaping:
        """The sizes and marks."""
        return self._history.present

    @property
    def table(self) -> dict[str, Any]:
        """The shaping as a project can keep it."""
        return shaping_table(self.shaping)

    @property
    def marks(self) -> Marks:
        """The marks."""
        return self.shaping.marks

    def chosen_mark(self) -> tuple[int, TimeMark]:
        """Return the chosen mark and its number.

        Raises:
            ParameterError: none is chosen.
        """
        if self.chosen is None:
            raise ParameterError("mark: none is chosen; click one, or choose one in the list")
        return self.chosen, self.marks[self.chosen]

    def change(self, what: str = "", **values: Any) -> None:
        """Take other sizes or marks; changes of the same thing that follow each other are undone together."""
        shaping = replace(self.shaping, **values)
        if shaping != self.shaping:
            self._history = self._history.do(shaping, what)
        self._changed()

    def set_marks(self, marks: Marks, chosen: int | None = None, what: str = "") -> None:
        """Take other marks, and choose one of them; none if it does not exist."""
        self.chosen = chosen
        self.change(what, marks=marks)

    def choose(self, mark: int | None, point: int = 0) -> None:
        """Choose a mark and one of its points."""
        self.chosen, self.point = mark, point
        self._keep_choice()
        self.on_choice()

    def go_on(self, point: Point) -> None:
        """Add a point to the line that is begun, or begin one."""
        self.line = (*self.line, point)
        self.on_choice()

    def finish_line(self) -> None:
        """Make a mark of the line that is begun.

        Raises:
            ParameterError: the line has fewer than two points.
        """
        if not self.line:
            raise ParameterError("line: none is begun; choose that a click draws a line, and click its points")
        marks = with_line(self.marks, self.line)
        self.line = ()
        self.set_marks(marks, len(marks) - 1)

    def undo(self) -> None:
        """Take back the last point of a line that is begun, or else the last change.

        Raises:
            ParameterError: there is none.
        """
        if self.line:
            self.line = self.line[:-1]
            self.on_choice()
            return
        self._history = self._history.undo("undo: there is no change of the rows to undo")
        self._changed()

    def redo(self) -> None:
        """Make the change again that was undone last.

        Raises:
            ParameterError: there is none.
        """
        self._history = self._history.redo("redo: there is no change of the rows to redo")
        self._changed()

    def _changed(self) -> None:
        self._keep_choice()
        self.on_change()

    def _keep_choice(self) -> None:
        """Choose nothing that does not exist."""
        if self.chosen is not None and not 0 <= self.chosen < len(self.marks):
            self.chosen = None
        points = 1 if self.chosen is None else len(self.marks[self.chosen].points)
        self.point = min(max(self.point, 0), points - 1)
