# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A pattern on a whole garment: its columns follow the wales, so that ribs run straight.

Columns are laid along every row that starts a fabric and are carried upwards, loop by loop. A decrease hands on the
column of the loop that shows; an increase makes columns anew, which go on from the side that lies away from its own
loop, so that the pattern closes or opens at the line of shaping and stays whole beside it. A pattern of changing counts
needs room for whole tiles; where a repeat begins and there is none above a column, tiles are laid anew beside it.
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
"""Column of a loop that no row below hands on."""


def follow_wales(fabric: StitchMesh, pattern: Pattern, remainder: Remainder) -> Placement:
    """Lay a pattern on every stitch of a garment; its first row stands on the cast-on row.

    Raises:
        ParameterError: a first row's loops do not divide, and ``remainder`` is ``refuse``.
    """
    return _Wales(fabric, pattern, remainder).placement()


class _Wales:
    """Columns of all loops so far, rows from below."""

    def __init__(self, fabric: StitchMesh, pattern: Pattern, remainder: Remainder) -> None:
        self.fabric, self.pattern, self.remainder = fabric, pattern, remainder
        self.room = None if keeps_counts(pattern) else TileFit(fabric, pattern, remainder)
        self.courses = find_courses(fabric)
        self.course_of = course_of_faces(fabric, self.courses)
        self.level = np.full(len(self.courses), -1)  # rows of the pattern below each course; -1 of a cast-on row
        self.above = np.full(fabric.side_count, _UNKNOWN)  # column handed on by each top side
        self.column = np.full(fabric.face_count, OUTSIDE)

    def placement(self) -> Placement:
        """Carry columns through all courses."""
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
            below = _filled(below, course.closed)
            self.level[number] += 1
        elif cast_on.all():
            self.above[tops] = self._lay_out(len(tops), course)
            return
        else:
            below = self._lay_out(len(below), course)
            self.level[number] = 0
        own = _own_columns(fabric, faces, below)
        if self.room and self.level[number] % self.pattern.height == 0:
            own = self._settled(self.room, faces, own, course.closed, first=self.level[number] == 0)
        self.column[faces] = own
        self.above[tops] = _columns_made(fabric, faces, own, course.closed)

    def _columns_below(self, number: int) -> tuple[IntArray, bool]:
        """Columns of the loops that a course stands on, and whether any is known; sets its level to that below."""
        fabric = self.fabric
        bottoms = np.array(bottom_sides(fabric, self.courses[number].faces), dtype=np.int64)
        sides = sides_across(fabric, bottoms, TOP)
        columns = np.where(sides == BORDER, _UNKNOWN, self.above[sides])
        under = self.course_of[fabric.side_face[sides[columns != _UNKNOWN]]]
        if len(under):
            self.level[number] = self.level[under].max()
        return columns, len(under) > 0

    @staticmethod
    def _settled(room: TileFit, faces: IntArray, own: IntArray, closed: bool, *, first: bool) -> IntArray:
        """Columns with room for whole tiles; in a first row all tiles may move if more then fit."""
        settled = room.settle(faces, own, closed)
        if first:
            moved = room.settle(faces, np.where(is_tile(own), OUTSIDE, own), closed)
            return max(settled, moved, key=lambda columns: int(is_tile(columns).sum()))
        return settled

    def _lay_out(self, count: int, course: Course) -> IntArray:
        where = f"row {self.fabric.row[course.faces[0]]} (face {course.faces[0]})"
        return lay_out(self.pattern, count, closed=course.closed, remainder=self.remainder, where=where)


def _filled(columns: IntArray, closed: bool) -> IntArray:
    """Columns that go on over unknown loops: from the left, and where there is nothing, from the right."""
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
    """Column of each face: that of its loop, of several the one that shows."""
    count = fabric.n_bottom[faces]
    shown = np.where(count > 1, _SHOWN[fabric.stitch[faces]], 0)
    places = np.minimum(np.cumsum(count) - count + shown, max(len(below) - 1, 0))
    return np.where(count > 0, below[places] if len(below) else OUTSIDE, OUTSIDE)


def _columns_made(fabric: StitchMesh, faces: IntArray, own: IntArray, closed: bool) -> IntArray:
    """Columns of all loops that a course leaves, left to right."""
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
    """Which loop of an increase carries its column on: the first that is no yarn-over, seen from outside."""
    if making.made[0] != "y":
        return 0
    return len(making.made) - 1 if making.made[-1] != "y" else len(making.made) // 2


def _column_beside(place: int, main: int, count: int, left: int, own: int, right: int) -> int:
    """Column of a loop of an increase: new ones left of the main loop go on from the left, and so from the right."""
    if place == main and own != OUTSIDE:
        return own
    neighbours = [(left, place + 1), (own, place - main), (right, place - count)]
    if place > main:
        neighbours.reverse()
    return next((column + steps for column, steps in neighbours if is_tile(np.array(column))), OUTSIDE)


def _shown_loops() -> IntArray:
    """Of each decrease the place of the loop in front, seen from the side where it is knit."""
    shown = np.zeros(max(Stitch) + 1, dtype=np.int64)
    for stitch, making in VOCABULARY.items():
        if making.n_bottom > 1:
            shown[stitch] = (making.order[-1] if making.made == "p" else making.order[0]) - 1
    return shown


_SHOWN = _shown_loops()
