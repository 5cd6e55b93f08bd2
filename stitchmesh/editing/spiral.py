# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conversion of ring rows to a spiral, as tubes are knit by hand, and back (Yuksel et al. 2012, section 4.3, figure 7).

Let s_0 .. s_R be the vertices of a wale, the seam, upwards through R rings. The last face of ring r lies to the left of
the seam. The ends of its right wale side change from s_r and s_(r+1) to s_(r+1) and s_(r+2), so that this face becomes
the neighbour of the first face of ring r + 1. The top ring needs one new vertex above the seam. The twins of course
sides stay unchanged. Every other vertex moves along its wale by its fraction t of the ring,

    p' = p + t (up(p) - p),  t = place on its course line / vertices of the line,

so that the step from one row to the next is distributed over all stitches of the ring.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.editing.reconnect import reconnect, replacement
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.mesh import BORDER, BOTTOM, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.border_lean import border_lean, vertex_step
from stitchmesh.mesh.change import Change
from stitchmesh.mesh.connectivity import corner_fans
from stitchmesh.mesh.courses import Course, bottom_sides, find_courses, sides_across, top_sides

CROWDED_STEP = 0.5
"""Fraction of the wale by which the highest course line moves where there is little space: below other stitches, and
where wales run together."""


def spiral(fabric: StitchMesh, seam: int | None = None) -> list[Change]:
    """Convert stacked rings to one row that rises around the tube, as ``make_spiral`` does."""
    return [replacement(fabric, make_spiral(fabric, seam))]


def unspiral(fabric: StitchMesh) -> list[Change]:
    """Convert every spiral back to rings: the inverse of ``spiral``, exact in the connections of the faces."""
    return [replacement(fabric, make_rings(fabric))]


def make_spiral(fabric: StitchMesh, seam: int | None = None) -> StitchMesh:
    """Convert stacked rings to one row that rises around the tube, so that a single yarn with two ends knits the tube.

    All stacks of two or more rings are converted, or only the stack that contains a given face. A row that is drawn
    together at its top, and the last row at a tip, stay rings; the spiral leads into this ring. If no wale runs through
    a whole stack, the stack is divided into parts, each as tall as its longest wale. The row numbers stay the same;
    each turn of the spiral has one number. Relax the mesh of stitches first, because the border of a spiral rises and
    does not follow the border of the surface.

    Args:
        fabric: a mesh of stitches.
        seam: a face; the seam runs along the left wale side of this face. By default a seam is chosen in every stack.

    Returns:
        The same faces, with one more vertex for each converted part.

    Raises:
        ParameterError: the face of the seam does not exist or does not lie in two stacked rings, or the mesh repeats on
            a lattice.
    """
    check_kind("make_spiral", fabric, StitchMesh)
    if fabric.lattice is not None:
        raise ParameterError("spiral: got a patch that repeats on a lattice; its rows are not rings of a tube")
    parts: list[CutRings] = []
    for stack in _stacks_to_convert(fabric, seam):
        parts += _cut_stack(fabric, stack, seam, {end for turns in parts for end in _ends(fabric, turns)})
    if not parts and seam is not None:
        raise ParameterError(f"seam: the wale left of face {seam} does not run through two rings; choose another face")
    for turns in parts:
        fabric = _to_spiral(fabric, turns)
    return fabric


def make_rings(fabric: StitchMesh) -> StitchMesh:
    """Convert every spiral back to rings: the inverse of ``make_spiral``, exact in the connections of the faces.

    Vertices move down their wales by the fraction by which they moved up. The result is exact where wales are straight
    and evenly divided. A spiral is a row whose row number increases from turn to turn.
    """
    for turns in _spirals(fabric):
        fabric = _to_rings(fabric, turns)
    return fabric


def _stacks_to_convert(fabric: StitchMesh, seam: int | None) -> list[list[Course]]:
    if seam is not None and not 0 <= seam < fabric.face_count:
        raise ParameterError(f"seam: got face {seam}; the mesh has faces 0 to {fabric.face_count - 1}")
    return [stack for stack in ring_stacks(fabric) if seam is None or any(seam in ring.faces for ring in stack)]


def _is_closing(fabric: StitchMesh, ring: Course) -> bool:
    """Return whether all wales of a ring begin in one vertex, or all end in one vertex, or converge at a tip.

    At a tip, the loops of the last ring become narrower towards the border, because a yarn is drawn through them. A
    spiral that went on above this border would cross itself.
    """
    faces = list(ring.faces)
    if not fabric.n_top[faces].any() or not fabric.n_bottom[faces].any():
        return True
    top, bottom = top_sides(fabric, faces), bottom_sides(fabric, faces)
    if (fabric.twin[top] != BORDER).any():
        return False
    # Wales converge at a tip if the width of the loops at the border, over the width at the bottom of the last
    # ring, is less. It is about 0.75 at tips of found rows, and 1 elsewhere.
    return bool(fabric.side_length[top].mean() < 0.9 * fabric.side_length[bottom].mean())


