# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small closed bodies for the tests of contact."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, Mesh

QUADS = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
"""Faces of a box, outwards."""


def box(half: tuple[float, float, float], centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """A box with sides of twice ``half``."""
    ring = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners = np.concatenate([np.column_stack([ring, np.full(4, z)]) for z in (-1, 1)])
    return Mesh.from_polygons(corners * np.array(half) + np.array(centre), QUADS)


def ball(radius: float, divisions: int = 3, centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """A ball of triangles, from an octahedron whose faces are divided into four a number of times."""
    corners = [np.array(c, dtype=float) for c in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))]
    faces = [[x, y, z] if (x + y + z) % 2 == 0 else [x, z, y] for x in (0, 1) for y in (2, 3) for z in (4, 5)]
    for _ in range(divisions):
        faces = [part for face in faces for part in _divided(corners, face)]
        corners, faces = _merged(corners, faces)
    directions = np.array([c / np.linalg.norm(c) for c in corners])
    return Mesh.from_polygons(radius * directions + np.array(centre), faces)


def _divided(corners: list[FloatArray], face: list[int]) -> list[list[int]]:
    first = len(corners)
    corners += [corners[face[k]] + corners[face[(k + 1) % 3]] for k in range(3)]
    a, b, c = face
    return [[a, first, first + 2], [b, first + 1, first], [c, first + 2, first + 1], [first, first + 1, first + 2]]


def _merged(corners: list[FloatArray], faces: list[list[int]]) -> tuple[list[FloatArray], list[list[int]]]:
    directions = np.array([c / np.linalg.norm(c) for c in corners])
    distinct, number = np.unique(directions.round(9), axis=0, return_inverse=True)
    return list(distinct), number.ravel()[np.array(faces)].tolist()
