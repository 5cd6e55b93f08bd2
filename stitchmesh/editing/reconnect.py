# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A stitch mesh with new vertices and twins, and the change that leads to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.change import Change, Patch, inverse_change


def reconnect(fabric: StitchMesh, vertices: FloatArray, corner: IntArray, twin: IntArray) -> StitchMesh:
    """Return the fabric with new vertices and twins; an edge keeps the stretch of its first side.

    Args:
        fabric: a mesh of stitches.
        vertices: positions of the vertices [cm], shape (V, 3).
        corner: vertex of each corner, shape (C,).
        twin: opposite side of each side, ``BORDER`` at borders, shape (C,).
    """
    changed = replace(fabric, vertices=vertices, face_vertex=corner, twin=twin, stretch=None)
    if fabric.stretch is None:
        return changed
    return replace(changed, stretch=fabric.stretch[fabric.side_edge[changed.edge_side]])


def replacement(before: StitchMesh, after: StitchMesh) -> Change:
    """Return the change from one stitch mesh to another: the inverse of the change from the second to the first."""
    nothing = np.zeros(0, dtype=np.int64)
    backwards = Patch(
        removed_faces=np.arange(after.face_count), removed_vertices=np.arange(len(after.vertices)),
        added_faces=np.arange(before.face_count), added_vertices=np.arange(len(before.vertices)),
        positions=np.zeros((0, 3)), face_size=nothing, corners=nothing, twin=np.zeros((0, 2), dtype=np.int64),
        faces={}, sides={}, stretch=np.zeros(0),
    )  # fmt: skip
    return inverse_change(after, backwards)
