# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Build a patch face by face: the faces that are removed from a stitch mesh, and the faces that are added.

Vertices are named by their numbers; a new vertex has the number that ``PatchBuilder.vertex`` returns. Edges of the
mesh are named by the integer that ``edge_of`` returns; a new edge is named by any other hashable value, for example a
tuple. Two added sides with the same edge name become twins. An added side on an edge of the mesh becomes the twin of
the remaining face's side on this edge.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import MeshError
from stitchmesh.mesh.change import UNKNOWN_STRETCH, Patch, stretch_at, vertices_left
from stitchmesh.mesh.polygon_mesh import BORDER, FloatArray, IntArray
from stitchmesh.mesh.renumbering import Renumbering
from stitchmesh.mesh.stitch_mesh import PER_FACE, PER_SIDE, StitchMesh


@dataclass(frozen=True)
class NewFace:
    """A face to be added."""

    corners: Sequence[int]
    """Vertices, counter-clockwise from the lower left."""
    edges: Sequence[Hashable]
    """Name of the edge of each side, in the same order."""
    n_bottom: int
    """Number of bottom sides."""
    n_top: int
    """Number of top sides."""
    stitch: int
    """Type code of the face."""
    row: int
    """Row of the face."""
    yarn: int = 0
    """Number of the yarn of the face."""
    twist: Sequence[int] = ()
    """Twist of each top side, from left to right; all 0 if empty."""
    cable_shift: Sequence[int] = ()
    """Cable shift of each top side, from left to right; all 0 if empty."""
    cable_layer: Sequence[int] = ()
    """Cable layer of each top side, from left to right; all 0 if empty."""

    def at_sides(self, name: str) -> list[int]:
        """Return a mark (a name of ``PER_SIDE``) of all sides of the face, in the order of the sides."""
        tops = list(getattr(self, name)) or [0] * self.n_top
        return [0] * (self.n_bottom + 1) + tops[::-1] + [0]


def edge_of(fabric: StitchMesh, side: int) -> int:
    """Return the name of the edge of a side: the lower of the numbers of its two sides."""
    across = int(fabric.twin[side])
    return int(side) if across == BORDER else min(int(side), across)


class PatchBuilder:
    """Collects the removed and the added faces of a patch."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Start with an empty patch of ``fabric``."""
        self._fabric = fabric
        self._removed: set[int] = set()
        self._faces: list[NewFace] = []
        self._positions: list[ArrayLike] = []

    def remove(self, face: int) -> None:
        """Remove a face of the mesh.

        Raises:
            MeshError: the mesh has no such face.
        """
        if not 0 <= face < self._fabric.face_count:
            raise MeshError(f"face {face}: does not exist; the mesh has faces 0 to {self._fabric.face_count - 1}")
        self._removed.add(int(face))

    def vertex(self, position: ArrayLike) -> int:
        """Add a vertex at a position [cm], shape (3,), and return its number for ``NewFace``."""
        self._positions.append(position)
        return len(self._fabric.vertices) + len(self._positions) - 1

    def put(self, face: NewFace) -> None:
        """Add a face."""
        self._faces.append(face)

    def patch(self) -> Patch:
        """Return the patch so far.

        Added faces and vertices first take the numbers of removed ones, and then the numbers after the last one.

        Raises:
            MeshError: an edge would have more than two sides.
        """
        fabric = self._fabric
        removed = np.array(sorted(self._removed), dtype=np.int64)
        corners = np.array([corner for face in self._faces for corner in face.corners], dtype=np.int64)
        gone = vertices_left(fabric, removed, corners[corners < len(fabric.vertices)])
        vertices = Renumbering.filling(len(fabric.vertices), gone, len(self._positions))
        faces = Renumbering.filling(fabric.face_count, removed, len(self._faces))
        return Patch(
            removed_faces=removed,
            removed_vertices=gone,
            added_faces=faces.added,
            added_vertices=vertices.added,
            positions=np.array(self._positions, dtype=np.float64).reshape(-1, 3),
            face_size=np.array([len(face.corners) for face in self._faces], dtype=np.int64),
            corners=np.concatenate([vertices.after, vertices.added])[corners],
            twin=self._twins(faces.added, faces.after),
            faces={name: np.array([getattr(face, name) for face in self._faces], dtype=np.int64) for name in PER_FACE},
            sides={
                name: np.array([mark for face in self._faces for mark in face.at_sides(name)], dtype=np.int64)
                for name in PER_SIDE
            },
            stretch=self._stretch(),
        )

    def _twins(self, faces: IntArray, after: IntArray) -> IntArray:
        """Twin of each added side, as in ``Patch.twin``."""
        fabric = self._fabric
        sides = [(int(number), place, edge) for number, face in zip(faces, self._faces, strict=True)
                 for place, edge in enumerate(face.edges)]  # fmt: skip
        by_edge: dict[Hashable, list[tuple[int, int]]] = {}
        for number, place, edge in sides:
            by_edge.setdefault(edge, []).append((number, place))
        for edge, own in by_edge.items():
            own += [(int(after[fabric.side_face[side]]), int(fabric.side_place[side])) for side in self._kept(edge)]
            if len(own) > 2:
                raise MeshError(f"change: edge {edge} would belong to {len(own)} faces; expected at most 2")
        twin = [next((other for other in by_edge[edge] if other != (number, place)), (BORDER, BORDER))
                for number, place, edge in sides]  # fmt: skip
        return np.array(twin, dtype=np.int64).reshape(-1, 2)

    def _kept(self, edge: Hashable) -> list[int]:
        """Sides of an edge of the mesh whose faces are not removed."""
        if not isinstance(edge, int):
            return []
        sides = [side for side in (edge, int(self._fabric.twin[edge])) if side != BORDER]
        return [side for side in sides if int(self._fabric.side_face[side]) not in self._removed]

    def _stretch(self) -> FloatArray:
        edges = [edge if isinstance(edge, int) else BORDER for face in self._faces for edge in face.edges]
        sides = np.array(edges, dtype=np.int64)
        if self._fabric.stretch is None or not len(sides):
            return np.full(len(sides), UNKNOWN_STRETCH)
        return np.where(sides == BORDER, UNKNOWN_STRETCH, stretch_at(self._fabric, sides))
