# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Pieces of a fabric in the order in which a hand knitter makes them.

A piece is what stays on one needle: each of its rows takes up the loops that the row before left there. A row that
takes all of them, or those that are not bound off, goes on with the piece; so does a short row, one that takes some
loops while a later row takes the others together with what the short row made. A row that takes loops of several
pieces, or some of a piece whose others go elsewhere, begins a new one.
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
    """From left to right; those of a round so that the last is worked first."""
    right_side: bool
    """Whether the right side faces the knitter."""
    passed: int = 0
    """Loops that are passed over, unworked, before the first stitch."""
    left_over: int = 0
    """Loops that are still on the needle after the last stitch, when the work is turned."""
    bound_off: tuple[int, ...] = ()
    """Loops bound off before it, by their places on the needle, counted from 0 at the right."""


@dataclass
class Piece:
    """Rows on one needle."""

    in_rounds: bool
    rows: list[PieceRow] = field(default_factory=list)
    sources: list[int] = field(default_factory=list)
    """Top sides whose loops it starts with, ``BORDER`` for one cast on, in the order in which they are worked."""
    needle: list[int] = field(default_factory=list)
    """Top sides whose loops are on the needle, from left to right; of a round, the last is worked first."""
    position: int = 0
    """Loops to the right of the place where the yarn is."""


def find_pieces(fabric: StitchMesh) -> list[Piece]:
    """All rows of a fabric, piece by piece, each after what it stands on.

    Raises:
        ParameterError: the fabric is not made of stitches yet, or rows stand on each other in a circle.
    """
    return _Making(fabric).pieces()


