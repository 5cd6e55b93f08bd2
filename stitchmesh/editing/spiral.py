# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Ring rows into a spiral, as they are knitted, and back (Yuksel et al. 2012, section 4.3, figure 7).

Let s_0 .. s_R be the vertices of a wale, the seam, upwards through R rings. The last face of ring r, left of the seam,
takes s_(r+1) and s_(r+2) for the corners of its right wale side in place of s_r and s_(r+1): it becomes the neighbour
of the first face of ring r + 1. Above the top ring that takes one new vertex. Which course sides lie across one
another does not change. Every other vertex climbs along its wale (``climb``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stitchmesh.editing.climb import climb
from stitchmesh.editing.reconnect import corner_fans, reconnected
from stitchmesh.editing.ring_rows import Turns, ring_stacks
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.courses import Course, find_courses


def make_spiral(fabric: StitchMesh, seam: int | None = None) -> StitchMesh:
    """Turn stacked rings into one row that climbs around the tube, so that it is one yarn with two ends.

    Every stack of two or more rings is turned, or the one that a given face lies in. A row drawn together at its top
    stays a ring that the spiral leads into. Where no wale runs through a whole stack, it is turned in pieces, each as
    tall as its tallest wale. Rows keep their numbers, one to each turn. Relax the mesh of stitches first: a border
    that climbs does not lie on the border of the surface.

    Args:
        fabric: stitch faces.
        seam: a face; the seam runs along its left wale side. Where None, one is chosen in every stack.

    Returns:
        The same faces; one vertex more for each stack turned.

    Raises:
        ParameterError: the seam is no face of two stacked rings.
    """
    if fabric.lattice is not None:
        raise ParameterError("spiral: got a patch that repeats on a lattice; its rows are no rings of a tube")
    turned: list[Turns] = []
    for stack in _stacks_to_turn(fabric, seam):
        turned += _cut(fabric, stack, seam, {end for turns in turned for end in _ends(fabric, turns)})
    if not turned and seam is not None:
        raise ParameterError(f"seam: the wale left of face {seam} does not run through two rings; choose another face")
    for turns in turned:
        fabric = _turned(fabric, turns)
    return fabric


def unspiral(fabric: StitchMesh) -> StitchMesh:
    """Turn every spiral back into rings: the inverse of ``make_spiral``, exact in how faces are connected.

    Vertices come down their wales by the share that they climbed, exactly where wales are straight and even. A spiral
    is a row whose faces change their row number on the way, upwards by turns.
    """
    for turns in _spirals(fabric):
        fabric = _unturned(fabric, turns)
    return fabric


def _stacks_to_turn(fabric: StitchMesh, seam: int | None) -> list[list[Course]]:
    if seam is not None and not 0 <= seam < fabric.face_count:
        raise ParameterError(f"seam: got face {seam}; the mesh has faces 0 to {fabric.face_count - 1}")
    return [stack for stack in ring_stacks(fabric) if seam is None or any(seam in ring.faces for ring in stack)]


def _is_closing(fabric: StitchMesh, ring: Course) -> bool:
    """Whether a ring's wales all begin, or all end, in one vertex."""
    faces = list(ring.faces)
    return not fabric.n_top[faces].any() or not fabric.n_bottom[faces].any()


def _cut(fabric: StitchMesh, stack: list[Course], seam: int | None, taken: set[int]) -> list[Turns]:
    """The stack in pieces of two rings and more, each with a seam through all of it that ends in free vertices."""
    own = {face for ring in stack for face in ring.faces}
    stack = [ring for ring in stack if not _is_closing(fabric, ring)]
    level = {face: number for number, ring in enumerate(stack) for face in ring.faces}
    starts = {int(fabric.face_vertex[fabric.face_start[face]]): face for face in level}
    pieces, lowest = [], 0
    while lowest < len(stack):
        columns = [_column(fabric, face, starts) for face in stack[lowest].faces]
        if seam is not None:
            columns = [column for column in columns if seam in column]
        possible = [Turns([_from(stack[level[face]].faces, face) for face in column]) for column in columns]
        possible = [_with_free_ends(fabric, turns, own) for turns in possible]
        possible = [turns for turns in possible if turns.rings and not taken & _ends(fabric, turns)]
        turns = max(possible, key=lambda each: len(each.rings), default=Turns([]))
        if len(turns.rings) > 1:
            pieces.append(turns)
        lowest = level[turns.firsts[-1]] + 1 if turns.rings else lowest + 1
    return pieces


def _column(fabric: StitchMesh, face: int, starts: dict[int, int]) -> list[int]:
    """Faces right of the wale that runs up from the left wale side of a face, as far as it runs through the rings."""
    column = [face]
    while (above := starts.get(int(fabric.face_vertex[fabric.left_wale[column[-1]]]), BORDER)) not in (BORDER, face):
        column.append(above)
    return column


def _ends(fabric: StitchMesh, turns: Turns) -> set[int]:
    """The vertices at both ends of a seam, and those that the wales opened beyond them reach."""
    lowest, highest = int(fabric.face_start[turns.firsts[0]]), _top_right(fabric, turns.rings[-1])
    ends = {int(fabric.face_vertex[side]) for side in (lowest, highest)}
    opened = [fabric.side_next[fabric.twin[side]] for side in (lowest, highest) if fabric.twin[side] != BORDER]
    return ends | {int(fabric.face_vertex[fabric.side_next[wale]]) for wale in opened}


def _with_free_ends(fabric: StitchMesh, turns: Turns, own: set[int]) -> Turns:
    """The turns without those that no spiral can start or end with."""
    rings = turns.rings
    while rings and not _may_end(fabric, _top_right(fabric, rings[-1]), _top_left(fabric, rings[-1]), own):
        rings = rings[:-1]
    while rings and not _may_end(fabric, int(fabric.face_start[rings[0][0]]), _bottom_right(fabric, rings[0]), own):
        rings = rings[1:]
    return Turns(rings)


def _top_right(fabric: StitchMesh, ring: Sequence[int]) -> int:
    """The top side left of the seam, which begins there."""
    return int(fabric.side_next[fabric.right_wale[ring[-1]]])


def _top_left(fabric: StitchMesh, ring: Sequence[int]) -> int:
    """The top side right of the seam, which ends there."""
    return int(fabric.side_previous[fabric.left_wale[ring[0]]])


def _bottom_right(fabric: StitchMesh, ring: Sequence[int]) -> int:
    """The bottom side left of the seam, which ends there."""
    return int(fabric.side_previous[fabric.right_wale[ring[-1]]])


def _may_end(fabric: StitchMesh, begins: int, ends: int, own: set[int]) -> bool:
    """Whether a spiral may end between two course sides that begin and end at the seam.

    Across from both is a border, or a ring of this stack whose two stitches there share the wale to open; that must
    not reach another border.
    """
    if fabric.is_wale[[begins, ends]].any():
        return False
    across, beside = fabric.twin[[begins, ends]].tolist()
    if across == BORDER or beside == BORDER:
        return across == beside
    wale = int(fabric.side_next[across])
    shared = fabric.is_wale[wale] and fabric.twin[wale] == fabric.side_previous[beside]
    beyond = fabric.face_vertex[fabric.side_next[wale]]
    is_inside = (fabric.twin[fabric.face_vertex == beyond] != BORDER).all()
    return bool(shared and is_inside) and int(fabric.side_face[across]) in own


def _from(faces: tuple[int, ...], first: int) -> list[int]:
    place = faces.index(first)
    return [*faces[place:], *faces[:place]]


def _turned(fabric: StitchMesh, turns: Turns) -> StitchMesh:
    """Connect each ring to the next along the seam and let the vertices climb."""
    twin = fabric.twin.copy()
    top = _top_right(fabric, turns.rings[-1])
    for side in (top, int(fabric.face_start[turns.firsts[0]])):
        _open_outside(fabric, twin, side)
    twin[fabric.right_wale[turns.lasts]] = BORDER
    twin[fabric.left_wale[turns.firsts]] = BORDER
    for last, first in zip(turns.lasts[:-1], turns.firsts[1:], strict=True):
        _join(twin, int(fabric.right_wale[last]), int(fabric.left_wale[first]))
    corner = _corners(fabric, twin, turns, {top: len(fabric.vertices)})
    return reconnected(fabric, climb(fabric, turns, up=True), corner, twin)


def _unturned(fabric: StitchMesh, turns: Turns) -> StitchMesh:
    """Connect the turns of a spiral to rings and let the vertices come down."""
    twin = fabric.twin.copy()
    for side in (int(fabric.right_wale[turns.lasts[-1]]), int(fabric.left_wale[turns.firsts[0]])):
        _close_outside(fabric, twin, side)
    for last, first in zip(turns.lasts, turns.firsts, strict=True):
        _join(twin, int(fabric.right_wale[last]), int(fabric.left_wale[first]))
    corner = _corners(fabric, twin, turns, {})
    spare = int(np.flatnonzero(np.bincount(corner, minlength=len(fabric.vertices)) == 0)[0])
    rings = reconnected(fabric, np.delete(fabric.vertices, spare, axis=0), corner - (corner > spare), twin)
    return replace(rings, vertices=climb(rings, turns, up=False)[:-1])


def _open_outside(fabric: StitchMesh, twin: IntArray, side: int) -> None:
    """Open the wale that goes on from the seam across a course side which begins there."""
    if fabric.twin[side] == BORDER:
        return
    wale = int(fabric.side_next[fabric.twin[side]])
    if twin[wale] != BORDER:
        twin[twin[wale]] = BORDER
    twin[wale] = BORDER


def _close_outside(fabric: StitchMesh, twin: IntArray, side: int) -> None:
    """Close the wale that the end of a spiral opened: with the side it makes a hole of three."""
    first = fabric.next_border_side(side)
    second = fabric.next_border_side(first)
    if fabric.next_border_side(second) == side and fabric.is_wale[[first, second]].all():
        _join(twin, first, second)


def _corners(fabric: StitchMesh, twin: IntArray, turns: Turns, named: dict[int, int]) -> IntArray:
    """Vertex of each corner once sides have other twins: one to each fan, named by its corners right of the seam."""
    fan = corner_fans(fabric, twin)
    low, firsts = fabric.right_wale[turns.lasts], np.array(turns.firsts)
    right_of_seam = np.concatenate([fabric.face_start[:-1][firsts], fabric.left_wale[firsts]])
    rest = np.setdiff1d(np.arange(fabric.side_count), np.concatenate([low, fabric.side_next[low]]))
    vertex = np.zeros(fan.max() + 1, dtype=np.int64)
    for corners in (rest, right_of_seam):
        vertex[fan[corners]] = fabric.face_vertex[corners]
    for corner, name in named.items():
        vertex[fan[corner]] = name
    return vertex[fan]


def _join(twin: IntArray, first: int, second: int) -> None:
    twin[first], twin[second] = second, first


def _spirals(fabric: StitchMesh) -> list[Turns]:
    """Rows that climb, by turns."""
    found = []
    for course in find_courses(fabric, climbing=True):
        faces = np.array(course.faces)
        rings = np.split(faces, np.flatnonzero(np.diff(fabric.row[faces])) + 1)
        firsts = np.array([ring[0] for ring in rings])
        heads = fabric.face_vertex[fabric.left_wale[firsts[:-1]]]
        if len(rings) > 1 and (heads == fabric.face_vertex[fabric.face_start[firsts[1:]]]).all():
            found.append(Turns([ring.tolist() for ring in rings]))
    return found
