# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces as an edit redraws them: chains of vertices and edges from left to right.

A ``Sketch`` takes a face out of the mesh when it is first asked for, so that it can be put back changed. Faces that
were taken out come back in the order of their numbers, so that where none is dropped all keep their numbers.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.editing.fitting import check_fit, fitting_stitch, stitch_named
from stitchmesh.editing.sides import check_face, course_place
from stitchmesh.editing.vertex_corners import VertexCorners
from stitchmesh.errors import MeshError, ParameterError
from stitchmesh.mesh import BORDER, FloatArray, StitchMesh
from stitchmesh.mesh.change import Patch
from stitchmesh.mesh.patch_builder import NewFace, PatchBuilder, edge_of
from stitchmesh.mesh.stitch import Stitch


@dataclass(frozen=True)
class Loop:
    """Marks of the loop on a top side."""

    twist: int = 0
    cable_shift: int = 0
    cable_layer: int = 0


@dataclass(eq=False)
class SketchFace:
    """A stitch face while it is redrawn; all lists run from left to right."""

    name: str
    """How messages name it."""
    low: list[int]
    """Vertices along the bottom, one more than bottom sides."""
    high: list[int]
    """Vertices along the top."""
    below: list[Hashable]
    """Names of the bottom edges."""
    above: list[Hashable]
    """Names of the top edges."""
    left: Hashable
    """Name of the left wale edge."""
    right: Hashable
    stitch: Stitch
    row: int
    yarn: int
    loops: list[Loop] = field(default_factory=list)
    """Marks of the top sides."""

    def __post_init__(self) -> None:
        self.loops = self.loops or [Loop() for _ in self.above]

    def chain(self, on_top: bool) -> tuple[list[int], list[Hashable]]:
        """Vertices and edges of its top or of its bottom."""
        return (self.high, self.above) if on_top else (self.low, self.below)

    def insert(self, on_top: bool, side: int, vertex: int, edges: tuple[Hashable, Hashable]) -> None:
        """Divide a course side at a vertex into two edges; the loop on a top side gives both its twist."""
        vertices, names = self.chain(on_top)
        vertices.insert(side + 1, vertex)
        names[side : side + 1] = edges
        if on_top:
            self.loops[side : side + 1] = [Loop(self.loops[side].twist)] * 2

    def widen(self, on_top: bool, place: int, vertices: tuple[int, int], edge: Hashable) -> None:
        """Make two vertices of one on its top or its bottom, with a new course side between them."""
        line, names = self.chain(on_top)
        line[place : place + 1] = vertices
        names.insert(place, edge)
        if on_top:
            self.loops.insert(place, Loop())

    def close(self, on_top: bool, side: int) -> None:
        """Take out a course side whose two ends are one vertex."""
        vertices, names = self.chain(on_top)
        del vertices[side + 1], names[side]
        if on_top:
            del self.loops[side]

    def rename_edge(self, old: Hashable, new: Hashable) -> None:
        """Give an edge another name wherever the face has it."""
        for names in (self.below, self.above):
            names[:] = [new if name == old else name for name in names]
        self.left, self.right = (new if name == old else name for name in (self.left, self.right))

    def turn(self) -> None:
        """Turn its frame by half a turn; the marks of its loops are lost."""
        self.low, self.high = self.high[::-1], self.low[::-1]
        self.below, self.above = self.above[::-1], self.below[::-1]
        self.left, self.right = self.right, self.left
        self.loops = [Loop() for _ in self.above]

    def drawn(self) -> NewFace:
        """The face to be put in."""
        return NewFace(
            corners=[*self.low, *self.high[::-1]],
            edges=[*self.below, self.right, *self.above[::-1], self.left],
            n_bottom=len(self.below), n_top=len(self.above), stitch=self.stitch, row=self.row, yarn=self.yarn,
            **{name: [getattr(loop, name) for loop in self.loops] for name in Loop.__dataclass_fields__},
        )  # fmt: skip


