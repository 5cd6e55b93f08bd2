# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces without area.

If a sliver is removed whose middle corner lies on its long side, that corner lies on a side of the neighbour, which
is then on the border: a T-junction, which is joined as any other one.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

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
    """Triangles around the corner with the lowest vertex for which they all have an area, or none."""
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
