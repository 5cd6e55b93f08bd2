# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The faces of a mesh as triangles, for all code that draws, cuts or measures a surface.

Polygons are divided into triangles by their ears, even a polygon that passes a bridge twice. An ear is a triangle of
three successive corners that holds no other corner (Meisters, *Polygons have ears*, 1975). The ear with the best shape
is cut off first; a quad is cut along the diagonal whose worse triangle has the better shape. The search begins at the
corner with the lowest vertex, so that the triangles are the same for every first corner. Polygons with the same number
of corners are divided together.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh.polygon_mesh import FloatArray, IntArray, Mesh, ranges

FLAT = 1e-11
"""A triangle is no ear if twice its area, over the area of the square around the polygon, is at most this. The limit is
above the area that ``Mesh`` calls zero."""
MOST_CORNERS = 2048
"""A polygon with more corners is divided as a fan, because the time to find ears grows with the square of this
number."""


@dataclass(frozen=True, eq=False)
class Ears:
    """The triangles of F polygons with C corners."""

    triangles: IntArray
    """Corners of each triangle, polygon by polygon, n - 2 triangles for n corners, shape (T, 3)."""
    whole: NDArray[np.bool_]
    """Whether the triangles cover their polygon without overlap, shape (F,); False if a polygon crosses itself or has
    more than ``MOST_CORNERS`` corners."""


def clip_ears(points: FloatArray, vertex: IntArray, size: IntArray, taken: IntArray | None = None) -> Ears:
    """Divide polygons into triangles.

    Args:
        points: positions of the corners, polygon by polygon, shape (C, 3); each polygon lies nearly in one plane.
        vertex: vertex at each corner, shape (C,); corners at one vertex do not hide each other.
        size: number of corners of each polygon, 3 or more, shape (F,).
        taken: pairs of vertices that no diagonal may join, each as ``pair_keys`` numbers it, in any order.
    """
    first = np.cumsum(size) - size
    triangles, whole = np.empty((len(vertex) - 2 * len(size), 3), dtype=np.int64), np.ones(len(size), dtype=bool)
    for count in np.unique(size).tolist():
        some = np.flatnonzero(size == count)
        corners = first[some, None] + np.arange(count)
        made = np.broadcast_to(np.arange(3), (len(some), 1, 3))
        if count > MOST_CORNERS:
            place = np.arange(count - 2)
            made, whole[some] = np.stack([0 * place, place + 1, place + 2], axis=1), False
        elif count > 3:
            made, whole[some] = _divided_by_ears(points[corners], vertex[corners], taken)
        triangles[(first - 2 * np.arange(len(size)))[some, None] + np.arange(count - 2)] = corners[:, :1, None] + made
    return Ears(triangles, whole)


def _divided_by_ears(
    points: FloatArray, vertex: IntArray, taken: IntArray | None
) -> tuple[IntArray, NDArray[np.bool_]]:
    """Divide polygons with the same number of corners.

    Args:
        points: positions of the corners, shape (F, n, 3).
        vertex: vertex at each corner, shape (F, n).
        taken: as for ``clip_ears``.

    Returns:
        Places in its polygon of the corners of each triangle, shape (F, n - 2, 3), and whether all are ears, (F,).
    """
    count, size = vertex.shape
    lowest = np.argmin(vertex * (vertex.max() + 1) + np.roll(vertex, -1, axis=1), axis=1)
    order = (lowest[:, None] + 1 + np.arange(size)) % size  # The corner with the lowest vertex comes last.
    row = np.arange(count)[:, None]
    polygons = _Polygons(_in_plane(points[row, order]), vertex[row, order].T)
    triangles, whole = np.empty((count, size - 2, 3), dtype=np.int64), polygons.least > 0.0
    left = np.broadcast_to(np.arange(size)[:, None], (size, count))
    for step in range(size - 2):
        ear, found = _best_ears(polygons, left, taken)
        for k in range(3):
            triangles[:, step, k] = left[(ear + k - 1) % len(left), row[:, 0]]
        whole &= found
        left = left.T[np.arange(len(left)) != ear[:, None]].reshape(count, -1).T
    return order[row[:, :, None], triangles], whole


