# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows with several yarns: floats behind the stitches of other yarns, and tails where a yarn is cut.

A yarn that pauses in a row is carried on the wrong side to its next stitch in the row, or to the end of the row. The
carried yarn is a float. Each float runs in a lane, which is a height of the face: the yarn with the lowest number takes
the lowest lane. The lane is ``FLOAT_CLEARANCE`` behind the deepest yarn that the float passes. Where yarns change
between two stitches, the yarn with the lower number crosses the wale side below the other yarn. The yarns of one row
therefore keep the same order along the whole row and never twist around each other. Where a row has more than two
yarns, others float past such a change. All lanes then have heights of their own, and are further behind
(``DEEP_CLEARANCE``): a yarn reaches the height of its lane in front of the other lanes, and passes between them. A
knitter makes such a float no longer than a float directly behind the stitches, so it has the rest length of that float.
With its drawn length it would be slack, and its loops would sink into the fabric, each by another amount. A yarn is cut
where its float would be too long.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from stitchmesh.mesh import BORDER, RIGHT, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.courses import course_of_faces, find_courses, left_neighbours, right_neighbours
from stitchmesh.mesh.own_stitch import StitchType
from stitchmesh.yarngen.bridges import Bridges, crossing_number
from stitchmesh.yarngen.row_ends import RowEndStrand, Strands, tail_points
from stitchmesh.yarngen.templates.table import template

FLOAT_CLEARANCE = 2.2
"""Distance of a float behind the deepest yarn that it passes [radii]."""
LANE_SHARES = (0.0, 0.45)
"""Height of the lanes of two yarns above the bottom of the face, over the height of the face."""
DEEP_CLEARANCE = 5.2
"""Distance of a float behind the deepest yarn that it passes, in a row of more than two yarns [radii]."""
CHANGE_SHARES = (-0.02, 0.33)
"""Height at which the yarn of the lower number and the yarn of the higher number cross the wale side between their
stitches, over the height of the face."""
CHANGE_OFFSET = (0.08, 0.08)
"""Displacement of the feet of two neighbouring stitches of different yarns at the wale side between them. First number:
displacement away from the wale side, over the width of the stitch. Second number: displacement of the lower yarn down
and of the higher yarn up, over the height of the stitch."""
TAIL_DEPTHS = (0.5, 0.85, 1.2)
"""Depths of the points of a tail behind the fabric, over the stitch width."""