class Sketch:
    """A patch in the making from faces that are redrawn, dropped and added."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Start with a stitch mesh that stays as it is."""
        self.fabric = fabric
        self._draft = PatchBuilder(fabric)
        self._positions: list[FloatArray] = []
        self._redrawn: dict[int, SketchFace] = {}
        self._dropped: set[int] = set()
        self._added: list[SketchFace] = []
        self._unsettled: list[tuple[SketchFace, str | None]] = []

    @cached_property
    def corners(self) -> VertexCorners:
        """The corners around the vertices of the mesh."""
        return VertexCorners(self.fabric)

    def face(self, number: int) -> SketchFace:
        """A face of the mesh, to be redrawn.

        Raises:
            ParameterError: there is no such face.
        """
        if number not in self._redrawn:
            self._redrawn[number] = face_of(self.fabric, number)
            self._draft.remove(number)
        return self._redrawn[number]

    def drop(self, number: int) -> SketchFace:
        """Take a face out for good; returns what it was."""
        self._dropped.add(number)
        return self.face(number)

    def add(self, face: SketchFace) -> None:
        """Put a new face in."""
        self._added.append(face)

    def vertex(self, position: ArrayLike) -> int:
        """Put a vertex in [cm]; returns its number."""
        self._positions.append(np.asarray(position, dtype=np.float64))
        return self._draft.vertex(self._positions[-1])

    def position(self, vertex: int) -> FloatArray:
        """Where a vertex lies, old or new [cm]."""
        count = len(self.fabric.vertices)
        place: FloatArray = self.fabric.vertices[vertex] if vertex < count else self._positions[vertex - count]
        return place

    def faces_around(self, vertices: Sequence[int]) -> list[int]:
        """Faces of the mesh, those dropped not counted, that have one of some vertices."""
        corners = [corner for vertex in vertices for corner in self.corners.around(vertex)]
        return sorted({int(face) for face in self.fabric.side_face[corners]} - self._dropped)

    def merge(self, first: int, second: int, prefer: int | None = None) -> int:
        """Make one vertex of the two ends of an edge, in all faces around them; returns its number.

        The one on the border stays if only one of them lies there, else the one preferred, else the one at which
        wale edges end if they do so only at one, else a vertex half way.
        """
        keep = self._meeting_place(first, second, prefer)
        old = {first, second} - {keep}
        for number in self.faces_around(sorted(old)):
            face = self.face(number)
            for vertices in (face.low, face.high):
                vertices[:] = [keep if vertex in old else vertex for vertex in vertices]
        return keep

    def _meeting_place(self, first: int, second: int, prefer: int | None) -> int:
        ends = (first, second)
        on_border = [self.corners.is_on_border(vertex) for vertex in ends]
        if on_border[0] != on_border[1]:
            return ends[on_border.index(True)]
        if prefer is not None:
            return prefer
        bare = [self.corners.is_bare(vertex) for vertex in ends]
        if bare[0] != bare[1]:
            return ends[bare.index(False)]
        return self.vertex(0.5 * (self.position(first) + self.position(second)))

    def settle(self, face: SketchFace, code: str | None = None) -> None:
        """Have a face take the stitch of a code, or the one like its own that fits its sides, when all is drawn."""
        self._unsettled.append((face, code))

    def patch(self) -> Patch:
        """What the sketch changes.

        Raises:
            ParameterError: no stitch, or not the one named, fits a face.
            MeshError: a face would visit a vertex twice.
        """
        redrawn = [self._redrawn[number] for number in sorted(self._redrawn) if number not in self._dropped]
        faces = [*redrawn, *self._added]
        uses = self._edge_uses(faces)
        for face, code in self._unsettled:
            face.stitch = _settled(face, code, sum(uses[edge] == 1 for edge in face.below))
        for face in faces:
            corners = [*face.low, *face.high]
            if len(set(corners)) < len(corners):
                raise MeshError(f"{face.name}: would touch itself in a vertex; there is no room for this edit")
            self._draft.put(face.drawn())
        return self._draft.patch()

    def _edge_uses(self, faces: list[SketchFace]) -> Counter[Hashable]:
        """How many faces each edge will have."""
        uses = Counter(edge for face in faces for edge in (*face.below, *face.above, face.left, face.right))
        for edge in list(uses):
            if isinstance(edge, int):
                sides = {edge, int(self.fabric.twin[edge])} - {BORDER}
                uses[edge] += sum(int(self.fabric.side_face[side]) not in self._redrawn for side in sides)
        return uses

    def course_side(self, side: int) -> tuple[SketchFace, bool, int]:
        """The face of a course side, whether the side is on its top, and its place there from the left."""
        face = self.face(int(self.fabric.side_face[side]))
        return face, *course_place(self.fabric, side)


def face_of(fabric: StitchMesh, number: int) -> SketchFace:
    """A face of a stitch mesh as it is.

    Raises:
        ParameterError: there is no such face.
    """
    check_face(fabric, number)
    start, n_bottom = int(fabric.face_start[number]), int(fabric.n_bottom[number])
    right, left = start + n_bottom, int(fabric.face_start[number + 1]) - 1
    corners = fabric.face_vertex[start : left + 1].tolist()
    edges: list[Hashable] = [edge_of(fabric, side) for side in range(start, left + 1)]
    tops = np.arange(left - 1, right, -1)
    marks = zip(*(getattr(fabric, name)[tops].tolist() for name in Loop.__dataclass_fields__), strict=True)
    return SketchFace(
        name=f"face {number}",
        low=corners[: n_bottom + 1], high=corners[n_bottom + 1 :][::-1],
        below=edges[:n_bottom], above=edges[n_bottom + 1 : -1][::-1], left=edges[-1], right=edges[n_bottom],
        stitch=Stitch(int(fabric.stitch[number])), row=int(fabric.row[number]), yarn=int(fabric.yarn[number]),
        loops=[Loop(*mark) for mark in marks],
    )  # fmt: skip


def like(face: SketchFace, **changes: object) -> SketchFace:
    """A new face of the same row and yarn."""
    return replace(face, name=f"the face beside {face.name}", loops=[], **changes)  # type: ignore[arg-type]


def _settled(face: SketchFace, code: str | None, free: int) -> Stitch:
    """The stitch that a face takes."""
    n_bottom, n_top = len(face.below), len(face.above)
    stitch = fitting_stitch(face.stitch, n_bottom, n_top, free) if code is None else stitch_named(code)
    if stitch is None:
        sides = f"{n_bottom} bottom and {n_top} top sides"
        raise ParameterError(f"{face.name}: would have {sides}; no stitch has them, make the edit elsewhere")
    check_fit(face.name, stitch, n_bottom, n_top, free)
    return stitch
