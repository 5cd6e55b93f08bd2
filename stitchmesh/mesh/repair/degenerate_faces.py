# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces that a repair removes or corrects: without area, with a corner twice, or with the vertices of another face.

A removed sliver can leave a T-junction: its middle corner then lies on a side of the neighbour, which is on the border.
This T-junction is joined like any other. A face may visit a vertex twice. The repair leaves out a corner that occurs
twice in succession, and a side that is passed forth and back. A polygon that touches itself in a vertex is separated
into its loops. A polygon that reaches its inner loop along a bridge, as programs write a face with a hole, is divided
into triangles.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from stitchmesh.mesh.polygon_mesh import IntArray
from stitchmesh.mesh.repair.action import ActionLog
from stitchmesh.mesh.repair.soup import NO_AREA, Soup


def remove_faces_without_area(soup: Soup, log: ActionLog) -> Soup:
    """Remove faces without area; polygons whose parts cancel are divided into triangles.

    Args:
        soup: faces that visit each of their vertices once.
        log: takes the actions.
    """
    empty = np.flatnonzero(soup.without_area)
    if not len(empty):
        return soup
    polygons = {face: _parts(soup, soup.corners_of(face)) for face in empty.tolist()}
    log.add("faces without area", [int(soup.origin[face]) for face, parts in polygons.items() if not parts])
    log.add("folded faces", [int(soup.origin[face]) for face, parts in polygons.items() if parts])
    return soup.replaced(polygons)


def _parts(soup: Soup, corners: list[int]) -> list[list[int]]:
    """Triangles around the lowest vertex for which all triangles have an area; none if there is no such vertex."""
    by_vertex = sorted(range(len(corners)), key=lambda place: int(soup.vertex[corners[place]]))
    for turn in by_vertex if len(corners) > 3 else []:
        first, *others = corners[turn:] + corners[:turn]
        triangles = [[first, *pair] for pair in pairwise(others)]
        if all(_has_area(soup, triangle) for triangle in triangles):
            return triangles
    return []


def _has_area(soup: Soup, triangle: list[int]) -> bool:
    a, b, c = soup.points[soup.vertex[triangle]]
    longest = max(np.sum((b - a) ** 2), np.sum((c - b) ** 2), np.sum((a - c) ** 2))
    return bool(0.5 * np.linalg.norm(np.cross(b - a, c - a)) > NO_AREA * longest)


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


def remove_duplicates(soup: Soup, log: ActionLog) -> Soup:
    """Keep the first of the faces that have the same vertices, in whatever order and direction.

    Args:
        soup: faces that visit each of their vertices once.
        log: takes the action.
    """
    sorted_vertex = soup.vertex[np.lexsort((soup.vertex, soup.side_face))]
    again = np.zeros(soup.face_count, dtype=bool)
    for size in np.unique(soup.size):
        faces = np.flatnonzero(soup.size == size)
        again[faces[_repeated_rows(sorted_vertex[soup.start[faces][:, None] + np.arange(size)])]] = True
    if not again.any():
        return soup
    log.add("duplicate faces", soup.origin[again].tolist())
    return soup.kept(np.flatnonzero(~again))


def _repeated_rows(rows: IntArray) -> IntArray:
    """Numbers of the rows that occur earlier too."""
    order = np.lexsort(rows.T[::-1])  # Equal rows keep their order.
    same = (np.diff(rows[order], axis=0) == 0).all(axis=1)
    return order[1:][same]
