# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Polygon meshes: immutable, validated, and connected by explicit twins.

Side ``k`` of a face runs from corner ``k`` to corner ``k + 1`` of the face. Sides are numbered through the whole mesh,
and a side has the number of the corner that it starts at. A corner, the side that starts there and their entry of
``face_vertex`` therefore share one number. The twin of a side is the side of the neighbouring face along the same
edge, in the opposite direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import MeshError, first_few
from stitchmesh.lattice import LARGEST_LENGTH, Lattice
from stitchmesh.mesh.arrays import unit_vectors
from stitchmesh.mesh.connectivity import check_fans, find_twins, linked_groups, next_sides

BORDER = -1
"""Twin of a side on the border, where no face is on the other side."""

NO_AREA = 1e-12
"""A face has no area up to this multiple of the square of its longest side: a cross product has such an error."""

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def frozen_array(values: ArrayLike, dtype: type) -> NDArray:
    """Return a read-only copy of an array, so that a later change by the caller cannot alter a frozen object."""
    if isinstance(values, np.ndarray) and values.dtype == dtype and values.base is None and not values.flags.writeable:
        return values  # The array is already read-only and is not a view of a writeable one.
    array: NDArray = np.array(values, dtype=dtype)
    array.setflags(write=False)
    return array


def ranges(start: IntArray, rows: IntArray) -> IntArray:
    """Return the indices of all entries of some rows of a CSR (compressed sparse row) array, row by row.

    Args:
        start: index of the first entry of each row, and the end of the last row, shape (n + 1,).
        rows: numbers of the rows, shape (m,).
    """
    counts = start[rows + 1] - start[rows]
    place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.repeat(start[rows], counts) + place


def check_positions(vertices: FloatArray) -> None:
    """Check the positions of vertices.

    Raises:
        MeshError: their shape is not (V, 3), or a coordinate is not finite or too large.
    """
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise MeshError(f"vertices: got shape {vertices.shape}; expected (V, 3)")
    bad = np.flatnonzero(~(np.abs(vertices) <= LARGEST_LENGTH).all(axis=1))
    if len(bad):
        found = f"coordinates are not finite or beyond {LARGEST_LENGTH:g}"
        raise MeshError(f"vertex {first_few(bad)}: {found}; repair the file that wrote them")


def extent(points: FloatArray) -> str:
    """Return the size of the bounding box of points [cm], shape (n, 3), as text: ``27.1 x 24.0 x 27.1 cm``."""
    size = points.max(axis=0) - points.min(axis=0)
    return f"{size[0]:.1f} x {size[1]:.1f} x {size[2]:.1f} cm"


