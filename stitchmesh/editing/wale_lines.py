# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits that insert and remove a column of stitches.

A column is inserted along a wale line, which runs upwards over wale edges as long as exactly one wale edge continues
from each vertex. To open the line, a course edge replaces each of its vertices, and a stitch is added between every two
course edges. If the line ends inside the fabric, the new course edge at the end goes to the next face beyond, on the
right, so that the column begins with an increase and ends with a decrease. A column that is removed runs through
stitches each of which works the single loop of the stitch below.
"""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.editing.fitting import plain_stitch_named
from stitchmesh.editing.sides import check_face, check_side, faces_beside
from stitchmesh.editing.sketch import Sketch, SketchFace, face_like
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, BOTTOM, LEFT, RIGHT, TOP, StitchMesh
from stitchmesh.mesh.change import Change
from stitchmesh.mesh.patch_builder import edge_of
from stitchmesh.mesh.stitch import Stitch


@dataclass(frozen=True)
class _WaleEdge:
    """A wale edge with its lower and upper vertex, and the faces beside it (``BORDER`` where there is none)."""

    name: int
    low: int
    high: int
    left: int
    right: int


def insert_wale(fabric: StitchMesh, side: int, courses: int | None = None, stitch: str = "k") -> list[Change]:
    """Insert a column of stitches along the wale line of a wale edge.

    Args:
        fabric: a mesh of stitches.
        side: either side of the edge; the column extends upwards and downwards as far as the line.
        courses: number of stitches of the column, counted upwards from this edge; by default the whole line is used.
        stitch: code of the new stitches; the stitch must have one loop below and one above.

    Raises:
        ParameterError: the side is not a wale side, the faces beside the line have opposite wale directions, the line
            is shorter than ``courses``, the stitch does not fit, or no stitch fits a face at an end of the line.
        MeshError: a face would touch itself.
    """
    check_side(fabric, side, "wale")
    made = plain_stitch_named(stitch, "a column")
    sketch = Sketch(fabric)
    line, is_closed = _line(sketch, side, courses)
    opened = _OpenedLine(sketch, line, is_closed)
    for edge in line:
        opened.add_stitch(edge, made)
    return [sketch.patch()]


def _line(sketch: Sketch, side: int, courses: int | None) -> tuple[list[_WaleEdge], bool]:
    """Return the wale edges of a line from below, and whether the line is closed."""
    fabric = sketch.fabric
    edge = _wale_edge(fabric, side)
    line = [edge]
    while (courses is None or len(line) < courses) and (following := _next_edge(sketch, line[-1].high, 1)) is not None:
        if following.name == edge.name:
            return line, True
        line.append(following)
    if courses is not None and len(line) != courses:
        raise ParameterError(f"courses: got {courses}; the line has {len(line)} from {fabric.side_name(side)} on")
    while courses is None and (following := _next_edge(sketch, line[0].low, -1)) is not None:
        line.insert(0, following)
    return line, line[-1].high == line[0].low


def _wale_edge(fabric: StitchMesh, side: int) -> _WaleEdge:
    left, right = faces_beside(fabric, side)
    ends = [int(fabric.face_vertex[side]), int(fabric.face_vertex[fabric.side_next[side]])]
    low, high = ends if fabric.role_of(side) == RIGHT else ends[::-1]
    return _WaleEdge(edge_of(fabric, side), low, high, left, right)


def _next_edge(sketch: Sketch, vertex: int, step: int) -> _WaleEdge | None:
    """Return the wale edge above (1) or below (-1) a vertex; None unless exactly one edge lies on each side."""
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


class _OpenedLine:
    """A wale line whose vertices are each replaced by two vertices."""

    def __init__(self, sketch: Sketch, line: list[_WaleEdge], is_closed: bool) -> None:
        self._sketch = sketch
        self._split: dict[int, tuple[int, int]] = {}
        before = [line[-1] if is_closed else None, *line[:-1]]
        for low, edge in zip(before, line, strict=True):
            self._open(low, edge)
        if not is_closed:
            self._open(line[-1], None)

    def add_stitch(self, edge: _WaleEdge, made: Stitch) -> None:
        """Add a stitch between the two copies of a wale edge."""
        sketch = self._sketch
        beside = [sketch.face(number) for number in (edge.right, edge.left) if number != BORDER]
        opened = ("opened", edge.name)
        if edge.right != BORDER:
            beside[0].rename_edge(edge.name, opened)
        low, high = (list(dict.fromkeys(self._split[vertex])) for vertex in (edge.low, edge.high))
        kept = beside[0].stitch in (Stitch.CAST_ON, Stitch.DRAW_THROUGH)
        face = face_like(
            beside[0], low=low, high=high,
            below=[("across", edge.low)] * (len(low) - 1), above=[("across", edge.high)] * (len(high) - 1),
            left=edge.name, right=opened, stitch=beside[0].stitch if kept else made,
        )  # fmt: skip
        sketch.add(face)
        sketch.fit_stitch(face)

    def _open(self, below: _WaleEdge | None, above: _WaleEdge | None) -> None:
        """Split the vertex between two wale edges of the line, or at an end of the line."""
        sketch, fabric = self._sketch, self._sketch.fabric
        vertex = below.high if below is not None else above.low  # type: ignore[union-attr]
        sectors = [_sector(fabric, edge, at_upper_end, rightwards)
                   for edge, at_upper_end in ((below, True), (above, False)) if edge is not None
                   for rightwards in (False, True)]  # fmt: skip
        left, right = sectors[0::2], sectors[1::2]
        lines = [next((line for line in each if line.side != BORDER), None) for each in (left, right)]
        if lines == [None, None]:
            self._split[vertex] = (vertex, vertex)  # all wales end here, so the column ends in a point
            return
        pair = self._pair(vertex, lines)
        self._split[vertex] = pair
        near = [{face for sector in each for face in sector.faces} for each in (left, right)]
        if below is None or above is None:
            self._widen(vertex, pair, near, lines)
        for faces, new in zip(near, pair, strict=True):
            for number in faces:
                _replace(sketch.face(number), vertex, new)

    def _pair(self, vertex: int, lines: list[_Sector | None]) -> tuple[int, int]:
        """Add two vertices on the course line, one on each side of the old one; at a border one stays in its place."""
        sketch = self._sketch
        here = sketch.position(vertex)
        fraction = 1 / 3 if None not in lines else 1 / 2
        ends = [here if line is None else here + fraction * (sketch.position(line.end) - here) for line in lines]
        return sketch.vertex(ends[0]), sketch.vertex(ends[1])

    def _widen(
        self, vertex: int, pair: tuple[int, int], near: list[set[int]], lines: list[_Sector | None]
    ) -> None:  # fmt: skip
        """Give the new edge at an end of the line to the face beyond on the right, or on the left if there is none."""
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
        sketch.fit_stitch(face)
        for number in far - {int(fabric.side_face[side])}:
            _replace(sketch.face(number), vertex, pair[0] if on_right else pair[1])


@dataclass(frozen=True)
class _Sector:
    """The faces around a vertex between the wale line and the course line beside it."""

    faces: tuple[int, ...]
    side: int
    """Side on the course line, ``BORDER`` where there is none."""
    end: int
    """The other vertex of that side."""


def _sector(fabric: StitchMesh, edge: _WaleEdge, at_upper_end: bool, rightwards: bool) -> _Sector:
    """Turn around an end of a wale edge, away from the edge, as far as the course line."""
    face = edge.right if rightwards else edge.left
    if face == BORDER:
        return _Sector((), BORDER, BORDER)
    wale = int(fabric.left_wale[face] if rightwards else fabric.right_wale[face])
    step = fabric.side_previous if at_upper_end == rightwards else fabric.side_next
    side, faces = int(step[wale]), [face]
    while fabric.role_of(side) in (RIGHT, LEFT):
        across = int(fabric.twin[side])
        if across == BORDER or int(fabric.side_face[across]) in faces:
            return _Sector(tuple(faces), BORDER, BORDER)
        faces.append(int(fabric.side_face[across]))
        side = int(step[across])
    end = side if at_upper_end == rightwards else fabric.side_next[side]
    return _Sector(tuple(faces), side, int(fabric.face_vertex[end]))


def _replace(face: SketchFace, old: int, new: int) -> None:
    for vertices in (face.low, face.high):
        vertices[:] = [new if vertex == old else vertex for vertex in vertices]


def remove_wale(fabric: StitchMesh, face: int, courses: int | None = None) -> list[Change]:
    """Remove the column of stitches through a face.

    The column extends as long as each stitch works the single loop of another stitch. If the column begins or ends
    inside the fabric, the adjacent faces there lose one loop.

    Args:
        fabric: a mesh of stitches.
        face: a face of the column; the column extends upwards and downwards from here.
        courses: number of stitches to remove, counted upwards from this face; by default the whole column is removed.

    Raises:
        ParameterError: the face does not exist or does not make one loop of one, the column is shorter than
            ``courses``, or no stitch fits a face at an end of the column.
        MeshError: the column joins two borders, or a face would touch itself.
    """
    check_face(fabric, face)
    column, is_closed = _column(fabric, face, courses)
    sketch = Sketch(fabric)
    removed = [sketch.drop(number) for number in column]
    for number, stitch in zip(column, removed, strict=True):
        _close_wale(sketch, number, stitch, column)
    first, last = int(fabric.face_start[column[0]]), int(fabric.right_wale[column[-1]]) + 1
    edges_below, edges_above = ([], []) if is_closed else (removed[0].below, removed[-1].above)
    ends = [(first, edge) for edge in edges_below] + [(last, edge) for edge in edges_above]
    beyond = [(_across(sketch, side), edge) for side, edge in ends]
    for chain in [*(stitch.low for stitch in removed), *([] if is_closed else [removed[-1].high])]:
        if len(chain) == 2:
            sketch.merge(*chain)
    for outer, edge in beyond:
        if outer is not None:
            on_top = edge in outer.above
            outer.close(on_top, outer.chain(on_top)[1].index(edge))
            sketch.fit_stitch(outer)
    return [sketch.patch()]


def _column(fabric: StitchMesh, face: int, courses: int | None) -> tuple[list[int], bool]:
    """Return the faces of a column from below, and whether the column is a ring."""
    if fabric.n_bottom[face] > 1 or fabric.n_top[face] > 1:
        raise ParameterError(f"face {face}: does not make one loop of one; expected a face of a plain column")
    column = [face]
    while (courses is None or len(column) < courses) and (following := _stacked(fabric, column[-1], 1)) != BORDER:
        if following == face:
            return column, True
        column.append(following)
    if courses is not None and len(column) != courses:
        raise ParameterError(f"courses: got {courses}; the column runs over {len(column)} from face {face}")
    while courses is None and (following := _stacked(fabric, column[0], -1)) != BORDER:
        column.insert(0, following)
    return column, _stacked(fabric, column[-1], 1) == column[0]


def _stacked(fabric: StitchMesh, face: int, step: int) -> int:
    """Return the face above (1) or below (-1) that shares the single loop of a face; ``BORDER`` if there is none."""
    if (fabric.n_top if step > 0 else fabric.n_bottom)[face] == 0:
        return BORDER
    side = int(fabric.right_wale[face]) + 1 if step > 0 else int(fabric.face_start[face])
    across = int(fabric.twin[side])
    if across == BORDER or fabric.role_of(across) != (BOTTOM if step > 0 else TOP):
        return BORDER
    other = int(fabric.side_face[across])
    return BORDER if fabric.n_bottom[other] > 1 or fabric.n_top[other] > 1 else other


def _close_wale(sketch: Sketch, number: int, stitch: SketchFace, column: list[int]) -> None:
    """Make the left and right neighbours of a removed stitch neighbours of one another."""
    fabric = sketch.fabric
    across, on_left = int(fabric.twin[fabric.right_wale[number]]), int(fabric.twin[fabric.left_wale[number]])
    if across == on_left == BORDER:
        raise ParameterError(f"{stitch.name}: is all of its row; without it the fabric would fall apart")
    if across == BORDER:
        return
    right = int(fabric.side_face[across])
    if right in column:
        raise ParameterError(f"{stitch.name}: has its column on both sides; no face could close the gap")
    sketch.face(right).rename_edge(stitch.right, stitch.left)


def _across(sketch: Sketch, side: int) -> SketchFace | None:
    """Return the face across a side for the edit to change; None at a border."""
    across = int(sketch.fabric.twin[side])
    return None if across == BORDER else sketch.face(int(sketch.fabric.side_face[across]))
