# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces during an edit, as chains of vertices and edges from left to right.

A ``Sketch`` removes a face from the mesh when the edit first asks for the face, so that it can add the changed face in
its place. It adds removed faces again in the order of their numbers; if no face is dropped, all faces keep their
numbers.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.editing.fitting import check_fit, fitting_stitch
from stitchmesh.editing.sides import VertexCorners, check_face, course_place
from stitchmesh.errors import MeshError, ParameterError
from stitchmesh.hand_knitting.words import stitch_named
from stitchmesh.mesh import BORDER, PER_SIDE, FloatArray, StitchMesh
from stitchmesh.mesh.change import Patch
from stitchmesh.mesh.own_stitch import FIRST_OWN
from stitchmesh.mesh.patch_builder import NewFace, PatchBuilder, edge_of
from stitchmesh.mesh.shaping_stitches import closing_half_turns
from stitchmesh.mesh.stitch import VOCABULARY, Stitch


@dataclass(frozen=True)
class SketchedLoop:
    """Marks of the loop at a top side, as in ``StitchMesh``."""

    twist: int = 0
    cable_shift: int = 0
    cable_layer: int = 0
    is_yarn_over: bool = False
    """Whether the loop was a yarn-over before the edit."""


@dataclass(eq=False)
class SketchFace:
    """A stitch face that an edit changes; all lists run from left to right."""

    name: str
    """Name of the face in messages."""
    low: list[int]
    """Vertices along the bottom, one more than the bottom sides."""
    high: list[int]
    """Vertices along the top, one more than the top sides."""
    below: list[Hashable]
    """Names of the bottom edges."""
    above: list[Hashable]
    """Names of the top edges."""
    left: Hashable
    """Name of the left wale edge."""
    right: Hashable
    """Name of the right wale edge."""
    stitch: int
    """Type code of the stitch."""
    row: int
    yarn: int
    loops: list[SketchedLoop] = field(default_factory=list)
    """Marks of the loops at the top sides; no marks by default."""

    def __post_init__(self) -> None:
        self.loops = self.loops or [SketchedLoop() for _ in self.above]

    def chain(self, on_top: bool) -> tuple[list[int], list[Hashable]]:
        """Return the vertices and edges of the top or of the bottom."""
        return (self.high, self.above) if on_top else (self.low, self.below)

    def insert(self, on_top: bool, side: int, vertex: int, edges: tuple[Hashable, Hashable]) -> None:
        """Divide a course side at a vertex into two edges; at the top, both new loops take the twist of the old one."""
        vertices, names = self.chain(on_top)
        vertices.insert(side + 1, vertex)
        names[side : side + 1] = edges
        if on_top:
            self.loops[side : side + 1] = [replace(self.loops[side], cable_shift=0, cable_layer=0)] * 2

    def widen(self, on_top: bool, place: int, vertices: tuple[int, int], edge: Hashable) -> None:
        """Replace one vertex of the top or bottom by two vertices, with a new course side between them."""
        line, names = self.chain(on_top)
        line[place : place + 1] = vertices
        names.insert(place, edge)
        if on_top:
            self.loops.insert(place, SketchedLoop())

    def close(self, on_top: bool, side: int) -> None:
        """Remove a course side whose two ends are the same vertex."""
        vertices, names = self.chain(on_top)
        del vertices[side + 1], names[side]
        if on_top:
            del self.loops[side]

    def rename_edge(self, old: Hashable, new: Hashable) -> None:
        """Rename an edge wherever it occurs in the face."""
        for names in (self.below, self.above):
            names[:] = [new if name == old else name for name in names]
        self.left, self.right = (new if name == old else name for name in (self.left, self.right))

    def turn(self) -> None:
        """Turn the face by half a turn, so that its bottom becomes its top; the marks of its loops are lost."""
        self.low, self.high = self.high[::-1], self.low[::-1]
        self.below, self.above = self.above[::-1], self.below[::-1]
        self.left, self.right = self.right, self.left
        self.loops = [SketchedLoop() for _ in self.above]

    def new_face(self) -> NewFace:
        """Return the face in the form that the patch adds."""
        return NewFace(
            corners=[*self.low, *self.high[::-1]],
            edges=[*self.below, self.right, *self.above[::-1], self.left],
            n_bottom=len(self.below), n_top=len(self.above), stitch=self.stitch, row=self.row, yarn=self.yarn,
            **{name: [getattr(loop, name) for loop in self.loops] for name in PER_SIDE},
        )  # fmt: skip


