# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The courses of a stitch mesh, and an order in which they can be knitted.

A course is a sequence of faces joined along their wale sides. A course of a tube is a ring. A course ends where the
row number changes, so that a spiral is divided into its numbered rows, and where the wale directions of two faces do
not match. A course can be knitted after all courses that its loops come from.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh.polygon_mesh import BORDER, IntArray
from stitchmesh.mesh.stitch_mesh import BOTTOM, LEFT, RIGHT, TOP, StitchMesh

Step = Callable[[int], int]
"""Function from the number of a face or side to the number of the next one, or to ``BORDER`` at the end."""


@dataclass(frozen=True)
class Course:
    """A course of a stitch mesh."""

    faces: tuple[int, ...]
    """Faces from left to right, as seen from the right side of the fabric."""
    closed: bool
    """Whether the course is a ring, so that the last face is the left neighbour of the first."""


def find_courses(fabric: StitchMesh, *, climbing: bool = False) -> list[Course]:
    """Find all courses; every face belongs to exactly one. A ring starts with its face of the lowest number.

    Args:
        fabric: stitch mesh.
        climbing: whether a course continues where the row number changes, as in a spiral.
    """
    following = right_neighbours(fabric)
    if not climbing:
        following = np.where(fabric.row[following] == fabric.row, following, BORDER)
    inner = following != BORDER
    has_left = np.zeros(fabric.face_count, dtype=bool)
    has_left[following[inner]] = True
    used = np.zeros(fabric.face_count, dtype=bool)
    found = []
    for start in [*np.flatnonzero(~has_left).tolist(), *range(fabric.face_count)]:
        if used[start]:
            continue
        faces, face = [], start
        while face != BORDER and not used[face]:
            used[face] = True
            faces.append(face)
            face = int(following[face])
        found.append(Course(tuple(faces), closed=face != BORDER))
    return found


def course_through(fabric: StitchMesh, face: int, *, climbing: bool = False) -> Course:
    """Find the course of one face only; a ring starts with this face.

    Args:
        fabric: stitch mesh.
        face: any face of the course.
        climbing: as for ``find_courses``.
    """
    right, left = fabric.right_wale, fabric.left_wale
    rightwards = partial(_beyond, fabric, leaving=right, entered=left, climbing=climbing)
    leftwards = partial(_beyond, fabric, leaving=left, entered=right, climbing=climbing)
    return Course(*chain_through(face, rightwards, leftwards))


def _beyond(fabric: StitchMesh, face: int, *, leaving: IntArray, entered: IntArray, climbing: bool) -> int:
    """Return the face of the same course across one wale side of a face, ``BORDER`` where the course ends.

    Args:
        fabric: stitch mesh.
        face: the face.
        leaving: wale side of each face through which the course leaves the face, shape (F,).
        entered: wale side of each face through which the course enters the face, shape (F,).
        climbing: as for ``find_courses``.
    """
    across = fabric.twin[leaving[face]]
    other = fabric.side_face[across]
    joined = across != BORDER and entered[other] == across and (climbing or fabric.row[other] == fabric.row[face])
    return int(other) if joined else BORDER


def chain_through(start: int, after: Step, before: Step) -> tuple[tuple[int, ...], bool]:
    """Follow a chain of faces or sides in both directions.

    Args:
        start: number of a face or a side of the chain.
        after: returns the next element of the chain.
        before: returns the previous element of the chain.

    Returns:
        The elements in order, and whether the chain is closed; a closed chain begins with ``start``.
    """
    chain = [start]
    while (following := after(chain[-1])) not in (BORDER, start):
        chain.append(following)
    if following == start:
        return tuple(chain), True
    backwards: list[int] = []
    while (preceding := before(backwards[-1] if backwards else start)) != BORDER:
        backwards.append(preceding)
    return (*backwards[::-1], *chain), False


def course_of_faces(fabric: StitchMesh, courses: list[Course]) -> IntArray:
    """Return the number of the course of each face, shape (F,)."""
    number = np.empty(fabric.face_count, dtype=np.int64)
    for index, course in enumerate(courses):
        number[list(course.faces)] = index
    return number