@dataclass(frozen=True, eq=False)
class Mesh:
    """Polygons with any number of corners that form an oriented manifold surface.

    V, F, C and E below are the numbers of vertices, faces, corners (or sides) and edges.

    Raises:
        MeshError: a coordinate is not finite, an index is out of range, a face is degenerate, the twins are not
            mutual, or the surface is not an oriented manifold. The message names the vertex, face or side.
    """

    vertices: FloatArray
    """Positions [cm], shape (V, 3)."""
    face_start: IntArray
    """Number of the first corner of each face, and C at the end, shape (F + 1,)."""
    face_vertex: IntArray
    """Vertex of each corner, shape (C,)."""
    twin: IntArray
    """Twin of each side, ``BORDER`` on the border, shape (C,)."""
    lattice: Lattice | None = None
    """Lattice of a periodic mesh; None for a mesh that does not repeat."""
    corner_image: IntArray | None = None
    """Integer lattice image of each corner, shape (C, 2); given if and only if there is a lattice."""

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
        """Build a mesh from polygons; sides with the same two vertices become twins.

        Args:
            vertices: positions [cm], shape (V, 3).
            faces: vertex numbers of each polygon, counter-clockwise when seen from outside.

        Raises:
            MeshError: as for the class, or an edge is shared by three faces, or the surface is one-sided.
        """
        points = np.asarray(vertices, dtype=np.float64)
        face_start = np.concatenate([[0], np.cumsum([len(face) for face in faces], dtype=np.int64)])
        face_vertex = np.array([v for face in faces for v in face], dtype=np.int64)
        twin = find_twins(face_start, face_vertex, len(points))
        return cls(points, face_start, face_vertex, twin)

    def __repr__(self) -> str:
        """Return one line: the numbers of faces and vertices, and the size."""
        periodic = ", periodic" if self.lattice is not None else ""
        counts = f"{self.face_count} faces, {len(self.vertices)} vertices"
        return f"{type(self).__name__}({counts}, {extent(self.vertices)}{periodic})"

    @property
    def polygons(self) -> list[list[int]]:
        """Vertices of each face, as ``from_polygons`` takes them."""
        return [face.tolist() for face in np.split(self.face_vertex, self.face_start[1:-1])]

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.face_start) - 1

    @property
    def side_count(self) -> int:
        """Number of sides, which is also the number of corners."""
        return len(self.face_vertex)

    @cached_property
    def side_face(self) -> IntArray:
        """Face of each side, shape (C,)."""
        return np.repeat(np.arange(self.face_count), np.diff(self.face_start))

    @cached_property
    def side_next(self) -> IntArray:
        """Next side around the same face, counter-clockwise, shape (C,)."""
        return next_sides(self.face_start)

    @cached_property
    def side_previous(self) -> IntArray:
        """Previous side around the same face, shape (C,)."""
        previous = np.empty(self.side_count, dtype=np.int64)
        previous[self.side_next] = np.arange(self.side_count)
        return previous

    @cached_property
    def side_beyond(self) -> IntArray:
        """Opposite side of the quad across each side, ``BORDER`` if there is no face or no quad across, shape (C,)."""
        across = np.where(self.twin == BORDER, 0, self.twin)
        is_quad = (np.diff(self.face_start) == 4)[self.side_face[across]] & (self.twin != BORDER)
        return np.where(is_quad, self.side_next[self.side_next[across]], BORDER)

    @cached_property
    def side_edge(self) -> IntArray:
        """Edge of each side, shape (C,); twins share an edge, and edges are numbered in order of their first sides."""
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
        """Position of each corner [cm], shifted by the lattice image of the corner, shape (C, 3)."""
        return self._position_of(np.arange(self.side_count))

    def _position_of(self, corners: IntArray) -> FloatArray:
        position = self.vertices[self.face_vertex[corners]]
        if self.lattice is not None and self.corner_image is not None:
            position = position + self.lattice.shift(self.corner_image[corners])
        return position

    @cached_property
    def side_image(self) -> IntArray:
        """Lattice image of the face across each side, relative to the side's own face, shape (C, 2).

        Both faces store an image of their common vertex. The difference of the two images is the number of periods by
        which the neighbour is shifted. It is zero at borders and without a lattice.
        """
        image = np.zeros((self.side_count, 2), dtype=np.int64)
        if self.corner_image is not None:
            inner = np.flatnonzero(self.twin != BORDER)
            image[inner] = self.corner_image[inner] - self.corner_image[self.side_next[self.twin[inner]]]
        return image

    def shift(self, image: ArrayLike) -> FloatArray:
        """Displacement of lattice images [cm], shape (..., 2) to (..., 3); zero without a lattice."""
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
    def rounding(self) -> float:
        """Coordinates that differ by less than this are equal [cm]: a millionth of the size of the mesh."""
        return 1e-6 * float(np.ptp(self.vertices, axis=0).max())

    @cached_property
    def vertex_normal(self) -> FloatArray:
        """Unit normal of each vertex, shape (V, 3): the area-weighted mean of the normals of the faces around it."""
        total = np.zeros_like(self.vertices)
        np.add.at(total, self.face_vertex, self.face_vector_area[self.side_face])
        return unit_vectors(total)

    @cached_property
    def boundary_loops(self) -> tuple[IntArray, ...]:
        """Border sides in their order around the border, one array for each closed border."""
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

    def previous_border_side(self, side: int) -> int:
        """The border side that ends where this border side starts."""
        side = int(self.side_previous[side])
        while self.twin[side] != BORDER:
            side = int(self.side_previous[self.twin[side]])
        return side

    def sides_of(self, faces: IntArray) -> IntArray:
        """All sides of the given faces, face by face."""
        return ranges(self.face_start, faces)

    def side_name(self, side: int) -> str:
        """Name of a side in messages: its number, its face and its two vertices."""
        start, end = self.face_vertex[side], self.face_vertex[self.side_next[side]]
        return f"side {side} (face {self.side_face[side]}, vertices {start}-{end})"

    def _check_arrays(self) -> None:
        check_positions(self.vertices)
        if self.face_count < 1:
            raise MeshError("mesh: got no faces; expected at least one polygon")
        sizes = np.diff(self.face_start)
        if self.face_start[0] != 0 or self.face_start[-1] != len(self.face_vertex) or sizes.min() < 3:
            raise MeshError(f"face {int(sizes.argmin())}: got {sizes.min()} corners; expected at least 3")
        bad = np.flatnonzero((self.face_vertex < 0) | (self.face_vertex >= len(self.vertices)))
        if len(bad):
            face, vertex = self.side_face[bad[0]], self.face_vertex[bad[0]]
            raise MeshError(f"face {face}: vertex {vertex} does not exist; expected 0 to {len(self.vertices) - 1}")
        if (self.lattice is None) != (self.corner_image is None):
            raise MeshError("mesh: a lattice and corner images must be given together; got one without the other")
        if self.corner_image is not None and self.corner_image.shape != (self.side_count, 2):
            raise MeshError(f"corner_image: got shape {self.corner_image.shape}; expected ({self.side_count}, 2)")

    def check_polygons(self, faces: IntArray) -> None:
        """Check that the given faces have an area and that their twins are mutual.

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
        bad = faces[area <= NO_AREA * scale]
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


def outline_sides(mesh: Mesh, faces: IntArray) -> IntArray:
    """Return the sides at the outline of a set of faces, shape (n,).

    Args:
        mesh: the mesh.
        faces: the faces, shape (m,).
    """
    within = np.zeros(mesh.face_count, dtype=bool)
    within[faces] = True
    sides = mesh.sides_of(faces)
    across = mesh.twin[sides]
    return sides[(across == BORDER) | ~within[mesh.side_face[across]]]


def connected_faces(mesh: Mesh) -> IntArray:
    """Number the connected parts of a mesh, and return the part of each face, shape (F,).

    Args:
        mesh: the mesh.
    """
    inner = np.flatnonzero(mesh.twin != BORDER)
    return linked_groups(mesh.face_count, mesh.side_face[inner], mesh.side_face[mesh.twin[inner]])
