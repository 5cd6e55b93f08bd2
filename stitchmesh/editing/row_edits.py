# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits of whole rows: reverse, insert, remove (Yuksel et al. 2012, sections 4.4 and 5.1)."""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np
from numpy.typing import NDArray

from stitchmesh.editing.fitting import plain_stitch_named
from stitchmesh.editing.sides import check_face
from stitchmesh.editing.sketch import Sketch, SketchFace, face_like
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, TOP, IntArray, StitchMesh
from stitchmesh.mesh.change import Change, Marks, apply_change
from stitchmesh.mesh.courses import Course, course_through, renumbered_rows
from stitchmesh.mesh.stitch import Stitch


def flip_row(fabric: StitchMesh, face: int) -> list[Change]:
    """Reverse the wale direction of a row, so that bottom sides become top sides.

    Increases become decreases, and the edges to adjacent rows become mismatched. Twists and cables of the row are lost,
    because its loops are replaced. If adjacent rows are reversed one after the other, the rows are numbered anew, so
    that each reversed row follows the row whose loops it works (``renumbered_rows``).

    Args:
        fabric: a mesh of stitches.
        face: any face of the row.

    Raises:
        ParameterError: the face does not exist, or a face of the row has no stitch with the opposite direction.
    """
    check_face(fabric, face)
    faces = course_through(fabric, face, climbing=True).faces
    changes = _number_after_flip(fabric, np.array(faces))
    for change in changes:
        fabric = apply_change(fabric, change)
    sketch = Sketch(fabric)
    for number in faces:
        turned = sketch.face(number)
        turned.turn()
        sketch.fit_stitch(turned)
    return [*changes, sketch.patch()]


def insert_row(fabric: StitchMesh, face: int, stitch: str = "k") -> list[Change]:
    """Insert a row above another row.

    The wale edges of the lower row are divided in the middle, and each loop of the lower row gets a new stitch. Twists
    and cables stay with the loops of the lower row. The numbers of the rows above increase by one.

    Args:
        fabric: a mesh of stitches.
        face: any face of the lower row.
        stitch: code of the new stitches; the stitch must have one loop below and one above.

    Raises:
        ParameterError: the face does not exist, the stitch does not fit, the row is part of a spiral, or the yarn is
            drawn through the loops of the row.
    """
    check_face(fabric, face)
    made = plain_stitch_named(stitch, "a new row")
    whole = course_through(fabric, face, climbing=True)
    row = _only_row(fabric, whole)
    changes, fabric = renumber_rows(fabric, fabric.row > row, 1)
    sketch = Sketch(fabric)
    faces = [sketch.face(number) for number in whole.faces]
    without_loops = next((lower for lower in faces if not lower.above), None)
    if without_loops is not None:
        raise ParameterError(f"{without_loops.name}: its row ends here and has no loops for another row")
    middles = _middles(sketch, faces)
    for lower in faces:
        _knit_above(sketch, lower, middles, made, row + 1)
    return [*changes, sketch.patch()]


def remove_row(fabric: StitchMesh, face: int) -> list[Change]:
    """Remove a row of stitches with one loop below and one above; the row above works the loops of the row below.

    Args:
        fabric: a mesh of stitches.
        face: any face of the row.

    Raises:
        ParameterError: the face does not exist, the row is a first row or part of a spiral, or a stitch of the row has
            another number of loops.
        MeshError: a face would touch itself.
    """
    check_face(fabric, face)
    whole = course_through(fabric, face, climbing=True)
    row = _only_row(fabric, whole)
    alone = np.count_nonzero(fabric.row == row) == len(whole.faces)
    changes, fabric = renumber_rows(fabric, (fabric.row > row) & alone, -1)
    sketch = Sketch(fabric)
    faces = [sketch.drop(number) for number in whole.faces]
    for number, removed in zip(whole.faces, faces, strict=True):
        if (len(removed.below), len(removed.above)) != (1, 1):
            raise ParameterError(f"{removed.name}: does not make one loop of one; change it first to remove its row")
        if fabric.twin[fabric.face_start[number]] == BORDER:
            raise ParameterError(f"{removed.name}: lies on the border; the first row carries all others, keep it")
    for number, removed in zip(whole.faces, faces, strict=True):
        below = sketch.face(int(fabric.side_face[fabric.twin[fabric.face_start[number]]]))
        below.rename_edge(removed.below[0], removed.above[0])
    wales = [(removed.low[0], removed.high[0]) for removed in faces]
    if not whole.closed:
        wales.append((faces[-1].low[-1], faces[-1].high[-1]))
    for low, high in wales:
        sketch.merge(low, high, prefer=high)
    return [*changes, sketch.patch()]


