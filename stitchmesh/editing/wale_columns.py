# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The edit that removes a column of stitches, in which each stitch works the single loop of the stitch below."""

from __future__ import annotations

from stitchmesh.editing.sides import check_face
from stitchmesh.editing.sketch import Sketch, SketchFace
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, BOTTOM, TOP, StitchMesh
from stitchmesh.mesh.change import Change


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
