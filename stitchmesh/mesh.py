# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes and stitch meshes: frozen, validated, connected by explicit twins.

Side ``k`` of a face runs from its corner ``k`` to its corner ``k + 1``. Sides are numbered through the whole mesh
like the corners they start at, so a corner, a side and an entry of ``face_vertex`` share one number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.connectivity import check_fans, find_twins, next_sides
from stitchmesh.errors import LabelError, MeshError, first_few
from stitchmesh.lattice import Lattice
from stitchmesh.stitch import SIDE_COUNTS, Stitch

BORDER = -1
"""Twin of a side that no face lies across."""
BOTTOM, RIGHT, TOP, LEFT = range(4)
"""Roles of the sides of a stitch face; bottom and top sides are course sides, right and left ones wale sides."""
PER_FACE = ("n_bottom", "n_top", "stitch", "row", "yarn")
"""Fields of a stitch mesh with one number for each face."""
PER_SIDE = ("twist", "cable_shift", "cable_layer")
"""Marks of the loops: fields of a stitch mesh with one number for each side."""

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_FIXED_SIDES = np.array([SIDE_COUNTS.get(stitch, (-1, -1)) for stitch in sorted(Stitch)])
"""Bottom and top sides by type code, -1 where any number will do."""


def frozen_array(values: ArrayLike, dtype: type) -> NDArray:
    """A read-only copy, so that no caller can change a noun behind its back."""
    if isinstance(values, np.ndarray) and values.dtype == dtype and values.base is None and not values.flags.writeable:
        return values  # already frozen, and nobody else's view
    array: NDArray = np.array(values, dtype=dtype)
    array.setflags(write=False)
    return array


def ranges(start: IntArray, rows: IntArray) -> IntArray:
    """Places of all entries of some compressed rows, row by row."""
    counts = start[rows + 1] - start[rows]
    place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.repeat(start[rows], counts) + place


