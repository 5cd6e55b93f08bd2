# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Insert a column of stitches along a wale line.

A wale line runs upwards over wale edges while exactly one goes on from each vertex. Opening it makes an edge of each
of its vertices and a stitch between every two. Where it ends inside the fabric, the new edge goes to the face beyond
on the right: the column begins in an increase and ends in a decrease.
"""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.editing.fitting import plain_stitch_named
from stitchmesh.editing.sides import check_side, faces_beside
from stitchmesh.editing.sketch import Sketch, SketchFace, like
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, LEFT, RIGHT, StitchMesh
from stitchmesh.mesh.change import Change
from stitchmesh.mesh.patch_builder import edge_of
from stitchmesh.mesh.stitch import Stitch


@dataclass(frozen=True)
class _WaleEdge:
    """A wale edge and the faces beside it, ``BORDER`` where there is none."""

    name: int
    foot: int
    head: int
    left: int
    right: int


def insert_wale(fabric: StitchMesh, side: int, courses: int | None = None, stitch: str = "k") -> list[Change]:
    """Insert a column of stitches along the wale line of a wale edge.

    Args:
        fabric: stitch faces.
        side: either side of the edge; the column runs both ways as far as the line goes.
        courses: stitches of the column, counted upwards from this edge; where not given the whole line.
        stitch: code of the new stitches, one of one loop on one loop.

    Raises:
        ParameterError: the side is no wale side, the faces beside the line run opposite ways, the line is shorter
            than ``courses``, the stitch does not fit, or a face at an end has no room for one loop more.
        MeshError: a face would touch itself.
    """
    check_side(fabric, side, "wale")
    made = plain_stitch_named(stitch, "a column")
    sketch = Sketch(fabric)
    line, is_closed = _line(sketch, side, courses)
    opened = _Opening(sketch, line, is_closed)
    for edge in line:
        opened.put_between(edge, made)
    return [sketch.patch()]


def _line(sketch: Sketch, side: int, courses: int | None) -> tuple[list[_WaleEdge], bool]:
    """Wale edges of a line upwards, and whether it closes."""
    fabric = sketch.fabric
    edge = _wale_edge(fabric, side)
    line = [edge]
    while (courses is None or len(line) < courses) and (onwards := _onwards(sketch, line[-1].head, 1)) is not None:
        if onwards.name == edge.name:
            return line, True
        line.append(onwards)
    if courses is not None and len(line) != courses:
        raise ParameterError(f"courses: got {courses}; the line has {len(line)} from {fabric.side_name(side)} on")
    while courses is None and (onwards := _onwards(sketch, line[0].foot, -1)) is not None:
        line.insert(0, onwards)
    return line, line[-1].head == line[0].foot


def _wale_edge(fabric: StitchMesh, side: int) -> _WaleEdge:
    left, right = faces_beside(fabric, side)
    ends = [int(fabric.face_vertex[side]), int(fabric.face_vertex[fabric.side_next[side]])]
    foot, head = ends if fabric.role_of(side) == RIGHT else ends[::-1]
    return _WaleEdge(edge_of(fabric, side), foot, head, left, right)


def _onwards(sketch: Sketch, vertex: int, step: int) -> _WaleEdge | None:
    """The wale edge upwards (1) or downwards (-1) of a vertex, where just one leads up to it and just one on."""
    fabric = sketch.fabric
    up: dict[int, int] = {}
    down: dict[int, int] = {}
    for corner in sketch.corners.around(vertex):
        before = int(fabric.side_previous[corner])
        for side, found in ((corner, {RIGHT: up, LEFT: down}), (before, {RIGHT: down, LEFT: up})):
            role = fabric.role_of(side)
            if role in found:
                found[role][edge_of(fabric, side)] = side
    if len(up) != 1 or len(down) != 1:
        return None
    return _wale_edge(fabric, *(up if step > 0 else down).values())


class _Opening:
    """A wale line while it is opened: two vertices for each of its own."""

    def __init__(self, sketch: Sketch, line: list[_WaleEdge], is_closed: bool) -> None:
        self._sketch = sketch
        self._split: dict[int, tuple[int, int]] = {}
        before = [line[-1] if is_closed else None, *line[:-1]]
        for low, edge in zip(before, line, strict=True):
            self._open(low, edge)
        if not is_closed:
            self._open(line[-1], None)

    def put_between(self, edge: _WaleEdge, made: Stitch) -> None:
        """Put a stitch between the two copies of a wale edge."""
        sketch = self._sketch
        beside = [sketch.face(number) for number in (edge.right, edge.left) if number != BORDER]
        opened = ("opened", edge.name)
        if edge.right != BORDER:
            beside[0].rename_edge(edge.name, opened)
        low, high = (list(dict.fromkeys(self._split[vertex])) for vertex in (edge.foot, edge.head))
        kept = beside[0].stitch in (Stitch.CAST_ON, Stitch.DRAW_THROUGH)
        face = like(
            beside[0], low=low, high=high,
            below=[("across", edge.foot)] * (len(low) - 1), above=[("across", edge.head)] * (len(high) - 1),
            left=edge.name, right=opened, stitch=beside[0].stitch if kept else made,
        )  # fmt: skip
        sketch.add(face)
        sketch.settle(face)

    def _open(self, below: _WaleEdge | None, above: _WaleEdge | None) -> None:
        """Split the vertex between two wale edges of the line, or at an end of it."""
        sketch, fabric = self._sketch, self._sketch.fabric
        vertex = below.head if below is not None else above.foot  # type: ignore[union-attr]
        sides = [_turn(fabric, edge, is_head, rightwards)
                 for edge, is_head in ((below, True), (above, False)) if edge is not None
                 for rightwards in (False, True)]  # fmt: skip
        left, right = sides[0::2], sides[1::2]
        lines = [next((line for line in each if line.side != BORDER), None) for each in (left, right)]
        if lines == [None, None]:
            self._split[vertex] = (vertex, vertex)  # all wales end here: the column runs to a point
            return
        pair = self._pair(vertex, lines)
        self._split[vertex] = pair
        near = [{face for turn in each for face in turn.faces} for each in (left, right)]
        if below is None or above is None:
            self._widen(vertex, pair, near, lines)
        for faces, new in zip(near, pair, strict=True):
            for number in faces:
                _replace(sketch.face(number), vertex, new)

    def _pair(self, vertex: int, lines: list[_Turn | None]) -> tuple[int, int]:
        """Two vertices on the course line, a third of the way to the next vertices; one stays on a border."""
        sketch = self._sketch
        here = sketch.position(vertex)
        share = 1 / 3 if None not in lines else 1 / 2
        ends = [here if line is None else here + share * (sketch.position(line.end) - here) for line in lines]
        return sketch.vertex(ends[0]), sketch.vertex(ends[1])

    def _widen(
        self, vertex: int, pair: tuple[int, int], near: list[set[int]], lines: list[_Turn | None]
    ) -> None:  # fmt: skip
        """Give the new edge at an end of the line to the face beyond on the right, if there is none on the left."""
        sketch, fabric = self._sketch, self._sketch.fabric
        far = set(sketch.faces_around([vertex])) - near[0] - near[1]
        across = [BORDER if line is None else int(fabric.twin[line.side]) for line in lines]
        on_right = across[1] != BORDER
        side = across[1] if on_right else across[0]
        if side == BORDER:
            return
        face, on_top, place = sketch.course_side(side)
        vertices, _ = face.chain(on_top)
        first = vertices[place] == vertex
        order = pair if first == on_right else pair[::-1]
        face.widen(on_top, place if first else place + 1, order, ("across", vertex))
        sketch.settle(face)
        for number in far - {int(fabric.side_face[side])}:
            _replace(sketch.face(number), vertex, pair[0] if on_right else pair[1])


@dataclass(frozen=True)
class _Turn:
    """What lies around a vertex between the wale line and the course line beside it."""

    faces: tuple[int, ...]
    side: int
    """Side on the course line, ``BORDER`` where there is none."""
    end: int
    """The other vertex of that side."""


def _turn(fabric: StitchMesh, edge: _WaleEdge, is_head: bool, rightwards: bool) -> _Turn:
    """Turn around the head or the foot of a wale edge, away from it, up to the course line."""
    face = edge.right if rightwards else edge.left
    if face == BORDER:
        return _Turn((), BORDER, BORDER)
    wale = int(fabric.left_wale[face] if rightwards else fabric.right_wale[face])
    step = fabric.side_previous if is_head == rightwards else fabric.side_next
    side, faces = int(step[wale]), [face]
    while fabric.role_of(side) in (RIGHT, LEFT):
        across = int(fabric.twin[side])
        if across == BORDER or int(fabric.side_face[across]) in faces:
            return _Turn(tuple(faces), BORDER, BORDER)
        faces.append(int(fabric.side_face[across]))
        side = int(step[across])
    end = side if is_head == rightwards else fabric.side_next[side]
    return _Turn(tuple(faces), side, int(fabric.face_vertex[end]))


def _replace(face: SketchFace, old: int, new: int) -> None:
    for vertices in (face.low, face.high):
        vertices[:] = [new if vertex == old else vertex for vertex in vertices]