@dataclass(frozen=True, eq=False)
class FloatRows:
    """The rows of a stitch mesh behind which floats run."""

    fabric: StitchMesh
    """The stitch mesh, including the bind-off row."""
    radius: float
    """Yarn radius [cm]."""
    points_per_width: float
    """Number of points along one stitch width of yarn."""

    @cached_property
    def following(self) -> IntArray:
        """The next face to the right of each face in its row, ``BORDER`` where there is none, shape (F,)."""
        return right_neighbours(self.fabric)

    @cached_property
    def preceding(self) -> IntArray:
        """The next face to the left of each face in its row, ``BORDER`` where there is none, shape (F,)."""
        return left_neighbours(self.fabric)

    @cached_property
    def yarns(self) -> list[list[int]]:
        """For each face the numbers of all yarns in its row, in ascending order."""
        courses = find_courses(self.fabric)
        each = [np.unique(self.fabric.yarn[list(course.faces)]).tolist() for course in courses]
        return [each[course] for course in course_of_faces(self.fabric, courses)]

    @cached_property
    def changes(self) -> list[int]:
        """Faces whose next face in the row has another yarn."""
        yarn = self.fabric.yarn
        return np.flatnonzero((self.following != BORDER) & (yarn[self.following] != yarn)).tolist()

    def images(self, faces: list[int]) -> IntArray:
        """Lattice images of faces that lie side by side from left to right, seen from the first face, shape (n, 2)."""
        steps = self.fabric.side_image[self.fabric.right_wale[faces]]
        return np.cumsum(steps, axis=0) - steps

    def point(self, face: int, across: float, up: float, height: float) -> FloatArray:
        """A point of a face [cm], shape (3,).

        Args:
            face: number of the face.
            across: distance from the left wale side, over the width of the face.
            up: distance from the bottom, over the height of the face.
            height: distance from the face along its normal [cm].
        """
        low, high = self.fabric.face_start[face], self.fabric.left_wale[face]
        right = self.fabric.right_wale[face]
        corners = np.array([low, right, self.fabric.side_next[right], high])
        weights = np.array([(1 - across) * (1 - up), across * (1 - up), across * up, (1 - across) * up])
        normal = weights @ self.fabric.vertex_normal[self.fabric.face_vertex[corners]]
        return weights @ self.fabric.corner_position[corners] + height * normal / np.linalg.norm(normal)

    def lane(self, face: int, yarn: int, clearance: float) -> tuple[float, float]:
        """Height of the lane of a yarn above the bottom of a face, over the height of the face, and its depth [cm].

        Args:
            face: number of the face.
            yarn: number of the yarn.
            clearance: distance behind the deepest yarn of the face [radii].
        """
        count, rank = len(self.yarns[face]), int(np.searchsorted(self.yarns[face], yarn))
        stitch = self.fabric.stitch_type(int(self.fabric.stitch[face]))
        deepest = _deepest(stitch, int(self.fabric.n_bottom[face]), int(self.fabric.n_top[face]))
        if count <= len(LANE_SHARES):
            return LANE_SHARES[rank], (deepest - clearance) * self.radius
        # Height of the lowest lane in such a row, as in ``LANE_SHARES``; the others are equally far apart, up to
        # the lowest lane of the row above.
        return -0.15 + rank / count, (deepest - clearance) * self.radius

    def clearance(self, face: int) -> float:
        """Distance of the floats in the row of a face behind the deepest yarn that they pass [radii]."""
        return DEEP_CLEARANCE if len(self.yarns[face]) > len(LANE_SHARES) else FLOAT_CLEARANCE

    def float_points(self, faces: list[int], yarn: int, clearance: float | None = None) -> list[FloatArray]:
        """Points of a yarn that floats behind faces [cm], each of shape (3,), in the lattice image of the first face.

        Args:
            faces: the faces, from left to right.
            yarn: number of the yarn.
            clearance: distance behind the deepest yarn of each face [radii]; the clearance of the row if it is None.
        """
        count = max(2, round(self.points_per_width))
        shares = (np.arange(count) + 0.5) / count
        away = self.fabric.shift(self.images(faces))
        return [
            self.point(face, share, *self.lane(face, yarn, clearance or self.clearance(face))) + shift
            for face, shift in zip(faces, away, strict=True)
            for share in shares
        ]

    def change_point(self, face: int, yarn: int, other: int) -> FloatArray:
        """Point at which a yarn crosses the right wale side of a face next to another yarn [cm], shape (3,)."""
        # Depth behind the fabric at which both yarns cross that wale side [radii].
        return self.point(face, 1.0, CHANGE_SHARES[yarn > other], -1.6 * self.radius)

    def faces_between(self, face: int, neighbour: IntArray, longest: int) -> list[int]:
        """Faces of other yarns between a face and the next face of the same yarn.

        Args:
            face: the face at which the search begins.
            neighbour: the next face of each face in the direction of the search, shape (F,).
            longest: largest number of stitches behind which a yarn is carried; the search stops one face later.
        """
        faces: list[int] = []
        beyond = int(neighbour[face])
        while beyond != BORDER and len(faces) <= longest and self.fabric.yarn[beyond] != self.fabric.yarn[face]:
            faces.append(beyond)
            beyond = int(neighbour[beyond])
        return faces


def lay_floats(rows: FloatRows, longest: int, bridges: Bridges) -> None:
    """Carry every yarn that changes along a row to its next stitch, or cut it and end it in tails.

    Args:
        rows: the rows of stitches.
        longest: largest number of stitches behind which a yarn is carried.
        bridges: holds the row ends; the floats and the tails are added.
    """
    fabric, yarn = rows.fabric, rows.fabric.yarn
    for face in rows.changes:
        faces = rows.faces_between(face, rows.following, longest)
        target = int(rows.following[faces[-1]])
        if target != BORDER and len(faces) <= longest and abs(fabric.row[target] - fabric.row[face]) <= 1:
            own, first, last = (int(yarn[each]) for each in (face, faces[0], faces[-1]))
            images = rows.images([face, *faces, target])
            begins, ends = fabric.shift(images[[1, -2]])
            ends_at = rows.change_point(face, own, first), rows.change_point(faces[-1], own, last) + ends
            points, direct = (
                np.array([ends_at[0], *(begins + np.array(rows.float_points(faces, own, clearance))), ends_at[1]])
                for clearance in (rows.clearance(face), FLOAT_CLEARANCE)
            )
            crossings = crossing_number(fabric.right_wale[face]), crossing_number(fabric.left_wale[target])
            image = int(images[-1, 0]), int(images[-1, 1])
            ratio = float(_length(direct) / _length(points))
            bridges.join(*crossings, points, rest_length_ratio=ratio, image=image, is_float=True)
    for face in rows.changes:
        after = int(rows.following[face])
        _end_in_tail(rows, bridges, int(fabric.right_wale[face]), _cut_tail(rows, face, after, 1))
        _end_in_tail(rows, bridges, int(fabric.left_wale[after]), _cut_tail(rows, after, face, -1))
    side_yarn = yarn[fabric.side_face]
    for side in np.flatnonzero(fabric.is_wale & fabric.mismatched & (side_yarn != side_yarn[fabric.twin])).tolist():
        _end_in_tail(rows, bridges, side, tail_points(fabric, side))


