# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Triangles of stereolithography files (STL), read from texts and binary files, and written as binary files.

A text has lines ``facet``, ``outer loop``, three times ``vertex x y z``, ``endloop`` and ``endfacet`` for each triangle
between ``solid`` and ``endsolid``. A binary file has 80 bytes of any content, the number of triangles as uint32, and
for each triangle its normal and its corners as float32, little-endian, and two further bytes. Corners at exactly equal
positions become one vertex. This module exists because meshio loses the end of a file on a full disk.
"""

from __future__ import annotations

from os import fspath

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_bytes
from stitchmesh.io.contents import FilePath, check_points, read_bytes
from stitchmesh.io.float32 import from_float32, to_float32
from stitchmesh.io.mesh_formats.welding import weld
from stitchmesh.mesh import FloatArray

HEAD = 84
"""Bytes before the first triangle of a binary file."""
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
"""A triangle of a binary file."""


def read_stl_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read triangles.

    Returns:
        Vertices in the file's unit, shape (V, 3), and the vertices of each triangle, counted from 0.

    Raises:
        FileError: the file is missing, a folder, unreadable, empty, cut short or malformed, a coordinate is not
            finite, or there are no triangles.
    """
    name, content = fspath(path), read_bytes(path)
    count = int.from_bytes(content[HEAD - 4 : HEAD], "little")
    size = HEAD + TRIANGLE.itemsize * count
    is_text = content.lstrip()[:5].lower() == b"solid" and size != len(content)
    if is_text and b"\0" not in content:
        corners = _text_corners(name, content)
    elif len(content) < HEAD or size > len(content):
        found = f"{count} triangles need {size} bytes, the file has {len(content)}"
        raise FileError(f"{name}: is not a valid STL file: {found}; it was cut short or altered")
    else:
        corners = from_float32(np.frombuffer(content, TRIANGLE, count, HEAD)["corners"].reshape(-1, 3))
    if not len(corners):
        raise FileError(f"{name}: has no faces; expected a polygon mesh")
    check_points(f"{name}: point", corners)
    return weld(corners, np.arange(len(corners)).reshape(-1, 3).tolist())


def write_stl_polygons(path: FilePath, vertices: FloatArray, faces: list[list[int]]) -> None:
    """Write triangles as a binary file.

    Args:
        path: the file.
        vertices: positions in the file's unit, shape (V, 3).
        faces: vertices of each triangle, counted from 0.

    Raises:
        FileError: a coordinate is too large for float32, or the file cannot be written.
    """
    triangles = np.zeros(len(faces), TRIANGLE)
    triangles["corners"] = to_float32(path, "the coordinates", vertices)[np.array(faces)]
    first, second, third = np.moveaxis(vertices[np.array(faces)], 1, 0)
    normals = np.cross(second - first, third - first)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    triangles["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    head = b"StitchMesh".ljust(HEAD - 4) + len(faces).to_bytes(4, "little")
    write_bytes(path, head + triangles.tobytes())


def _text_corners(name: str, content: bytes) -> NDArray[np.float64]:
    """Return the corners of all triangles of a text, shape (3 T, 3)."""
    corners: list[list[float]] = []
    for number, line in enumerate(content.decode("utf-8", errors="replace").splitlines(), start=1):
        words = line.split()
        word = words[0].lower() if words else "solid"
        if word == "vertex":
            corners.append(_corner(name, number, words))
        elif word == "endloop" and (not corners or len(corners) % 3):
            raise FileError(f"{name}: line {number}: a facet does not have three corners; STL holds triangles")
        elif word not in ("solid", "facet", "outer", "endloop", "endfacet", "endsolid"):
            raise FileError(f"{name}: line {number}: got {line.strip()[:40]!r}; expected a line of an STL file")
    if len(corners) % 3:
        raise FileError(f"{name}: ends within a facet; the file was cut short")
    return np.array(corners).reshape(-1, 3)


def _corner(name: str, number: int, words: list[str]) -> list[float]:
    try:
        x, y, z = (float(word) for word in words[1:])
    except ValueError as error:
        found = " ".join(words)[:40]
        raise FileError(f"{name}: line {number}: got {found!r}; expected 'vertex' and three numbers") from error
    return [x, y, z]