def _unmarked() -> IntArray:
    """Marks that are all zero; they get their length when a mesh is made."""
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Polygons of any size that form an oriented manifold surface.

    Raises:
        MeshError: a coordinate is not finite, an index is out of range, a face is degenerate, the twins are not
            mutual, or the surface is not an oriented manifold. The message names the vertex, face or side.
    """

    vertices: FloatArray
    """Positions [cm], shape (V, 3)."""
    face_start: IntArray
    """Where each face's corners start, shape (F + 1,)."""
    face_vertex: IntArray
    """Vertex of each corner, shape (C,)."""
    twin: IntArray
    """The side across each side, ``BORDER`` where there is none, shape (C,)."""
    lattice: Lattice | None = None
    """Periods of a mesh that repeats."""
    corner_image: IntArray | None = None
    """Integer lattice image of each corner, shape (C, 2); only with a lattice."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen_array(self.vertices, np.float64))
        for name in ("face_start", "face_vertex", "twin"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.int64))
        if self.corner_image is not None:
            object.__setattr__(self, "corner_image", frozen_array(self.corner_image, np.int64))
        self._check_arrays()
        self.check_polygons(np.arange(self.face_count))
        self.check_vertices_used()
        across = self.side_next[np.where(self.twin == BORDER, 0, self.twin)]
        check_fans(self.face_vertex, np.where(self.twin == BORDER, BORDER, across), len(self.vertices))

    @classmethod
    def from_polygons(cls, vertices: ArrayLike, faces: Sequence[Sequence[int]]) -> Mesh:
        """Connect polygons by their vertex numbers.

        Args:
            vertices: positions [cm], shape (V, 3).
            faces: vertex numbers of each polygon, counter-clockwise seen from outside.

        Raises:
            MeshError: as for the class; here also for edges shared by three faces and one-sided surfaces.
        """
        points = np.asarray(vertices, dtype=np.float64)
        face_start = np.concatenate([[0], np.cumsum([len(face) for face in faces], dtype=np.int64)])
        face_vertex = np.array([v for face in faces for v in face], dtype=np.int64)
        twin = find_twins(face_start, face_vertex, len(points))
        return cls(points, face_start, face_vertex, twin)

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.face_start) - 1

    @property
    def side_count(self) -> int:
        """Number of sides, which is the number of corners."""
        return len(self.face_vertex)

    @cached_property
    def side_face(self) -> IntArray:
        """Face of each side, shape (C,)."""
        return np.repeat(np.arange(self.face_count), np.diff(self.face_start))

    @cached_property
    def side_next(self) -> IntArray:
        """Next side around the same face, shape (C,)."""
        return next_sides(self.face_start)

    @cached_property
    def side_previous(self) -> IntArray:
        """Previous side around the same face, shape (C,)."""
        previous = np.empty(self.side_count, dtype=np.int64)
        previous[self.side_next] = np.arange(self.side_count)
        return previous

    @cached_property
    def side_edge(self) -> IntArray:
        """Edge of each side, shape (C,); twins share an edge, numbered by the first of their sides."""
        sides = np.arange(self.side_count)
        first = np.where(self.twin == BORDER, sides, np.minimum(sides, self.twin))
        return (np.cumsum(first == sides) - 1)[first]

    @cached_property
    def edge_side(self) -> IntArray:
        """First side of each edge, shape (E,)."""
        sides = np.arange(self.side_count)
        return np.flatnonzero((self.twin == BORDER) | (sides < self.twin))

    @cached_property
    def corner_position(self) -> FloatArray:
        """Position of each corner [cm], lattice image included, shape (C, 3)."""
        return self._position_of(np.arange(self.side_count))

    def _position_of(self, corners: IntArray) -> FloatArray:
        position = self.vertices[self.face_vertex[corners]]
        if self.lattice is not None and self.corner_image is not None:
            position = position + self.lattice.shift(self.corner_image[corners])
        return position

    @cached_property
    def side_image(self) -> IntArray:
        """Lattice image of the face across each side, seen from the side's own face, shape (C, 2).

        Both faces know their common vertices; where their images of one differ, the neighbour lies so many periods
        away. Zero at borders and without a lattice.
        """
        image = np.zeros((self.side_count, 2), dtype=np.int64)
        if self.corner_image is not None:
            inner = np.flatnonzero(self.twin != BORDER)
            image[inner] = self.corner_image[inner] - self.corner_image[self.side_next[self.twin[inner]]]
        return image

    def shift(self, image: ArrayLike) -> FloatArray:
        """Displacement of lattice images [cm], zero without a lattice, shape (..., 2) to (..., 3)."""
        if self.lattice is None:
            return np.zeros((*np.shape(image)[:-1], 3))
        return self.lattice.shift(image)

    @cached_property
    def side_length(self) -> FloatArray:
        """Length of each side [cm], shape (C,)."""
        position = self.corner_position
        return np.linalg.norm(position[self.side_next] - position, axis=1)

    @cached_property
    def face_vector_area(self) -> FloatArray:
        """Area of each face times its normal [cm^2], shape (F, 3)."""
        position = self.corner_position
        origin = position[self.face_start[:-1]][self.side_face]
        spans = np.cross(position - origin, position[self.side_next] - origin)
        return 0.5 * np.add.reduceat(spans, self.face_start[:-1], axis=0)

    @cached_property
    def vertex_normal(self) -> FloatArray:
        """Unit normal of each vertex, the area-weighted mean of its faces', shape (V, 3)."""
        total = np.zeros_like(self.vertices)
        np.add.at(total, self.face_vertex, self.face_vector_area[self.side_face])
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return total / np.where(length > 0.0, length, 1.0)

    @cached_property
    def boundary_loops(self) -> tuple[IntArray, ...]:
        """Border sides in walking order, one array for each closed border."""
        loops, seen = [], np.zeros(self.side_count, dtype=bool)
        for start in np.flatnonzero(self.twin == BORDER):
            if seen[start]:
                continue
            loop, side = [], int(start)
            while not seen[side]:
                seen[side] = True
                loop.append(side)
                side = self.next_border_side(side)
            loops.append(np.array(loop))
        return tuple(loops)

    def next_border_side(self, side: int) -> int:
        """The border side that starts where this border side ends."""
        side = int(self.side_next[side])
        while self.twin[side] != BORDER:
            side = int(self.side_next[self.twin[side]])
        return side

    def sides_of(self, faces: IntArray) -> IntArray:
        """All sides of some faces, face by face."""
        return ranges(self.face_start, faces)

    def side_name(self, side: int) -> str:
        """How messages name a side: its face and its two vertices."""
        start, end = self.face_vertex[side], self.face_vertex[self.side_next[side]]
        return f"side {side} (face {self.side_face[side]}, vertices {start}-{end})"

    def _check_arrays(self) -> None:
        if self.vertices.ndim != 2 or self.vertices.shape[1:] != (3,):
            raise MeshError(f"vertices: got shape {self.vertices.shape}; expected (V, 3)")
        if self.face_count < 1:
            raise MeshError("mesh: got no faces; expected at least one polygon")
        bad = np.flatnonzero(~np.isfinite(self.vertices).all(axis=1))
        if len(bad):
            raise MeshError(f"vertex {first_few(bad)}: coordinates are not finite; repair the file that wrote them")
        sizes = np.diff(self.face_start)
        if self.face_start[0] != 0 or self.face_start[-1] != len(self.face_vertex) or sizes.min() < 3:
            raise MeshError(f"face {int(sizes.argmin())}: got {sizes.min()} corners; expected at least 3")
        bad = np.flatnonzero((self.face_vertex < 0) | (self.face_vertex >= len(self.vertices)))
        if len(bad):
            face, vertex = self.side_face[bad[0]], self.face_vertex[bad[0]]
            raise MeshError(f"face {face}: vertex {vertex} does not exist; expected 0 to {len(self.vertices) - 1}")
        if (self.lattice is None) != (self.corner_image is None):
            raise MeshError("mesh: a lattice and corner images come together; got one without the other")
        if self.corner_image is not None and self.corner_image.shape != (self.side_count, 2):
            raise MeshError(f"corner_image: got shape {self.corner_image.shape}; expected ({self.side_count}, 2)")

    def check_polygons(self, faces: IntArray) -> None:
        """Check that some faces have an area and that their twins are mutual.

        Raises:
            MeshError: as for the class.
        """
        self._check_twins(self.sides_of(faces))
        self._check_areas(faces)

    def _check_twins(self, sides: IntArray) -> None:
        if self.twin.shape != self.face_vertex.shape:
            raise MeshError(f"twin: got {len(self.twin)} entries; expected one for each of {self.side_count} sides")
        inner = sides[self.twin[sides] != BORDER]
        across = self.twin[inner]
        bad = inner[(across < 0) | (across >= self.side_count) | (across == inner)]
        if not len(bad):
            mutual = self.twin[across] == inner
            start, end = self.face_vertex, self.face_vertex[self.side_next]
            bad = inner[~mutual | (start[inner] != end[across]) | (end[inner] != start[across])]
        if len(bad):
            raise MeshError(f"{self.side_name(bad[0])}: its twin {self.twin[bad[0]]} is not the same edge reversed")

    def _check_areas(self, faces: IntArray) -> None:
        sides, size = self.sides_of(faces), np.diff(self.face_start)[faces]
        first = np.cumsum(size) - size
        position, after = self._position_of(sides), self._position_of(self.side_next[sides])
        origin = np.repeat(position[first], size, axis=0)
        spans = np.add.reduceat(np.cross(position - origin, after - origin), first, axis=0)
        area = 0.5 * np.linalg.norm(spans, axis=1)
        scale = np.maximum.reduceat(np.sum((after - position) ** 2, axis=1), first)
        bad = faces[area <= 1e-12 * scale]  # rounding of a cross product of that size
        if len(bad):
            raise MeshError(f"face {first_few(bad)}: area is zero; remove it or move its vertices apart")

    def check_vertices_used(self) -> None:
        """Check that every vertex belongs to a face.

        Raises:
            MeshError: as for the class.
        """
        used = np.zeros(len(self.vertices), dtype=bool)
        used[self.face_vertex] = True
        if not used.all():
            bad = np.flatnonzero(~used)
            raise MeshError(f"vertex {first_few(bad)}: no face uses it; remove isolated vertices")


