# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles whose parts meet in single vertices, as a surface of which each vertex has one fan of triangles.

The triangles outside a region of yarns may touch one another in a vertex alone. Mesh files of manifold surfaces need a
vertex of its own for each fan.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import IntArray


def one_vertex_for_each_fan(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Return triangles whose vertices have one fan each, and the vertex that each new vertex was.

    Args:
        triangles: vertices of each triangle, shape (T, 3); each edge belongs to at most two of them.

    Returns:
        Vertices of each triangle, shape (T, 3), and the given vertex of each of them, shape (n,).
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    corners = np.arange(triangles.size).reshape(-1, 3)
    starts, ends = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    flat = triangles.ravel()
    reversed_side = flat[starts] > flat[ends]
    low, high = np.where(reversed_side, ends, starts), np.where(reversed_side, starts, ends)
    order = np.lexsort((flat[high], flat[low]))
    low, high = low[order], high[order]
    same = np.flatnonzero((flat[low[1:]] == flat[low[:-1]]) & (flat[high[1:]] == flat[high[:-1]]))
    one = np.concatenate([low[same], high[same]])
    other = np.concatenate([low[same + 1], high[same + 1]])
    links = coo_array((np.ones(len(one)), (one, other)), shape=(len(flat), len(flat)))
    count, fan = connected_components(links, directed=False)
    source = np.empty(count, dtype=np.int64)
    source[fan] = flat
    return fan[corners].astype(np.int64), source
