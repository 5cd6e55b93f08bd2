# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The border of a cloth in its sides: parts that run on without a corner.

A rectangle has four; the hem of a skirt is one closed side.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from stitchmesh.mesh import BORDER, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth

CORNER = 50.0
"""Angle by which a border turns at a corner [degrees]; the hem of a coarse sleeve turns by less at each edge."""


def border_sides(cloth: Cloth) -> tuple[IntArray, ...]:
    """Return the sides of triangles along each part of the border, ascending; parts by their lowest side."""
    sides = np.flatnonzero(cloth.twin == BORDER)
    start, end = cloth.side_vertices[sides].T
    along = cloth.vertices[end] - cloth.vertices[start]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), np.finfo(float).tiny)
    leaving = np.full(len(cloth.vertices), -1)
    leaving[start] = np.arange(len(sides))
    following = leaving[end]  # A border is closed: a side leaves each vertex at which one ends.
    smooth = (along * along[following]).sum(axis=1) > np.cos(np.radians(CORNER))
    joined = np.flatnonzero(smooth), following[smooth]
    graph = csr_array((np.ones(len(joined[0])), joined), shape=(len(sides), len(sides)))
    count, part = connected_components(graph, directed=False)
    return tuple(sides[part == number] for number in range(count))
