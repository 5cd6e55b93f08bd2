# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat pieces with re-entrant corners: letters, steps, and outlines like those of sewing patterns of garments."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.path import Path as Outline

from benchmarks.scenes.surface_shapes.flat_sheets import sheet
from benchmarks.scenes.surface_shapes.level_surface import triangle_mesh
from stitchmesh.mesh import FloatArray, Mesh

Point = tuple[float, float]
EDGE = 1.5
"""Length of an edge of a triangle [cm]."""
CURVE_POINTS = 14
"""Points along a curve."""


def curve(start: Point, control: Point, end: Point) -> list[Point]:
    """Points of a quadratic curve."""
    t = np.linspace(0.0, 1.0, CURVE_POINTS)[:, None]
    points = (1.0 - t) ** 2 * np.array(start) + 2.0 * t * (1.0 - t) * np.array(control) + t**2 * np.array(end)
    return [(float(x), float(y)) for x, y in points]


LETTERS: dict[str, list[Point]] = {
    "L": [(0, 0), (30, 0), (30, 14), (12, 14), (12, 36), (0, 36)],
    "T": [(0, 0), (12, 0), (12, 20), (26, 20), (26, 32), (-14, 32), (-14, 20), (0, 20)],
    "U": [(0, 0), (32, 0), (32, 30), (21, 30), (21, 12), (11, 12), (11, 30), (0, 30)],
    "plus": [
        (10, 0), (22, 0), (22, 10), (32, 10), (32, 22), (22, 22), (22, 32), (10, 32), (10, 22), (0, 22),
        (0, 10), (10, 10),
    ],
    "steps": [(0, 0), (30, 0), (30, 10), (20, 10), (20, 20), (10, 20), (10, 30), (0, 30)],
}  # fmt: skip
"""Pieces whose sides are straight."""
BODY: list[Point] = [(0, 0), (46, 0), *curve((46, 30), (40, 31), (39, 40)), (38, 54), (30, 56)]
ARMHOLE: list[Point] = [(16, 56), (8, 54), *curve((7, 40), (6, 31), (0, 30))]
GARMENTS: dict[str, list[Point]] = {
    "vest front": [*BODY, (23, 36), *ARMHOLE],
    "vest back": [*BODY, *curve((30, 56), (23, 51), (16, 56))[1:-1], *ARMHOLE],
    "T-shirt front": [
        (0, 0), (48, 0), *curve((49, 38), (42, 44), (44, 58)), *curve((31, 62), (24, 46), (17, 62)),
        *curve((4, 58), (6, 44), (-1, 38)),
    ],
    "sleeve": [
        (6, 0), (30, 0), *curve((38, 30), (32, 32), (28, 38)), *curve((28, 38), (24, 44), (18, 44))[1:],
        *curve((18, 44), (12, 44), (8, 38))[1:], *curve((8, 38), (4, 32), (-2, 30))[1:],
    ],
    "trousers": [(4, 0), (24, 0), *curve((28, 50), (23, 52), (22, 60)), (21, 76), (0, 78), (0, 50)],
    "dress": [
        *curve((-30, 0), (0, -6), (30, 0)), (14, 50), *curve((20, 66), (14, 70), (15, 80)),
        *curve((9, 84), (0, 66), (-9, 84)), *curve((-15, 80), (-14, 70), (-20, 66)), (-14, 50),
    ],
}  # fmt: skip


def piece(outline: list[Point]) -> Mesh:
    """Triangles of a piece in the plane z = 0."""
    corners = np.array([*outline, outline[0]], dtype=np.float64)
    border = np.concatenate([divided(start, end) for start, end in pairwise(corners)])
    points, triangles = sheet(border, Outline(corners, closed=True).contains_points, EDGE)
    used, numbered = np.unique(triangles, return_inverse=True)
    return triangle_mesh(np.column_stack([points[used], np.zeros(len(used))]), numbered.reshape(-1, 3))


def divided(start: FloatArray, end: FloatArray) -> FloatArray:
    """Points along a side without its end, at most an edge apart, shape (n, 2)."""
    count = int(np.ceil(np.linalg.norm(end - start) / EDGE))
    return start + (end - start) * np.arange(count)[:, None] / count
