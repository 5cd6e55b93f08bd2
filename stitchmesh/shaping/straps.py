# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Straps and bibs: borders at which part of a row is bound off while the rest of it goes on.

The upper border of a camisole is bound off in front and behind, its straps are knitted on from there, and the last rows
of the two halves of a strap are grafted to each other where the strap is highest.
"""

from __future__ import annotations

from itertools import groupby

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.selection.borders import CLOSED_LENGTH
from stitchmesh.shaping.borders import (
    facing_of,
    highest_border,
    is_hole_in_side,
    is_whole_border,
    length_of,
    outline_sides,
    upwards,
)
from stitchmesh.shaping.triangle_surface import TriangleSurface

LEVEL_PART = 0.15
"""Range of heights, over the length, below which a part of a border is level."""


def bound_off(
    surface: TriangleSurface, border: IntArray, rows: list[IntArray], tops: list[int], up: FloatArray
) -> list[IntArray]:
    """Return the rows of a border that end part of a row, while the rest goes on, as at the neck between straps.

    These are the lower ones of the rows of one border that face upwards, such as the back of a bib, and all of them
    where the border rises between them, as along straps. Of a hole in the side, such as an armhole, they are the parts
    below it.

    Args:
        surface: the surface.
        border: a border.
        rows: its rows.
        tops: the highest vertices of its straps.
        up: unit vector, shape (3,).
    """
    if is_hole_in_side(surface, border, up):
        pieces = outline_sides(surface, border)
        facing = facing_of(surface, pieces, up)
        return [piece for piece, side in zip(pieces, facing, strict=True) if side > 0.0]
    upper = _upper_rows(surface, rows, up)
    if len(upper) < 2:
        return []
    if tops:
        return upper
    highest = upper[highest_border(surface, upper, up)]
    return [row for row in upper if row is not highest]


def _upper_rows(surface: TriangleSurface, rows: list[IntArray], up: FloatArray) -> list[IntArray]:
    """The parts of borders among some rows that face upwards."""
    return [row for row in rows if not is_whole_border(surface, row) and upwards(surface, row, up) > 0.0]


def tops_of_straps(surface: TriangleSurface, border: IntArray, rows: list[IntArray], up: FloatArray) -> list[int]:
    """Return the highest vertices of a border between its upper rows, if it rises above all of them as along straps."""
    rows = _upper_rows(surface, rows, up)
    if len(rows) < 2:
        return []
    height = surface.vertices @ up
    used = set(np.concatenate(rows).tolist())
    ring = np.roll(border, -int(np.flatnonzero(border == rows[0][0])[0]))
    between = [(own, list(run)) for own, run in groupby(ring.tolist(), key=used.__contains__)]
    tops = [max(run, key=height.__getitem__) for own, run in between if not own]
    level = max(float(height[row].max()) for row in rows)
    return [top for top in tops if height[top] > level + CLOSED_LENGTH]


def across_strap(surface: TriangleSurface, top: int) -> IntArray:
    """Return the shortest path over edges from a vertex of a border to another border, or the vertex without one."""
    from scipy.sparse.csgraph import dijkstra

    others = [border for border in surface.borders if top not in border]
    if not others:
        return np.array([top])
    distance, before = dijkstra(surface.edge_graph, directed=False, indices=top, return_predecessors=True)
    facing = np.concatenate(others)
    path = [int(facing[distance[facing].argmin()])]
    while path[-1] != top:
        path.append(int(before[path[-1]]))
    return np.array(path)


def is_level(surface: TriangleSurface, row: IntArray, up: FloatArray) -> bool:
    """Return whether a part of a border is nearly level, so that a row can run along all of it."""
    return float(np.ptp(surface.vertices[row] @ up)) < LEVEL_PART * length_of(surface, row, closed=False)
