# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pieces of a fabric, in the order in which a hand knitter makes them.

A piece consists of rows that are worked on one needle. Each row of a piece takes loops that the previous row left on
the needle. A row continues the piece in two cases: it takes all loops that are not bound off, or it is a short row. A
short row takes some of the loops, and a later row takes the other loops together with the loops of the short row. A row
starts a new piece if it takes loops of several pieces, or some loops of a piece whose other loops are taken elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.mesh import BORDER, BOTTOM, LEFT, RIGHT, TOP, StitchMesh
from stitchmesh.mesh.courses import (
    Course,
    bottom_sides,
    course_of_faces,
    courses_below,
    find_courses,
    knitting_order,
    top_sides,
)
from stitchmesh.mesh.stitch import Stitch


@dataclass(frozen=True)
class PieceRow:
    """One row of a piece."""

    faces: tuple[int, ...]
    """Faces from left to right; a round is cut so that its last face is worked first."""
    right_side: bool
    """Whether the knitter looks at the right side of the fabric."""
    passed: int = 0
    """Number of loops that are left unworked before the first stitch."""
    left_over: int = 0
    """Number of loops that are left unworked after the last stitch, before the work is turned."""
    bound_off: tuple[int, ...] = ()
    """Loops that are bound off before the row, by their places on the needle, counted from 0 at the right."""


@dataclass
class Piece:
    """Rows on one needle."""

    in_rounds: bool
    """Whether the piece is worked in rounds; otherwise it is worked back and forth."""
    rows: list[PieceRow] = field(default_factory=list)
    """Rows in working order."""
    sources: list[int] = field(default_factory=list)
    """Top sides whose loops the piece starts with, in working order; ``BORDER`` for a loop that is cast on."""
    needle: list[int] = field(default_factory=list)
    """Top sides whose loops are on the needle, from left to right; in a round the last loop is worked first."""
    position: int = 0
    """Number of loops on the needle to the right of the yarn."""


def find_pieces(fabric: StitchMesh) -> list[Piece]:
    """Divide a fabric into pieces; each row comes after the rows that its loops come from.

    Raises:
        ParameterError: the fabric has panels that are not divided into stitches, or rows depend on each other in a
            cycle.
    """
    return _PieceFinder(fabric).pieces()


