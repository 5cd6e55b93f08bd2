# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Balls and boxes as closed meshes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.mesh import Mesh
from stitchmesh.mixed.output.loop_subdivision import loop_subdivision

BALL_ROUNDS = 4
"""How often the faces of an octahedron are divided into four; a quarter of a circle has 16 edges."""
OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
OCTANTS = [[x, y, z] if (x + y + z) % 2 == 0 else [x, z, y] for x in (0, 1) for y in (2, 3) for z in (4, 5)]
"""Faces of the octahedron, outwards."""
QUADS = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
"""Faces of a box, outwards; corners 0 to 3 are the lower ring."""


def ball(radius: float, centre: ArrayLike) -> Mesh:
    """Return a ball of triangles whose corners lie on the sphere."""
    divided = loop_subdivision(OCTANTS, len(OCTAHEDRON), BALL_ROUNDS)
    points = divided.linear @ OCTAHEDRON
    directions = points / np.linalg.norm(points, axis=1, keepdims=True)
    return Mesh.from_polygons(radius * directions + np.asarray(centre), divided.triangles.tolist())


def box(size: ArrayLike, centre: ArrayLike) -> Mesh:
    """Return a box of six faces."""
    ring = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    corners = np.concatenate([np.column_stack([ring, np.full(4, z)]) for z in (-0.5, 0.5)])
    return Mesh.from_polygons(corners * np.asarray(size) + np.asarray(centre), QUADS)
