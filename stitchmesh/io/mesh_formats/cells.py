# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cells of grids that become faces, and cells that are left out beside them.

A cell of second order becomes a polygon through its corners and the middles of its sides. The module also divides
strips into triangles, and polygons for formats that limit the number of corners of a face.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from os import fspath

import numpy as np

from stitchmesh.errors import FileError, MeshError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.face_triangles import clip_ears

_RING_OF_6, _RING_OF_8 = [0, 3, 1, 4, 2, 5], [0, 4, 1, 5, 2, 6, 3, 7]
RINGS: dict[str, slice | list[int]] = {
    "triangle": slice(None), "quad": slice(None), "polygon": slice(None), "pixel": [0, 1, 3, 2],
    "triangle6": _RING_OF_6, "triangle7": _RING_OF_6, "quad8": _RING_OF_8, "quad9": _RING_OF_8,
}  # fmt: skip
"""Points around each type of cells that becomes faces. In cells of second order, the corners are numbered before the
middles of the sides."""
BESIDE = ("vertex", "poly_vertex", "line", "polyline", "line3", "tetra", "voxel", "hexahedron", "wedge", "pyramid",
          "tetra10", "hexahedron20", "hexahedron27", "wedge15", "pyramid13")  # fmt: skip
"""Types of cells that can be left out, because they are no surfaces."""
logger = logging.getLogger(__name__)


def check_cells_left_out(name: str, faces: int, others: Mapping[str, int]) -> None:
    """Check that a grid has faces, and that all other cells are no surfaces.

    Args:
        name: the file, for messages.
        faces: number of faces.
        others: number of cells of each other type.

    Raises:
        FileError: the grid has no faces, or other cells are surfaces.
    """
    solid = [kind for kind in others if kind not in ("vertex", "poly_vertex", "line", "polyline", "line3")]
    unknown = [kind for kind in others if kind not in BESIDE]
    if unknown or (solid and not faces):
        kind = (unknown or solid)[0]
        raise FileError(f"{name}: got {kind} cells; expected a surface of triangles, quads or polygons")
    if not faces:
        raise FileError(f"{name}: has no faces; expected a polygon mesh")


def used_points(name: str, points: FloatArray, faces: list[list[int]]) -> tuple[FloatArray, list[list[int]]]:
    """Leave out the points that belong only to cells that are left out.

    Args:
        name: what the faces come from, for messages.
        points: shape (P, 3).
        faces: points of each face.

    Returns:
        The points of the faces in their order, shape (V, 3), and the faces with their new numbers.

    Raises:
        MeshError: a face names a point that does not exist.
    """
    corners = [point for face in faces for point in face]
    unknown = next((point for point in corners if not 0 <= point < len(points)), None)
    if unknown is not None:
        raise MeshError(f"{name}: a face names point {unknown}; expected 0 to {len(points) - 1}")
    used = np.zeros(len(points), dtype=bool)
    used[corners] = True
    number = (np.cumsum(used) - 1).tolist()
    return points[used], [[number[point] for point in face] for face in faces]


def strip_triangles(corners: IntArray) -> IntArray:
    """Return the triangles of a strip, shape (n - 2, 3): each three corners in succession, every other one turned over.

    Args:
        corners: points of the strip, shape (n,).
    """
    first = np.arange(max(0, len(corners) - 2))
    return corners[np.stack([first, first + 1 + first % 2, first + 2 - first % 2], axis=1)]


def divide_large_faces(
    path: FilePath, vertices: FloatArray, faces: list[list[int]], most_corners: int
) -> list[list[int]]:
    """Divide the faces that have too many corners into triangles, and log the number of these faces as a warning.

    Args:
        path: the file to which the faces are written, for messages.
        vertices: positions, shape (V, 3).
        faces: vertices of each face, counted from 0.
        most_corners: largest number of corners of a face in the format, 3 or 4.

    Returns:
        The faces in their order; the triangles of a divided face take its place.

    Raises:
        FileError: a face cannot be divided, because it has no interior.
    """
    large = [number for number, face in enumerate(faces) if len(face) > most_corners]
    if not large:
        return faces
    kind = "triangles" if most_corners == 3 else "triangles and quads"
    logger.warning("%s: the format holds %s; %d larger faces are divided", fspath(path), kind, len(large))
    corners = np.concatenate([faces[number] for number in large])
    size = np.array([len(faces[number]) for number in large])
    ears = clip_ears(vertices[corners], corners, size)
    if not ears.whole.all():
        name = f"face with the vertices {faces[large[int(np.argmin(ears.whole))]][:6]}"
        raise FileError(f"{fspath(path)}: the {name} cannot be divided into triangles; write .obj, .off or .ply")
    parts = np.split(corners[ears.triangles], np.cumsum(size - 2)[:-1])
    made = dict(zip(large, (part.tolist() for part in parts), strict=True))
    return [part for number, face in enumerate(faces) for part in made.get(number, [face])]
