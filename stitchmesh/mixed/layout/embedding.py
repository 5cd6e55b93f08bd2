# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The triangle that holds each point of the panels, and the point's barycentric coordinates (Casafranca 2020, 3.1).

Each triangle of a panel is entered in the cells of a grid that its bounding box touches. The candidates of a point are
the triangles of its cell. They are tried one after the other, for all points at a time, until a candidate holds the
point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth

NO_TRIANGLE = -1
"""Triangle of a point outside its panel."""


@dataclass(frozen=True, eq=False)
class BarycentricPoints:
    """Triangles and barycentric coordinates of points."""

    triangle: IntArray
    """Triangle of each point, ``NO_TRIANGLE`` outside the panel, shape (n,)."""
    barycentric: FloatArray
    """Barycentric coordinates, not negative and with sum 1, shape (n, 3)."""


@dataclass(frozen=True, eq=False)
class _Grid:
    """The triangles of a panel, in the cells of a grid."""

    low: FloatArray
    cell_size: float
    shape: IntArray
    """Number of cells along x and y."""
    start: IntArray
    """Where each cell begins in ``entry``, and the number of entries at the end."""
    entry: IntArray
    """Triangles in the cells, cell by cell, as numbers within the panel from 0."""
    triangle: IntArray
    """Number in the cloth of each triangle of the panel."""
    affine: FloatArray
    """Barycentric coordinates of (x, y, 1) in each triangle of the panel, shape (n, 3, 3)."""


def embed_points(cloth: Cloth, panel: IntArray, position: FloatArray) -> BarycentricPoints:
    """Find the triangle of each point.

    Args:
        cloth: the cloth.
        panel: panel of each point, shape (n,).
        position: position in the panel [cm], shape (n, 2).
    """
    triangle = np.full(len(position), NO_TRIANGLE)
    barycentric = np.zeros((len(position), 3))
    order = np.argsort(panel, kind="stable")
    bounds = np.searchsorted(panel[order], np.arange(len(cloth.panel_names) + 1))
    for number in np.unique(panel).tolist():
        grid = _grid(cloth, number)
        points = order[bounds[number] : bounds[number + 1]]
        for part in np.split(points, range(1_000_000, len(points), 1_000_000)):  # parts bound the memory
            triangle[part], barycentric[part] = _locate(grid, position[part])
    return BarycentricPoints(triangle, barycentric)


def embed_among(cloth: Cloth, position: FloatArray, first: IntArray, end: IntArray) -> BarycentricPoints:
    """Find the triangle of each point among given ones; a point outside of all of them gets the nearest one.

    Args:
        cloth: the cloth.
        position: position in the panel [cm], shape (n, 2).
        first: first triangle that may hold each point, shape (n,).
        end: number after the last triangle that may hold each point, shape (n,).
    """
    numbers = np.arange(len(cloth.triangles))
    return BarycentricPoints(*_first_holding(_affine_maps(cloth.rest), numbers, first.copy(), end, position, -np.inf))


def _affine_maps(rest: FloatArray) -> FloatArray:
    corners = np.concatenate([rest, np.ones((len(rest), 3, 1))], axis=2)
    maps: FloatArray = np.linalg.inv(corners.transpose(0, 2, 1))
    return maps


def _grid(cloth: Cloth, panel: int) -> _Grid:
    own = np.flatnonzero(cloth.panel == panel)
    low, high = cloth.rest[own].min(axis=1), cloth.rest[own].max(axis=1)
    size = np.ptp(np.concatenate([low, high]), axis=0)
    # half a mean bounding box, but at most 16 cells for each triangle where few large triangles are among small ones
    cell_size = max(float((high - low).mean()) / 2.0, float(np.sqrt(size.prod() / (16 * len(own)))))
    origin = low.min(axis=0)
    shape = (size / cell_size).astype(np.int64) + 1
    first, last = (((bound - origin) / cell_size).astype(np.int64) for bound in (low, high))
    span = last - first + 1
    count = span.prod(axis=1)
    place = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    column, row = np.divmod(place, np.repeat(span[:, 1], count))
    cell = (np.repeat(first[:, 0], count) + column) * shape[1] + np.repeat(first[:, 1], count) + row
    order = np.argsort(cell, kind="stable")
    start = np.searchsorted(cell[order], np.arange(shape.prod() + 1))
    entered = np.repeat(np.arange(len(own)), count)[order]
    return _Grid(origin, cell_size, shape, start, entered, own, _affine_maps(cloth.rest[own]))


def _locate(grid: _Grid, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Triangle and barycentric coordinates of points of one panel."""
    column, row = np.clip(((points - grid.low) / grid.cell_size).astype(np.int64), 0, grid.shape - 1).T
    cell = column * grid.shape[1] + row
    own, barycentric = _first_holding(
        grid.affine, grid.entry, grid.start[cell], grid.start[cell + 1], points, -1e-9  # on a border up to rounding
    )
    return np.where(own < 0, NO_TRIANGLE, grid.triangle[own]), barycentric


def _first_holding(
    affine: FloatArray, listed: IntArray, candidate: IntArray, end: IntArray, points: FloatArray, outside: float
) -> tuple[IntArray, FloatArray]:
    """Triangle and barycentric coordinates of points, each of which has a range of candidates.

    Args:
        affine: barycentric coordinates of (x, y, 1), shape (T, 3, 3).
        listed: triangles in the order in which they are tried.
        candidate: first entry of ``listed`` for each point, shape (n,); it is changed.
        end: number after the last entry for each point, shape (n,).
        points: points in the plane, shape (n, 2).
        outside: if no candidate holds a point, the least coordinate with which a triangle is still taken.
    """
    triangle, barycentric = np.full(len(points), NO_TRIANGLE), np.zeros((len(points), 3))
    best = np.full(len(points), outside)
    open_points = np.flatnonzero(candidate < end)
    while len(open_points):
        tried = listed[candidate[open_points]]
        found = _barycentric(affine[tried], points[open_points])
        least = found.min(axis=1)
        better = least >= best[open_points]
        taken = open_points[better]
        triangle[taken], barycentric[taken], best[taken] = tried[better], found[better], least[better]
        candidate[open_points] += 1
        open_points = open_points[(least < 0.0) & (candidate[open_points] < end[open_points])]
    barycentric = np.maximum(barycentric, 0.0)
    return triangle, barycentric / np.where(triangle < 0, 1.0, barycentric.sum(axis=1))[:, None]


def _barycentric(affine: FloatArray, points: FloatArray) -> FloatArray:
    return affine[:, :, 0] * points[:, :1] + affine[:, :, 1] * points[:, 1:] + affine[:, :, 2]


def rest_positions(cloth: Cloth, triangle: IntArray, barycentric: FloatArray) -> FloatArray:
    """Return the positions of points in their panels [cm], shape (n, 2)."""
    positions: FloatArray = np.einsum("nk,nkd->nd", barycentric, cloth.rest[triangle])
    return positions


def world_positions(
    cloth: Cloth, triangle: IntArray, barycentric: FloatArray, vertices: FloatArray | None = None
) -> FloatArray:
    """Return the positions of points in space, the product B v of Casafranca et al. 2020 [cm], shape (n, 3).

    Args:
        cloth: the cloth.
        triangle: triangle of each point, shape (n,).
        barycentric: barycentric coordinates of each point, shape (n, 3).
        vertices: positions of the vertices [cm], shape (V, 3); by default the positions of the cloth.
    """
    corners = (cloth.vertices if vertices is None else np.asarray(vertices))[cloth.triangles]
    positions: FloatArray = np.einsum("nk,nkd->nd", barycentric, corners[triangle])
    return positions
