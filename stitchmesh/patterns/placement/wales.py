# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Placement of a pattern on a whole garment: its columns follow the wales, so that ribs run straight.

Columns are assigned to the loops of every row that starts a fabric and are carried upwards from loop to loop. A
decrease passes on the column of the loop that shows. An increase makes new columns; they continue the columns of the
neighbour on the side away from the increase's own loop. The pattern therefore opens or closes at the line of shaping
and stays whole beside it. A pattern with increases and decreases needs space for whole tiles: where a repeat begins and
the tile of a column does not fit, new tiles are placed beside it.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, TOP, IntArray, StitchMesh
from stitchmesh.mesh.courses import (
    Course,
    bottom_sides,
    course_of_faces,
    courses_below,
    find_courses,
    knitting_order,
    sides_across,
    top_sides,
)
from stitchmesh.mesh.stitch import VOCABULARY, Making, Stitch
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.columns import OUTSIDE, Remainder, is_tile, keeps_counts, lay_out
from stitchmesh.patterns.placement.placement import Placement, is_worked
from stitchmesh.patterns.placement.tile_fit import TileFit

_UNKNOWN = OUTSIDE - 1
"""Column of a loop to which no row below passes on a column."""


def follow_wales(fabric: StitchMesh, pattern: Pattern, remainder: Remainder) -> Placement:
    """Place a pattern on every stitch of a garment; its first row lies on the cast-on row.

    Raises:
        ParameterError: ``remainder`` is ``refuse`` and whole tiles do not cover a first row.
    """
    return _WalePlacement(fabric, pattern, remainder).placement()


class _WalePlacement:
    """Columns of all loops and faces, filled row by row from below."""

    def __init__(self, fabric: StitchMesh, pattern: Pattern, remainder: Remainder) -> None:
        self.fabric, self.pattern, self.remainder = fabric, pattern, remainder
        self.tile_fit = None if keeps_counts(pattern) else TileFit(fabric, pattern, remainder)
        self.courses = find_courses(fabric)
        self.course_of = course_of_faces(fabric, self.courses)
        self.level = np.full(len(self.courses), -1)  # rows of the pattern below each course; -1 for a cast-on row
        self.above = np.full(fabric.side_count, _UNKNOWN)  # column that each top side passes on
        self.column = np.full(fabric.face_count, OUTSIDE)

    def placement(self) -> Placement:
        """Carry the columns through all courses and return the placement."""
        order, left = knitting_order(courses_below(self.fabric, self.courses))
        for number in [*order, *left]:
            self._carry(number)
        level = self.level[self.course_of]
        placed = is_worked(self.fabric) & (level >= 0)
        return Placement(np.where(placed, self.column, OUTSIDE), level % self.pattern.height)

    def _carry(self, number: int) -> None:
        course, fabric = self.courses[number], self.fabric
        faces = np.array(course.faces)
        below, known = self._columns_below(number)
        tops = np.array(top_sides(fabric, course.faces), dtype=np.int64)
        cast_on = fabric.stitch[faces] == Stitch.CAST_ON
        if known:
            below = _fill_unknown(below, course.closed)
            self.level[number] += 1
        elif cast_on.all():
            self.above[tops] = self._lay_out(len(tops), course)
            return
        else:
            below = self._lay_out(len(below), course)
            self.level[number] = 0
        own = _own_columns(fabric, faces, below)
        if self.tile_fit and self.level[number] % self.pattern.height == 0:
            own = self._fit_tiles(self.tile_fit, faces, own, course.closed, first=self.level[number] == 0)
        self.column[faces] = own
        self.above[tops] = _columns_made(fabric, faces, own, course.closed)

    def _columns_below(self, number: int) -> tuple[IntArray, bool]:
        """Return the columns of the loops below a course, and whether any is known; set the level to the one below."""
        fabric = self.fabric
        bottoms = np.array(bottom_sides(fabric, self.courses[number].faces), dtype=np.int64)
        sides = sides_across(fabric, bottoms, TOP)
        columns = np.where(sides == BORDER, _UNKNOWN, self.above[sides])
        under = self.course_of[fabric.side_face[sides[columns != _UNKNOWN]]]
        if len(under):
            self.level[number] = self.level[under].max()
        return columns, len(under) > 0

    @staticmethod
    def _fit_tiles(tile_fit: TileFit, faces: IntArray, own: IntArray, closed: bool, *, first: bool) -> IntArray:
        """Return columns with whole tiles; in a first row, all tiles may move if more tiles fit then."""
        fitted = tile_fit.fit(faces, own, closed)
        if first:
            moved = tile_fit.fit(faces, np.where(is_tile(own), OUTSIDE, own), closed)
            return max(fitted, moved, key=lambda columns: int(is_tile(columns).sum()))
        return fitted

    def _lay_out(self, count: int, course: Course) -> IntArray:
        where = f"row {self.fabric.row[course.faces[0]]} (face {course.faces[0]})"
        return lay_out(self.pattern, count, closed=course.closed, remainder=self.remainder, where=where)


