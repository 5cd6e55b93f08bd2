# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The state of the page Rows: sizes and marks with undo, the borders that marks name, and the meaning of a click."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stitchmesh.app.project.shaping import Point, Shaping, plain_mark, shaping_of, shaping_table
from stitchmesh.editing.undo_history import UndoHistory
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray, Mesh
from stitchmesh.shaping.marks import UNTIMED, TimeMark

AUTOMATIC = "automatic"
"""Role of a border without a mark."""


class MeshBorders:
    """The borders of one mesh, by number."""

    def __init__(self, mesh: Mesh) -> None:
        """Find the borders."""
        self.mesh = mesh
        self.loops: tuple[IntArray, ...] = mesh.boundary_loops
        """The sides along each border, in order."""

    @property
    def sides(self) -> IntArray:
        """The sides along all borders."""
        return np.concatenate([np.zeros(0, dtype=np.int64), *self.loops])

    def of_side(self, side: int) -> int:
        """Return the border to which a side belongs."""
        return next(number for number, loop in enumerate(self.loops) if side in loop)

    def point(self, number: int) -> Point:
        """Return the point by which a mark names a border [cm]: the first vertex along it."""
        x, y, z = self.mesh.corner_position[self.loops[number][0]].tolist()
        return x, y, z

    def nearest(self, point: Sequence[float]) -> int | None:
        """Return the border nearest to a point [cm], which is the border of a mark there; None without borders."""
        position, place = self.mesh.corner_position, np.asarray(point, dtype=np.float64)
        away = [float(np.linalg.norm(position[loop] - place, axis=1).min()) for loop in self.loops]
        return int(np.argmin(away)) if away else None

    def mark_of(self, marks: Sequence[TimeMark], number: int) -> int | None:
        """Return the number of the mark that names a border; None if no mark does."""
        for place, mark in enumerate(marks):
            if mark.kind == "border" and self.nearest(mark.points[0]) == number:
                return place
        return None

    def role_of(self, marks: Sequence[TimeMark], number: int) -> str:
        """Return the role that a mark gives a border."""
        mark = self.mark_of(marks, number)
        return AUTOMATIC if mark is None else marks[mark].role

    def words(self, number: int) -> str:
        """Describe a border by its length and its height above the lowest point of the mesh."""
        loop = self.loops[number]
        length = float(self.mesh.side_length[loop].sum())
        height = float(self.mesh.corner_position[loop, 1].mean() - self.mesh.vertices[:, 1].min())
        return f"border of {length:.0f} cm at height {height:.0f} cm"


Marks = tuple[TimeMark, ...]
"""Marks in the order in which they were made."""


def with_next_role(marks: Marks, borders: MeshBorders, number: int) -> Marks:
    """Return the marks after a click at a border: consecutive clicks give it one role after another."""
    cycle, role = (AUTOMATIC, "begin", "end", "side"), borders.role_of(marks, number)
    after = cycle[(cycle.index(role) + 1) % len(cycle)] if role in cycle else AUTOMATIC
    return with_border_role(marks, borders, number, after)


def with_border_role(marks: Marks, borders: MeshBorders, number: int, role: Any) -> Marks:
    """Return the marks after a change of the role of a border; a border with an automatic role has no mark."""
    mark = borders.mark_of(marks, number)
    if role == AUTOMATIC:
        return marks if mark is None else without_mark(marks, mark)
    if mark is not None:
        return with_role(marks, mark, role)
    return (*marks, TimeMark("border", (borders.point(number),), role))


def with_role(marks: Marks, number: int, role: Any) -> Marks:
    """Return the marks with another role of one mark; only some roles have a time, and only plain places a radius.

    Raises:
        ParameterError: the mark cannot have the role.
    """
    mark = marks[number]
    time, radius = None if role in UNTIMED else mark.time, mark.radius if role == "plain" else None
    return with_mark(marks, number, replace(mark, role=role, time=time, radius=radius))


def with_point(marks: Marks, number: int, place: int, point: Point) -> Marks:
    """Return the marks after one point of a mark has moved.

    Raises:
        ParameterError: the mark is a border.
    """
    mark = marks[number]
    if mark.kind == "border":
        raise ParameterError("move: a border has no points; choose a tip or a line")
    points = [*mark.points[:place], point, *mark.points[place + 1 :]]
    return with_mark(marks, number, plain_mark(replace(mark, points=points)))


def without_point(marks: Marks, number: int, place: int) -> Marks:
    """Return the marks without one point of a mark; a line that keeps only one point is dropped."""
    points = [*marks[number].points[:place], *marks[number].points[place + 1 :]]
    if len(points) < 2:
        return without_mark(marks, number)
    return with_mark(marks, number, plain_mark(replace(marks[number], points=points)))


def without_mark(marks: Marks, number: int) -> Marks:
    """Return the marks without one of them."""
    return (*marks[:number], *marks[number + 1 :])


def with_mark(marks: Marks, number: int, mark: TimeMark) -> Marks:
    """Return the marks in which another mark replaces one of them."""
    return (*marks[:number], mark, *marks[number + 1 :])


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

    def with_tip(self, point: Point) -> RowsState:
        """Add a tip at which knitting ends."""
        return self.with_marks((*self.marks, TimeMark("point", (point,), "end")), len(self.marks))

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
        if len(self.line) < 2:
            raise ParameterError("line: has one point; click where it goes on, or put a tip instead")
        marks = (*self.marks, TimeMark("stroke", self.line, "row"))
        return replace(self, line=()).with_marks(marks, len(self.marks))

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
