# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Points as small octahedra of one colour."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.scene.drawing import Colour, Surface
from stitchmesh.mesh import FloatArray

OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
OCTAHEDRON_FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


def point_marks(centres: FloatArray, size: float, colour: Colour) -> Surface:
    """Return marks of points.

    Args:
        centres: the points [cm], shape (n, 3).
        size: distance of the corners of each octahedron from its point [cm].
        colour: their colour, sRGB.
    """
    points = (centres[:, None] + size * OCTAHEDRON).reshape(-1, 3)
    triangles = (len(OCTAHEDRON) * np.arange(len(centres))[:, None, None] + OCTAHEDRON_FACES).reshape(-1, 3)
    return Surface(points, triangles, colour)