class _Making:
    """The courses of a fabric, and the pieces as far as they are made."""

    def __init__(self, fabric: StitchMesh) -> None:
        panels = np.flatnonzero(fabric.stitch == Stitch.PANEL)
        if len(panels):
            raise ParameterError(f"face {panels[0]}: is a panel of a coarse mesh, not a stitch; tessellate it first")
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
                f"face {first_few(faces)}: their rows stand on each other in a circle, so none can be knitted first; "
                "a hand knitter needs a fabric with a first row"
            )

    def pieces(self) -> list[Piece]:
        """Rows while there are any: those that go on with the piece at hand first, then by their numbers."""
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
        face = self.courses[course].faces[0]
        return int(self.fabric.row[face]), course

    def _next_row(self, ready: set[int], piece: Piece) -> tuple[int, PieceRow] | None:
        """The first course that goes on with a piece."""
        last = self.number[piece.rows[-1].faces[0]]
        for course in sorted(ready & (self._near(piece) | self.above[last]), key=self._rank):
            row = self._round(piece, course) if self._is_round(course) else self._flat_row(piece, course)
            if row is not None:
                return course, row
        return None

    def _near(self, piece: Piece) -> set[int]:
        """Courses that take loops of a piece's needle."""
        across = self.fabric.twin[piece.needle]
        across = across[across != BORDER]
        return {int(self.number[self.fabric.side_face[side]]) for side in across}

    def _is_round(self, course: int) -> bool:
        """Whether a course closes, or goes on in the next as a spiral does."""
        found = self.courses[course]
        if found.closed:
            return True
        ends = self.fabric.right_wale[found.faces[-1]], self.fabric.left_wale[found.faces[0]]
        across = [int(self.fabric.twin[side]) for side in ends]
        return any(
            side != BORDER and self.fabric.side_role[side] == role and self._meets(course, side)
            for side, role in zip(across, (LEFT, RIGHT), strict=True)
        )

    def _meets(self, course: int, side: int) -> bool:
        """Whether a side is of a course directly above or below."""
        other = int(self.number[self.fabric.side_face[side]])
        return other in self.above[course] or other in self.below[course]

    def _taken(self, faces: tuple[int, ...]) -> list[int]:
        """Top sides whose loops some faces take, from left to right; ``BORDER`` where a loop is cast on for them."""
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
        found = self.courses[course]
        faces = self._turned_to_start(found) if found.closed else found.faces
        piece = Piece(in_rounds=self._is_round(course), sources=self._taken(faces)[::-1])
        piece.rows.append(PieceRow(faces, right_side=bool(piece.sources)))
        piece.needle = top_sides(self.fabric, faces)
        piece.position = 0 if piece.in_rounds or not piece.sources else len(piece.needle)
        return piece

    def _turned_to_start(self, course: Course) -> tuple[int, ...]:
        """The faces of a ring, turned so that it starts where loops of another row begin, if there are several."""
        below = [self._source_course(face) for face in course.faces]
        for place in range(len(below)):
            if below[place] != below[place - 1]:
                return course.faces[place:] + course.faces[:place]
        return course.faces

    def _source_course(self, face: int) -> int:
        taken = self._taken((face,))
        return BORDER if not taken or taken[0] == BORDER else int(self.number[self.fabric.side_face[taken[0]]])

    def _round(self, piece: Piece, course: int) -> PieceRow | None:
        """A round that takes all loops of a round's needle, in their order around."""
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
        """The round from the marker on; where a stitch takes loops on both sides of it, from the stitch after that."""
        ends = {self._taken((face,))[-1]: face for face in course.faces if self._taken((face,))}
        passed = next(passed for passed, side in enumerate(piece.needle[::-1]) if side in ends)
        end = course.faces.index(ends[piece.needle[len(piece.needle) - 1 - passed]]) + 1
        return PieceRow(course.faces[end:] + course.faces[:end], right_side=True, passed=passed)

    def _flat_row(self, piece: Piece, course: int) -> PieceRow | None:
        """A row, worked from where the yarn is, over loops that lie side by side on the needle."""
        faces = self.courses[course].faces
        taken = self._taken(faces)
        if piece.in_rounds or not taken or taken[0] not in piece.needle:
            return None
        first = piece.needle.index(taken[0])
        if piece.needle[first : first + len(taken)] != taken:
            return None
        left, right = first, len(piece.needle) - first - len(taken)
        free = [side for side in piece.needle if self.fabric.twin[side] == BORDER]
        bound: tuple[int, ...] = ()
        if left + right and len(free) == left + right:
            bound = tuple(place for place, side in enumerate(piece.needle[::-1]) if self.fabric.twin[side] == BORDER)
            left = right = 0
        elif left + right and not self._is_short(piece, course, taken):
            return None
        right_side = not piece.rows[-1].right_side
        return self._placed(piece, faces, right_side, left, right, bound)

    def _placed(
        self, piece: Piece, faces: tuple[int, ...], right_side: bool, left: int, right: int, bound: tuple[int, ...]
    ) -> PieceRow | None:
        """The row as it is worked from where the yarn is; None where the yarn would have to go back."""
        before, after = (right, left) if right_side else (left, right)
        at = 0 if bound else piece.position if right_side else len(piece.needle) - piece.position
        if before < at:
            return None
        return PieceRow(faces, right_side, before - at, after, bound)

    def _is_short(self, piece: Piece, course: int, taken: list[int]) -> bool:
        """Whether a later course takes up what this one leaves together with what it makes."""
        rest = set(piece.needle) - set(taken)
        across = [int(self.fabric.twin[side]) for side in rest]
        if any(side == BORDER or self.fabric.side_role[side] != BOTTOM for side in across):
            return False
        takers = {int(self.number[self.fabric.side_face[side]]) for side in across}
        return all(taker in self._reached_from(course, max(map(self._rank, takers))) for taker in takers)

    def _reached_from(self, course: int, highest: tuple[int, int]) -> set[int]:
        """Courses above one, up to a rank."""
        reached, front = {course}, [course]
        while front:
            for other in self.above[front.pop()]:
                if other not in reached and self._rank(other) <= highest:
                    reached.add(other)
                    front.append(other)
        return reached - {course}

    def _add_row(self, piece: Piece, course: int, row: PieceRow) -> None:
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
