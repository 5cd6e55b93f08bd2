# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A stitch mesh whose sides get other twins: the corners that then meet in one vertex, and the mesh so connected."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.connectivity import find_fans


def corner_fans(fabric: StitchMesh, twin: IntArray) -> IntArray:
    """Number of the fan of faces that each corner belongs to, shape (C,).

    Args:
        fabric: the stitch mesh.
        twin: the side that is to lie across each side, shape (C,).
    """
    return find_fans(np.where(twin == BORDER, BORDER, fabric.side_next[twin]))


def reconnected(fabric: StitchMesh, vertices: FloatArray, corner: IntArray, twin: IntArray) -> StitchMesh:
    """The fabric connected otherwise; an edge keeps the stretch of its first side."""
    changed = replace(fabric, vertices=vertices, face_vertex=corner, twin=twin, stretch=None)
    if fabric.stretch is None:
        return changed
    return replace(changed, stretch=fabric.stretch[fabric.side_edge[changed.edge_side]])
