# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Several yarns in a row: floats behind the stitches of other yarns, and tails where a yarn is cut.

A yarn that pauses is carried on the wrong side to its next stitch in the row, or to the row's end. It runs in a lane of
its own, the yarn of the lowest number lowest, ``FLOAT_CLEARANCE`` behind the deepest yarn that it passes; and where yarns change
between two stitches, the one of the lower number crosses the wale side below the other. So yarns of one row lie in the
same order all along it and never twist about one another. A yarn that would be carried too far is cut.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from stitchmesh.mesh import BORDER, RIGHT, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.courses import course_of_faces, find_courses, left_neighbours, right_neighbours
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarngen.bridges import Bridges, crossing_number
from stitchmesh.yarngen.row_ends import Strand, Strands, tail_points
from stitchmesh.yarngen.templates.table import template

FLOAT_CLEARANCE = 2.2
"""Distance of a float behind the deepest yarn that it passes, and of deeper lanes behind the others [radii]."""
LANE_SHARES = (0.0, 0.45)
"""How far up a face the lanes run, over its height; further yarns run in the same places behind them."""
CHANGE_SHARES = (-0.02, 0.33)
"""Where the lower and the higher of two yarns pass the wale side between their stitches, over its height."""
CHANGE_DEPTH = 1.6
"""How far behind the fabric they pass it [radii]."""
CHANGE_OFFSET = (0.08, 0.08)
"""How far two stitches of different yarns are drawn apart at the foot of the wale side between them, and how far the
one of the lower number down and the other up: shares of their width and height."""
TURN_SPACING = 2.4
"""How far behind one another yarns turn to the next row [radii]."""
TAIL_DEPTHS = (0.5, 0.85, 1.2)
"""How far a tail hangs behind the fabric, over the stitch width."""
TAIL_OFFSET = 0.15
"""How far a tail stands away from the wale side where its yarn is cut, over the stitch width."""


