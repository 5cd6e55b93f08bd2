# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The faces of a mesh as triangles, for drawing and for picking."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh.polygon_mesh import IntArray, Mesh


@dataclass(frozen=True, eq=False)
class FaceTriangles:
    """Triangles that cover the faces of a mesh, face by face in ascending order."""

    corners: IntArray
    """Corners of the mesh at the corners of each triangle, anticlockwise seen from outside, shape (T, 3)."""
    face: IntArray
    """Face that each triangle covers, ascending, shape (T,)."""


def face_triangles(mesh: Mesh) -> FaceTriangles:
    """Divide the faces into triangles that share the first corner of their face.

    A face with n corners has n - 2 triangles. They cover a face exactly if all its corners can be seen from the first
    one, which holds for every convex face.
    """
    count = np.diff(mesh.face_start) - 2
    face = np.repeat(np.arange(mesh.face_count), count)
    place = np.arange(len(face)) - np.repeat(np.cumsum(count) - count, count)
    first = mesh.face_start[face]
    return FaceTriangles(np.stack([first, first + place + 1, first + place + 2], axis=1), face)
