# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Fabrics made without other stages of the pipeline, for the tests of mesh relaxation."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.stitch import Stitch


def grid_fabric(points: FloatArray, *, wrap: bool = False) -> StitchMesh:
    """Knit stitches between grid points of shape (rows + 1, columns + 1, 3), or (rows + 1, columns, 3) if wrapped."""
    rows, around = points.shape[0] - 1, points.shape[1]
    columns = around if wrap else around - 1
    row, column = (index.ravel() for index in np.indices((rows, columns)))
    following = (column + 1) % around
    lower, upper = row * around, (row + 1) * around
    corners = np.stack([lower + column, lower + following, upper + following, upper + column], axis=1).ravel()
    ones = np.ones(len(row), dtype=np.int64)
    face_start = 4 * np.arange(len(row) + 1)
    return StitchMesh(
        vertices=points.reshape(-1, 3),
        face_start=face_start,
        face_vertex=corners,
        twin=find_twins(face_start, corners, points.shape[0] * around),
        n_bottom=ones,
        n_top=ones,
        stitch=int(Stitch.KNIT) * ones,
        row=row,
    )


def rectangle_points(columns: int, rows: int, width: float, height: float) -> FloatArray:
    """Uniform grid points of a flat rectangle, shape (rows + 1, columns + 1, 3)."""
    x, y = np.meshgrid(np.linspace(0.0, width, columns + 1), np.linspace(0.0, height, rows + 1))
    return np.stack([x, y, np.zeros_like(x)], axis=2)


def tube_points(around: int, rows: int, radius: float, height: float) -> FloatArray:
    """Uniform grid points of an upright tube with outward faces, shape (rows + 1, around, 3)."""
    angle = 2.0 * np.pi * np.arange(around) / around
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * angle], axis=1)
    levels = np.linspace(0.0, height, rows + 1)[:, None, None] * np.array([0.0, 0.0, 1.0])
    return ring[None] + levels


def tube_chord_points(coarse_around: int, parts: int, levels: FloatArray, radius: float) -> FloatArray:
    """Grid points of a tube on the flat faces of its coarse mesh, with ``parts`` points per coarse edge."""
    ring = tube_points(coarse_around, 1, radius, 1.0)[0]
    share = (np.arange(parts) / parts)[None, :, None]
    chords = (1.0 - share) * ring[:, None] + share * np.roll(ring, -1, axis=0)[:, None]
    return chords.reshape(1, -1, 3) + levels[:, None, None] * np.array([0.0, 0.0, 1.0])


def increase_fabric() -> StitchMesh:
    """A row of one 1-to-3 increase, below a row of three knit stitches."""
    vertices = [[1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0], [3, 1, 0], *([x, 2, 0] for x in range(4))]
    corners = np.array([0, 1, 5, 4, 3, 2, 2, 3, 7, 6, 3, 4, 8, 7, 4, 5, 9, 8])
    face_start = np.array([0, 6, 10, 14, 18])
    return StitchMesh(
        vertices=np.array(vertices, dtype=float),
        face_start=face_start,
        face_vertex=corners,
        twin=find_twins(face_start, corners, 10),
        n_bottom=np.ones(4, dtype=int),
        n_top=np.array([3, 1, 1, 1]),
        stitch=np.array([Stitch.KYK, Stitch.KNIT, Stitch.KNIT, Stitch.KNIT]),
        row=np.array([0, 1, 1, 1]),
    )


def cube() -> Mesh:
    """The cube with coordinates from -1 to 1."""
    vertices = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return Mesh.from_polygons(vertices, faces)


def rotation(seed: int) -> FloatArray:
    """A random rotation matrix, shape (3, 3)."""
    matrix = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return matrix * np.sign(np.linalg.det(matrix))
