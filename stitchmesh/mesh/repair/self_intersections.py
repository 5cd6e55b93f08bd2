# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces of a mesh that cross each other.

The triangles of all faces are put in the order of a curve that fills space, and a binary tree of bounding boxes stands
above them. Pairs of boxes that overlap are followed down the tree, all pairs of a level at a time. Source of the order:
Morton, *A computer oriented geodetic data base and a new technique in file sequencing* (1966).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, check_kind, described
from stitchmesh.mesh.face_triangles import FaceTriangles, face_triangles
from stitchmesh.mesh.polygon_mesh import BORDER, FloatArray, IntArray, Mesh

MOST_PAIRS = 2**17
"""Number of pairs of boxes that are followed at a time, which limits the memory."""
ROUNDING = 1e-12
"""The volume of a tetrahedron counts as rounding up to this multiple of the cube of the extent of two triangles."""
BITS = 20
"""Bits of each coordinate in the order of the triangles."""


@dataclass(frozen=True, eq=False)
class _Triangles:
    """The triangles of the faces of a mesh; T is their number."""

    corner: FloatArray
    """Positions of the corners [cm], shape (T, 3, 3)."""
    vertex: IntArray
    """Vertices at the corners, shape (T, 3)."""
    on_border: NDArray[np.bool_]
    """Whether the side from each corner to the next lies on the border of the mesh, shape (T, 3)."""
    ends_on_border: NDArray[np.bool_]
    """Whether each corner lies on the border of the mesh, shape (T, 3)."""
    face: IntArray
    """Face of each triangle, shape (T,)."""


def self_intersections(mesh: Mesh, most: int = 1000) -> IntArray:
    """Find pairs of faces that cross each other and share no vertex.

    A side of one face passes through the inside of the other one. Faces that only touch, or lie in one plane, do not
    cross. Faces with more than three corners are divided into triangles by their ears. A periodic mesh is
    searched within one period.

    Args:
        mesh: the mesh.
        most: number of pairs after which the search ends.

    Returns:
        The two faces of each pair, the lower number first, in ascending order, shape (n, 2) with n at most ``most``.

    Raises:
        ParameterError: ``most`` is below 1, or the mesh is no mesh.
    """
    check_kind("self_intersections", mesh, Mesh)
    if not isinstance(most, int | np.integer) or most < 1:
        raise ParameterError(f"most: got {described(most)}; expected a whole number of at least 1")
    triangles = _triangles(mesh, face_triangles(mesh))
    found = np.zeros((0, 2), dtype=np.int64)
    for overlapping in _overlapping_pairs(triangles.corner):
        pairs = overlapping[_are_apart(triangles.vertex, overlapping)]
        faces = np.sort(triangles.face[pairs[_cross(triangles, pairs)]], axis=1)
        fresh = np.unique(faces, axis=0)
        found = np.unique(np.concatenate([found, fresh[_share_no_vertex(mesh, fresh)]]), axis=0)
        if len(found) >= most:
            break
    return found[:most]


def _triangles(mesh: Mesh, divided: FaceTriangles) -> _Triangles:
    corners = divided.corners
    after = np.roll(corners, -1, axis=1)
    on_border = (mesh.side_next[corners] == after) & (mesh.twin[corners] == BORDER)
    ends = np.zeros(len(mesh.vertices), dtype=bool)
    ends[mesh.face_vertex[mesh.twin == BORDER]] = True  # Each vertex of the border starts one of its sides.
    vertex = mesh.face_vertex[corners]
    return _Triangles(mesh.corner_position[corners], vertex, on_border, ends[vertex], divided.face)


def _are_apart(vertex: IntArray, pairs: IntArray) -> NDArray[np.bool_]:
    """Whether two triangles share no vertex, shape (n,)."""
    first, second = vertex[pairs[:, 0]], vertex[pairs[:, 1]]
    shared: NDArray[np.bool_] = (first[:, :, None] == second[:, None, :]).any(axis=(1, 2))
    return ~shared


def _share_no_vertex(mesh: Mesh, pairs: IntArray) -> NDArray[np.bool_]:
    """Whether two different faces share no vertex, shape (n,)."""
    vertices = {int(face): set(mesh.face_vertex[mesh.sides_of(np.array([face]))].tolist()) for face in np.unique(pairs)}
    return np.array([vertices[a].isdisjoint(vertices[b]) for a, b in pairs.tolist()], dtype=bool)


def _overlapping_pairs(corner: FloatArray) -> Iterator[IntArray]:
    """Yield pairs of triangles whose bounding boxes overlap, some at a time, shape (n, 2).

    Args:
        corner: positions of the corners of the triangles [cm], shape (T, 3, 3).
    """
    order, levels = _box_tree(corner)
    stack = [(0, np.zeros((1, 2), dtype=np.int64))]
    while stack:
        level, pairs = stack.pop()
        if len(pairs) > MOST_PAIRS:
            half = len(pairs) // 2
            stack += [(level, pairs[half:]), (level, pairs[:half])]
        elif level == len(levels) - 1:
            yield order[pairs[pairs[:, 0] != pairs[:, 1]]]
        else:
            stack.append((level + 1, _children(pairs, *levels[level + 1])))