class _PieceFinder:
    """The courses of a fabric with their dependencies, and the assignment of courses to pieces."""

    def __init__(self, fabric: StitchMesh) -> None:
        panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
        if len(panels):
            raise ParameterError(
                f"face {panels[0]}: is a panel of a coarse mesh, not a stitch; tessellate the mesh first"
            )
        self.fabric = fabric
        self.courses = find_courses(fabric)
        self.number = course_of_faces(fabric, self.courses)
        self.below = courses_below(fabric, self.courses)
        self.above: list[set[int]] = [set() for _ in self.courses]
        for course, under in enumerate(self.below):
            for other in under:
                self.above[other].add(course)
        rest = knitting_order(self.below)[1]
        if rest:
            faces = sorted(self.courses[course].faces[0] for course in rest)
            raise ParameterError(
                f"face {first_few(faces)}: their rows depend on each other in a cycle, so that no row can be knitted "
                "first; hand knitting needs a fabric with a first row"
            )

    def pieces(self) -> list[Piece]:
        """Assign all courses: a course that continues the current piece comes first, then the lowest row number."""
        missing = [len(under) for under in self.below]
        ready = {course for course, count in enumerate(missing) if count == 0}
        made: list[Piece] = []
        while ready:
            row = self._next_row(ready, made[-1]) if made else None
            if row is None:
                course = min(ready, key=self._rank)
                made.append(self._new_piece(course))
            else:
                course = row[0]
                self._add_row(made[-1], course, row[1])
            ready.remove(course)
            for other in self.above[course]:
                missing[other] -= 1
                if missing[other] == 0:
                    ready.add(other)
        return made

    def _rank(self, course: int) -> tuple[int, int]:
        """Order of a course among others: its row number, then its own number."""
        face = self.courses[course].faces[0]
        return int(self.fabric.row[face]), course

    def _next_row(self, ready: set[int], piece: Piece) -> tuple[int, PieceRow] | None:
        """The first ready course that continues a piece, and its row; None if there is none."""
        last = self.number[piece.rows[-1].faces[0]]
        for course in sorted(ready & (self._near(piece) | self.above[last]), key=self._rank):
            row = self._round(piece, course) if self._is_round(course) else self._flat_row(piece, course)
            if row is not None:
                return course, row
        return None

    def _near(self, piece: Piece) -> set[int]:
        """Courses that take loops from the needle of a piece."""
        across = self.fabric.twin[piece.needle]
        across = across[across != BORDER]
        return {int(self.number[self.fabric.side_face[side]]) for side in across}

    def _is_round(self, course: int) -> bool:
        """Whether a course is closed, or continues in the course above or below as in a spiral."""
        found = self.courses[course]
        if found.closed:
            return True
        ends = self.fabric.right_wale[found.faces[-1]], self.fabric.left_wale[found.faces[0]]
        across = [int(self.fabric.twin[side]) for side in ends]
        return any(
            side != BORDER and self.fabric.side_role[side] == role and self._is_adjacent(course, side)
            for side, role in zip(across, (LEFT, RIGHT), strict=True)
        )

    def _is_adjacent(self, course: int, side: int) -> bool:
        """Whether a side belongs to a course directly above or below the given course."""
        other = int(self.number[self.fabric.side_face[side]])
        return other in self.above[course] or other in self.below[course]

    def _taken(self, faces: tuple[int, ...]) -> list[int]:
        """Top sides whose loops the given faces take, from left to right; ``BORDER`` for a loop that is cast on."""
        fabric = self.fabric
        taken = []
        for side in bottom_sides(fabric, faces):
            across = int(fabric.twin[side])
            if across != BORDER and fabric.side_role[across] == TOP:
                taken.append(across)
            elif fabric.stitch[fabric.side_face[side]] != Stitch.CAST_ON:
                taken.append(BORDER)
        return taken

    def _new_piece(self, course: int) -> Piece:
        """A new piece whose first row is the course."""
        found = self.courses[course]
        faces = self._rotate_to_start(found) if found.closed else found.faces
        piece = Piece(in_rounds=self._is_round(course), sources=self._taken(faces)[::-1])
        piece.rows.append(PieceRow(faces, right_side=bool(piece.sources)))
        piece.needle = top_sides(self.fabric, faces)
        piece.position = 0 if piece.in_rounds or not piece.sources else len(piece.needle)
        return piece

    def _rotate_to_start(self, course: Course) -> tuple[int, ...]:
        """The faces of a ring, rotated to start at a change of the course below, if there are several courses below."""
        below = [self._source_course(face) for face in course.faces]
        for place in range(len(below)):
            if below[place] != below[place - 1]:
                return course.faces[place:] + course.faces[:place]
        return course.faces

    def _source_course(self, face: int) -> int:
        """Course from which the first loop of a face comes, ``BORDER`` if there is none."""
        taken = self._taken((face,))
        return BORDER if not taken or taken[0] == BORDER else int(self.number[self.fabric.side_face[taken[0]]])

    def _round(self, piece: Piece, course: int) -> PieceRow | None:
        """The row of a course that takes all loops of a piece in rounds, in their cyclic order; else None."""
        found = self.courses[course]
        taken = self._taken(found.faces)
        if not piece.in_rounds or len(taken) != len(piece.needle) or not taken or set(taken) != set(piece.needle):
            return None
        if not found.closed:
            return PieceRow(found.faces, right_side=True) if taken == piece.needle else None
        first = taken.index(piece.needle[0])
        if taken[first:] + taken[:first] != piece.needle:
            return None
        return self._from_marker(piece, found)

    def _from_marker(self, piece: Piece, course: Course) -> PieceRow:
        """The round that starts at the end of the previous round.

        If a stitch takes loops from both sides of this place, the round starts with the next stitch.
        """
        ends = {self._taken((face,))[-1]: face for face in course.faces if self._taken((face,))}
        passed = next(passed for passed, side in enumerate(piece.needle[::-1]) if side in ends)
        end = course.faces.index(ends[piece.needle[len(piece.needle) - 1 - passed]]) + 1
        return PieceRow(course.faces[end:] + course.faces[:end], right_side=True, passed=passed)

    def _flat_row(self, piece: Piece, course: int) -> PieceRow | None:
        """The row of a course that takes neighbouring loops of a flat piece; None if it does not continue the piece."""
        faces = self.courses[course].faces
        taken = self._taken(faces)
        if piece.in_rounds or not taken or taken[0] not in piece.needle:
            return None
        first = piece.needle.index(taken[0])
        if piece.needle[first : first + len(taken)] != taken:
            return None
        left, right = first, len(piece.needle) - first - len(taken)
        free = [side for side in piece.needle if self.fabric.twin[side] == BORDER]
        bound_off: tuple[int, ...] = ()
        if left + right and len(free) == left + right:
            bound_off = tuple(i for i, side in enumerate(piece.needle[::-1]) if self.fabric.twin[side] == BORDER)
            left = right = 0
        elif left + right and not self._is_short(piece, course, taken):
            return None
        right_side = not piece.rows[-1].right_side
        return self._row_from_yarn(piece, faces, right_side, left, right, bound_off)

    def _row_from_yarn(
        self, piece: Piece, faces: tuple[int, ...], right_side: bool, left: int, right: int, bound_off: tuple[int, ...]
    ) -> PieceRow | None:
        """The row as it is worked from the place of the yarn; None if the yarn is beyond the first stitch.

        Args:
            piece: the piece, before the row.
            faces: faces of the row, from left to right.
            right_side: whether the knitter looks at the right side.
            left: number of loops on the needle to the left of the row.
            right: number of loops on the needle to the right of the row.
            bound_off: loops that are bound off first (``PieceRow.bound_off``).
        """
        before, after = (right, left) if right_side else (left, right)
        position = 0 if bound_off else piece.position if right_side else len(piece.needle) - piece.position
        if before < position:
            return None
        return PieceRow(faces, right_side, before - position, after, bound_off)

    def _is_short(self, piece: Piece, course: int, taken: list[int]) -> bool:
        """Whether later courses take the loops that this course leaves, together with the loops that it makes."""
        rest = set(piece.needle) - set(taken)
        across = [int(self.fabric.twin[side]) for side in rest]
        if any(side == BORDER or self.fabric.side_role[side] != BOTTOM for side in across):
            return False
        takers = {int(self.number[self.fabric.side_face[side]]) for side in across}
        highest = max(self._rank(taker)[0] for taker in takers)
        return takers <= self._reached_from(course, highest)

    def _reached_from(self, course: int, highest: int) -> set[int]:
        """Courses above the given course, directly or indirectly, up to a row."""
        reached, front = {course}, [course]
        while front:
            for other in self.above[front.pop()]:
                if other not in reached and self._rank(other)[0] <= highest:
                    reached.add(other)
                    front.append(other)
        return reached - {course}

    def _add_row(self, piece: Piece, course: int, row: PieceRow) -> None:
        """Add a row to a piece and update the loops on its needle and the position of the yarn."""
        taken, made = self._taken(row.faces), top_sides(self.fabric, row.faces)
        piece.rows.append(row)
        if piece.in_rounds:
            piece.needle = made
            return
        if row.bound_off:
            piece.needle = taken
        first = piece.needle.index(taken[0])
        right = len(piece.needle) - first - len(taken)
        piece.needle[first : first + len(taken)] = made
        piece.position = right + len(made) if row.right_side else right