def _cut_stack(fabric: StitchMesh, stack: list[Course], seam: int | None, taken: set[int]) -> list[CutRings]:
    """Divide a stack into parts of at least two rings.

    A seam runs through the whole of each part, and the vertices at its ends are not used by another seam.

    Args:
        fabric: a mesh of stitches.
        stack: rings from below.
        seam: a face beside the seam, or None to choose the longest seam.
        taken: vertices at the ends of other seams.
    """
    own = {face for ring in stack for face in ring.faces}
    stack = [ring for ring in stack if not _is_closing(fabric, ring)]
    level = {face: number for number, ring in enumerate(stack) for face in ring.faces}
    starts = {int(fabric.face_vertex[fabric.face_start[face]]): face for face in level}
    parts, lowest = [], 0
    while lowest < len(stack):
        columns = [_column(fabric, face, starts) for face in stack[lowest].faces]
        if seam is not None:
            columns = [column for column in columns if seam in column]
        possible = [CutRings([_start_at(stack[level[face]].faces, face) for face in column]) for column in columns]
        possible = [_with_free_ends(fabric, turns, own) for turns in possible]
        possible = [turns for turns in possible if turns.rings and not taken & _ends(fabric, turns)]
        turns = max(possible, key=lambda each: len(each.rings), default=CutRings([]))
        if len(turns.rings) > 1:
            parts.append(turns)
        lowest = level[turns.firsts[-1]] + 1 if turns.rings else lowest + 1
    return parts


def _column(fabric: StitchMesh, face: int, starts: dict[int, int]) -> list[int]:
    """Return the faces to the right of the wale that rises from the left wale side of a face, through all rings."""
    column = [face]
    while (above := starts.get(int(fabric.face_vertex[fabric.left_wale[column[-1]]]), BORDER)) not in (BORDER, face):
        column.append(above)
    return column


def _ends(fabric: StitchMesh, turns: CutRings) -> set[int]:
    """Return the vertices at both ends of a seam, and the far ends of the wales that are opened beyond the seam."""
    lowest, highest = int(fabric.face_start[turns.firsts[0]]), _top_right(fabric, turns.rings[-1])
    ends = {int(fabric.face_vertex[side]) for side in (lowest, highest)}
    opened = [fabric.side_next[fabric.twin[side]] for side in (lowest, highest) if fabric.twin[side] != BORDER]
    return ends | {int(fabric.face_vertex[fabric.side_next[wale]]) for wale in opened}


def _with_free_ends(fabric: StitchMesh, turns: CutRings, own: set[int]) -> CutRings:
    """Return the turns without the rings where no spiral can start or end."""
    rings = turns.rings
    while rings and not _may_end(fabric, _top_right(fabric, rings[-1]), _top_left(fabric, rings[-1]), own):
        rings = rings[:-1]
    while rings and not _may_end(fabric, int(fabric.face_start[rings[0][0]]), _bottom_right(fabric, rings[0]), own):
        rings = rings[1:]
    return CutRings(rings)


def _top_right(fabric: StitchMesh, ring: Sequence[int]) -> int:
    """Return the top side to the left of the seam, which begins at the seam."""
    return int(fabric.side_next[fabric.right_wale[ring[-1]]])


def _top_left(fabric: StitchMesh, ring: Sequence[int]) -> int:
    """Return the top side to the right of the seam, which ends at the seam."""
    return int(fabric.side_previous[fabric.left_wale[ring[0]]])


def _bottom_right(fabric: StitchMesh, ring: Sequence[int]) -> int:
    """Return the bottom side to the left of the seam, which ends at the seam."""
    return int(fabric.side_previous[fabric.right_wale[ring[-1]]])


def _may_end(fabric: StitchMesh, begins: int, ends: int, own: set[int]) -> bool:
    """Return whether a spiral may end between two course sides that begin and end at the seam.

    Both sides must lie on a border, or face a ring of the same stack. In the second case the two stitches of that ring
    share a wale edge, which is opened; the far end of this edge must not lie on another border. None of the four
    stitches may then be an increase or a decrease, because some of its loops would lie on the wrong side of the yarn.
    """
    if fabric.is_wale[[begins, ends]].any():
        return False
    across, beside = fabric.twin[[begins, ends]].tolist()
    if across == BORDER or beside == BORDER:
        return across == beside
    wale = int(fabric.side_next[across])
    shared = fabric.is_wale[wale] and fabric.twin[wale] == fabric.side_previous[beside]
    beyond = fabric.face_vertex[fabric.side_next[wale]]
    around = fabric.side_face[[begins, ends, across, beside]]
    is_plain = (fabric.n_bottom[around] <= 1).all() and (fabric.n_top[around] <= 1).all()
    is_inside = (fabric.twin[fabric.face_vertex == beyond] != BORDER).all()
    return bool(shared and is_plain and is_inside) and int(fabric.side_face[across]) in own


