# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The courses of a stitch mesh: faces joined along their wale sides, and the order in which they can be knitted.

A course of a tube is a ring. A course also ends where its row number changes, so that a spiral is cut into the rows
it was numbered by, and where wale directions do not match. It can be knitted when the courses that its loops come
from have been.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from stitchmesh.mesh.polygon_mesh import BORDER, IntArray
from stitchmesh.mesh.stitch_mesh import BOTTOM, LEFT, RIGHT, TOP, StitchMesh

Step = Callable[[int], int]
"""From the number of a face or side to that of the next one, ``BORDER`` at the end."""


@dataclass(frozen=True)
class Course:
    """Faces beside each other, from left to right seen from the right side."""

    faces: tuple[int, ...]
    closed: bool
    """Whether the last face meets the first."""


def find_courses(fabric: StitchMesh, *, climbing: bool = False) -> list[Course]:
    """All courses; every face belongs to one. A ring starts at its face of the lowest number.

    Args:
        fabric: stitch faces.
        climbing: whether a course goes on where its row number changes, as the row of a spiral does.
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
    """The course of one face, found without a look at the others; a ring starts at this face.

    Args:
        fabric: stitch faces.
        face: any face of the course.
        climbing: as for ``find_courses``.
    """
    right, left = fabric.right_wale, fabric.left_wale
    rightwards = partial(_beyond, fabric, leaving=right, entered=left, climbing=climbing)
    leftwards = partial(_beyond, fabric, leaving=left, entered=right, climbing=climbing)
    return Course(*chain_through(face, rightwards, leftwards))


def _beyond(fabric: StitchMesh, face: int, *, leaving: IntArray, entered: IntArray, climbing: bool) -> int:
    """The face of the same course across one of a face's wale sides, ``BORDER`` where the course ends."""
    across = fabric.twin[leaving[face]]
    other = fabric.side_face[across]
    joined = across != BORDER and entered[other] == across and (climbing or fabric.row[other] == fabric.row[face])
    return int(other) if joined else BORDER


def chain_through(start: int, after: Step, before: Step) -> tuple[tuple[int, ...], bool]:
    """What comes one after another through some start, and whether it closes; a ring begins with the start.

    Args:
        start: number of a face or a side.
        after: to what comes after each.
        before: to what comes before each.
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
    """Number of the course of each face, shape (F,)."""
    number = np.empty(fabric.face_count, dtype=np.int64)
    for index, course in enumerate(courses):
        number[list(course.faces)] = index
    return number


def courses_below(fabric: StitchMesh, courses: list[Course]) -> list[set[int]]:
    """For each course, those that its loops come from; itself among them where it stands on its own loops."""
    number = course_of_faces(fabric, courses)
    sides = np.flatnonzero(fabric.side_role == BOTTOM)
    faces = faces_across(fabric, sides, TOP)
    below: list[set[int]] = [set() for _ in courses]
    above, under = number[fabric.side_face[sides[faces != BORDER]]], number[faces[faces != BORDER]]
    for one, other in zip(above.tolist(), under.tolist(), strict=True):
        below[one].add(other)
    return below


def knitting_order(below: list[set[int]]) -> tuple[list[int], list[int]]:
    """Courses in an order in which each comes after those below it, and the courses that no order can reach.

    Args:
        below: what ``courses_below`` returned.
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


def bottom_sides(fabric: StitchMesh, faces: Sequence[int]) -> list[int]:
    """Bottom sides of some faces, from left to right."""
    start, count = fabric.face_start, fabric.n_bottom
    return [side for face in faces for side in range(int(start[face]), int(start[face] + count[face]))]


def top_sides(fabric: StitchMesh, faces: Sequence[int]) -> list[int]:
    """Top sides of some faces, from left to right."""
    left, right = fabric.left_wale, fabric.right_wale
    return [side for face in faces for side in range(int(left[face]) - 1, int(right[face]), -1)]


def right_neighbours(fabric: StitchMesh) -> IntArray:
    """The face to the right of each the same way up, whatever its row, ``BORDER`` where there is none, shape (F,)."""
    return faces_across(fabric, fabric.right_wale, LEFT)


def left_neighbours(fabric: StitchMesh) -> IntArray:
    """The face to the left of each, likewise."""
    return faces_across(fabric, fabric.left_wale, RIGHT)


def faces_across(fabric: StitchMesh, sides: IntArray, role: int) -> IntArray:
    """The face across each of some sides, ``BORDER`` where there is none or the side there has another role."""
    across = sides_across(fabric, sides, role)
    return np.where(across == BORDER, BORDER, fabric.side_face[across])


def sides_across(fabric: StitchMesh, sides: IntArray, role: int) -> IntArray:
    """The side across each of some sides, ``BORDER`` where there is none or it has another role."""
    across = fabric.twin[sides]
    return np.where((across != BORDER) & (fabric.side_role[across] == role), across, BORDER)
