# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""T-junctions: border vertices that lie on a border edge of another face.

The edge is divided at the vertex if a part of the edge then coincides with an edge of another face. A triangle is
divided into triangles; a larger face takes the vertex as a further corner.
"""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np

from stitchmesh.mesh.polygon_mesh import FloatArray, IntArray
from stitchmesh.mesh.repair.action import ActionLog
from stitchmesh.mesh.repair.soup import Soup, numbers_in, open_sides

ROUNDING = 1e-11
"""A distance from an edge counts as rounding up to this multiple of the length of the edge."""

Insertions = dict[int, list[int]]
"""Vertices that divide a side, in their order along the side."""


def join_junctions(soup: Soup, distance: float, log: ActionLog) -> Soup:
    """Divide border edges at the border vertices that lie on them; the same soup if there are none.

    Args:
        soup: welded faces that visit each of their vertices once.
        distance: largest distance of a vertex from an edge [cm].
        log: takes the action.
    """
    sides = np.flatnonzero(open_sides(soup))
    inserted = _useful(soup, sides, _candidates(soup, sides, distance))
    if not inserted:
        return soup
    vertices, first = np.unique(soup.vertex, return_index=True)
    corner = {vertex: int(first[np.searchsorted(vertices, vertex)]) for row in inserted.values() for vertex in row}
    log.add("T-junctions", sorted({int(soup.source[place]) for place in corner.values()}))
    faces = sorted({int(soup.side_face[side]) for side in inserted})
    rows = {side: [corner[vertex] for vertex in row] for side, row in inserted.items()}
    return soup.replaced({face: _divided(soup, soup.corners_of(face), rows) for face in faces})


def _candidates(soup: Soup, sides: IntArray, distance: float) -> Insertions:
    """Vertices on each border side that are no corners of its face."""
    found: Insertions = {}
    taken: dict[int, set[int]] = {}
    for side, vertex in _vertices_on_sides(soup, sides, distance).tolist():
        face = int(soup.side_face[side])
        corners = taken.setdefault(face, set(soup.vertex[soup.corners_of(face)].tolist()))
        if vertex not in corners:
            corners.add(vertex)
            found.setdefault(side, []).append(vertex)
    return found


def _vertices_on_sides(soup: Soup, sides: IntArray, distance: float) -> IntArray:
    """Border sides and the border vertices that lie on them, in their order along the side, shape (n, 2)."""
    pairs = _near_pairs(soup, sides, distance)
    side, vertex = pairs.T
    start = soup.points[soup.vertex[side]]
    span, length = soup.points[soup.head[side]] - start, soup.side_length[side]
    offset = soup.points[vertex] - start
    along = np.einsum("ni,ni->n", offset, span) / length
    away = np.linalg.norm(offset - (along / length)[:, None] * span, axis=1)
    within = np.minimum(along, length - along)
    # A vertex that is farther from the edge than half of its distance from the end belongs to the end.
    on = (away <= np.maximum(distance, ROUNDING * length)) & (away <= 0.5 * within) & (within > 0.0)
    return pairs[on][np.lexsort((vertex[on], along[on], side[on]))]


def _near_pairs(soup: Soup, sides: IntArray, distance: float) -> IntArray:
    """Border sides and border vertices near them that are not their ends, shape (n, 2).

    Long sides are divided into pieces of the mean length, so that the balls around pieces hold few vertices.
    """
    from scipy.spatial import cKDTree

    sides = sides[soup.side_length[sides] > 0.0]
    if not len(sides):
        return np.zeros((0, 2), dtype=np.int64)
    vertices = numbers_in(np.concatenate([soup.vertex[sides], soup.head[sides]]), len(soup.points))
    length = soup.side_length[sides]
    count = np.ceil(length / length.mean()).astype(np.int64)
    piece = np.repeat(np.arange(len(sides)), count)
    place = np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count) + 0.5
    centre = _along(soup, sides[piece], place / count[piece])
    reach = 0.5 * length / count + np.maximum(distance, ROUNDING * length)
    near = cKDTree(soup.points[vertices]).query_ball_point(centre, reach[piece] * (1.0 + ROUNDING))
    found = np.fromiter(map(len, near), dtype=np.int64, count=len(near))
    vertex = vertices[np.concatenate([np.asarray(row, dtype=np.int64) for row in near])]
    side = sides[np.repeat(piece, found)]
    other = (vertex != soup.vertex[side]) & (vertex != soup.head[side])
    return np.unique(np.stack([side[other], vertex[other]], axis=1), axis=0)


def _along(soup: Soup, sides: IntArray, fraction: FloatArray) -> FloatArray:
    """Points at fractions of sides [cm], shape (n, 3)."""
    start, end = soup.points[soup.vertex[sides]], soup.points[soup.head[sides]]
    return start + fraction[:, None] * (end - start)


def _useful(soup: Soup, sides: IntArray, inserted: Insertions) -> Insertions:
    """Leave out vertices at which a side need not be divided, because neither part of it would have another face."""
    if not inserted:
        return {}
    whole = np.setdiff1d(sides, list(inserted))
    ends = zip(soup.vertex[whole].tolist(), soup.head[whole].tolist(), strict=True)
    borders = Counter(_edge(start, end) for start, end in ends)
    while True:
        chains = {side: [int(soup.vertex[side]), *row, int(soup.head[side])] for side, row in inserted.items()}
        faces = borders + Counter(_edge(*pair) for chain in chains.values() for pair in pairwise(chain))
        kept = {
            side: [
                vertex
                for before, vertex, after in zip(chain, chain[1:], chain[2:], strict=False)
                if faces[_edge(before, vertex)] > 1 or faces[_edge(vertex, after)] > 1
            ]
            for side, chain in chains.items()
        }
        if kept == inserted:
            return {side: row for side, row in kept.items() if row}
        inserted = kept


def _edge(start: int, end: int) -> tuple[int, int]:
    return min(start, end), max(start, end)


def _divided(soup: Soup, corners: list[int], rows: Insertions) -> list[list[int]]:
    """Polygons that cover a face whose sides are divided.

    Args:
        soup: the faces.
        corners: corners of the face, which are also its sides.
        rows: corners at the vertices that divide each side.
    """
    polygon = [corner for side in corners for corner in [side, *rows.get(side, [])]]
    return soup.ears_of(polygon).triangles.tolist() if len(corners) == 3 else [polygon]
