# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The courses of a stitch mesh: faces joined along their wale sides, and the order in which they can be knitted.

A course of a tube is a ring. A course also ends where its row number changes, so that a spiral is cut into the rows
it was numbered by, and where wale directions do not match. It can be knitted when the courses that its loops come
from have been.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import BORDER, IntArray, StitchMesh

BOTTOM, RIGHT, TOP, LEFT = range(4)
"""Roles of the sides of a face, as ``StitchMesh.side_role`` numbers them."""


@dataclass(frozen=True)
class Course:
    """Faces beside each other, from left to right seen from the right side."""

    faces: tuple[int, ...]
    closed: bool
    """Whether the last face meets the first."""


def find_courses(fabric: StitchMesh) -> list[Course]:
    """All courses; every face belongs to one. A ring starts at its face of the lowest number."""
    following = right_neighbours(fabric)
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


def course_of_faces(fabric: StitchMesh, courses: list[Course]) -> IntArray:
    """Number of the course of each face, shape (F,)."""
    number = np.empty(fabric.face_count, dtype=np.int64)
    for index, course in enumerate(courses):
        number[list(course.faces)] = index
    return number


def courses_below(fabric: StitchMesh, courses: list[Course]) -> list[set[int]]:
    """For each course, those that its loops come from; itself among them where it stands on its own loops."""
    number = course_of_faces(fabric, courses)
    sides = np.flatnonzero((fabric.side_role == BOTTOM) & (fabric.twin != BORDER))
    sides = sides[fabric.side_role[fabric.twin[sides]] == TOP]
    below: list[set[int]] = [set() for _ in courses]
    above, under = number[fabric.side_face[sides]], number[fabric.side_face[fabric.twin[sides]]]
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


def bottom_sides(fabric: StitchMesh, faces: tuple[int, ...]) -> list[int]:
    """Bottom sides of some faces, from left to right."""
    start, count = fabric.face_start, fabric.n_bottom
    return [side for face in faces for side in range(int(start[face]), int(start[face] + count[face]))]


def top_sides(fabric: StitchMesh, faces: tuple[int, ...]) -> list[int]:
    """Top sides of some faces, from left to right."""
    left, right = fabric.left_wale, fabric.right_wale
    return [side for face in faces for side in range(int(left[face]) - 1, int(right[face]), -1)]


def right_neighbours(fabric: StitchMesh) -> IntArray:
    """The face to the right of each the same way up, whatever its row, ``BORDER`` where there is none, shape (F,)."""
    across = fabric.twin[fabric.right_wale]
    joined = (across != BORDER) & (fabric.side_role[across] == LEFT)
    return np.where(joined, fabric.side_face[across], BORDER)
