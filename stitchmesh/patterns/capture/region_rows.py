# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The rows of a rectangular region in wales and courses: each row is worked on all loops of the row below.

The module also finds the line along which stacked rings are cut open, so that a tube becomes the tile of a pattern.

The cut runs between stitches from the lowest to the highest ring. It meets each course line between two loops, and no
cable may cross it there. Where a yarn-over lies at the cut, the cut can pass on either side of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, first_few
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh import BORDER, BOTTOM, TOP, IntArray, StitchMesh
from stitchmesh.mesh.courses import faces_across, sides_across
from stitchmesh.patterns.placement.placement import find_runs, is_worked


@dataclass(frozen=True, eq=False)
class RegionRow:
    """One row of a region."""

    faces: IntArray
    """Faces from left to right, shape (n,)."""
    below: IntArray
    """The top side across from each bottom side, from left to right, shape (b,); ``BORDER`` where there is none."""
    tops: IntArray
    """Top sides from left to right, shape (t,)."""
    closed: bool
    """Whether the row is a ring."""

    def rolled(self, faces: int, bottoms: int, tops: int) -> RegionRow:
        """Return a ring that starts after the given numbers of faces, bottom sides and top sides."""
        turned = np.roll(self.faces, -faces), np.roll(self.below, -bottoms), np.roll(self.tops, -tops)
        return RegionRow(*turned, self.closed)


def stacked_rows(fabric: StitchMesh, inside: NDArray[np.bool_]) -> list[RegionRow]:
    """Return the rows of a region from the bottom up; a ring starts at any face.

    Args:
        fabric: stitch mesh.
        inside: whether each face belongs to the region, shape (F,).

    Raises:
        ParameterError: a face is no stitch of a pattern, rings and flat rows are mixed, or the rows do not form one
            stack in which each row is worked on all loops of the row below.
    """
    _check_stitches(fabric, inside)
    rows = [_region_row(fabric, np.array(run.faces), run.closed) for run in find_runs(fabric, inside)]
    flat = next((row for row in rows if not row.closed), None)
    ring = next((row for row in rows if row.closed), None)
    if flat and ring:
        raise ParameterError(
            f"region: {_place(fabric, ring)} is a whole ring and {_place(fabric, flat)} is not; "
            "take whole rings only, or leave a wale out of each ring"
        )
    lowest = [row for row in rows if not _taken(fabric, row, inside).any()]
    if len(lowest) != 1:
        ends = " and ".join(_place(fabric, row) for row in lowest[:2]) or "none"
        raise ParameterError(
            f"region: {len(lowest)} of its rows lie on no other row of it ({ends}); expected one, the lowest row of a "
            "rectangle: choose one part, without steps at its lower edge"
        )
    return _stack(fabric, rows, lowest[0])


def _check_stitches(fabric: StitchMesh, inside: NDArray[np.bool_]) -> None:
    bad = np.flatnonzero(inside & ~is_worked(fabric))
    if len(bad):
        name = stitch_name(fabric.stitch_type(int(fabric.stitch[bad[0]])))
        raise ParameterError(
            f"region: face {first_few(bad)}: is {name}, which no pattern holds; leave cast-on rows, bind-offs, "
            "drawn-through loops and panels out"
        )


def _region_row(fabric: StitchMesh, faces: IntArray, closed: bool) -> RegionRow:
    start = fabric.face_start[faces]
    bottoms = _ranges(start, fabric.n_bottom[faces], 1)
    tops = _ranges(fabric.left_wale[faces] - 1, fabric.n_top[faces], -1)
    return RegionRow(faces, sides_across(fabric, bottoms, TOP), tops, closed)


def _ranges(first: IntArray, count: IntArray, step: int) -> IntArray:
    """Return ``count`` numbers from each first number, ``step`` apart."""
    within: IntArray = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return np.repeat(first, count) + step * within


