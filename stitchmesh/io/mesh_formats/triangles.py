# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles of strips, as files hold them, and of polygons, for formats that limit the number of corners of a face."""

from __future__ import annotations

import logging
from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.ears import clip_ears

logger = logging.getLogger(__name__)


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
