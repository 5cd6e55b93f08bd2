# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The line between points that were clicked, laid onto the surface so that it can be seen."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stitchmesh.app.project.shaping import Point
from stitchmesh.mesh import FloatArray
from stitchmesh.mesh.picking import PickingTable, pick

PIECES = 12
"""Number of pieces of the line between two points."""
LIFT = 0.004
"""Distance of the line from the surface, over the size of the mesh."""


def line_on_surface(table: PickingTable, points: Sequence[Point]) -> FloatArray:
    """Return the pieces of the line through some points, shape (n, 2, 3).

    Each piece of a straight line is moved along the mean normal of the surface at both ends until it meets the surface.

    Args:
        table: the surface, prepared for picking.
        points: the points, on the surface [cm].
    """
    pieces = [_between(table, np.array(start), np.array(end)) for start, end in pairwise(points)]
    return np.concatenate([np.zeros((0, 2, 3)), *pieces])


def _between(table: PickingTable, start: FloatArray, end: FloatArray) -> FloatArray:
    """The pieces between two points, shape (n, 2, 3)."""
    size = float(np.linalg.norm(np.ptp(table.mesh.vertices, axis=0)))
    normals = np.stack([_normal(table, start), _normal(table, end)])
    outward = normals.mean(axis=0)
    outward = outward / max(float(np.linalg.norm(outward)), 1e-9)
    path = []
    for share in np.linspace(0.0, 1.0, PIECES + 1):
        place = (1.0 - share) * start + share * end
        met = pick(table, place + size * outward, -outward) if outward.any() else None
        path.append((place if met is None else met.point) + LIFT * size * outward)
    return np.stack([path[:-1], path[1:]], axis=1)


def _normal(table: PickingTable, point: FloatArray) -> FloatArray:
    """The normal of the mesh at the vertex nearest to a point, shape (3,)."""
    nearest = int(np.linalg.norm(table.mesh.vertices - point, axis=1).argmin())
    normal: FloatArray = table.mesh.vertex_normal[nearest]
    return normal