def _fill_unknown(columns: IntArray, closed: bool) -> IntArray:
    """Return the columns with unknown ones continued from the left, or from the right if none is known on the left."""
    known = np.flatnonzero(columns != _UNKNOWN)
    if len(known) == len(columns):
        return columns
    places = np.arange(len(columns))
    before = np.searchsorted(known, places, side="right") - 1
    source = known[before] - np.where((before < 0) & closed, len(columns), 0)
    source = np.where((before < 0) & (not closed), known[0], source)
    columns = columns[source % len(columns)]
    return np.where(is_tile(columns), columns + places - source, np.where(places == source, columns, OUTSIDE))


def _own_columns(fabric: StitchMesh, faces: IntArray, below: IntArray) -> IntArray:
    """Return the column of each face: that of its loop or, for a decrease, that of the loop that shows."""
    count = fabric.n_bottom[faces]
    shown = np.where(count > 1, _SHOWN[fabric.stitch[faces]], 0)
    places = np.minimum(np.cumsum(count) - count + shown, max(len(below) - 1, 0))
    return np.where(count > 0, below[places] if len(below) else OUTSIDE, OUTSIDE)


def _columns_made(fabric: StitchMesh, faces: IntArray, own: IntArray, closed: bool) -> IntArray:
    """Return the columns of all loops that a course makes, left to right."""
    count = fabric.n_top[faces]
    made = np.repeat(own, count)
    first = np.cumsum(count) - count
    for index in np.flatnonzero((count > 1) | ((count > 0) & (fabric.n_bottom[faces] == 0))):
        left = own[index - 1] if index or closed else OUTSIDE
        right = own[(index + 1) % len(own)] if index + 1 < len(own) or closed else OUTSIDE
        making = VOCABULARY.get(Stitch(int(fabric.stitch[faces[index]])))
        main = _main_loop(making) if making else 0
        made[first[index] : first[index] + count[index]] = [
            _column_beside(place, main, count[index], int(left), int(own[index]), int(right))
            for place in range(count[index])
        ]
    return made


def _main_loop(making: Making) -> int:
    """Return the index of the loop of an increase that keeps the column.

    It is the first loop, or the last loop if the first is a yarn-over, or the middle loop if both are yarn-overs.
    """
    if making.made[0] != "y":
        return 0
    return len(making.made) - 1 if making.made[-1] != "y" else len(making.made) // 2


def _column_beside(place: int, main: int, count: int, left: int, own: int, right: int) -> int:
    """Return the column of a loop of an increase.

    New columns left of the main loop continue those of the left neighbour; new columns right of it continue those of
    the right neighbour.

    Args:
        place: index of the loop in the increase.
        main: index of the loop that keeps the column.
        count: number of loops of the increase.
        left: column of the left neighbour.
        own: column of the increase.
        right: column of the right neighbour.
    """
    if place == main and own != OUTSIDE:
        return own
    neighbours = [(left, place + 1), (own, place - main), (right, place - count)]
    if place > main:
        neighbours.reverse()
    return next((column + steps for column, steps in neighbours if is_tile(np.array(column))), OUTSIDE)


def _shown_loops() -> IntArray:
    """Return the index of the loop in front of each decrease, as seen from the side on which it is knit."""
    shown = np.zeros(max(Stitch) + 1, dtype=np.int64)
    for stitch, making in VOCABULARY.items():
        if making.n_bottom > 1:
            shown[stitch] = (making.order[-1] if making.made == "p" else making.order[0]) - 1
    return shown


_SHOWN = _shown_loops()
