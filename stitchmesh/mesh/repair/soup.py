# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygons that need not be connected or valid, with the vertices and faces of the input that they come from.

``EdgeSides`` holds the sides of polygons along each edge, whatever their number and direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import MeshError
from stitchmesh.mesh.connectivity import next_sides
from stitchmesh.mesh.face_triangles import Ears, clip_ears
from stitchmesh.mesh.polygon_mesh import NO_AREA, FloatArray, IntArray, check_positions, ranges


@dataclass(frozen=True, eq=False)
class Soup:
    """Polygons; corners and sides have the same numbers as in a ``Mesh``.

    V, F and C below are the numbers of points, faces and corners.
    """

    points: FloatArray
    """Positions [cm], shape (V, 3); some may be unused."""
    start: IntArray
    """Number of the first corner of each face, and C at the end, shape (F + 1,)."""
    vertex: IntArray
    """Point of each corner, shape (C,); welded vertices have one number."""
    source: IntArray
    """Vertex of the input that each corner comes from, shape (C,)."""
    origin: IntArray
    """Face of the input that each face comes from, -1 for a face that fills a hole, shape (F,)."""

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.start) - 1

    @cached_property
    def size(self) -> IntArray:
        """Number of corners of each face, shape (F,)."""
        return np.diff(self.start)

    @cached_property
    def side_face(self) -> IntArray:
        """Face of each side, shape (C,)."""
        return np.repeat(np.arange(self.face_count), self.size)

    @cached_property
    def side_next(self) -> IntArray:
        """Next side around the same face of each side, shape (C,)."""
        return next_sides(self.start)

    @cached_property
    def head(self) -> IntArray:
        """Point at which each side ends, shape (C,)."""
        return self.vertex[self.side_next]

    @cached_property
    def side_length(self) -> FloatArray:
        """Length of each side [cm], shape (C,)."""
        return np.linalg.norm(self.points[self.head] - self.points[self.vertex], axis=1)

    @cached_property
    def vector_area(self) -> FloatArray:
        """Area of each face times its normal [cm^2], shape (F, 3)."""
        position = self.points[self.vertex]
        from_first = position - np.repeat(position[self.start[:-1]], self.size, axis=0)
        spans = np.cross(from_first, from_first[self.side_next])
        return 0.5 * np.add.reduceat(spans, self.start[:-1], axis=0)

    @cached_property
    def area(self) -> FloatArray:
        """Area of each face [cm^2], shape (F,)."""
        return np.linalg.norm(self.vector_area, axis=1)

    @cached_property
    def without_area(self) -> NDArray[np.bool_]:
        """Whether ``Mesh`` would refuse each face because it has no area, shape (F,)."""
        longest = np.maximum.reduceat(self.side_length, self.start[:-1])
        return self.area <= NO_AREA * longest**2

    def corners_of(self, face: int) -> list[int]:
        """Return the numbers of the corners of a face."""
        return list(range(int(self.start[face]), int(self.start[face + 1])))

    def ears_of(self, corners: list[int]) -> Ears:
        """Divide the polygon of some corners, in their order, into triangles of these corners."""
        vertex = self.vertex[corners]
        ears = clip_ears(self.points[vertex], vertex, np.array([len(corners)]))
        return Ears(np.array(corners)[ears.triangles], ears.whole)

    def kept(self, faces: IntArray) -> Soup:
        """Return some faces alone.

        Args:
            faces: their numbers, ascending, shape (n,).
        """
        return self._of_corners(ranges(self.start, faces), self.size[faces], faces)

    def replaced(self, polygons: dict[int, list[list[int]]]) -> Soup:
        """Return the faces with some of them replaced.

        Args:
            polygons: polygons that take the place of each of these faces, as numbers of corners of any face.
        """
        if not polygons:
            return self
        others = np.setdiff1d(np.arange(self.face_count), list(polygons))
        made = [(face, polygon) for face, parts in polygons.items() for polygon in parts]
        owner = np.concatenate([others, np.array([face for face, _ in made], dtype=np.int64)])
        size = np.concatenate([self.size[others], np.array([len(polygon) for _, polygon in made], dtype=np.int64)])
        corners = np.array([corner for _, polygon in made for corner in polygon], dtype=np.int64)
        pool = np.concatenate([ranges(self.start, others), corners])
        order = np.argsort(owner, kind="stable")
        corners = pool[ranges(np.concatenate([[0], np.cumsum(size)]), order)]
        return self._of_corners(corners, size[order], owner[order])

    def reversed(self, chosen: NDArray[np.bool_]) -> Soup:
        """Return the soup with some faces reversed; their first corners stay first.

        Args:
            chosen: whether to reverse each face, shape (F,).
        """
        first, size = self.start[:-1][self.side_face], self.size[self.side_face]
        place = np.arange(len(self.vertex)) - first
        corner = first + np.where(chosen[self.side_face], (size - place) % size, place)
        return replace(self, vertex=self.vertex[corner], source=self.source[corner])

    def sides_after_reversal(self, chosen: NDArray[np.bool_]) -> IntArray:
        """Return the number that each side has after ``reversed``, shape (C,)."""
        first, size = self.start[:-1][self.side_face], self.size[self.side_face]
        place = np.arange(len(self.vertex)) - first
        return first + np.where(chosen[self.side_face], size - 1 - place, place)

    def _of_corners(self, corners: IntArray, size: IntArray, faces: IntArray) -> Soup:
        start = np.concatenate([[0], np.cumsum(size)])
        return Soup(self.points, start, self.vertex[corners], self.source[corners], self.origin[faces])