def _box_tree(corner: FloatArray) -> tuple[IntArray, list[tuple[FloatArray, FloatArray]]]:
    """Order of the triangles, and the lower and upper corners of the boxes of each level, the root first."""
    low, high = corner.min(axis=1), corner.max(axis=1)
    order = np.argsort(_along_curve(0.5 * (low + high)), kind="stable")
    empty = 2 ** int(np.ceil(np.log2(len(order)))) - len(order)
    low = np.concatenate([low[order], np.full((empty, 3), np.inf)])
    high = np.concatenate([high[order], np.full((empty, 3), -np.inf)])
    levels = [(low, high)]
    while len(low) > 1:
        low, high = np.minimum(low[::2], low[1::2]), np.maximum(high[::2], high[1::2])
        levels.append((low, high))
    return order, levels[::-1]


def _along_curve(centre: FloatArray) -> IntArray:
    """Places of points along a curve that fills their bounding box, shape (T,)."""
    origin, size = centre.min(axis=0), np.ptp(centre, axis=0).max()
    cell = ((centre - origin) * ((2**BITS - 1) / size if size > 0.0 else 0.0)).astype(np.int64)
    place = np.zeros(len(centre), dtype=np.int64)
    for bit in range(BITS):
        for axis in range(3):
            place |= ((cell[:, axis] >> bit) & 1) << (3 * bit + axis)
    return place


def _children(pairs: IntArray, low: FloatArray, high: FloatArray) -> IntArray:
    """Pairs of the boxes below pairs of boxes that overlap, shape (n, 2).

    Args:
        pairs: boxes of one level, the lower number first, shape (m, 2).
        low: lower corners of the boxes of the next level, shape (k, 3).
        high: their upper corners, shape (k, 3).
    """
    below = (2 * pairs)[:, None, :] + np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    first, second = below.reshape(-1, 2)[below.reshape(-1, 2)[:, 0] <= below.reshape(-1, 2)[:, 1]].T
    for axis in range(3):
        near = (low[first, axis] <= high[second, axis]) & (low[second, axis] <= high[first, axis])
        first, second = first[near], second[near]
    return np.stack([first, second], axis=1)


def _cross(triangles: _Triangles, pairs: IntArray) -> NDArray[np.bool_]:
    """Whether a side of one triangle passes through the other one, shape (n,)."""
    crossing = np.zeros(len(pairs), dtype=bool)
    for first, second in (pairs.T, pairs.T[::-1]):
        side = _sides_of_plane(triangles.corner[first], triangles.corner[second])
        passing = side * np.roll(side, -1, axis=1) < 0.0
        row, start = np.nonzero(passing)
        hit = _passes_through(triangles, first[row], second[row], start)
        crossing[row[hit]] = True
    return crossing


def _sides_of_plane(plane: FloatArray, points: FloatArray) -> FloatArray:
    """On which side of the planes of triangles the corners of other triangles lie: 1, -1, or 0 in the plane.

    Args:
        plane: corners of the triangles [cm], shape (n, 3, 3).
        points: corners of the others [cm], shape (n, 3, 3).
    """
    origin = plane[:, :1]
    normal = np.cross(plane[:, 1] - plane[:, 0], plane[:, 2] - plane[:, 0])
    volume = np.einsum("nki,ni->nk", points - origin, normal)
    return _sign(volume, _extent(plane, points)[:, None])


def _passes_through(triangles: _Triangles, first: IntArray, second: IntArray, start: IntArray) -> NDArray[np.bool_]:
    """Whether a side passes through a triangle, given that its ends lie on different sides of the plane, shape (n,).

    A side through an edge between two triangles of the surface passes through the surface; a side through the border of
    the surface only touches it.

    Args:
        triangles: all triangles.
        first: triangles that are passed, shape (n,).
        second: triangles with the sides, shape (n,).
        start: corner of the second triangle at which the side starts, shape (n,).
    """
    plane, other = triangles.corner[first], triangles.corner[second]
    rows = np.arange(len(first))
    tail, head = other[rows, start], other[rows, (start + 1) % 3]
    spans = plane - tail[:, None]
    moment = np.cross(spans, np.roll(spans, -1, axis=1))
    turn = _sign(np.einsum("nki,ni->nk", moment, head - tail), _extent(plane, other)[:, None])
    way = np.sign(turn.sum(axis=1))[:, None]
    on_side = turn == 0.0
    on_corner = on_side & np.roll(on_side, 1, axis=1)
    outside = (turn * way < 0.0) | (on_side & triangles.on_border[first])
    outside |= on_corner & triangles.ends_on_border[first]
    return ~outside.any(axis=1) & (way[:, 0] != 0.0)


def _sign(volume: FloatArray, extent: FloatArray) -> FloatArray:
    sign: FloatArray = np.where(np.abs(volume) <= ROUNDING * extent**3, 0.0, np.sign(volume))
    return sign


def _extent(first: FloatArray, second: FloatArray) -> FloatArray:
    """Extent of the corners of pairs of triangles along the longest axis [cm], shape (n,)."""
    corners = np.concatenate([first, second], axis=1)
    extent: FloatArray = np.ptp(corners, axis=1).max(axis=1)
    return extent
