# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Medit's meshes in text (``.mesh``): words and numbers between any white space, in one line or in many.

``Vertices``, ``Triangles`` and ``Quadrilaterals`` are followed by their number and by the numbers of each entry, of
which the last one is a reference that is ignored. All other words are left out with the numbers behind them. This
module exists because meshio takes the words line by line.
"""

from __future__ import annotations

from os import fspath

import numpy as np

from stitchmesh.errors import FileError
from stitchmesh.io.contents import FilePath, check_points, read_lines, say_left_out
from stitchmesh.mesh import FloatArray

CORNERS = {"Triangles": 3, "Quadrilaterals": 4}
"""Number of corners of the faces behind each word."""


def read_medit_polygons(path: FilePath) -> tuple[FloatArray, list[list[int]]]:
    """Read triangles and quadrilaterals; the vertices of a file of two dimensions lie in the plane z = 0.

    Returns:
        Vertices in the file's unit, shape (V, 3), and the vertices of each face, counted from 0, in the order of the
        file.

    Raises:
        FileError: the file is missing, a folder, unreadable, empty, binary, cut short or malformed, a coordinate is not
            finite, a vertex does not exist, or there are no faces.
    """
    name = fspath(path)
    words = [word for line in read_lines(path) for word in line.partition("#")[0].split()]
    if words[:1] != ["MeshVersionFormatted"]:
        raise FileError(f"{name}: is not a valid medit file; expected the word MeshVersionFormatted first")
    try:
        vertices, faces, others = _content(words)
    except (ValueError, IndexError, OverflowError) as error:
        raise FileError(f"{name}: is not a valid medit file ({error}); it was cut short or altered") from error
    if not faces:
        raise FileError(f"{name}: has no faces; expected a polygon mesh")
    check_points(f"{name}: point", vertices)
    bad = [index for index, face in enumerate(faces) if not 0 <= min(face) <= max(face) < len(vertices)]
    if bad:
        found = f"face {bad[0]} names the vertices {[vertex + 1 for vertex in faces[bad[0]]]}"
        raise FileError(f"{name}: {found}; expected numbers from 1 to {len(vertices)}")
    say_left_out(path, others, "elements")
    return vertices, faces


def _content(words: list[str]) -> tuple[FloatArray, list[list[int]], dict[str, int]]:
    """Return the vertices, shape (V, 3), the vertices of each face, and the numbers of elements that are left out."""
    dimension, place = 3, 2
    vertices, faces, others = np.zeros((0, 3)), [], {}
    while place < len(words) and words[place] != "End":
        word, count = words[place], int(words[place + 1])
        columns = dimension + 1 if word == "Vertices" else CORNERS.get(word, -1) + 1
        end = place + 2 + columns * count
        if word == "Dimension" and count not in (2, 3):
            raise ValueError(f"it has {count} dimensions")
        if count < 0 or end > len(words):
            raise ValueError(f"{word[:20]} states {count} elements")
        if word == "Dimension":
            dimension = count
        elif word == "Vertices":
            numbers = np.array([float(text) for text in words[place + 2 : end]]).reshape(count, columns)
            vertices = np.pad(numbers[:, :dimension], ((0, 0), (0, 3 - dimension)))
        elif word in CORNERS:
            corners = np.array([int(text) for text in words[place + 2 : end]], dtype=np.int64).reshape(count, columns)
            faces += (corners[:, :-1] - 1).tolist()
        else:
            others[word] = count
            end = next((n for n in range(end, len(words)) if words[n][0].isalpha()), len(words))
        place = end
    return vertices, faces, others
