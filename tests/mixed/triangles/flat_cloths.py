# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat cloths of one panel: grids of several kinds, a disc, and single triangles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import Delaunay

from stitchmesh.mixed.cloth.cloth import Cloth

FloatArray = NDArray[np.float64]
KINDS = ("diagonals", "alternating", "equilateral", "irregular")


def flat_cloth(points: ArrayLike, triangles: ArrayLike, angle: float = 0.0) -> Cloth:
    """The cloth of plane points; ``angle`` turns the axes of its panel against those of the points."""
    plane = np.asarray(points, dtype=np.float64)
    corners = np.asarray(triangles, dtype=np.int64)
    c, s = np.cos(angle), np.sin(angle)
    turned = plane @ np.array([[c, -s], [s, c]])
    return Cloth(
        vertices=np.column_stack([plane, np.zeros(len(plane))]),
        triangles=corners,
        rest=turned[corners],
        panel=np.zeros(len(corners), dtype=int),
        panel_names=("panel",),
    )


def with_seam(cloth: Cloth, edges: ArrayLike, angle: float = 0.0) -> Cloth:
    """The cloth with one seam along successive edges inside it, which has that rest angle."""
    seam = np.asarray(edges)
    return replace(cloth, seam_edges=seam, seam_start=np.array([0, len(seam)]), seam_angle=np.array([angle]))


def rectangle(kind: str, columns: int, rows: int, width: float = 1.0, height: float = 1.0) -> Cloth:
    """A rectangle of about ``columns`` times ``rows`` cells, each of two triangles."""
    if kind == "irregular":
        return flat_cloth(*_irregular(columns, rows, width, height))
    points, triangles = _cells(columns, rows, kind == "alternating")
    if kind == "equilateral":  # a parallelogram, whose cells are pairs of equilateral triangles when width = height
        points = points @ np.array([[1.0, 0.0], [0.5, np.sqrt(0.75)]])
    return flat_cloth(points * [width / columns, height / rows], triangles)


def _cells(columns: int, rows: int, alternating: bool) -> tuple[FloatArray, NDArray[np.int64]]:
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    corner = np.arange((columns + 1) * (rows + 1)).reshape(rows + 1, columns + 1)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))
    triangles = np.stack([a, b, d, b, c, d], axis=1)
    if alternating:
        odd = (np.add.outer(np.arange(rows), np.arange(columns)) % 2 == 1).ravel()
        triangles[odd] = np.stack([a, b, c, a, c, d], axis=1)[odd]
    return np.column_stack([x.ravel(), y.ravel()]), triangles.reshape(-1, 3)


def _irregular(columns: int, rows: int, width: float, height: float) -> tuple[FloatArray, NDArray[np.int64]]:
    points, _triangles = _cells(columns, rows, False)
    inner = (points > 0.0).all(axis=1) & (points < [columns, rows]).all(axis=1)
    points[inner] += np.random.default_rng(3).uniform(-0.3, 0.3, size=(int(inner.sum()), 2))
    return points * [width / columns, height / rows], anticlockwise(points, Delaunay(points).simplices)


def anticlockwise(points: FloatArray, triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles with area, turned to be anticlockwise."""
    one, other = points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]]
    doubled = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    turned = np.where((doubled < 0.0)[:, None], triangles[:, ::-1], triangles)
    return turned[np.abs(doubled) > 1e-9 * np.abs(doubled).max()]


def disc(rings: int, radius: float) -> Cloth:
    """A disc of rings of equally spaced points, six more on each ring."""
    parts = [np.zeros((1, 2))]
    for ring in range(1, rings + 1):
        angle = 2.0 * np.pi * np.arange(6 * ring) / (6 * ring)
        parts.append(radius * ring / rings * np.column_stack([np.cos(angle), np.sin(angle)]))
    points = np.concatenate(parts)
    return flat_cloth(points, anticlockwise(points, Delaunay(points).simplices))
