# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The faces of a mesh as triangles, for all that draws, cuts or measures a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh.ears import clip_ears, pair_keys
from stitchmesh.mesh.polygon_mesh import IntArray, Mesh, ranges


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
    too, and none is flat where a corner lies on the straight line between its neighbours. Two faces can share two sides
    that meet; then neither is cut along the diagonal between the ends of these sides, which would be one edge of four
    triangles. The triangles of a mesh without a lattice therefore form a mesh too.
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
    """Faces with a diagonal that is an edge or a diagonal of another face too, and the pairs that are taken for them.

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
