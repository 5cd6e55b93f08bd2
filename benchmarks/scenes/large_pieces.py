# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat pieces and tubes of any number of faces: quads that are not labeled yet, and pieces of a pattern."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.patterns import Pattern, apply_pattern
from stitchmesh.patterns.swatch_mesh import plain_piece


def quads(columns: int, rows: int, *, around: bool, width: float = 1.0, height: float = 1.0) -> Mesh:
    """A flat piece of quads in the plane z = 0, or a tube around the y axis; a quad is of some size [cm]."""
    count = columns if around else columns + 1
    if around:
        angle = 2.0 * np.pi * np.arange(count) / count
        flat = columns * width / (2.0 * np.pi) * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    else:
        flat = np.stack([width * np.arange(count), np.zeros(count)], axis=1)
    x, z = np.tile(flat, (rows + 1, 1)).T
    level = height * np.repeat(np.arange(rows + 1.0), count)
    row, column = (grid.ravel() for grid in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    after = (column + 1) % count
    corners = np.stack([column, after, after + count, column + count], axis=1) + (row * count)[:, None]
    return Mesh.from_polygons(np.stack([x, level, z], axis=1), corners.tolist())


def meshes_of_quads(faces: int) -> dict[str, Mesh]:
    """Meshes of about a number of faces: a tube as high as wide, one with eight times the faces in a row, and a piece.

    Args:
        faces: the number.
    """
    side = round(faces**0.5)
    return {
        "tube": quads(side, faces // side, around=True),
        "wide tube": quads(8 * side, faces // (8 * side), around=True),
        "flat piece": quads(side, faces // side, around=False),
    }


def pattern_piece(pattern: Pattern, faces: int, *, closed: bool) -> StitchMesh:
    """Return a piece of a pattern with about ``faces`` faces, flat or as a tube."""
    columns = pattern.width * max(round(faces**0.5 / pattern.width), 1)
    rows = 1 + pattern.height * max(round(faces / columns / pattern.height), 1)
    plain = plain_piece(columns, rows, 1.0, 1.0)
    return apply_pattern(_rolled_up(plain, columns, rows) if closed else plain, pattern, remainder="refuse")


def _rolled_up(plain: StitchMesh, columns: int, rows: int) -> StitchMesh:
    """Return a flat piece as a tube: the last column joins the first."""
    angle = 2 * np.pi * np.arange(columns) / columns
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * columns / (2 * np.pi)
    points = np.concatenate([np.tile(ring, (rows + 1, 1)), np.repeat(np.arange(rows + 1.0), columns)[:, None]], axis=1)
    level, place = np.divmod(plain.face_vertex, columns + 1)
    corners = level * columns + place % columns
    twin = find_twins(plain.face_start, corners, len(points))
    return replace(plain, vertices=points, face_vertex=corners, twin=twin)
