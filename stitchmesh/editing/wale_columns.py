# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Remove a column of stitches, each of which stands on the single loop of another."""

from __future__ import annotations

from stitchmesh.editing.sides import check_face
from stitchmesh.editing.sketch import Sketch, SketchFace
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, BOTTOM, TOP, StitchMesh
from stitchmesh.mesh.change import Change


def remove_wale(fabric: StitchMesh, face: int, courses: int | None = None) -> list[Change]:
    """Take out the column of stitches through a face: as far as each stands on the single loop of another.

    Where it begins and ends inside the fabric, the faces there make or take one loop less.

    Args:
        fabric: stitch faces.
        face: a face of the column; the column runs both ways as far as it goes.
        courses: stitches to take out, counted upwards from this face; where not given the whole column.

    Raises:
        ParameterError: there is no such face, it does not make one loop of one, the column is shorter than
            ``courses``, or a face at an end has no stitch for one loop less.
        MeshError: the column joins two borders, or a face would touch itself.
    """
    check_face(fabric, face)
    column, is_closed = _column(fabric, face, courses)
    sketch = Sketch(fabric)
    gone = [sketch.drop(number) for number in column]
    for number, stitch in zip(column, gone, strict=True):
        _close_wale(sketch, number, stitch, column)
    first, last = int(fabric.face_start[column[0]]), int(fabric.right_wale[column[-1]]) + 1
    ends = [] if is_closed else [(first, edge) for edge in gone[0].below] + [(last, edge) for edge in gone[-1].above]
    beyond = [(_across(sketch, side), edge) for side, edge in ends]
    for chain in [*(stitch.low for stitch in gone), *([] if is_closed else [gone[-1].high])]:
        if len(chain) == 2:
            sketch.merge(*chain)
    for outer, edge in beyond:
        if outer is not None:
            on_top = edge in outer.above
            outer.close(on_top, outer.chain(on_top)[1].index(edge))
            sketch.settle(outer)
    return [sketch.patch()]


def _column(fabric: StitchMesh, face: int, courses: int | None) -> tuple[list[int], bool]:
    """Faces of a column upwards, and whether it closes."""
    if fabric.n_bottom[face] > 1 or fabric.n_top[face] > 1:
        raise ParameterError(f"face {face}: does not make one loop of one; expected a face of a plain column")
    column = [face]
    while (courses is None or len(column) < courses) and (onwards := _stacked(fabric, column[-1], 1)) != BORDER:
        if onwards == face:
            return column, True
        column.append(onwards)
    if courses is not None and len(column) != courses:
        raise ParameterError(f"courses: got {courses}; the column runs over {len(column)} from face {face}")
    while courses is None and (onwards := _stacked(fabric, column[0], -1)) != BORDER:
        column.insert(0, onwards)
    return column, _stacked(fabric, column[-1], 1) == column[0]


def _stacked(fabric: StitchMesh, face: int, step: int) -> int:
    """The face above (1) or below (-1) that works the same single loop and no other, ``BORDER`` where there is none."""
    if (fabric.n_top if step > 0 else fabric.n_bottom)[face] == 0:
        return BORDER
    side = int(fabric.right_wale[face]) + 1 if step > 0 else int(fabric.face_start[face])
    across = int(fabric.twin[side])
    if across == BORDER or fabric.role_of(across) != (BOTTOM if step > 0 else TOP):
        return BORDER
    other = int(fabric.side_face[across])
    return BORDER if fabric.n_bottom[other] > 1 or fabric.n_top[other] > 1 else other


def _close_wale(sketch: Sketch, number: int, stitch: SketchFace, column: list[int]) -> None:
    """Make the neighbours of a stitch of the column each other's."""
    fabric = sketch.fabric
    across, on_left = int(fabric.twin[fabric.right_wale[number]]), int(fabric.twin[fabric.left_wale[number]])
    if across == on_left == BORDER:
        raise ParameterError(f"{stitch.name}: is all of its row; without it the fabric would fall apart")
    if across == BORDER:
        return
    right = int(fabric.side_face[across])
    if right in column:
        raise ParameterError(f"{stitch.name}: has its column on both sides; there is nothing that could close the gap")
    sketch.face(right).rename_edge(stitch.right, stitch.left)


def _across(sketch: Sketch, side: int) -> SketchFace | None:
    """The face across a side, to be redrawn."""
    across = int(sketch.fabric.twin[side])
    return None if across == BORDER else sketch.face(int(sketch.fabric.side_face[across]))
