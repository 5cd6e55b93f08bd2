# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The largest grid of plain stitches around a face: adjacent rows of equal length, each directly above another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.courses import chain_through, right_neighbours
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.columns import OUTSIDE, Remainder, lay_out
from stitchmesh.patterns.placement.placement import Placement, is_plain, plain_above
from stitchmesh.selection.parts import face_centres
from stitchmesh.selection.wales import middle_of_front


@dataclass(frozen=True, eq=False)
class StitchGrid:
    """Plain stitches in adjacent rows and columns."""

    faces: IntArray
    """Faces of the grid from the lower left, shape (rows, columns)."""
    closed: bool
    """Whether the rows are rings."""


def grid_around(fabric: StitchMesh, face: int) -> StitchGrid:
    """Return the grid with the most stitches that contains a face.

    The grid ends at shaping, short rows, borders and rows that are knit in the other direction.

    Raises:
        ParameterError: the face does not exist, or is not a plain stitch.
    """
    _check_start(fabric, face)
    neighbours = _Neighbours(fabric)
    chain, closed = chain_through(face, neighbours.right.item, neighbours.left.item)
    row = np.roll(chain, -int(np.argmin(chain))) if closed else np.array(chain)
    place, closed = int(np.flatnonzero(row == face)[0]), closed and len(row) > 1
    up, down = neighbours.reach(row, neighbours.above, closed), neighbours.reach(row, neighbours.below, closed)
    columns, rows_up, rows_down = _largest_rectangle(up, down, place, closed)
    faces = row[columns]
    below = neighbours.rows_beyond(faces, neighbours.below, rows_down)[:0:-1]
    above = neighbours.rows_beyond(faces, neighbours.above, rows_up)
    return StitchGrid(np.array([*below, *above]), closed and len(columns) == len(row))


def fill_grid(
    fabric: StitchMesh, pattern: Pattern, grid: StitchGrid, remainder: Remainder, *, centre: bool = False
) -> Placement:
    """Place a pattern on a grid, from the bottom of the grid; ``centre`` means the same as in ``lay_pattern``.

    Raises:
        ParameterError: the pattern is wider than the grid, or ``remainder`` is ``refuse`` and whole repeats do not
            cover the grid.
    """
    rows, columns = grid.faces.shape
    where = f"grid at face {grid.faces[0, 0]}"
    if remainder == "refuse" and rows % pattern.height:
        found = f"got {rows} rows for the {pattern.height} of pattern {pattern.name!r}"
        raise ParameterError(f"{where}: {found}; expected a multiple of the pattern's rows, or another remainder")
    middle = middle_of_front(face_centres(fabric, grid.faces[0]), grid.closed) if centre else None
    along = lay_out(pattern, columns, closed=grid.closed, remainder=remainder, where=where, middle=middle)
    if (along == OUTSIDE).all():
        needed = pattern.width if grid.closed else sum(pattern.rows[0].bottoms)
        raise ParameterError(
            f"{where}: got {columns} columns; pattern {pattern.name!r} needs at least {needed}, choose another face"
        )
    placement = Placement.nowhere(fabric)
    placement.column[grid.faces] = along
    placement.row[grid.faces] = np.arange(rows)[:, None] % pattern.height
    return placement


def _check_start(fabric: StitchMesh, face: int) -> None:
    if not 0 <= face < fabric.face_count:
        raise ParameterError(f"face {face}: does not exist; the mesh has faces 0 to {fabric.face_count - 1}")
    if not is_plain(fabric)[face]:
        name = stitch_name(fabric.stitch_type(int(fabric.stitch[face])))
        found = f"{name} on {fabric.n_bottom[face]} bottom and {fabric.n_top[face]}"
        raise ParameterError(f"face {face}: is {found} top sides; a pattern starts from a plain stitch such as knit")


class _Neighbours:
    """The plain faces right of, left of, above and below each plain face; ``BORDER`` where there is none."""

    def __init__(self, fabric: StitchMesh) -> None:
        plain = is_plain(fabric)
        right = right_neighbours(fabric)
        self.right = np.where(plain & (right != BORDER) & plain[right], right, BORDER)
        self.above = plain_above(fabric)
        self.left, self.below = _reversed(self.right), _reversed(self.above)

    def reach(self, row: IntArray, step: IntArray, closed: bool) -> IntArray:
        """Return how far the columns of a row extend up or down.

        Args:
            row: faces of the row, left to right.
            step: the next face above or below each face.
            closed: whether the row is a ring.

        Returns:
            The number of further rows in each column, and the number of rows in which each column stays adjacent to the
            column on its right, shape (2, columns). The pair of the last column is that with the first column; it is
            used only if the row is a ring.
        """
        count = len(row)
        alone, paired = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
        start, there = set(row.tolist()), row
        live, joined = np.ones(count, dtype=bool), np.ones(count, dtype=bool)
        while True:
            there = np.where(live, step[there], BORDER)
            live = live & (there != BORDER)
            if not live.any() or start & set(there[live].tolist()):
                return np.stack([alone, paired])
            following = np.roll(there, -1)
            joined = joined & live & (self.right[there] == following) & (following != BORDER)
            alone += live
            paired += joined

    @staticmethod
    def rows_beyond(faces: IntArray, step: IntArray, rows: int) -> list[IntArray]:
        """Return a row and the rows beyond it, up to a given number."""
        result = [faces]
        for _ in range(rows):
            result.append(step[result[-1]])
        return result


def _reversed(step: IntArray) -> IntArray:
    back = np.full(len(step), BORDER)
    inner = np.flatnonzero(step != BORDER)
    back[step[inner]] = inner
    return back


def _largest_rectangle(up: IntArray, down: IntArray, place: int, closed: bool) -> tuple[IntArray, int, int]:
    """Return the columns, rows above and rows below of the largest rectangle that contains a column of the row."""
    count = up.shape[1]
    if closed:
        whole = int(up.min()), int(down.min())
        turn = np.roll(np.arange(count), count // 2 - place)
        best, *rows = _widest(up[:, turn], down[:, turn], count // 2)
        if count * (1 + sum(whole)) >= len(best) * (1 + sum(rows)):
            return np.arange(count), *whole
        return turn[best], rows[0], rows[1]
    best, *rows = _widest(up, down, place)
    return best, rows[0], rows[1]


def _widest(up: IntArray, down: IntArray, place: int) -> tuple[IntArray, int, int]:
    """Return the largest rectangle in an open row, over all combinations of a left and a right end."""
    reach = []
    for rows in (up, down):
        rightwards = np.minimum.accumulate(np.minimum(rows[0, place:], np.append(rows[0, place], rows[1, place:-1])))
        leftwards = np.minimum.accumulate(
            np.minimum(rows[0, place::-1], np.append(rows[0, place], rows[1, :place][::-1]))
        )
        reach.append(np.minimum(leftwards[:, None], rightwards[None, :]))
    width = np.arange(place + 1)[:, None] + np.arange(up.shape[1] - place)[None, :] + 1
    left, right = np.unravel_index(int(np.argmax(width * (1 + reach[0] + reach[1]))), width.shape)
    return np.arange(place - left, place + right + 1), int(reach[0][left, right]), int(reach[1][left, right])
