# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces that visit a vertex twice.

A corner that occurs twice in succession, and a side that is passed forth and back, are left out. A polygon that touches
itself in a vertex is separated into its loops. A polygon that reaches its inner loop along a bridge, as programs write
a face with a hole, is divided into triangles.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh.polygon_mesh import IntArray
from stitchmesh.mesh.repair.action import ActionLog
from stitchmesh.mesh.repair.soup import Soup


def correct_repeated_corners(soup: Soup, log: ActionLog) -> Soup:
    """Return faces that visit each of their vertices once; a face with fewer than three vertices is left out.

    Args:
        soup: the faces.
        log: takes the actions.
    """
    polygons = {int(face): _simple_polygons(soup, soup.corners_of(face)) for face in _faces_at_fault(soup)}
    log.add("faces without area", [int(soup.origin[face]) for face, parts in polygons.items() if not parts])
    log.add("repeated corners", [int(soup.origin[face]) for face, parts in polygons.items() if parts])
    return soup.replaced(polygons)


def _faces_at_fault(soup: Soup) -> IntArray:
    """Faces with fewer than three corners, or with a vertex that occurs twice, ascending."""
    order = np.lexsort((soup.vertex, soup.side_face))
    twice = (np.diff(soup.vertex[order]) == 0) & (np.diff(soup.side_face[order]) == 0)
    return np.union1d(soup.side_face[order[:-1]][twice], np.flatnonzero(soup.size < 3))


def _simple_polygons(soup: Soup, corners: list[int]) -> list[list[int]]:
    """Polygons that cover a face and visit each of their vertices once, as numbers of corners."""
    corners = _without_spikes(soup, corners)
    vertices = [int(soup.vertex[corner]) for corner in corners]
    if len(corners) < 3 or len(set(vertices)) == len(vertices):
        return [corners] if len(corners) >= 3 else []
    sides = set(zip(vertices, vertices[1:] + vertices[:1], strict=True))
    if any((end, start) in sides for start, end in sides):
        ears = soup.ears_of(corners)
        if ears.whole[0]:
            return ears.triangles.tolist()
    again = next(place for place, vertex in enumerate(vertices) if vertex in vertices[:place])
    first = vertices.index(vertices[again])
    rest = corners[:first] + corners[again:]
    return _simple_polygons(soup, corners[first:again]) + _simple_polygons(soup, rest)


def _without_spikes(soup: Soup, corners: list[int]) -> list[int]:
    """Leave out corners that repeat the corner before them, and sides that are passed forth and back at once."""
    kept = list(corners)
    place = 0
    while place < len(kept) and len(kept) >= 3:
        before, here, after = (int(soup.vertex[kept[(place + step) % len(kept)]]) for step in (-1, 0, 1))
        if here == after:
            kept.pop(place + 1 if place + 1 < len(kept) else place)  # The first corner of a face stays the first one.
        elif before == after:
            kept = [corner for number, corner in enumerate(kept) if number not in (place, (place + 1) % len(kept))]
        else:
            place += 1
            continue
        place = 0
    return kept
