# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Face meshes: polygons of any type, joined side by side, with all data of an ``.smobj`` file about them.

A face mesh is not a surface. The same point may be several vertices, faces that are joined need not touch, a join may
turn the side of the cloth, and a face may have no area. A face mesh whose faces are all stitches is also a stitch mesh
(``faces.stitches``).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import MeshError, first_few
from stitchmesh.faces.face_type import FaceType
from stitchmesh.lattice import LARGEST_LENGTH
from stitchmesh.mesh import FloatArray, IntArray, frozen_array
from stitchmesh.mesh.polygon_mesh import extent

Record = tuple[str, ...]
"""The words of one line of a file."""


@dataclass(frozen=True)
class Checkpoint:
    """A place on a yarn, and the length of yarn from there to the next checkpoint of the yarn."""

    face: int
    """Face, counted from 0."""
    side: int
    """Side of the face that the yarn crosses, counted from 0."""
    crossing: int
    """Number of the crossing along the side, counted from 0."""
    lengths: tuple[tuple[float, int], ...]
    """Pairs of a factor and a unit, whose products sum to the length; empty at the end of a yarn."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FaceMesh:
    """Faces of any type and the joins of their sides, with all records of an ``.smobj`` file.

    V, F, C and J below are the numbers of vertices, faces, corners and joins.

    Raises:
        MeshError: an array has the wrong shape, a number is out of range or not finite, a face does not have as many
            corners as its type has sides, or a side is joined twice.
    """

    types: tuple[FaceType, ...]
    """Types of faces; types that no face has are kept."""
    vertices: FloatArray
    """Positions [cm], shape (V, 3)."""
    face_start: IntArray
    """First corner of each face, and C at the end, shape (F + 1,)."""
    face_vertex: IntArray
    """Vertex of each corner, shape (C,)."""
    face_type: IntArray
    """Type of each face, shape (F,)."""
    source_line: IntArray
    """Line of the program that made each face, 0 if unknown, -1 if the file says nothing, shape (F,)."""
    joins: IntArray
    """Two sides that are joined, as numbers of their first corners, shape (J, 2)."""
    reverses: NDArray[np.bool_]
    """Whether the second side of a join runs against the first, as on an oriented surface, shape (J,)."""
    hints: tuple[Record, ...] = ()
    """Records of a machine plan, in order: needles (h), orders (o and I) and variants (t) of faces."""
    units: tuple[tuple[str, float], ...] = ()
    """Name and default length [cm] of each unit of yarn length."""
    checkpoints: tuple[Checkpoint, ...] = ()
    """Lengths of yarn, in order along each yarn."""
    texture: tuple[Record, ...] = ()
    """Records of texture and material, in order."""
    corner_texture: tuple[str, ...] = field(default=())
    """Text after the vertex of each corner, such as ``/2``; empty if no corner has a texture."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen_array(np.reshape(self.vertices, (-1, 3)), np.float64))
        for name in ("face_start", "face_vertex", "face_type", "source_line"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.int64))
        object.__setattr__(self, "joins", frozen_array(np.reshape(self.joins, (-1, 2)), np.int64))
        object.__setattr__(self, "reverses", frozen_array(self.reverses, np.bool_))
        self._check_faces()
        self._check_joins()

    def __repr__(self) -> str:
        """Return one line: the numbers of faces and joins, and the size."""
        return f"FaceMesh({self.face_count} faces, {len(self.joins)} joins, {extent(self.vertices)})"

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.face_start) - 1

    def type_of(self, face: int) -> FaceType:
        """Return the type of a face."""
        return self.types[self.face_type[face]]

    def corners_of(self, face: int) -> FloatArray:
        """Return the positions of the corners of a face [cm], shape (corners, 3)."""
        return self.vertices[self.face_vertex[self.face_start[face] : self.face_start[face + 1]]]

    def side_at(self, corner: int) -> tuple[int, int]:
        """Return the face of a side, and its place in the face, both counted from 0."""
        face = int(np.searchsorted(self.face_start, corner, side="right")) - 1
        return face, corner - int(self.face_start[face])

    def _check_faces(self) -> None:
        if self.face_count < 1:
            raise MeshError("face mesh: got no faces; expected at least one")
        if not (np.abs(self.vertices) <= LARGEST_LENGTH).all():
            raise MeshError(f"face mesh: a coordinate is not finite or beyond {LARGEST_LENGTH:g}")
        _check_range("face_vertex", self.face_vertex, len(self.vertices), self.face_start[-1])
        _check_range("face_type", self.face_type, len(self.types), self.face_count)
        if self.source_line.shape != (self.face_count,):
            raise MeshError(f"source_line: got shape {self.source_line.shape}; expected ({self.face_count},)")
        sides = np.array([len(kind.labels) for kind in self.types])[self.face_type]
        bad = np.flatnonzero(np.diff(self.face_start) != sides)
        if len(bad):
            found = f"{np.diff(self.face_start)[bad[0]]} corners"
            raise MeshError(f"face {first_few(bad)}: got {found}; its type {self.type_of(bad[0])} has {sides[bad[0]]}")

    def _check_joins(self) -> None:
        _check_range("joins", self.joins.ravel(), len(self.face_vertex), 2 * len(self.reverses))
        twice = np.flatnonzero(np.bincount(self.joins.ravel(), minlength=1) > 1)
        if len(twice):
            face, side = self.side_at(int(twice[0]))
            raise MeshError(f"face {face}, side {side}: is joined twice; a side joins one other side")


def _check_range(name: str, values: IntArray, limit: int, count: int) -> None:
    if values.shape != (count,):
        raise MeshError(f"{name}: got shape {values.shape}; expected ({count},)")
    bad = np.flatnonzero((values < 0) | (values >= limit))
    if len(bad):
        raise MeshError(f"{name} {first_few(bad)}: got {values[bad[0]]}; expected 0 to {limit - 1}")