def _start_at(faces: tuple[int, ...], first: int) -> list[int]:
    place = faces.index(first)
    return [*faces[place:], *faces[:place]]


def _to_spiral(fabric: StitchMesh, turns: CutRings) -> StitchMesh:
    """Connect each ring to the next ring along the seam, and move the vertices up along their wales."""
    twin = fabric.twin.copy()
    top = _top_right(fabric, turns.rings[-1])
    for side in (top, int(fabric.face_start[turns.firsts[0]])):
        _open_outside(fabric, twin, side)
    twin[fabric.right_wale[turns.lasts]] = BORDER
    twin[fabric.left_wale[turns.firsts]] = BORDER
    for last, first in zip(turns.lasts[:-1], turns.firsts[1:], strict=True):
        _join(twin, int(fabric.right_wale[last]), int(fabric.left_wale[first]))
    corner = _corners(fabric, twin, turns, {top: len(fabric.vertices)})
    return reconnect(fabric, _climb(fabric, turns, up=True), corner, twin)


def _to_rings(fabric: StitchMesh, turns: CutRings) -> StitchMesh:
    """Connect each turn of a spiral to a ring, and move the vertices down along their wales."""
    twin = fabric.twin.copy()
    for side in (int(fabric.right_wale[turns.lasts[-1]]), int(fabric.left_wale[turns.firsts[0]])):
        _close_outside(fabric, twin, side)
    for last, first in zip(turns.lasts, turns.firsts, strict=True):
        _join(twin, int(fabric.right_wale[last]), int(fabric.left_wale[first]))
    corner = _corners(fabric, twin, turns, {})
    unused = int(np.flatnonzero(np.bincount(corner, minlength=len(fabric.vertices)) == 0)[0])
    rings = reconnect(fabric, np.delete(fabric.vertices, unused, axis=0), corner - (corner > unused), twin)
    return replace(rings, vertices=_climb(rings, turns, up=False)[:-1])


def _open_outside(fabric: StitchMesh, twin: IntArray, side: int) -> None:
    """Open the wale edge that continues the seam across a course side that begins at the seam."""
    if fabric.twin[side] == BORDER:
        return
    wale = int(fabric.side_next[fabric.twin[side]])
    if twin[wale] != BORDER:
        twin[twin[wale]] = BORDER
    twin[wale] = BORDER


def _close_outside(fabric: StitchMesh, twin: IntArray, side: int) -> None:
    """Close the wale edge that was opened at the end of a spiral, where three sides bound a hole."""
    first = fabric.next_border_side(side)
    second = fabric.next_border_side(first)
    if fabric.next_border_side(second) == side and fabric.is_wale[[first, second]].all():
        _join(twin, first, second)


def _corners(fabric: StitchMesh, twin: IntArray, turns: CutRings, named: dict[int, int]) -> IntArray:
    """Return the vertex of each corner for new twins, shape (C,).

    Each fan of corners has one vertex: the earlier vertex of its corners to the right of the seam.

    Args:
        fabric: a mesh of stitches.
        twin: the new twins, shape (C,).
        turns: the rings or turns along the seam.
        named: vertices of further corners, by corner.
    """
    fan = corner_fans(twin, fabric.side_next)
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


def _spirals(fabric: StitchMesh) -> list[CutRings]:
    """Return all rows whose row number increases along the row, divided into turns."""
    found = []
    for course in find_courses(fabric, climbing=True):
        faces = np.array(course.faces)
        rings = np.split(faces, np.flatnonzero(np.diff(fabric.row[faces])) + 1)
        firsts = np.array([ring[0] for ring in rings])
        heads = fabric.face_vertex[fabric.left_wale[firsts[:-1]]]
        if len(rings) > 1 and (heads == fabric.face_vertex[fabric.face_start[firsts[1:]]]).all():
            found.append(CutRings([ring.tolist() for ring in rings]))
    return found


def _climb(fabric: StitchMesh, turns: CutRings, *, up: bool) -> FloatArray:
    """Return the vertices, moved along their wales, and the new upper end of the seam [cm], shape (V + 1, 3).

    Args:
        fabric: a mesh of stitches whose rows are rings.
        turns: the rings, cut along the seam.
        up: True to make a spiral of rings, False to make rings of a spiral.
    """
    lines, count = _course_lines(fabric, turns), len(fabric.vertices)
    moved = np.concatenate([fabric.vertices, fabric.vertices[lines[-1][:1]]])
    for level, line in enumerate(lines):
        ring = turns.rings[min(level, len(turns.rings) - 1) if up else max(level - 1, 0)]
        step = _steps(fabric, ring, line)
        if level == len(turns.rings):
            step = np.where(_is_free(fabric, turns), _border_steps(fabric, line, step), CROWDED_STEP * step)
        fraction = np.arange(len(line))[:, None] / len(line)
        moved[line] += fraction * step if up else -fraction * step
    moved[count] += step[0]
    return moved


