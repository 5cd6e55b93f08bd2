# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits of single wale and course edges (Yuksel et al. 2012, section 5.3 and figure 13).

A wale edge divides the loops of a row between two stitches. If it is added, removed or shifted, the course lines above
and below stay unchanged. A course edge is a loop. A split adds one loop to the face below, which makes the loop, and to
the face above, which works the loop. At a border only one face changes.
"""

from __future__ import annotations

from stitchmesh.editing.sides import check_face, check_side, faces_beside
from stitchmesh.editing.sketch import Sketch, SketchFace, face_like
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.change import Change
from stitchmesh.mesh.stitch import CODES, VOCABULARY, Stitch


def add_wale_edge(
    fabric: StitchMesh, face: int, below: int, above: int,
    stitch_left: str | None = None, stitch_right: str | None = None,
) -> list[Change]:  # fmt: skip
    """Divide a face into two adjacent faces of its row.

    Args:
        fabric: a mesh of stitches.
        face: the face.
        below: number of bottom sides of the left part; the right part gets the others.
        above: number of top sides of the left part; the right part gets the others.
        stitch_left: code of the stitch of the left part; by default a stitch like the old one.
        stitch_right: code of the stitch of the right part; by default a stitch like the old one.

    Raises:
        ParameterError: the face does not exist or has fewer sides, or no stitch fits a part.
    """
    check_face(fabric, face)
    sketch = Sketch(fabric)
    left = sketch.face(face)
    for name, count, sides in (("below", below, left.below), ("above", above, left.above)):
        if not 0 <= count <= len(sides):
            raise ParameterError(f"{name}: got {count}; face {face} has {len(sides)} such sides")
    right = face_like(
        left, low=left.low[below:], high=left.high[above:], below=left.below[below:], above=left.above[above:],
        left="new wale",
    )  # fmt: skip
    right.loops = left.loops[above:]
    del left.low[below + 1 :], left.high[above + 1 :], left.below[below:], left.above[above:], left.loops[above:]
    left.right = "new wale"
    sketch.add(right)
    sketch.fit_stitch(left, stitch_left)
    sketch.fit_stitch(right, stitch_right)
    return [sketch.patch()]


def remove_wale_edge(fabric: StitchMesh, side: int, stitch: str | None = None) -> list[Change]:
    """Join the two faces beside a wale edge to one face.

    The new stitch makes its loops as the two old stitches did, if such a stitch exists.

    Args:
        fabric: a mesh of stitches.
        side: either side of the edge.
        stitch: code of the new stitch; by default the stitch is chosen from the two old ones.

    Raises:
        ParameterError: the side is not a wale side, the face across does not exist or has the opposite wale direction,
            or no stitch fits.
    """
    sketch = Sketch(fabric)
    left, right, right_number = _beside(sketch, side)
    sketch.drop(right_number)
    code = stitch or _combined_code(left, right)
    left.low += right.low[1:]
    left.high += right.high[1:]
    left.below += right.below
    left.above += right.above
    left.loops += right.loops
    left.right = right.right
    left.stitch = left.stitch if len(left.below) > len(right.below) else right.stitch
    sketch.fit_stitch(left, code)
    return [sketch.patch()]


def shift_wale_edge(
    fabric: StitchMesh, side: int, end: str, direction: str,
    stitch_left: str | None = None, stitch_right: str | None = None,
) -> list[Change]:  # fmt: skip
    """Move one end of a wale edge by one vertex along its course line, so that one loop changes to the adjacent stitch.

    Args:
        fabric: a mesh of stitches.
        side: either side of the edge.
        end: ``"top"`` or ``"bottom"``, the end that moves.
        direction: ``"left"`` or ``"right"``.
        stitch_left: code of the stitch of the left face; by default a stitch like the old one.
        stitch_right: code of the stitch of the right face; by default a stitch like the old one.

    Raises:
        ParameterError: the side is not a wale side, the face across does not exist or has the opposite wale direction,
            the end or the direction is unknown, or no stitch fits a face.
    """
    _check_word("end", end, ("top", "bottom"))
    _check_word("direction", direction, ("left", "right"))
    sketch = Sketch(fabric)
    left, right, _ = _beside(sketch, side)
    on_top, rightwards = end == "top", direction == "right"
    donor = right if rightwards else left
    if not donor.chain(on_top)[1]:
        raise ParameterError(f"{donor.name}: has no {end} side to give up; shift the edge in the other direction")
    line, edges, border = _joined(left, right, on_top)
    border += 1 if rightwards else -1
    for face, first, last in ((left, 0, border), (right, border, len(edges))):
        vertices, names = face.chain(on_top)
        vertices[:], names[:] = line[first : last + 1], edges[first:last]
    if on_top:
        loops = left.loops + right.loops
        left.loops, right.loops = loops[:border], loops[border:]
    sketch.fit_stitch(left, stitch_left)
    sketch.fit_stitch(right, stitch_right)
    return [sketch.patch()]


def _beside(sketch: Sketch, side: int) -> tuple[SketchFace, SketchFace, int]:
    """Return the faces to the left and right of a wale edge, and the number of the right one."""
    check_side(sketch.fabric, side, "wale")
    left, right = faces_beside(sketch.fabric, side)
    if BORDER in (left, right):
        name = sketch.fabric.side_name(side)
        raise ParameterError(f"{name}: lies on the border; expected a wale edge between two faces")
    return sketch.face(left), sketch.face(right), right


def _joined(left: SketchFace, right: SketchFace, on_top: bool) -> tuple[list[int], list, int]:
    """Return the vertices and edges along both faces, and the place of the vertex between the faces."""
    (first, first_edges), (second, second_edges) = left.chain(on_top), right.chain(on_top)
    return [*first, *second[1:]], [*first_edges, *second_edges], len(first_edges)


def _combined_code(left: SketchFace, right: SketchFace) -> str | None:
    """Return the code of the stitch that makes the loops of two stitches; None if there is no such stitch."""
    if left.stitch not in VOCABULARY or right.stitch not in VOCABULARY:
        return None
    first, second = VOCABULARY[Stitch(left.stitch)], VOCABULARY[Stitch(right.stitch)]
    code = first.made + second.made
    return code if code in CODES and first.n_bottom + second.n_bottom == VOCABULARY[CODES[code]].n_bottom else None


def _check_word(name: str, word: str, known: tuple[str, str]) -> None:
    if word not in known:
        raise ParameterError(f"{name}: got {word!r}; expected {known[0]} or {known[1]}")


def split_course_edge(
    fabric: StitchMesh, side: int, stitch_below: str | None = None, stitch_above: str | None = None
) -> list[Change]:
    """Split a course edge into two edges, with a new vertex in its middle.

    Args:
        fabric: a mesh of stitches.
        side: either side of the edge.
        stitch_below: code of the new stitch of the face below the edge; by default a stitch like the old one.
        stitch_above: code of the new stitch of the face above the edge; by default a stitch like the old one.

    Raises:
        ParameterError: the side is not a course side or is part of a cable, or no stitch fits a face.
    """
    check_side(fabric, side, "course")
    sketch = Sketch(fabric)
    places = _places(sketch, side)
    vertices, _ = places[0][0].chain(places[0][1])
    ends = vertices[places[0][2] : places[0][2] + 2]
    middle = sketch.vertex(0.5 * (sketch.position(ends[0]) + sketch.position(ends[1])))
    for face, on_top, place in places:
        _check_uncrossed(face, on_top, place)
        left, right = face.chain(on_top)[0][place : place + 2]
        face.insert(on_top, place, middle, (("half", left), ("half", right)))
        sketch.fit_stitch(face, stitch_below if on_top else stitch_above)
    return [sketch.patch()]


def collapse_course_edge(
    fabric: StitchMesh, side: int, stitch_below: str | None = None, stitch_above: str | None = None
) -> list[Change]:
    """Collapse a course edge to one vertex; this reverses a split.

    Args:
        fabric: a mesh of stitches.
        side: either side of the edge.
        stitch_below: code of the new stitch of the face below the edge; by default a stitch like the old one.
        stitch_above: code of the new stitch of the face above the edge; by default a stitch like the old one.

    Raises:
        ParameterError: the side is not a course side or is part of a cable, or no stitch fits a face.
        MeshError: the edge joins two borders, or a face would touch itself.
    """
    check_side(fabric, side, "course")
    sketch = Sketch(fabric)
    places = _places(sketch, side)
    face, on_top, place = places[0]
    first, second = face.chain(on_top)[0][place : place + 2]
    for face, on_top, place in places:
        _check_uncrossed(face, on_top, place)
        sketch.fit_stitch(face, stitch_below if on_top else stitch_above)
    sketch.merge(first, second)
    for face, on_top, place in places:
        face.close(on_top, place)
    return [sketch.patch()]


def _places(sketch: Sketch, side: int) -> list[tuple[SketchFace, bool, int]]:
    """Return the faces of a course edge; for each, whether the edge is on its top, and its place from the left."""
    sides = [side, int(sketch.fabric.twin[side])]
    return [sketch.course_side(side) for side in sides if side != BORDER]


def _check_uncrossed(face: SketchFace, on_top: bool, place: int) -> None:
    if on_top and face.loops[place].cable_shift:
        raise ParameterError(f"{face.name}: its loop is part of a cable; clear the cable first")
