# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Corners that meet in one vertex, once sides have other twins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh


def corner_fans(fabric: StitchMesh, twin: IntArray) -> IntArray:
    """Number of the fan of faces that each corner belongs to, shape (C,).

    Args:
        fabric: the stitch mesh.
        twin: the side that is to lie across each side, shape (C,).
    """
    inner = np.flatnonzero(twin != BORDER)
    neighbour = fabric.side_next[twin[inner]]
    count = fabric.side_count
    link = coo_array((np.ones(len(inner)), (inner, neighbour)), shape=(count, count))
    fans: IntArray = connected_components(link.tocsr(), directed=False)[1].astype(np.int64)
    return fans


def reconnected(fabric: StitchMesh, vertices: FloatArray, corner: IntArray, twin: IntArray) -> StitchMesh:
    """The fabric connected otherwise; an edge keeps the stretch of its first side."""
    changed = replace(fabric, vertices=vertices, face_vertex=corner, twin=twin, stretch=None)
    if fabric.stretch is None:
        return changed
    return replace(changed, stretch=fabric.stretch[fabric.side_edge[changed.edge_side]])