def courses_below(fabric: StitchMesh, courses: list[Course]) -> list[set[int]]:
    """Return, for each course, the courses that its loops come from; a course may take loops of itself."""
    number = course_of_faces(fabric, courses)
    sides = np.flatnonzero(fabric.side_role == BOTTOM)
    faces = faces_across(fabric, sides, TOP)
    below: list[set[int]] = [set() for _ in courses]
    above, under = number[fabric.side_face[sides[faces != BORDER]]], number[faces[faces != BORDER]]
    for one, other in zip(above.tolist(), under.tolist(), strict=True):
        below[one].add(other)
    return below


def knitting_order(below: list[set[int]]) -> tuple[list[int], list[int]]:
    """Sort the courses so that each comes after the courses below it (topological order).

    Args:
        below: for each course, the courses that its loops come from (``courses_below``).

    Returns:
        The courses in that order, and the courses that cannot be ordered because they depend on a cycle.
    """
    missing = [len(courses) for courses in below]
    above: list[list[int]] = [[] for _ in below]
    for course, under in enumerate(below):
        for other in under:
            above[other].append(course)
    ready = [course for course, count in enumerate(missing) if count == 0]
    order = []
    while ready:
        course = heapq.heappop(ready)
        order.append(course)
        for other in above[course]:
            missing[other] -= 1
            if missing[other] == 0:
                heapq.heappush(ready, other)
    done = set(order)
    return order, [course for course in range(len(below)) if course not in done]


def renumbered_rows(below: IntArray, above: IntArray, flipped: NDArray[np.bool_]) -> IntArray:
    """Return the new number of each row after rows were flipped, so that a flipped row follows the rows below it.

    Rows that are not flipped keep their order where the flipped rows permit it.

    Args:
        below: rows whose top sides are seams where the wale directions match, shape (n,).
        above: row at the other side of each seam, shape (n,).
        flipped: whether each row was flipped, shape (rows,).
    """
    binding = (below != above) & ((below < above) | flipped[below] | flipped[above])
    if not (below[binding] > above[binding]).any():
        return np.arange(len(flipped))
    under: list[set[int]] = [set() for _ in flipped]
    for lower, upper in zip(below[binding].tolist(), above[binding].tolist(), strict=True):
        under[upper].add(lower)
    order, cyclic = knitting_order(under)
    number = np.empty(len(flipped), dtype=np.int64)
    number[[*order, *cyclic]] = np.arange(len(flipped))
    return number


def bottom_sides(fabric: StitchMesh, faces: Sequence[int]) -> list[int]:
    """Return the bottom sides of faces of one course, from left to right."""
    start, count = fabric.face_start, fabric.n_bottom
    return [side for face in faces for side in range(int(start[face]), int(start[face] + count[face]))]


def top_sides(fabric: StitchMesh, faces: Sequence[int]) -> list[int]:
    """Return the top sides of faces of one course, from left to right."""
    left, right = fabric.left_wale, fabric.right_wale
    return [side for face in faces for side in range(int(left[face]) - 1, int(right[face]), -1)]


def right_neighbours(fabric: StitchMesh) -> IntArray:
    """Return the right neighbour of each face, whatever its row, shape (F,).

    The result is ``BORDER`` where there is no neighbour or where the neighbour has the opposite wale direction.
    """
    return faces_across(fabric, fabric.right_wale, LEFT)


def left_neighbours(fabric: StitchMesh) -> IntArray:
    """Return the left neighbour of each face, under the conditions of ``right_neighbours``, shape (F,)."""
    return faces_across(fabric, fabric.left_wale, RIGHT)


def faces_across(fabric: StitchMesh, sides: IntArray, role: int) -> IntArray:
    """Return the face across each side, ``BORDER`` if there is none or if its side does not have the given role.

    Args:
        fabric: stitch mesh.
        sides: sides, shape (n,).
        role: role that the twin must have.
    """
    across = sides_across(fabric, sides, role)
    return np.where(across == BORDER, BORDER, fabric.side_face[across])


def sides_across(fabric: StitchMesh, sides: IntArray, role: int) -> IntArray:
    """Return the twin of each side, ``BORDER`` if there is none or if the twin does not have the given role.

    Args:
        fabric: stitch mesh.
        sides: sides, shape (n,).
        role: role that the twin must have.
    """
    across = fabric.twin[sides]
    return np.where((across != BORDER) & (fabric.side_role[across] == role), across, BORDER)