@dataclass(frozen=True, eq=False, kw_only=True)
class StitchMesh(Mesh):
    """A mesh whose faces stand in the knitting frame (Yuksel et al. 2012, section 4).

    The corners of each face are rotated so that its sides run counter-clockwise from the lower left: ``n_bottom``
    bottom course sides, the right wale side, ``n_top`` top course sides (right to left), the left wale side. The
    role of a side follows from its position, so no edge label can disagree with it.

    Raises:
        LabelError: a face has not exactly two wale sides, an edge is wale to one face and course to the other, a
            stitch has the wrong number of sides, or a mark stands where none can.
    """

    n_bottom: IntArray
    """Number of bottom course sides of each face, shape (F,)."""
    n_top: IntArray
    """Number of top course sides of each face, shape (F,)."""
    stitch: IntArray
    """Type code of each face (``Stitch``), shape (F,)."""
    row: IntArray
    """Row of each face, numbered in knitting order, shape (F,)."""
    yarn: IntArray = field(default_factory=_unmarked)
    """Which yarn each face is knitted with, numbered like colours, shape (F,); all 0 where not given."""
    twist: IntArray = field(default_factory=_unmarked)
    """Half turn of the loop on each top side, 1 or -1, else 0; at 1 the leg from the left is in front, shape (C,)."""
    cable_shift: IntArray = field(default_factory=_unmarked)
    """How many loops to the right the loop on each top side is moved before it is worked, shape (C,)."""
    cable_layer: IntArray = field(default_factory=_unmarked)
    """Of loops that cross, the one of the higher number lies in front, shape (C,); set on top sides."""
    stretch: FloatArray | None = None
    """Length over rest length of each edge after mesh relaxation, shape (E,); None before it."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("n_bottom", "n_top", "stitch", "row"):
            values = frozen_array(getattr(self, name), np.int64)
            if values.shape != (self.face_count,):
                raise LabelError(f"{name}: got shape {values.shape}; expected one number for each face")
            object.__setattr__(self, name, values)
        self._fill_marks()
        if self.stretch is not None:
            object.__setattr__(self, "stretch", frozen_array(self.stretch, np.float64))
        self.check_stitch_faces(np.arange(self.face_count))
        if self.stretch is not None and self.stretch.shape != (len(self.edge_side),):
            raise LabelError(f"stretch: got shape {self.stretch.shape}; expected one number for each edge")

    def _fill_marks(self) -> None:
        counts = {"yarn": self.face_count, **dict.fromkeys(PER_SIDE, self.side_count)}
        for name, count in counts.items():
            values = np.asarray(getattr(self, name), dtype=np.int64)
            values = frozen_array(values if values.size else np.zeros(count), np.int64)
            if values.shape != (count,):
                raise LabelError(f"{name}: got shape {values.shape}; expected ({count},)")
            object.__setattr__(self, name, values)

    @cached_property
    def side_role(self) -> IntArray:
        """Role of each side: ``BOTTOM``, ``RIGHT``, ``TOP`` or ``LEFT``, shape (C,)."""
        return self.role_of(np.arange(self.side_count))

    @overload
    def role_of(self, sides: int) -> int: ...
    @overload
    def role_of(self, sides: IntArray) -> IntArray: ...
    def role_of(self, sides: IntArray | int) -> IntArray | int:
        """Role of some sides, or of one, without a look at the whole mesh."""
        face = self.side_face[sides]
        above = sides - self.face_start[face] - self.n_bottom[face]  # 0 on the right wale side
        role: IntArray = (above >= 0) + 1 * (above > 0) + (above > self.n_top[face])
        return role

    @cached_property
    def side_place(self) -> IntArray:
        """Place of each side within its face, counted from the lower left, shape (C,)."""
        return np.arange(self.side_count) - self.face_start[:-1][self.side_face]

    @cached_property
    def is_wale(self) -> NDArray[np.bool_]:
        """Whether each side is a wale side, shape (C,)."""
        return self.side_role % 2 == 1

    @cached_property
    def right_wale(self) -> IntArray:
        """Right wale side of each face, shape (F,)."""
        return self.face_start[:-1] + self.n_bottom

    @cached_property
    def left_wale(self) -> IntArray:
        """Left wale side of each face, shape (F,)."""
        return self.face_start[1:] - 1

    @cached_property
    def mismatched(self) -> NDArray[np.bool_]:
        """Sides whose two faces both call them top, or both bottom, or both left (section 4.4), shape (C,)."""
        across = np.where(self.twin == BORDER, 0, self.twin)
        return (self.twin != BORDER) & (self.side_role == self.side_role[across])

    @cached_property
    def face_stretch(self) -> FloatArray | None:
        """Mean stretch of each face's edges, shape (F,); None before mesh relaxation."""
        if self.stretch is None:
            return None
        total = np.add.reduceat(self.stretch[self.side_edge], self.face_start[:-1])
        return total / np.diff(self.face_start)

    def check_stitch_faces(self, faces: IntArray) -> None:
        """Check that some faces are legal stitch faces that fit their neighbours.

        Raises:
            LabelError: as for the class.
        """
        sides = self.sides_of(faces)
        self._check_sides(faces, sides)
        self._check_stitches(faces)
        self._check_marks(faces, sides)

    def _check_sides(self, faces: IntArray, sides: IntArray) -> None:
        sizes, bottom, top = np.diff(self.face_start)[faces], self.n_bottom[faces], self.n_top[faces]
        bad = np.flatnonzero((bottom < 0) | (top < 0) | (bottom + top + 2 != sizes))
        if len(bad):
            found = f"{bottom[bad[0]]} bottom and {top[bad[0]]} top sides of {sizes[bad[0]]}"
            raise LabelError(f"face {faces[bad[0]]}: got {found}; a stitch face needs exactly 2 wale sides beside them")
        across = np.where(self.twin[sides] == BORDER, sides, self.twin[sides])
        bad = sides[self.role_of(sides) % 2 != self.role_of(across) % 2]
        if len(bad):
            other = self.side_face[self.twin[bad[0]]]
            raise LabelError(f"{self.side_name(bad[0])}: wale to one face and course to face {other}")

    def _check_stitches(self, faces: IntArray) -> None:
        stitch = self.stitch[faces]
        if stitch.min() < 0 or stitch.max() > max(Stitch):
            raise LabelError(f"stitch: got codes {stitch.min()} to {stitch.max()}; expected 0 to {max(Stitch)}")
        bottom, top = _FIXED_SIDES[stitch].T
        bad = np.flatnonzero((bottom >= 0) & ((self.n_bottom[faces] != bottom) | (self.n_top[faces] != top)))
        if len(bad):
            face, name = faces[bad[0]], Stitch(int(stitch[bad[0]])).name
            found = f"{self.n_bottom[face]} bottom and {self.n_top[face]} top sides"
            raise LabelError(f"face {face}: {name} on {found}; it needs {bottom[bad[0]]} and {top[bad[0]]}")

    def _check_marks(self, faces: IntArray, sides: IntArray) -> None:
        for name in PER_SIDE:
            marked = sides[getattr(self, name)[sides] != 0]
            bad = marked[self.role_of(marked) != TOP]
            if len(bad):
                raise LabelError(f"{self.side_name(bad[0])}: has a {name}; only top sides of a face carry one")
        bad = sides[np.abs(self.twist[sides]) > 1]
        if len(bad):
            raise LabelError(f"{self.side_name(bad[0])}: twist {self.twist[bad[0]]}; expected -1, 0 or 1")
        bad = faces[self.yarn[faces] < 0]
        if len(bad):
            raise LabelError(f"face {first_few(bad)}: got yarn {self.yarn[bad[0]]}; yarns are numbered from 0")
