# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whole rows: turn over, insert, remove (Yuksel et al. 2012, sections 4.4 and 5.1)."""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np
from numpy.typing import NDArray

from stitchmesh.editing.fitting import plain_stitch_named
from stitchmesh.editing.sides import check_face
from stitchmesh.editing.sketch import Sketch, SketchFace, like
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.change import Change, Marks, apply_change
from stitchmesh.mesh.courses import Course, course_through
from stitchmesh.mesh.stitch import Stitch


def flip_row(fabric: StitchMesh, face: int) -> list[Change]:
    """Turn the wale direction of a row over: bottom sides become top sides.

    Increases become decreases, and the row's edges are mismatched to rows that stay. Twists and cables on its loops
    are lost, as its loops are.

    Args:
        fabric: stitch faces.
        face: any face of the row.

    Raises:
        ParameterError: there is no such face, or a face has no stitch the other way up.
    """
    check_face(fabric, face)
    sketch = Sketch(fabric)
    for number in course_through(fabric, face, climbing=True).faces:
        turned = sketch.face(number)
        turned.turn()
        sketch.settle(turned)
    return [sketch.patch()]


def insert_row(fabric: StitchMesh, face: int, stitch: str = "k") -> list[Change]:
    """Insert a row above a row: its wale edges are divided in the middle, and each of its loops gets a stitch on it.

    Twists and cables stay with the loops of the lower row. Rows above are numbered on.

    Args:
        fabric: stitch faces.
        face: any face of the lower row.
        stitch: code of the new stitches, one of one loop on one loop.

    Raises:
        ParameterError: there is no such face, the stitch does not fit, the row climbs in a spiral, or its yarn is
            drawn through at its top.
    """
    check_face(fabric, face)
    made = plain_stitch_named(stitch, "a new row")
    whole = course_through(fabric, face, climbing=True)
    row = _only_row(fabric, whole)
    numbered, fabric = _numbered(fabric, fabric.row > row, 1)
    sketch = Sketch(fabric)
    faces = [sketch.face(number) for number in whole.faces]
    ended = next((lower for lower in faces if not lower.above), None)
    if ended is not None:
        raise ParameterError(f"{ended.name}: its row ends here, it has no loops to knit on")
    middles = _middles(sketch, faces)
    for lower in faces:
        _knit_above(sketch, lower, middles, made, row + 1)
    return [*numbered, sketch.patch()]


def remove_row(fabric: StitchMesh, face: int) -> list[Change]:
    """Take out a row of stitches of one loop on one loop; the row above works the loops of the row below.

    Args:
        fabric: stitch faces.
        face: any face of the row.

    Raises:
        ParameterError: there is no such face, the row is a first row, climbs in a spiral, or has an increase, a
            decrease or another stitch that is not one loop on one.
        MeshError: a face would touch itself.
    """
    check_face(fabric, face)
    whole = course_through(fabric, face, climbing=True)
    row = _only_row(fabric, whole)
    alone = np.count_nonzero(fabric.row == row) == len(whole.faces)
    numbered, fabric = _numbered(fabric, (fabric.row > row) & alone, -1)
    sketch = Sketch(fabric)
    faces = [sketch.drop(number) for number in whole.faces]
    for number, gone in zip(whole.faces, faces, strict=True):
        if (len(gone.below), len(gone.above)) != (1, 1):
            raise ParameterError(f"{gone.name}: does not make one loop of one; change it first to remove its row")
        if fabric.twin[fabric.face_start[number]] == BORDER:
            raise ParameterError(f"{gone.name}: stands on the border; the first row holds all others, keep it")
    for number, gone in zip(whole.faces, faces, strict=True):
        below = sketch.face(int(fabric.side_face[fabric.twin[fabric.face_start[number]]]))
        below.rename_edge(gone.below[0], gone.above[0])
    wales = [(gone.low[0], gone.high[0]) for gone in faces]
    if not whole.closed:
        wales.append((faces[-1].low[-1], faces[-1].high[-1]))
    for low, high in wales:
        sketch.merge(low, high, prefer=high)
    return [*numbered, sketch.patch()]


def _only_row(fabric: StitchMesh, whole: Course) -> int:
    """The row number that all faces share."""
    rows = np.unique(fabric.row[list(whole.faces)])
    if len(rows) > 1:
        raise ParameterError(
            f"face {whole.faces[0]}: its row climbs from row {rows[0]} to row {rows[-1]}; turn the spiral back first"
        )
    for side in (fabric.left_wale[whole.faces[0]], fabric.right_wale[whole.faces[-1]]):
        if not whole.closed and fabric.twin[side] != BORDER:
            raise ParameterError(f"{fabric.side_name(side)}: the row goes on the other way up; flip a part of it first")
    return int(rows[0])


def _middles(sketch: Sketch, faces: list[SketchFace]) -> dict[Hashable, int]:
    """A new vertex in the middle of each wale edge of a row."""
    middles: dict[Hashable, int] = {}
    for face in faces:
        for edge, place in ((face.left, 0), (face.right, -1)):
            if edge not in middles:
                ends = sketch.position(face.low[place]), sketch.position(face.high[place])
                middles[edge] = sketch.vertex(0.5 * (ends[0] + ends[1]))
    return middles


def _knit_above(sketch: Sketch, lower: SketchFace, middles: dict[Hashable, int], stitch: Stitch, row: int) -> None:
    """Draw a face up to a new course line, and a stitch above it on each of its loops."""
    ends = middles[lower.left], middles[lower.right]
    tops = lower.high[0], lower.high[-1]
    left, right = (sketch.position(end) - sketch.position(corner) for end, corner in zip(ends, tops, strict=True))
    down = 0.5 * (left + right)
    inner = [sketch.vertex(sketch.position(vertex) + down) for vertex in lower.high[1:-1]]
    line = [ends[0], *inner, ends[1]]
    count = len(lower.above)
    wales = [("upper", lower.left), *((lower, "wale", place) for place in range(1, count)), ("upper", lower.right)]
    courses: list[Hashable] = [(lower, "course", place) for place in range(count)]
    for place in range(count):
        sketch.add(
            like(
                lower, low=line[place : place + 2], high=lower.high[place : place + 2], below=[courses[place]],
                above=[lower.above[place]], left=wales[place], right=wales[place + 1], stitch=stitch, row=row,
            )
        )  # fmt: skip
    lower.high, lower.above = line, courses
    lower.left, lower.right = ("lower", lower.left), ("lower", lower.right)


def _numbered(fabric: StitchMesh, chosen: NDArray[np.bool_], step: int) -> tuple[list[Change], StitchMesh]:
    """Number the rows of some faces on by a step: the change, and the stitch mesh after it."""
    places = np.flatnonzero(chosen)
    if len(places) == 0:
        return [], fabric
    change = Marks("row", places, fabric.row[places] + step)
    return [change], apply_change(fabric, change)