def numbers_in(numbers: IntArray, count: int) -> IntArray:
    """Return the different numbers of an array, ascending; faster than sorting them.

    Args:
        numbers: numbers from 0 to count - 1, of any shape.
        count: the number of possible numbers.
    """
    occurs = np.zeros(count, dtype=bool)
    occurs[numbers] = True
    return np.flatnonzero(occurs)


def soup_of(vertices: ArrayLike, faces: Sequence[Sequence[int]]) -> Soup:
    """Return checked polygons.

    Args:
        vertices: positions [cm], shape (V, 3).
        faces: vertices of each polygon.

    Raises:
        MeshError: the positions have another shape, a coordinate is not finite, a vertex does not exist, or there are
            no faces.
    """
    points = _points(vertices)
    size, vertex = _flat(faces)
    bad = np.flatnonzero((vertex < 0) | (vertex >= len(points)))
    if len(bad):
        face = int(np.searchsorted(np.cumsum(size), bad[0], side="right"))
        where = f"face {face}: vertex {vertex[bad[0]]} does not exist"
        raise MeshError(f"{where}; got {len(points)} vertices, expected numbers from 0 to {len(points) - 1}")
    start = np.concatenate([[0], np.cumsum(size)])
    return Soup(points, start, vertex, vertex, np.arange(len(size)))


def _points(vertices: ArrayLike) -> FloatArray:
    try:
        points = np.array(vertices, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MeshError(f"vertices: got values that form no array of numbers ({error}); expected (V, 3)") from error
    check_positions(points)
    return points


def _flat(faces: Sequence[Sequence[int]]) -> tuple[IntArray, IntArray]:
    """Return the number of corners of each face, shape (F,), and the vertices of all corners, shape (C,)."""
    if len(faces) == 0:
        raise MeshError("mesh: got no faces; expected at least one polygon")
    size = np.fromiter(map(len, faces), dtype=np.int64, count=len(faces))
    corners = np.array(list(chain.from_iterable(faces)))
    if not len(corners):
        raise MeshError("mesh: got faces without corners; expected at least one polygon")
    if corners.dtype.kind not in "iu":
        raise MeshError(f"faces: got vertex numbers of type {corners.dtype}; expected whole numbers")
    return size, corners.astype(np.int64)


@dataclass(frozen=True, eq=False)
class EdgeSides:
    """Sides by edge; E is the number of edges and C the number of sides."""

    sides: IntArray
    """Sides, edge by edge, and ascending for each edge, shape (C,)."""
    first: IntArray
    """Place of the first side of each edge in ``sides``, shape (E,)."""
    count: IntArray
    """Number of sides of each edge, shape (E,)."""

    def with_count(self, count: int) -> IntArray:
        """Return the sides of all edges that have ``count`` sides, shape (n, count)."""
        return self.sides[self.first[self.count == count][:, None] + np.arange(count)]

    def crowded_counts(self) -> list[int]:
        """Return the different numbers of sides of edges that have more than two."""
        return [int(count) for count in np.unique(self.count) if count > 2]


def edge_sides(tail: IntArray, head: IntArray) -> EdgeSides:
    """Group sides by their two ends.

    Args:
        tail: number of the vertex at which each side starts, shape (C,).
        head: number of the vertex at which each side ends, shape (C,).
    """
    key = edge_keys(tail, head, int(tail.max(initial=0)) + 1)
    sides = np.argsort(key, kind="stable")
    is_first = np.concatenate([[True], np.diff(key[sides]) != 0])
    first = np.flatnonzero(is_first[: len(key)])
    return EdgeSides(sides, first, np.diff(np.append(first, len(key))))


def edge_keys(tail: IntArray, head: IntArray, vertex_count: int) -> IntArray:
    """Return a number for each pair of ends, the same for both directions, shape (n,)."""
    return np.minimum(tail, head) * vertex_count + np.maximum(tail, head)


def edges_of(soup: Soup) -> EdgeSides:
    """Group the sides of polygons by edge."""
    return edge_sides(soup.vertex, soup.head)


def open_sides(soup: Soup) -> NDArray[np.bool_]:
    """Return whether each side is alone on its edge, shape (C,)."""
    alone = np.zeros(len(soup.vertex), dtype=bool)
    alone[edges_of(soup).with_count(1)[:, 0]] = True
    return alone
