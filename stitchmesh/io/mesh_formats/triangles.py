# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Division of polygons into triangles, for formats that limit the number of corners of a face.

VTK divides the polygons, because VTK also divides concave polygons correctly.
"""

from __future__ import annotations

import logging
from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray

logger = logging.getLogger(__name__)


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
    made: list[list[int]] = []
    parts = _triangles(path, vertices, [faces[number] for number in large])
    of_face = dict(zip(large, parts, strict=True))
    for number, face in enumerate(faces):
        made += of_face.get(number, [face])
    return made


def _triangles(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> list[list[list[int]]]:
    """Return the triangles of each face, as vertices counted from 0."""
    import pyvista

    data = pyvista.PolyData(vertices, faces=np.concatenate([[len(face), *face] for face in faces]))
    data.cell_data["face"] = np.arange(len(faces))
    cut = data.triangulate()
    corners, face = cut.regular_faces, cut.cell_data["face"]
    parts: list[list[list[int]]] = [[] for _ in faces]
    for number, triangle in zip(face.tolist(), corners.tolist(), strict=True):
        parts[number].append(triangle)
    for polygon, part in zip(faces, parts, strict=True):
        if len(part) != len(polygon) - 2:
            name = f"face with the vertices {polygon[:6]}"
            raise FileError(f"{fspath(path)}: the {name} cannot be divided into triangles; write .obj, .off or .ply")
    return parts
