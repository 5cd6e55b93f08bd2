# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits that graft two borders together, and that separate two rows along a seam.

Grafting joins the loops of two borders that have equally many loops. If both borders are top borders, the wale
directions of the rows are opposite at the seam; every two adjacent stitches are then linked by a closed ring of yarn
across the seam, as in Kitchener stitch (Yuksel et al. 2012, section 4.4). A top border can also be grafted to the
bottom sides of stitches that work loops.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from stitchmesh.editing.reconnect import reconnect, replacement
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, TOP, IntArray, StitchMesh
from stitchmesh.mesh.change import Change
from stitchmesh.mesh.connectivity import corner_fans
from stitchmesh.mesh.courses import chain_through
from stitchmesh.mesh.stitch import Stitch


def graft(fabric: StitchMesh, first_side: int, second_side: int) -> list[Change]:
    """Graft two border lines together. Vertices that become one vertex move to their mean position.

    Args:
        fabric: a stitch mesh that has both borders; the borders may belong to separate pieces.
        first_side: a course side on one border. The line extends to the next wale sides of the border, or around the
            tube.
        second_side: a course side on the other border. On a tube, the two given sides are joined to one another.

    Raises:
        ParameterError: a side is not a course side on a border or has no loop to graft, both sides lie on one line, or
            the numbers of loops of the two lines differ.
    """
    _check_border_sides(fabric, first_side, second_side)
    first, second = _border_line(fabric, first_side), _border_line(fabric, second_side)
    if second_side in first:
        raise ParameterError(f"graft: sides {first_side} and {second_side} lie on one line; choose two borders")
    if len(first) != len(second):
        raise ParameterError(
            f"graft: got {len(first)} loops at side {first_side} and {len(second)} at side {second_side}; expected "
            "equal numbers: increase or decrease in the row before"
        )
    if _is_ring(fabric, first) != _is_ring(fabric, second):
        raise ParameterError(f"graft: one of sides {first_side} and {second_side} lies on a ring; expected both")
    across = [second[0], *second[:0:-1]] if _is_ring(fabric, first) else second[::-1]
    twin = fabric.twin.copy()
    twin[first], twin[across] = across, first
    return [replacement(fabric, _merge_vertices(fabric, twin))]


def ungraft(fabric: StitchMesh, side: int) -> list[Change]:
    """Separate two rows along the course line through a side.

    This is the inverse of ``graft``, exact in the twins of sides.

    Args:
        fabric: a mesh of stitches.
        side: a course side inside the fabric. The line extends to the borders, or around the tube.

    Raises:
        ParameterError: the side is not a course side between two faces, or the course line meets itself elsewhere.
    """
    if not 0 <= side < fabric.side_count or fabric.is_wale[side] or fabric.twin[side] == BORDER:
        raise ParameterError(f"ungraft: got side {side}; expected a course side between two faces")
    after, before = (partial(_next_course_side, fabric, step=step) for step in (fabric.side_next, fabric.side_previous))
    line = np.array(chain_through(side, _until_repeated(after, side), _until_repeated(before, side))[0])
    twin = fabric.twin.copy()
    twin[fabric.twin[line]], twin[line] = BORDER, BORDER
    fan = corner_fans(twin, fabric.side_next)
    vertex = np.zeros(fan.max() + 1, dtype=np.int64)
    vertex[fan] = fabric.face_vertex
    first = np.unique(vertex, return_index=True)[1]
    duplicates = np.setdiff1d(np.arange(len(vertex)), first)
    vertices = np.concatenate([fabric.vertices, fabric.vertices[vertex[duplicates]]])
    vertex[duplicates] = len(fabric.vertices) + np.arange(len(duplicates))
    return [replacement(fabric, reconnect(fabric, vertices, vertex[fan], twin))]


def _check_border_sides(fabric: StitchMesh, *sides: int) -> None:
    for side in sides:
        if not 0 <= side < fabric.side_count or fabric.is_wale[side] or fabric.twin[side] != BORDER:
            raise ParameterError(f"graft: got side {side}; expected a course side on a border")
        if fabric.side_role[side] != TOP and fabric.stitch[fabric.side_face[side]] == Stitch.CAST_ON:
            raise ParameterError(f"graft: {fabric.side_name(side)} is cast on: it has no loop; graft a top border")
    if all(fabric.side_role[side] != TOP for side in sides):
        raise ParameterError(f"graft: sides {sides[0]} and {sides[1]} are both bottoms; one must be a top with loops")


def _border_line(fabric: StitchMesh, side: int) -> list[int]:
    """Return the adjacent border sides with the same role as a side, in border order; a ring starts at the side."""
    role = fabric.side_role[side]
    loop = next(loop for loop in fabric.boundary_loops if side in loop)
    loop = np.roll(loop, -int(np.flatnonzero(loop == side)[0]))
    others = np.flatnonzero(fabric.side_role[loop] != role)
    if len(others) == 0:
        return loop.tolist()
    return [*loop[others[-1] + 1 :].tolist(), *loop[: others[0]].tolist()]


def _is_ring(fabric: StitchMesh, line: list[int]) -> bool:
    return fabric.next_border_side(line[-1]) == line[0]


def _until_repeated(step: Callable[[int], int], start: int) -> Callable[[int], int]:
    """Return a step along a course line that raises an error where the line meets itself, so that walks end."""
    seen = {start}

    def next_side(side: int) -> int:
        following = step(side)
        if following in seen and following != start:
            raise ParameterError(f"ungraft: the course line through side {start} meets itself at side {following}")
        seen.add(following)
        return following

    return next_side


def _next_course_side(fabric: StitchMesh, side: int, *, step: IntArray) -> int:
    """Return the next course side of a line, in the same face or across a wale side; ``BORDER`` at the end.

    The line also ends beside a face that has no course side there, such as the face at the end of a short row.
    """
    following = int(step[side])
    if fabric.is_wale[following]:
        across = int(fabric.twin[following])
        following = BORDER if across == BORDER else int(step[across])
    ends = following == BORDER or fabric.is_wale[following] or fabric.twin[following] == BORDER
    return BORDER if ends else following


def _merge_vertices(fabric: StitchMesh, twin: IntArray) -> StitchMesh:
    """Return the fabric with other twins; merged vertices keep the lowest number and take their mean position."""
    fan = corner_fans(twin, fabric.side_next)
    pairs = np.unique(np.stack([fan, fabric.face_vertex], axis=1), axis=0)
    count = np.bincount(pairs[:, 0])
    middle = np.stack([np.bincount(pairs[:, 0], axis) / count for axis in fabric.vertices[pairs[:, 1]].T], axis=1)
    lowest = pairs[np.searchsorted(pairs[:, 0], np.arange(len(count))), 1]
    order = np.argsort(lowest, kind="stable")
    number = np.empty(len(count), dtype=np.int64)
    number[order] = np.arange(len(count))
    return reconnect(fabric, middle[order], number[fan], twin)
