# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cells of grids that become faces, and cells that are left out beside them.

A cell of second order becomes a polygon through its corners and the middles of its sides.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.mesh import FloatArray

RING_OF_6 = [0, 3, 1, 4, 2, 5]
"""Points around a triangle of second order, whose corners are numbered before the middles of its sides."""
RING_OF_8 = [0, 4, 1, 5, 2, 6, 3, 7]
"""Points around a quad of second order."""
BESIDE = ("vertex", "poly_vertex", "line", "polyline", "line3", "tetra", "voxel", "hexahedron", "wedge", "pyramid",
          "tetra10", "hexahedron20", "hexahedron27", "wedge15", "pyramid13")  # fmt: skip
"""Types of cells that can be left out, because they are no surfaces."""


def check_cells_left_out(name: str, faces: int, others: Mapping[str, int]) -> None:
    """Check that a grid has faces, and that all other cells are no surfaces.

    Args:
        name: the file, for messages.
        faces: number of faces.
        others: number of cells of each other type.

    Raises:
        FileError: it has not.
    """
    solid = [kind for kind in others if kind not in ("vertex", "poly_vertex", "line", "polyline", "line3")]
    unknown = [kind for kind in others if kind not in BESIDE]
    if unknown or (solid and not faces):
        kind = (unknown or solid)[0]
        raise FileError(f"{name}: got {kind} cells; expected a surface of triangles, quads or polygons")
    if not faces:
        raise FileError(f"{name}: has no faces; expected a polygon mesh")


def used_points(points: FloatArray, faces: list[list[int]]) -> tuple[FloatArray, list[list[int]]]:
    """Leave out the points that belong only to cells that are left out.

    Args:
        points: shape (P, 3).
        faces: points of each face.

    Returns:
        The points of the faces in their order, shape (V, 3), and the faces with their new numbers.
    """
    used = np.zeros(len(points), dtype=bool)
    used[[point for face in faces for point in face]] = True
    number = (np.cumsum(used) - 1).tolist()
    return points[used], [[number[point] for point in face] for face in faces]