def _length(points: FloatArray) -> FloatArray:
    """Return the length of the line through points [cm]."""
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


def separate_corners(rows: FloatRows, corner_position: FloatArray) -> FloatArray:
    """Corners of the faces, displaced where two neighbouring stitches have different yarns [cm], shape (C, 3).

    The displacement (``CHANGE_OFFSET``) makes room for the yarns that change there.

    Args:
        rows: the rows of stitches.
        corner_position: corners before the displacement [cm], shape (C, 3).
    """
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


def carried_strands(rows: FloatRows, longest: int) -> Strands:
    """The strands at each row end that more than one yarn reaches.

    Args:
        rows: the rows of stitches.
        longest: largest number of stitches behind which a yarn is carried.

    Returns:
        The strands by border side and yarn; empty if the fabric has one yarn.
    """
    fabric = rows.fabric
    if (fabric.yarn == fabric.yarn[0]).all():
        return {}
    right = fabric.right_wale[fabric.twin[fabric.right_wale] == BORDER]
    left = fabric.left_wale[fabric.twin[fabric.left_wale] == BORDER]
    found = {int(side): _last_faces(rows, int(side), rows.preceding, longest) for side in right}
    found |= {int(side): _last_faces(rows, int(side), rows.following, longest) for side in left}
    return {side: _strands(rows, side, last) for side, last in found.items() if len(last) > 1}


def _last_faces(rows: FloatRows, side: int, neighbour: IntArray, longest: int) -> dict[int, list[int]]:
    """For each yarn that reaches a row end, the faces from the row end to the last stitch of that yarn."""
    face = int(rows.fabric.side_face[side])
    row = int(rows.fabric.row[face])
    found: dict[int, list[int]] = {}
    faces: list[int] = []
    while face != BORDER and len(faces) <= longest and rows.fabric.row[face] == row and face not in faces:
        found.setdefault(int(rows.fabric.yarn[face]), [*faces, face])
        faces.append(face)
        face = int(neighbour[face])
    return found


def _strands(rows: FloatRows, side: int, last: dict[int, list[int]]) -> dict[int, RowEndStrand]:
    """The strands at a row end by the number of their yarn, from the faces that ``_last_faces`` returns."""
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
        # Distance between the depths at which the yarns of a row turn to the next row [radii].
        depth = rank * 2.4 * rows.radius
        end = int(fabric.side_face[side])
        points.append(rows.point(end, float(is_right), CHANGE_SHARES[min(rank, 1)], -depth))
        result[yarn] = RowEndStrand(crossing_number(own), np.array(points), depth, tail)
    return result


def _cut_tail(rows: FloatRows, face: int, beside: int, direction: int) -> FloatArray:
    """Points of the tail of a yarn that is cut at the wale side between two faces [cm], shape (n, 3).

    Args:
        rows: the rows of stitches.
        face: face of the yarn that is cut.
        beside: the neighbouring face, which has another yarn.
        direction: 1 if the neighbouring face lies to the right, -1 if it lies to the left.
    """
    fabric = rows.fabric
    left = face if direction > 0 else beside
    begins = 0.0 if direction > 0 else fabric.shift(fabric.side_image[fabric.left_wale[face]])
    own, other = int(rows.fabric.yarn[face]), int(rows.fabric.yarn[beside])
    width = float(np.linalg.norm(rows.point(face, 1.0, 0.5, 0.0) - rows.point(face, 0.0, 0.5, 0.0)))
    up = CHANGE_SHARES[own > other]
    # Distance of a tail from the wale side at which its yarn is cut, over the stitch width.
    away = [rows.point(left, 1.0 + direction * 0.15, up, -depth * width) for depth in TAIL_DEPTHS]
    return np.array([rows.change_point(left, own, other), *away]) + begins


def _end_in_tail(rows: FloatRows, bridges: Bridges, side: int, tail: FloatArray) -> None:
    """End the yarn in a tail where it crosses a side, unless a bridge or a tail begins there."""
    crossing = crossing_number(side)
    if not bridges.redirects(crossing):
        bridges.end_in_tail(crossing, tail)


@lru_cache(maxsize=1024)
def _deepest(stitch: StitchType, n_bottom: int, n_top: int) -> float:
    """Height of the deepest yarn of a stitch [radii]; it is negative."""
    return min(float(part.curve[:, 2].min()) for part in template(stitch, n_bottom, n_top).parts)
