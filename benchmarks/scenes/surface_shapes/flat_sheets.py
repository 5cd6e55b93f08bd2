# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat sheets of irregular triangles, a box of six of them, and a Moebius strip.

Sheets stand upright in the plane z = 0 and face +z.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from stitchmesh.mesh import FloatArray, IntArray, Mesh

from .even_triangles import BoolArray
from .level_surface import triangle_mesh

SWEEPS = 8
"""Sweeps in which the points inside a sheet are spread."""
LEAST_GAP = 0.6
"""Least distance of a point inside from the border, in parts of an edge."""
SEED = 7
"""Seed of the points inside."""
Inside = Callable[[FloatArray], BoolArray]


def flat_square(edge: float = 1.0) -> Mesh:
    """A square of 20 cm."""
    return triangle_mesh(*_upright(*rectangle(20.0, 20.0, edge)))


def flat_disc(edge: float = 1.0) -> Mesh:
    """A disc of radius 10."""
    return triangle_mesh(*_upright(*sheet(circle(10.0, edge), lambda p: np.hypot(*p.T) < 10.0, edge)))


def annulus_disc(edge: float = 1.0) -> Mesh:
    """A disc of radius 20 with a hole of radius 6 in its middle."""
    border = np.concatenate([circle(20.0, edge), circle(6.0, edge)])
    return triangle_mesh(*_upright(*sheet(border, lambda p: np.abs(np.hypot(*p.T) - 13.0) < 7.0, edge)))


def _upright(points: FloatArray, corners: IntArray) -> tuple[FloatArray, IntArray]:
    return np.column_stack([points, np.zeros(len(points))]), corners


def circle(radius: float, edge: float) -> FloatArray:
    """Points of a circle, shape (n, 2)."""
    count = round(2.0 * np.pi * radius / edge)
    angle = 2.0 * np.pi * np.arange(count) / count
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def rectangle(width: float, height: float, edge: float) -> tuple[FloatArray, IntArray]:
    """Points, shape (n, 2), and triangles of a rectangle around (0, 0)."""
    x, y = (np.linspace(-0.5, 0.5, round(size / edge) + 1) * size for size in (width, height))
    level = [np.column_stack([x, np.full(len(x), end)]) for end in (y[0], y[-1])]
    upright = [np.column_stack([np.full(len(y) - 2, end), y[1:-1]]) for end in (x[0], x[-1])]
    corner = np.array([x[-1], y[-1]])
    return sheet(np.concatenate([*level, *upright]), lambda p: (np.abs(p) < corner).all(axis=1), edge)


def sheet(border: FloatArray, inside: Inside, edge: float) -> tuple[FloatArray, IntArray]:
    """Triangulate what is inside a border by random points that are spread, and Delaunay's triangles of them."""
    low, high = border.min(axis=0), border.max(axis=0)
    lattice = np.stack(np.meshgrid(*(np.arange(a, b, 0.93 * edge) for a, b in zip(low, high, strict=True))), axis=-1)
    inner = lattice.reshape(-1, 2)
    inner = inner + np.random.default_rng(SEED).uniform(-0.5, 0.5, inner.shape) * edge
    inner = inner[inside(inner) & (cKDTree(border).query(inner)[0] > LEAST_GAP * edge)]
    points = np.concatenate([border, inner])
    for _ in range(SWEEPS):
        corners = _delaunay(points, inside)
        sides = corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        number = np.bincount(sides[:, 0], minlength=len(points))
        mean = np.column_stack([np.bincount(sides[:, 0], points[sides[:, 1], k], len(points)) for k in range(2)])
        points[len(border) :] = (mean / np.maximum(number, 1)[:, None])[len(border) :]
    return points, _delaunay(points, inside)


def _delaunay(points: FloatArray, inside: Inside) -> IntArray:
    """Triangles whose middles are inside, anticlockwise."""
    corners = Delaunay(points).simplices.astype(np.int64)
    corners = corners[inside(points[corners].mean(axis=1))]
    (x1, y1), (x2, y2) = (points[corners[:, k]].T - points[corners[:, 0]].T for k in (1, 2))
    area = x1 * y2 - x2 * y1
    corners[area < 0.0] = corners[area < 0.0, ::-1]
    return corners[np.abs(area) > 1e-9]


def box(edge: float = 1.0, size: tuple[float, float, float] = (20.0, 30.0, 10.0)) -> Mesh:
    """A closed box with sharp edges."""
    points, corners = [], []
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        flat, faces = rectangle(size[one], size[other], edge)
        for side in (0, 1):
            places = np.zeros((len(flat), 3))
            places[:, [one, other]], places[:, axis] = flat, (side - 0.5) * size[axis]
            corners.append((faces if side else faces[:, ::-1]) + sum(map(len, points)))
            points.append(places)
    return triangle_mesh(*_welded(np.concatenate(points), np.concatenate(corners)))


def _welded(points: FloatArray, corners: IntArray) -> tuple[FloatArray, IntArray]:
    """Join points at one place."""
    _, first, number = np.unique(np.round(points, 6), axis=0, return_index=True, return_inverse=True)
    return points[first], number.ravel()[corners]


def moebius_polygons(edge: float = 1.0, radius: float = 12.0, width: float = 6.0) -> tuple[FloatArray, IntArray]:
    """Vertices, shape (n, 3), and triangles, shape (m, 3), of a Moebius strip; no mesh takes this one-sided surface."""
    across, count = round(width / edge), round(2.0 * np.pi * radius / edge)
    turn, place = np.meshgrid(2.0 * np.pi * np.arange(count) / count, np.linspace(-0.5, 0.5, across + 1) * width)
    out = radius + place * np.cos(turn / 2.0)
    vertices = np.stack([out * np.cos(turn), place * np.sin(turn / 2.0), out * np.sin(turn)], axis=-1)
    number = np.arange(vertices[..., 0].size).reshape(across + 1, count)
    number = np.concatenate([number, number[::-1, :1]], axis=1)  # After one turn the strip is upside down.
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]))
    odd = np.arange(len(a)) % 2 == 1
    first = np.where(odd[:, None], np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(odd[:, None], np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    return vertices.reshape(-1, 3), np.concatenate([first, second])


SHEETS = (box, flat_square, flat_disc, annulus_disc)