def pair_keys(one: IntArray, other: IntArray) -> IntArray:
    """Return one number for each pair of vertices, the same in both directions."""
    keys: IntArray = (np.maximum(one, other) << 32) + np.minimum(one, other)
    return keys


@dataclass(frozen=True, eq=False)
class _Polygons:
    """Polygons in their mean planes, in columns, because NumPy adds up columns faster than short rows."""

    flat: NDArray[np.complex128]
    """Positions of the corners [cm], anticlockwise, shape (n, F)."""
    vertex: IntArray
    """Vertex at each corner, shape (n, F)."""

    @cached_property
    def least(self) -> FloatArray:
        """Twice the area of a triangle that is flat [cm^2], shape (F,)."""
        return FLAT * np.maximum(np.ptp(self.flat.real, axis=0), np.ptp(self.flat.imag, axis=0)) ** 2


def _in_plane(points: FloatArray) -> NDArray[np.complex128]:
    """Positions in the mean plane of each polygon, anticlockwise, shape (n, F)."""
    spans = points - points[:, :1]
    normal = np.cross(spans, np.roll(spans, -1, axis=1)).sum(axis=1)
    across = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    right = np.cross(across, normal)
    x, y = (
        np.einsum("fnd,fd->nf", spans, axis) / np.maximum(np.linalg.norm(axis, axis=1), np.finfo(float).tiny)
        for axis in (right, np.cross(normal, right))
    )
    plane: NDArray[np.complex128] = x + 1j * y
    return plane


def _best_ears(polygons: _Polygons, left: IntArray, taken: IntArray | None) -> tuple[IntArray, NDArray[np.bool_]]:
    """Find the best ear of the rest of each polygon.

    Args:
        polygons: the polygons.
        left: corners that are left, shape (m, F).
        taken: as for ``clip_ears``.

    Returns:
        The place of the best triangle in ``left``, and whether it is an ear, shape (F,) each.
    """
    column, size = np.arange(left.shape[1]), len(left)
    b = polygons.flat[left, column]
    a, c = np.roll(b, 1, axis=0), np.roll(b, -1, axis=0)
    area = _turn(a, b, c)
    shape = np.where(area > polygons.least, area, np.minimum(area, 0.0))
    shape /= np.maximum(_square(b - a) + _square(c - b) + _square(a - c), np.finfo(float).tiny)
    if size == 4:
        shape = np.minimum(shape, np.roll(shape, 2, axis=0))  # The other ear at the same diagonal.
    free = shape.copy()
    if taken is not None and size > 3:
        vertex = polygons.vertex[left, column]
        free[np.isin(pair_keys(np.roll(vertex, 1, axis=0), np.roll(vertex, -1, axis=0)), taken)] = -1.0
    ear = _first_of_best(free)
    doubtful = column[free[ear, column] > 0.0] if size > 4 else column[:0]
    while len(doubtful):
        hidden = doubtful[_hold_corners(polygons, left[:, doubtful], ear[doubtful], doubtful)]
        free[ear[hidden], hidden] = -1.0
        ear[hidden] = _first_of_best(free[:, hidden])
        doubtful = hidden[free[ear[hidden], hidden] > 0.0]
    found = free[ear, column] > 0.0
    return np.where(found, ear, np.argmax(shape, axis=0)), found


def _first_of_best(shape: FloatArray) -> IntArray:
    """The first of the best places of each column; places that differ by rounding only are equal, shape (F,)."""
    best = shape.max(axis=0)
    # The two diagonals of a rectangle may differ by so much by rounding.
    place: IntArray = np.argmax(shape >= best - 1e-9 * np.abs(best), axis=0)
    return place


