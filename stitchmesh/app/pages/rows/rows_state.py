# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The state of the page Rows: sizes and marks with undo, the chosen mark, and the meaning of a click."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from stitchmesh.app.pages.rows.marks import Marks, with_line
from stitchmesh.app.project.shaping import Point, Shaping, shaping_of, shaping_table
from stitchmesh.editing.undo_history import UndoHistory
from stitchmesh.errors import ParameterError
from stitchmesh.shaping.marks import TimeMark

BORDER, TIP, LINE, MOVE = "marks a border", "puts a tip", "draws a line", "moves the chosen point"
"""The meanings of a click."""
ROWS, STITCHES = "rows", "stitches"
"""The choices of what the page shows."""


@dataclass(frozen=True)
class RowsState:
    """A shaping that the user prepares, and the user's choices. Each method returns the state after an action."""

    history: UndoHistory[Shaping]
    """The sizes and marks, with undo."""
    chosen: int | None = None
    """Number of the chosen mark; None if none is chosen."""
    point: int = 0
    """Number of the chosen point of the chosen mark."""
    line: tuple[Point, ...] = ()
    """Points of an unfinished line."""
    meaning: str = BORDER
    """The meaning of a click."""
    shown: str = ROWS
    """Whether the page shows rows or, where there are any, stitches."""

    @classmethod
    def of_settings(cls, settings: dict[str, Any], otherwise: Shaping) -> RowsState:
        """Return the state from a project's settings; without one, a state with another shaping."""
        return cls(UndoHistory(shaping_of(settings["draft"]) if "draft" in settings else otherwise))

    @property
    def shaping(self) -> Shaping:
        """The sizes and marks."""
        return self.history.present

    @property
    def table(self) -> dict[str, Any]:
        """The shaping as a table that a project can keep."""
        return shaping_table(self.shaping)

    @property
    def marks(self) -> Marks:
        """The marks."""
        return self.shaping.marks

    @property
    def handle(self) -> tuple[int, int] | None:
        """Number of the chosen mark, and of its chosen point; None if none is chosen."""
        return None if self.chosen is None else (self.chosen, self.point)

    @property
    def aims(self) -> bool:
        """Whether a click means a place even on a point of a mark."""
        return bool(self.line) or (self.meaning == MOVE and self.chosen is not None)

    def chosen_mark(self) -> tuple[int, TimeMark]:
        """Return the chosen mark and its number.

        Raises:
            ParameterError: no mark is chosen.
        """
        if self.chosen is None:
            raise ParameterError("mark: none is chosen; click one, or choose one in the list")
        return self.chosen, self.marks[self.chosen]

    def with_shaping(self, shaping: Shaping, what: str = "") -> RowsState:
        """Take another shaping; consecutive changes of the same thing are undone together."""
        return self._with(history=self.history if shaping == self.shaping else self.history.do(shaping, what))

    def with_marks(self, marks: Marks, chosen: int | None = None, what: str = "") -> RowsState:
        """Take other marks, and choose one of them; choose none if it does not exist."""
        return replace(self, chosen=chosen).with_shaping(replace(self.shaping, marks=marks), what)

    def choosing(self, mark: int | None, point: int = 0) -> RowsState:
        """Choose a mark and one of its points."""
        return self._with(chosen=mark, point=point)

    def with_line_point(self, point: Point) -> RowsState:
        """Add a point to the unfinished line, or begin one."""
        return replace(self, line=(*self.line, point))

    def with_finished_line(self) -> RowsState:
        """Make a mark of the unfinished line.

        Raises:
            ParameterError: the line has fewer than two points.
        """
        if not self.line:
            raise ParameterError("line: none is begun; choose that a click draws a line, and click its points")
        return replace(self, line=()).with_marks(with_line(self.marks, self.line), len(self.marks))

    def undone(self) -> RowsState:
        """Remove the last point of an unfinished line, or else undo the last change.

        Raises:
            ParameterError: there is none.
        """
        if self.line:
            return replace(self, line=self.line[:-1])
        return self._with(history=self.history.undo("undo: there is no change of the rows to undo"))

    def redone(self) -> RowsState:
        """Make the last undone change again.

        Raises:
            ParameterError: there is none.
        """
        return self._with(history=self.history.redo("redo: there is no change of the rows to redo"))

    def _with(self, **values: Any) -> RowsState:
        """Return the state with other values; choices that do not exist any more are dropped."""
        state = replace(self, **values)
        chosen = state.chosen
        if chosen is not None and not 0 <= chosen < len(state.marks):
            chosen = None
        points = 1 if chosen is None else len(state.marks[chosen].points)
        return replace(state, chosen=chosen, point=min(max(state.point, 0), points - 1))