def _course_lines(fabric: StitchMesh, turns: CutRings) -> list[list[int]]:
    """Return the vertices of the course lines below, between and above the rings, from the seam to the right."""
    bottoms = [bottom_sides(fabric, ring) for ring in turns.rings]
    tops = [side + 1 for side in top_sides(fabric, turns.rings[-1])]  # the ends of the sides, on the left
    return [fabric.face_vertex[corners].tolist() for corners in (*bottoms, tops)]


def _is_free(fabric: StitchMesh, turns: CutRings) -> NDArray[np.bool_]:
    """Return whether no face lies above each vertex of the highest course line, shape (n, 1)."""
    border = fabric.twin[top_sides(fabric, turns.rings[-1])] == BORDER
    return (border & np.roll(border, 1))[:, None]


def _border_steps(fabric: StitchMesh, line: list[int], step: FloatArray) -> FloatArray:
    """Return the steps beyond a top border [cm], shape (n, 3).

    The steps follow the normal where wales run together, for example around a crown.
    """
    places = np.arange(len(line))
    leaning = border_lean(fabric.vertices[line], step, np.stack([places, np.roll(places, -1)]))
    fraction = CROWDED_STEP if leaning.any() else 1.0
    return fraction * vertex_step(step, leaning, fabric.vertex_normal[line])


def _steps(fabric: StitchMesh, ring: list[int], line: list[int]) -> FloatArray:
    """Return the upward wale vector of a ring at each vertex of an adjacent course line [cm], shape (n, 3).

    The vectors are interpolated between the wales.
    """
    low, high = fabric.face_vertex[fabric.face_start[:-1][ring]], fabric.face_vertex[fabric.left_wale[ring]]
    wales = fabric.vertices[high] - fabric.vertices[low]
    at = {int(vertex): number for ends in (low, high) for number, vertex in enumerate(ends)}
    known = [place for place, vertex in enumerate(line) if vertex in at]
    found = wales[[at[line[place]] for place in known]]
    return np.stack([np.interp(np.arange(len(line)), known, axis, period=len(line)) for axis in found.T], axis=1)


@dataclass(frozen=True)
class CutRings:
    """A stack of rings that is cut along a seam."""

    rings: list[list[int]]
    """Faces of each ring, from the face to the right of the seam around to the face on its left."""

    @property
    def firsts(self) -> list[int]:
        """Faces to the right of the seam, from below."""
        return [ring[0] for ring in self.rings]

    @property
    def lasts(self) -> list[int]:
        """Faces to the left of the seam, from below."""
        return [ring[-1] for ring in self.rings]


def ring_stacks(fabric: StitchMesh) -> list[list[Course]]:
    """Return the maximal stacks of rings, each from below; the top of a ring is exactly the bottom of the next ring."""
    rings = [ring for ring in find_courses(fabric, climbing=True) if ring.closed]
    ring_of = np.full(fabric.face_count, BORDER)
    for number, ring in enumerate(rings):
        ring_of[list(ring.faces)] = number
    above = [_only_neighbour(fabric, ring, ring_of, TOP) for ring in rings]
    below = [_only_neighbour(fabric, ring, ring_of, BOTTOM) for ring in rings]
    stacks, used = [], [False] * len(rings)
    for number in range(len(rings)):
        lowest = number
        while (under := below[lowest]) != BORDER and above[under] == lowest and under != number:
            lowest = under
        stack = []
        while lowest != BORDER and not used[lowest]:
            used[lowest] = True
            stack.append(rings[lowest])
            over = above[lowest]
            lowest = over if over != BORDER and below[over] == lowest else BORDER
        if stack:
            stacks.append(stack)
    return stacks


def _only_neighbour(fabric: StitchMesh, ring: Course, ring_of: IntArray, role: int) -> int:
    """Return the ring with the same wale direction across all top or bottom sides of a ring, or ``BORDER``."""
    sides = top_sides(fabric, ring.faces) if role == TOP else bottom_sides(fabric, ring.faces)
    across = sides_across(fabric, np.array(sides, dtype=np.int64), BOTTOM if role == TOP else TOP)
    if len(sides) == 0 or (across == BORDER).any():
        return BORDER
    found = np.unique(ring_of[fabric.side_face[across]])
    return int(found[0]) if len(found) == 1 else BORDER