class Sketch:
    """A patch under construction, from changed, dropped and added faces."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Start with a stitch mesh; the mesh is never modified."""
        self.fabric = fabric
        self._builder = PatchBuilder(fabric)
        self._positions: list[FloatArray] = []
        self._changed: dict[int, SketchFace] = {}
        self._dropped: set[int] = set()
        self._added: list[SketchFace] = []
        self._stitches_to_fit: list[tuple[SketchFace, str | None]] = []

    @cached_property
    def corners(self) -> VertexCorners:
        """The corners around the vertices of the mesh."""
        return VertexCorners(self.fabric)

    def face(self, number: int) -> SketchFace:
        """Return a face of the mesh for the edit to change.

        Raises:
            ParameterError: the face does not exist.
        """
        if number not in self._changed:
            self._changed[number] = face_of(self.fabric, number)
            self._builder.remove(number)
        return self._changed[number]

    def drop(self, number: int) -> SketchFace:
        """Remove a face for good, and return the face."""
        self._dropped.add(number)
        return self.face(number)

    def add(self, face: SketchFace) -> None:
        """Add a new face."""
        self._added.append(face)

    def vertex(self, position: ArrayLike) -> int:
        """Add a vertex at a position [cm], shape (3,); return its number."""
        self._positions.append(np.asarray(position, dtype=np.float64))
        return self._builder.vertex(self._positions[-1])

    def position(self, vertex: int) -> FloatArray:
        """Return the position of an old or new vertex [cm], shape (3,)."""
        count = len(self.fabric.vertices)
        place: FloatArray = self.fabric.vertices[vertex] if vertex < count else self._positions[vertex - count]
        return place

    def faces_around(self, vertices: Sequence[int]) -> list[int]:
        """Return the faces of the mesh at some vertices, without dropped faces."""
        corners = [corner for vertex in vertices for corner in self.corners.around(vertex)]
        return sorted({int(face) for face in self.fabric.side_face[corners]} - self._dropped)

    def merge(self, first: int, second: int, prefer: int | None = None) -> int:
        """Merge the two ends of an edge to one vertex in all faces around them; return the number of that vertex.

        If only one end lies on a border, that end stays. Otherwise the preferred end stays. Without a preferred end,
        the end at which wale edges meet stays if there are wale edges at one end only; otherwise a new vertex is added
        half way between the two ends.

        Args:
            first: one end of the edge.
            second: the other end of the edge.
            prefer: the preferred end.
        """
        keep = self._merged_vertex(first, second, prefer)
        old = {first, second} - {keep}
        for number in self.faces_around(sorted(old)):
            face = self.face(number)
            for vertices in (face.low, face.high):
                vertices[:] = [keep if vertex in old else vertex for vertex in vertices]
        return keep

    def _merged_vertex(self, first: int, second: int, prefer: int | None) -> int:
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

    def fit_stitch(self, face: SketchFace, code: str | None = None) -> None:
        """Choose the stitch of a face when the patch is made: by its code, or the one most like the old stitch.

        The choice waits for the patch because it depends on the final sides of the face.
        """
        self._stitches_to_fit.append((face, code))

    def patch(self) -> Patch:
        """Return the patch.

        Raises:
            ParameterError: no stitch fits a face, or the chosen stitch does not fit.
            MeshError: a face would contain a vertex twice.
        """
        changed = [self._changed[number] for number in sorted(self._changed) if number not in self._dropped]
        faces = [*changed, *self._added]
        uses = self._edge_uses(faces)
        for face, code in self._stitches_to_fit:
            face.stitch = _fitted_stitch(face, code, sum(uses[edge] == 1 for edge in face.below))
            face.loops = _fitted_loops(face, closes=code is None)
        for face in faces:
            corners = [*face.low, *face.high]
            if len(set(corners)) < len(corners):
                raise MeshError(f"{face.name}: would touch itself in a vertex; there is no space for this edit")
            self._builder.put(face.new_face())
        return self._builder.patch()

    def _edge_uses(self, faces: list[SketchFace]) -> Counter[Hashable]:
        """Return the number of faces that will have each edge."""
        uses = Counter(edge for face in faces for edge in (*face.below, *face.above, face.left, face.right))
        for edge in list(uses):
            if isinstance(edge, int):
                sides = {edge, int(self.fabric.twin[edge])} - {BORDER}
                uses[edge] += sum(int(self.fabric.side_face[side]) not in self._changed for side in sides)
        return uses

    def course_side(self, side: int) -> tuple[SketchFace, bool, int]:
        """Return the face of a course side, whether the side is on its top, and the place there from the left."""
        face = self.face(int(self.fabric.side_face[side]))
        return face, *course_place(self.fabric, side)