@dataclass(frozen=True, eq=False)
class Rows:
    """The stitches that floats are laid behind."""

    fabric: StitchMesh
    radius: float
    """Yarn radius [cm]."""
    points_per_width: float
    """Points along a stitch width of yarn."""

    @cached_property
    def following(self) -> IntArray:
        """The next face of each in its row, ``BORDER`` where there is none, shape (F,)."""
        return right_neighbours(self.fabric)

    @cached_property
    def preceding(self) -> IntArray:
        """The face before each in its row, ``BORDER`` where there is none, shape (F,)."""
        return left_neighbours(self.fabric)

    @cached_property
    def yarns(self) -> list[list[int]]:
        """Numbers of the yarns in each face's turn of its row, ascending."""
        courses = find_courses(self.fabric)
        each = [np.unique(self.fabric.yarn[list(course.faces)]).tolist() for course in courses]
        return [each[course] for course in course_of_faces(self.fabric, courses)]

    @cached_property
    def changes(self) -> list[int]:
        """Faces whose next one is of another yarn."""
        yarn = self.fabric.yarn
        return np.flatnonzero((self.following != BORDER) & (yarn[self.following] != yarn)).tolist()

    def images(self, faces: list[int]) -> IntArray:
        """Lattice image of faces beside one another from left to right, seen from the first, shape (n, 2)."""
        steps = self.fabric.side_image[self.fabric.right_wale[faces]]
        return np.cumsum(steps, axis=0) - steps

    def point(self, face: int, across: float, up: float, height: float) -> FloatArray:
        """A point of a face: shares of its width and height, and its height over the fabric [cm]."""
        low, high = self.fabric.face_start[face], self.fabric.left_wale[face]
        right = self.fabric.right_wale[face]
        corners = np.array([low, right, self.fabric.side_next[right], high])
        weights = np.array([(1 - across) * (1 - up), across * (1 - up), across * up, (1 - across) * up])
        normal = weights @ self.fabric.vertex_normal[self.fabric.face_vertex[corners]]
        return weights @ self.fabric.corner_position[corners] + height * normal / np.linalg.norm(normal)

    def lane(self, face: int, yarn: int) -> tuple[float, float]:
        """How far up a face a yarn floats behind it, and at what height [cm]."""
        rank = int(np.searchsorted(self.yarns[face], yarn))
        deepest = _deepest(*(int(n[face]) for n in (self.fabric.stitch, self.fabric.n_bottom, self.fabric.n_top)))
        return LANE_SHARES[rank % len(LANE_SHARES)], (
            deepest - FLOAT_CLEARANCE * (1 + rank // len(LANE_SHARES))
        ) * self.radius

    def float_points(self, faces: list[int], yarn: int) -> list[FloatArray]:
        """Points [cm] of a yarn that floats behind faces from left to right, in the lattice image of the first."""
        count = max(2, round(self.points_per_width))
        shares = (np.arange(count) + 0.5) / count
        away = self.fabric.shift(self.images(faces))
        return [
            self.point(face, share, *self.lane(face, yarn)) + shift
            for face, shift in zip(faces, away, strict=True)
            for share in shares
        ]

    def change_point(self, face: int, yarn: int, other: int) -> FloatArray:
        """Where a yarn passes the right wale side of a face at which it changes with another [cm]."""
        return self.point(face, 1.0, CHANGE_SHARES[yarn > other], -CHANGE_DEPTH * self.radius)

    def faces_between(self, face: int, neighbour: IntArray, longest: int) -> list[int]:
        """The other faces that lie between a face and the next of its yarn, or so many as a yarn is carried behind."""
        faces: list[int] = []
        following_face = int(neighbour[face])
        while (
            following_face != BORDER
            and len(faces) <= longest
            and self.fabric.yarn[following_face] != self.fabric.yarn[face]
        ):
            faces.append(following_face)
            following_face = int(neighbour[following_face])
        return faces


def lay_floats(rows: Rows, longest: int, bridges: Bridges) -> None:
    """Carry or cut every yarn where it changes along a row.

    Args:
        rows: the stitches.
        longest: stitches behind which a yarn is carried.
        bridges: takes the floats and the tails; holds the row ends.
    """
    fabric, yarn = rows.fabric, rows.fabric.yarn
    for face in rows.changes:
        faces = rows.faces_between(face, rows.following, longest)
        target = int(rows.following[faces[-1]])
        if target != BORDER and len(faces) <= longest and abs(fabric.row[target] - fabric.row[face]) <= 1:
            own, first, last = (int(yarn[each]) for each in (face, faces[0], faces[-1]))
            images = rows.images([face, *faces, target])
            begins, ends = fabric.shift(images[[1, -2]])
            points = [rows.change_point(face, own, first), *(point + begins for point in rows.float_points(faces, own))]
            points.append(rows.change_point(faces[-1], own, last) + ends)
            crossings = crossing_number(fabric.right_wale[face]), crossing_number(fabric.left_wale[target])
            image = int(images[-1, 0]), int(images[-1, 1])
            bridges.join(*crossings, np.array(points), image=image, is_float=True)
    for face in rows.changes:
        after = int(rows.following[face])
        _end_in_tail(rows, bridges, int(fabric.right_wale[face]), _cut_tail(rows, face, after, 1))
        _end_in_tail(rows, bridges, int(fabric.left_wale[after]), _cut_tail(rows, after, face, -1))
    side_yarn = yarn[fabric.side_face]
    for side in np.flatnonzero(fabric.is_wale & fabric.mismatched & (side_yarn != side_yarn[fabric.twin])).tolist():
        _end_in_tail(rows, bridges, side, tail_points(fabric, side))


def separate_corners(rows: Rows, corner_position: FloatArray) -> FloatArray:
    """Corners with room for the yarns that change between two stitches [cm], shape (C, 3), from where they are."""
    fabric, position = rows.fabric, corner_position.copy()
    across_share, up_share = CHANGE_OFFSET
    for face in rows.changes:
        after = int(rows.following[face])
        sign = 1.0 if fabric.yarn[face] > fabric.yarn[after] else -1.0
        for each, direction in ((face, -1.0), (after, 1.0)):
            left, right = fabric.face_start[each], fabric.right_wale[each]
            foot, head = (right, fabric.side_next[right]) if each == face else (left, fabric.left_wale[each])
            across = corner_position[right] - corner_position[left]
            up = corner_position[head] - corner_position[foot]
            position[foot] += direction * across_share * across - direction * sign * up_share * up
    return position


def carried_strands(rows: Rows, longest: int) -> Strands:
    """The yarns that are carried to each row end to which more than one comes."""
    fabric = rows.fabric
    if (fabric.yarn == fabric.yarn[0]).all():
        return {}
    right = fabric.right_wale[fabric.twin[fabric.right_wale] == BORDER]
    left = fabric.left_wale[fabric.twin[fabric.left_wale] == BORDER]
    found = {int(side): _last_faces(rows, int(side), rows.preceding, longest) for side in right}
    found |= {int(side): _last_faces(rows, int(side), rows.following, longest) for side in left}
    return {side: _strands(rows, side, last) for side, last in found.items() if len(last) > 1}


def _last_faces(rows: Rows, side: int, neighbour: IntArray, longest: int) -> dict[int, list[int]]:
    """For each yarn its last face before a row's end and those between, from the row's end inwards."""
    face = int(rows.fabric.side_face[side])
    row = int(rows.fabric.row[face])
    found: dict[int, list[int]] = {}
    faces: list[int] = []
    while face != BORDER and len(faces) <= longest and rows.fabric.row[face] == row and face not in faces:
        found.setdefault(int(rows.fabric.yarn[face]), [*faces, face])
        faces.append(face)
        face = int(neighbour[face])
    return found


def _strands(rows: Rows, side: int, last: dict[int, list[int]]) -> dict[int, Strand]:
    fabric, result = rows.fabric, {}
    is_right = fabric.side_role[side] == RIGHT
    for rank, yarn in enumerate(sorted(last)):
        *faces, face = last[yarn]
        own = fabric.right_wale[face] if is_right else fabric.left_wale[face]
        points, tail = [], tail_points(fabric, side)
        if faces:
            tail = _cut_tail(rows, face, faces[-1], 1 if is_right else -1)
            left_of_change = face if is_right else faces[-1]
            points.append(rows.change_point(left_of_change, yarn, int(fabric.yarn[faces[-1]])))
            lanes = rows.float_points(faces[::-1] if is_right else faces, yarn)
            points += lanes if is_right else lanes[::-1]
        depth = rank * TURN_SPACING * rows.radius
        end = int(fabric.side_face[side])
        points.append(rows.point(end, float(is_right), CHANGE_SHARES[min(rank, 1)], -depth))
        result[yarn] = Strand(crossing_number(own), np.array(points), depth, tail)
    return result


def _cut_tail(rows: Rows, face: int, beside: int, direction: int) -> FloatArray:
    """Points of the tail where the yarn of a face is cut at the wale side to the face beside it [cm]."""
    fabric = rows.fabric
    left = face if direction > 0 else beside
    begins = 0.0 if direction > 0 else fabric.shift(fabric.side_image[fabric.left_wale[face]])
    own, other = int(rows.fabric.yarn[face]), int(rows.fabric.yarn[beside])
    width = float(np.linalg.norm(rows.point(face, 1.0, 0.5, 0.0) - rows.point(face, 0.0, 0.5, 0.0)))
    up = CHANGE_SHARES[own > other]
    away = [rows.point(left, 1.0 + direction * TAIL_OFFSET, up, -depth * width) for depth in TAIL_DEPTHS]
    return np.array([rows.change_point(left, own, other), *away]) + begins


def _end_in_tail(rows: Rows, bridges: Bridges, side: int, tail: FloatArray) -> None:
    crossing = crossing_number(side)
    if not bridges.redirects(crossing):
        bridges.end_in_tail(crossing, tail)


@lru_cache(maxsize=1024)
def _deepest(stitch: int, n_bottom: int, n_top: int) -> float:
    """Height of the deepest yarn of a stitch [radii]."""
    return min(float(part.curve[:, 2].min()) for part in template(Stitch(stitch), n_bottom, n_top).parts)
