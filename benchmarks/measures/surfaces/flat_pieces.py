# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Flat pieces with re-entrant corners, in four widths of stitches each: whether they knit, and whether the loops hold.

Letters, steps, and outlines like those of sewing patterns and of simulators of cloth: the front and the back of a vest
and the front of a T-shirt, a sleeve, half of trousers, and a dress.
"""

from __future__ import annotations

import logging
from itertools import pairwise

import numpy as np
from matplotlib.path import Path as Outline

import stitchmesh as sm
from benchmarks.surface_shapes.flat_sheets import sheet
from benchmarks.surface_shapes.level_surface import triangle_mesh
from benchmarks.table import Rows
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.run import QUIET

Point = tuple[float, float]
EDGE = 1.5
"""Length of an edge of a triangle [cm]."""
CURVE_POINTS = 14
"""Points along a curve."""
STRAIGHT_WIDTHS, CURVED_WIDTHS = (0.8, 1.2, 1.6, 2.4), (1.0, 1.4, 2.0, 2.8)
"""Widths of the stitches of letters and of garments [cm]."""


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


def state(mesh: Mesh, width: float) -> str:
    """Knit a piece; return ``held`` and the number of stitches, or what refuses it."""
    try:
        shaped = sm.shape_fabric(mesh, stitch_width=width, progress=False)
        fabric = sm.relax_mesh(shaped.fabric, surface=shaped.surface_mesh, run=QUIET).fabric
        fabric = sm.make_room(fabric, quality="draft")
        sm.check_loops(fabric, sm.generate_yarns(fabric, quality="draft"))
    except StitchMeshError as error:
        return str(error)
    return f"held, {fabric.face_count} stitches"


def flat_pieces(names: tuple[str, ...] = (), /) -> Rows:
    """Yield a row for each piece and width, and the number of those that hold.

    Args:
        names: pieces; all if none
    """
    logging.disable(logging.WARNING)
    states = []
    yield "piece", "stitches of cm", "state"
    for outlines, widths in ((LETTERS, STRAIGHT_WIDTHS), (GARMENTS, CURVED_WIDTHS)):
        for name in [name for name in outlines if name in (names or outlines)]:
            mesh = piece(outlines[name])
            for width in widths:
                states.append(state(mesh, width))
                yield name, f"{width:.1f}", states[-1]
    yield f"{sum(one.startswith('held') for one in states)} of {len(states)} held"