def face_of(fabric: StitchMesh, number: int) -> SketchFace:
    """Return an unchanged face of a stitch mesh.

    Raises:
        ParameterError: the face does not exist.
    """
    check_face(fabric, number)
    start, n_bottom = int(fabric.face_start[number]), int(fabric.n_bottom[number])
    right, left = start + n_bottom, int(fabric.face_start[number + 1]) - 1
    corners = fabric.face_vertex[start : left + 1].tolist()
    edges: list[Hashable] = [edge_of(fabric, side) for side in range(start, left + 1)]
    tops = np.arange(left - 1, right, -1)
    marks = zip(*(getattr(fabric, name)[tops].tolist() for name in PER_SIDE), _is_over(fabric, number), strict=True)
    return SketchFace(
        name=f"face {number}",
        low=corners[: n_bottom + 1], high=corners[n_bottom + 1 :][::-1],
        below=edges[:n_bottom], above=edges[n_bottom + 1 : -1][::-1], left=edges[-1], right=edges[n_bottom],
        stitch=int(fabric.stitch[number]), row=int(fabric.row[number]), yarn=int(fabric.yarn[number]),
        loops=[SketchedLoop(*mark) for mark in marks],
    )  # fmt: skip


def _is_over(fabric: StitchMesh, number: int) -> list[bool]:
    """Return whether each loop on top of a face is a yarn-over, from left to right."""
    making = fabric.makings.get(int(fabric.stitch[number]))
    return [making is not None and making.made[loop] == "y" for loop in range(fabric.n_top[number])]


def face_like(face: SketchFace, **changes: object) -> SketchFace:
    """Return a new face that equals another except for the given fields, and without marks of loops."""
    return replace(face, name=f"the face beside {face.name}", loops=[], **changes)  # type: ignore[arg-type]


def _fitted_stitch(face: SketchFace, code: str | None, free: int) -> Stitch:
    """Return the new stitch of a face; ``free`` is the number of its bottom edges on the border."""
    n_bottom, n_top = len(face.below), len(face.above)
    old = Stitch(face.stitch) if face.stitch < FIRST_OWN else Stitch.KNIT
    stitch = fitting_stitch(old, n_bottom, n_top, free) if code is None else stitch_named(code)
    if stitch is None:
        sides = f"{n_bottom} bottom and {n_top} top sides"
        raise ParameterError(f"{face.name}: would have {sides}; no stitch has these, make the edit elsewhere")
    check_fit(face.name, stitch, n_bottom, n_top, free)
    return stitch


def _fitted_loops(face: SketchFace, *, closes: bool) -> list[SketchedLoop]:
    """Return the loops of a face that has its new stitch, from left to right.

    A yarn-over that becomes another loop loses its half turn. A loop that becomes a yarn-over of an increase is a made
    one if the edit chose the stitch (``closes``), and a plain yarn-over if the user named the stitch.
    """
    if face.stitch not in VOCABULARY:
        return face.loops
    made, turns = VOCABULARY[Stitch(face.stitch)].made, closing_half_turns(Stitch(face.stitch))
    fitted = []
    for loop, letter, turn in zip(face.loops, made, turns, strict=True):
        is_over = letter == "y"
        changes = is_over != loop.is_yarn_over and (closes or not is_over) and (turn or not is_over)
        fitted.append(replace(loop, twist=turn) if changes else loop)
    return fitted
