# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat rectangles of triangles: with diagonals in one direction, with alternating ones, or irregular."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth

Kind = Literal["diagonals", "alternating", "irregular"]


def rectangle(kind: Kind, columns: int, rows: int, edge: float) -> Cloth:
    """A flat cloth of cells of two triangles, whose sides have some length [cm]."""
    plane, corners = cells(columns, rows, alternating=kind == "alternating")
    if kind == "irregular":
        inner = ((plane > 0) & (plane < [columns, rows])).all(axis=1)
        corners = irregular(plane, inner, 0.3, seed=3)
    return Cloth(
        vertices=np.column_stack([plane * edge, np.zeros(len(plane))]),
        triangles=corners,
        rest=plane[corners] * edge,
        panel=np.zeros(len(corners), dtype=int),
        panel_names=("panel",),
    )


def cells(columns: int, rows: int, *, alternating: bool = False) -> tuple[FloatArray, IntArray]:
    """Points in the plane at whole numbers, shape (n, 2), and two triangles for each cell, shape (m, 3)."""
    x, y = (part.ravel() for part in np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0)))
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    a, b, c, d = first, first + 1, first + columns + 2, first + columns + 1
    corners = np.stack([a, b, d, b, c, d], axis=1)
    if alternating:
        odd = (np.add.outer(np.arange(rows), np.arange(columns)) % 2 == 1).ravel()
        corners[odd] = np.stack([a, b, c, a, c, d], axis=1)[odd]
    return np.column_stack([x, y]), corners.reshape(-1, 3)


def irregular(plane: FloatArray, inner: NDArray[np.bool_], most: float, *, seed: int) -> IntArray:
    """Move inner points of a plane at random, by ``most`` at most, and return Delaunay's triangles, anticlockwise."""
    plane[inner] += np.random.default_rng(seed).uniform(-most, most, size=(int(inner.sum()), 2))
    corners = Delaunay(plane).simplices
    one, other = plane[corners[:, 1]] - plane[corners[:, 0]], plane[corners[:, 2]] - plane[corners[:, 0]]
    doubled = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    turned: IntArray = np.where((doubled < 0.0)[:, None], corners[:, ::-1], corners)[np.abs(doubled) > 1e-6]
    return turned
