# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits that split and collapse course edges (Yuksel et al. 2012, section 5.3 and figure 13).

A course edge is a loop. A split adds one loop to the face below, which makes the loop, and to the face above, which
works the loop. At a border only one face changes.
"""

from __future__ import annotations

from stitchmesh.editing.sides import check_side
from stitchmesh.editing.sketch import Sketch, SketchFace
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.change import Change


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
