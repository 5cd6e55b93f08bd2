# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygons cut into triangles."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import IntArray, Mesh

from .even_triangles import split_edges
from .level_surface import triangle_mesh


def triangulated(mesh: Mesh, edge: float | None = None) -> Mesh:
    """Cut the faces of a mesh without a lattice into triangles.

    Args:
        mesh: convex polygons.
        edge: edges that are longer are split at their midpoints [cm]; None splits none.
    """
    points, corners = np.array(mesh.vertices), fans(mesh)
    if edge is not None:
        points, corners = split_edges(points, corners, edge)
    return triangle_mesh(points, corners)


def fans(mesh: Mesh) -> IntArray:
    """Triangles of each face around one of its corners: the first one in even faces, the second one in odd faces."""
    triangles = []
    for face, start in enumerate(mesh.face_start[:-1]):
        ring = np.roll(mesh.face_vertex[start : mesh.face_start[face + 1]], -(face % 2))
        triangles += [(ring[0], ring[k], ring[k + 1]) for k in range(1, len(ring) - 1)]
    return np.array(triangles, dtype=np.int64)
