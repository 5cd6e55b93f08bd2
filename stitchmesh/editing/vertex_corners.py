# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The corners around each vertex of a stitch mesh, found by steps from face to face."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, BOTTOM, TOP, StitchMesh


class VertexCorners:
    """A table of one corner of each vertex, from which the other corners are found."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Find one corner of each vertex."""
        self._fabric = fabric
        self._corner = np.empty(len(fabric.vertices), dtype=np.int64)
        self._corner[fabric.face_vertex] = np.arange(fabric.side_count)

    def around(self, vertex: int) -> list[int]:
        """Return the corners at a vertex; an empty list for a vertex that is not part of the mesh."""
        if vertex >= len(self._corner):
            return []
        fabric, first = self._fabric, int(self._corner[vertex])
        corners, corner = [first], int(fabric.twin[fabric.side_previous[first]])
        while corner not in (BORDER, first):
            corners.append(corner)
            corner = int(fabric.twin[fabric.side_previous[corner]])
        across = int(fabric.twin[first])
        while corner == BORDER and across != BORDER:
            corners.append(int(fabric.side_next[across]))
            across = int(fabric.twin[corners[-1]])
        return corners

    def sides(self, vertex: int) -> list[int]:
        """Return all sides that start or end at a vertex."""
        corners = self.around(vertex)
        return [*corners, *(int(self._fabric.side_previous[corner]) for corner in corners)]

    def is_on_border(self, vertex: int) -> bool:
        """Whether a vertex lies on a border."""
        return any(self._fabric.twin[side] == BORDER for side in self.sides(vertex))

    def is_bare(self, vertex: int) -> bool:
        """Whether no wale edge ends at a vertex."""
        return all(self._fabric.role_of(side) in (BOTTOM, TOP) for side in self.sides(vertex))