def _taken(fabric: StitchMesh, row: RegionRow, inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether each loop below a row is made by a face of the region, shape (b,)."""
    return np.asarray((row.below != BORDER) & inside[fabric.side_face[row.below]])


def _stack(fabric: StitchMesh, rows: list[RegionRow], lowest: RegionRow) -> list[RegionRow]:
    """Return the rows from the lowest row up."""
    number = np.full(fabric.face_count, BORDER)
    for index, row in enumerate(rows):
        number[row.faces] = index
    stack = [lowest]
    while len(stack) <= len(rows):
        above = faces_across(fabric, stack[-1].tops, BOTTOM)
        above = number[above[above != BORDER]]
        if not (above != BORDER).any():
            break
        stack.append(_on_top(fabric, stack[-1], rows[above[above != BORDER][0]]))
    if len(stack) != len(rows):
        seen = {int(row.faces.min()) for row in stack}
        left = next(row for row in rows if int(row.faces.min()) not in seen)
        raise ParameterError(
            f"region: {_place(fabric, left)} does not lie on the {len(stack)} rows from {_place(fabric, lowest)} up; "
            "expected one rectangle of wales and courses"
        )
    return stack


def _on_top(fabric: StitchMesh, below: RegionRow, row: RegionRow) -> RegionRow:
    """Return a row that is worked on exactly the loops of the row below it; a ring may begin at another loop.

    Raises:
        ParameterError: the row leaves loops out, or takes other loops.
    """
    turn = int(np.argmax(row.below == below.tops[0])) if row.closed else 0
    if not np.array_equal(np.roll(row.below, -turn), below.tops):
        missing, more = len(np.setdiff1d(below.tops, row.below)), len(np.setdiff1d(row.below, below.tops))
        raise ParameterError(
            f"region: {_place(fabric, row)} leaves out {missing} of the {len(below.tops)} loops of the row below in "
            f"the region, and takes {more} from elsewhere; expected a rectangle of wales and courses"
        )
    return row


def _place(fabric: StitchMesh, row: RegionRow) -> str:
    return f"row {fabric.row[row.faces[0]]} (face {row.faces[0]})"


@dataclass(frozen=True, eq=False)
class _Limits:
    """The limits before the faces of a ring, each shape (n,)."""

    bottoms: IntArray
    """Number of bottom sides of the ring before each limit."""
    tops: IntArray
    """Number of top sides of the ring before each limit."""
    low: IntArray
    """Place of each limit on the course line below, counted along the tops of the ring below."""


def cut_rings(fabric: StitchMesh, rings: list[RegionRow]) -> list[RegionRow]:
    """Return stacked rings that all start at one cut, as near as possible to the faces of the lowest numbers.

    Raises:
        ParameterError: decreases and cables leave no room for such a cut.
    """
    limits = [_limits(fabric, ring, rings[number - 1] if number else None) for number, ring in enumerate(rings)]
    free = _free_limits(fabric, rings, limits)
    if not free[0].any():
        raise ParameterError(
            "region: decreases and cables leave no line on which its rings can be cut open; "
            "leave a wale out of each ring, or take fewer rows"
        )
    result: list[RegionRow] = []
    at = None
    for ring, limit, possible in zip(rings, limits, free, strict=True):
        here = np.flatnonzero(possible if at is None else possible & (limit.low == at))
        first = int(here[np.argmin(ring.faces[here])])
        result.append(ring.rolled(first, int(limit.bottoms[first]), int(limit.tops[first])))
        at = int(limit.tops[first]) % len(ring.tops)
    return result


def _limits(fabric: StitchMesh, ring: RegionRow, under: RegionRow | None) -> _Limits:
    bottoms, tops = (np.cumsum(count) - count for count in (fabric.n_bottom[ring.faces], fabric.n_top[ring.faces]))
    turn = 0 if under is None else int(np.argmax(under.tops == ring.below[0]))
    return _Limits(bottoms, tops, (bottoms + turn) % max(len(ring.below), 1))


def _free_limits(fabric: StitchMesh, rings: list[RegionRow], limits: list[_Limits]) -> list[NDArray[np.bool_]]:
    """Return, for each ring, whether a cut may begin below it at each limit and run on to the highest ring."""
    free: list[NDArray[np.bool_]] = []
    open_above = np.ones(len(rings[-1].tops), dtype=bool)
    for number in range(len(rings) - 1, -1, -1):
        ring, limit = rings[number], limits[number]
        line = rings[number - 1].tops if number else ring.below
        possible = open_above[limit.tops % len(ring.tops)] & ~_crossed(fabric, line)[limit.low]
        free.append(possible)
        open_above = np.zeros(len(line), dtype=bool)
        open_above[limit.low[possible]] = True
    return free[::-1]


def _crossed(fabric: StitchMesh, line: IntArray) -> NDArray[np.bool_]:
    """Whether a loop of a cable passes between each top side of a closed course line and its left neighbour."""
    crossed = np.zeros(len(line), dtype=bool)
    shift = np.where(line == BORDER, 0, fabric.cable_shift[line])
    for place in np.flatnonzero(shift > 0).tolist():
        crossed[np.arange(place + 1, place + int(shift[place]) + 1) % len(line)] = True
    return crossed