def _hold_corners(polygons: _Polygons, left: IntArray, ear: IntArray, column: IntArray) -> NDArray[np.bool_]:
    """Whether an ear of some polygons holds or touches another corner that is left, shape of ``column``."""
    own = [left[(ear + k) % len(left), np.arange(len(column))] for k in (-1, 0, 1)]
    a, b, c = (polygons.flat[corner, column] for corner in own)
    others, vertex = polygons.flat[left, column], polygons.vertex[left, column]
    inside = np.minimum.reduce([_turn(p, q, others) for p, q in ((a, b), (b, c), (c, a))]) >= -polygons.least[column]
    for corner in own:
        inside &= vertex != polygons.vertex[corner, column]
    held: NDArray[np.bool_] = inside.any(axis=0)
    return held


def _turn(a: NDArray[np.complex128], b: NDArray[np.complex128], c: NDArray[np.complex128]) -> FloatArray:
    """Twice the area of triangles in a plane, positive anticlockwise."""
    return ((b - a).conj() * (c - a)).imag


def _square(side: NDArray[np.complex128]) -> FloatArray:
    return side.real**2 + side.imag**2


@dataclass(frozen=True, eq=False)
class FaceTriangles:
    """Triangles that cover the faces of a mesh, face by face in ascending order."""

    corners: IntArray
    """Corners of the mesh at the corners of each triangle, anticlockwise seen from outside, shape (T, 3)."""
    face: IntArray
    """Face that each triangle covers, ascending, shape (T,)."""


def face_triangles(mesh: Mesh) -> FaceTriangles:
    """Divide the faces into triangles by their ears (``clip_ears``).

    A face with n corners has n - 2 triangles, the same ones whichever corner is its first. They cover a concave face
    too, and none of them is flat, even if a corner lies on the straight line between its neighbours. Two faces can
    share two sides that meet. Then neither face is cut along the diagonal between the ends of these sides, because this
    diagonal would be one edge of four triangles. The triangles of a mesh without a lattice therefore form a mesh too.
    """
    corners = _divided(mesh, np.arange(mesh.face_count), None)
    size = np.diff(mesh.face_start) - 2
    if mesh.lattice is None and size.max() > 1:
        clash, taken = _faces_that_clash(mesh, corners)
        if len(clash):
            corners[ranges(np.concatenate([[0], np.cumsum(size)]), clash)] = _divided(mesh, clash, taken)
    return FaceTriangles(corners, np.repeat(np.arange(mesh.face_count), size))


def _divided(mesh: Mesh, faces: IntArray, taken: IntArray | None) -> IntArray:
    """Corners of the triangles of some faces, face by face, shape (t, 3)."""
    sides = mesh.sides_of(faces)
    size = np.diff(mesh.face_start)[faces]
    return sides[clip_ears(mesh.corner_position[sides], mesh.face_vertex[sides], size, taken).triangles]


def _faces_that_clash(mesh: Mesh, corners: IntArray) -> tuple[IntArray, IntArray]:
    """Faces with a diagonal that is also an edge or a diagonal of another face, and the vertex pairs to avoid.

    Args:
        mesh: the mesh.
        corners: corners of its triangles, shape (T, 3).
    """
    after = np.roll(corners, -1, axis=1)
    diagonal = (mesh.side_next[corners] != after) & (corners < after)  # A diagonal occurs once in each direction.
    start = np.concatenate([mesh.edge_side, corners[diagonal]])
    end = np.concatenate([mesh.side_next[mesh.edge_side], after[diagonal]])
    keys, face = pair_keys(mesh.face_vertex[start], mesh.face_vertex[end]), mesh.side_face[start]
    order = np.argsort(keys)
    again = np.flatnonzero(np.diff(keys[order]) == 0)
    shared = np.concatenate([order[again], order[again + 1]])
    clash = np.unique(face[shared[shared >= len(mesh.edge_side)]])
    kept = ~np.isin(face, clash)
    kept[shared] = kept[: len(mesh.edge_side)] = True
    return clash, keys[kept]
