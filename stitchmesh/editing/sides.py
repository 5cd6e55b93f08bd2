# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Checks, places and neighbours of single faces, sides and vertices by number, without a search through the mesh."""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, BOTTOM, LEFT, RIGHT, TOP, StitchMesh


def check_face(fabric: StitchMesh, face: int) -> None:
    """Check that a face exists.

    Raises:
        ParameterError: the face does not exist.
    """
    if not 0 <= face < fabric.face_count:
        raise ParameterError(f"face {face}: does not exist; the mesh has faces 0 to {fabric.face_count - 1}")


def check_side(fabric: StitchMesh, side: int, kind: str) -> None:
    """Check that a side exists and is a ``"course"``, ``"wale"`` or ``"top"`` side.

    Raises:
        ParameterError: the side does not exist, or is of another kind.
    """
    if not 0 <= side < fabric.side_count:
        raise ParameterError(f"side {side}: does not exist; the mesh has sides 0 to {fabric.side_count - 1}")
    role = fabric.role_of(side)
    if role not in {"course": (BOTTOM, TOP), "wale": (RIGHT, LEFT), "top": (TOP,)}[kind]:
        found = ("bottom", "right wale", "top", "left wale")[role]
        raise ParameterError(f"{fabric.side_name(side)}: is a {found} side; expected a {kind} side")


def course_place(fabric: StitchMesh, side: int) -> tuple[bool, int]:
    """Whether a course side is on top of its face, and the place of the side there from the left."""
    face = int(fabric.side_face[side])
    place = side - int(fabric.face_start[face])
    n_bottom, n_top = int(fabric.n_bottom[face]), int(fabric.n_top[face])
    return (False, place) if place < n_bottom else (True, n_bottom + n_top - place)


def faces_beside(fabric: StitchMesh, side: int) -> tuple[int, int]:
    """Return the faces to the left and right of a wale edge; ``BORDER`` where there is none.

    Args:
        fabric: a mesh of stitches.
        side: either side of the edge.

    Raises:
        ParameterError: the two faces have opposite wale directions, or are one face.
    """
    across, role = int(fabric.twin[side]), fabric.role_of(side)
    if across != BORDER and fabric.role_of(across) == role:
        name = fabric.side_name(side)
        raise ParameterError(f"{name}: its two faces run in opposite directions; flip one of the rows first")
    face = int(fabric.side_face[side])
    other = BORDER if across == BORDER else int(fabric.side_face[across])
    if face == other:
        raise ParameterError(f"{fabric.side_name(side)}: has one face on both sides; expected two")
    return (face, other) if role == RIGHT else (other, face)


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