def _number_after_flip(fabric: StitchMesh, faces: IntArray) -> list[Change]:
    """Return the change of row numbers that the reversal of these faces requires; an empty list if there is none."""
    flipped_face = np.zeros(fabric.face_count, dtype=bool)
    flipped_face[faces] = True
    flipped_row = np.zeros(int(fabric.row.max()) + 1, dtype=bool)
    flipped_row[fabric.row[faces]] = True
    below, above = _matched_rows(fabric, fabric.sides_of(faces), flipped_face)
    if not (below > above).any():
        return []
    number = renumbered_rows(*_matched_rows(fabric, np.arange(fabric.side_count), flipped_face), flipped_row)
    moved = np.flatnonzero(number[fabric.row] != fabric.row)
    return [Marks("row", moved, number[fabric.row[moved]])]


def _matched_rows(fabric: StitchMesh, sides: IntArray, flipped_face: NDArray[np.bool_]) -> tuple[IntArray, IntArray]:
    """Return, for each side whose wale directions match after some faces are flipped, the rows below and above it."""
    sides = sides[(fabric.role_of(sides) % 2 == 0) & (fabric.twin[sides] != BORDER)]
    across = fabric.twin[sides]
    faces, others = fabric.side_face[sides], fabric.side_face[across]
    top = (fabric.role_of(sides) == TOP) ^ flipped_face[faces]
    matched = top != (fabric.role_of(across) == TOP) ^ flipped_face[others]
    rows, other_rows = fabric.row[faces[matched]], fabric.row[others[matched]]
    return np.where(top[matched], rows, other_rows), np.where(top[matched], other_rows, rows)


def _only_row(fabric: StitchMesh, whole: Course) -> int:
    """Return the row number that all faces of a course share.

    Raises:
        ParameterError: the course is part of a spiral, turns back in short rows or a bobble, or continues with the
            opposite wale direction.
    """
    rows = np.unique(fabric.row[list(whole.faces)])
    if len(rows) > 1:
        raise ParameterError(
            f"face {whole.faces[0]}: its row climbs from row {rows[0]} to row {rows[-1]}; turn the spiral back first"
        )
    for side in () if whole.closed else (fabric.left_wale[whole.faces[0]], fabric.right_wale[whole.faces[-1]]):
        name = fabric.side_name(side)
        if fabric.twin[side] != BORDER:
            raise ParameterError(f"{name}: the row continues with the opposite direction; flip a part of it first")
        if fabric.next_border_side(fabric.next_border_side(side)) == side:
            raise ParameterError(f"{name}: the row turns back here, in short rows or a bobble; choose another row")
    return int(rows[0])


def _middles(sketch: Sketch, faces: list[SketchFace]) -> dict[Hashable, int]:
    """Add a vertex in the middle of each wale edge of a row, and return the vertices by edge."""
    middles: dict[Hashable, int] = {}
    for face in faces:
        for edge, place in ((face.left, 0), (face.right, -1)):
            if edge not in middles:
                ends = sketch.position(face.low[place]), sketch.position(face.high[place])
                middles[edge] = sketch.vertex(0.5 * (ends[0] + ends[1]))
    return middles


def _knit_above(sketch: Sketch, lower: SketchFace, middles: dict[Hashable, int], stitch: Stitch, row: int) -> None:
    """Shorten a face to a new course line, and add a stitch above the line on each of its loops."""
    ends = middles[lower.left], middles[lower.right]
    corners = lower.high[0], lower.high[-1]
    left, right = (sketch.position(end) - sketch.position(corner) for end, corner in zip(ends, corners, strict=True))
    down = 0.5 * (left + right)
    inner = [sketch.vertex(sketch.position(vertex) + down) for vertex in lower.high[1:-1]]
    line = [ends[0], *inner, ends[1]]
    count = len(lower.above)
    wales = [("upper", lower.left), *((lower, "wale", place) for place in range(1, count)), ("upper", lower.right)]
    courses: list[Hashable] = [(lower, "course", place) for place in range(count)]
    for place in range(count):
        sketch.add(
            face_like(
                lower, low=line[place : place + 2], high=lower.high[place : place + 2], below=[courses[place]],
                above=[lower.above[place]], left=wales[place], right=wales[place + 1], stitch=stitch, row=row,
            )
        )  # fmt: skip
    lower.high, lower.above = line, courses
    lower.left, lower.right = ("lower", lower.left), ("lower", lower.right)


def renumber_rows(fabric: StitchMesh, chosen: NDArray[np.bool_], step: int) -> tuple[list[Change], StitchMesh]:
    """Add a step to the row numbers of the chosen faces; return the change, and the mesh after the change."""
    places = np.flatnonzero(chosen)
    if len(places) == 0:
        return [], fabric
    change = Marks("row", places, fabric.row[places] + step)
    return [change], apply_change(fabric, change)
