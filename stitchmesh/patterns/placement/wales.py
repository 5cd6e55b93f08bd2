# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Placement of a pattern on a garment or on a region: its columns follow the wales, and its rows follow the courses.

Columns are assigned to the loops of every row that starts a fabric or a region, and are carried upwards from loop to
loop. The pattern's row is counted from there, and it is the same along a whole course. A decrease passes on the column
of its visible loop. An increase makes new columns; they continue the columns of the neighbour on the side away from the
increase's own loop. The pattern therefore opens or closes at the line of shaping, and its columns stay straight beside
the line, as a knitter keeps them.
"""

from __future__ import annotations

from itertools import count

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, TOP, IntArray, StitchMesh
from stitchmesh.mesh.courses import Course, bottom_sides, knitting_order, sides_across, top_sides
from stitchmesh.mesh.stitch import VOCABULARY, Making, Stitch
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.placement.columns import OUTSIDE, Remainder, is_elastic, is_tile, lay_out, spread_tiles
from stitchmesh.patterns.placement.placement import Placement, find_runs, is_plain, is_worked
from stitchmesh.patterns.placement.rebuilt_runs import Rebuilt, RunPlan, line_above, line_below, rebuild_runs
from stitchmesh.patterns.placement.units import units_of
from stitchmesh.patterns.placement.whole_tiles import WholeTiles, shaped_faces
from stitchmesh.selection.wales import middle_of_front

_UNKNOWN = OUTSIDE - 1
"""Column of a loop to which no row below passes on a column."""
_FIRST_NEW_TILE = 1 << 20
"""Number of the first tile that begins above the first row."""


def follow_wales(
    fabric: StitchMesh, pattern: Pattern, remainder: Remainder, inside: NDArray[np.bool_], *, centre: bool = False
) -> tuple[Placement, Rebuilt | None]:
    """Place a pattern on every stitch of a region; its first row lies on the first row that is not a cast-on row.

    Args:
        fabric: stitch mesh.
        pattern: the pattern.
        remainder: what happens to the loops of a first row that whole tiles do not cover.
        inside: whether each face belongs to the region, shape (F,).
        centre: whether the middle of a tile lies in the middle of the front of each first row.

    Returns:
        The placement, and the change that moves the increases and decreases of the region to the limits of the tiles
        (``whole_tiles.py``), None if nothing moves. After the change the pattern must be placed again.

    Raises:
        ParameterError: ``remainder`` is ``refuse`` and whole tiles do not cover a first row.
    """
    wales = _WalePlacement(fabric, pattern, remainder, inside, centre)
    placement = wales.placement()
    return placement, rebuild_runs(fabric, wales.plans, np.zeros((0, 3))) if wales.plans else None


class _WalePlacement:
    """Columns of all loops and faces of a region, filled run by run from below."""

    def __init__(
        self, fabric: StitchMesh, pattern: Pattern, remainder: Remainder, inside: NDArray[np.bool_], centre: bool
    ) -> None:
        self.fabric, self.pattern, self.remainder, self.inside = fabric, pattern, remainder, inside
        self.centre = centre
        self.runs = find_runs(fabric, inside)
        self.run_of = np.full(fabric.face_count, BORDER)
        for number, run in enumerate(self.runs):
            self.run_of[list(run.faces)] = number
        self.level = np.full(len(self.runs), -1)  # rows of the pattern below each run; -1 for a cast-on row
        self.above = np.full(fabric.side_count, _UNKNOWN)  # column that each top side passes on
        self.column = np.full(fabric.face_count, OUTSIDE)
        self.tiles = None if is_elastic(pattern) else WholeTiles(pattern, units_of(pattern))
        self.new_tiles = count(_FIRST_NEW_TILE)
        self.plans: list[RunPlan] = []
        self.is_worked, self.is_plain = is_worked(fabric), is_plain(fabric)

    def placement(self) -> Placement:
        """Carry the columns through all runs and return the placement."""
        order, left = knitting_order(self._runs_below())
        for number in [*order, *left]:
            self._carry(number)
        placed = self.is_worked & self.inside
        level = np.where(self.inside, self.level[self.run_of], -1)
        return Placement(np.where(placed & (level >= 0), self.column, OUTSIDE), level % self.pattern.height)

    def _runs_below(self) -> list[set[int]]:
        """Return, for each run, the runs from which its loops come."""
        fabric = self.fabric
        sides = fabric.sides_of(np.flatnonzero(self.inside))
        across = sides_across(fabric, sides, TOP)
        under = self.run_of[fabric.side_face[across]]
        joined = (fabric.side_role[sides] == 0) & (across != BORDER) & (under != BORDER)
        below: list[set[int]] = [set() for _ in self.runs]
        pairs = np.unique(np.stack([self.run_of[fabric.side_face[sides[joined]]], under[joined]], axis=1), axis=0)
        for run, other in pairs.tolist():
            below[run].add(other)
        return below

    def _carry(self, number: int) -> None:
        run, fabric = self.runs[number], self.fabric
        faces = np.array(run.faces)
        below, known = self._columns_below(number)
        tops = np.array(top_sides(fabric, run.faces), dtype=np.int64)
        if known:
            below = _fill_unknown(below, run.closed)
            self.level[number] += 1
        elif (fabric.stitch[faces] == Stitch.CAST_ON).all():
            self.above[tops] = self._lay_out(tops, run)
            return
        else:
            below = self._lay_out(np.array(bottom_sides(fabric, run.faces), dtype=np.int64), run)
            self.level[number] = 0
        if self.level[number] % self.pattern.height == 0 and self.remainder != "refuse":
            below = self._begin_tiles(below, run)
        own = _own_columns(fabric, faces, below)
        self.column[faces] = own
        if not (self.tiles and self.is_worked[faces].all() and not self.is_plain[faces].all()):
            self.above[tops] = _columns_made(fabric, faces, own, run.closed)
        elif not self._keep_tiles_whole(self.tiles, run, below, own):
            self.above[tops] = _columns_made(fabric, faces, own, run.closed)

    def _keep_tiles_whole(self, tiles: WholeTiles, run: Course, below: IntArray, own: IntArray) -> bool:
        """Give columns to the loops above a shaped run, and plan its faces; return whether its tiles are in order."""
        fabric = self.fabric
        # A run whose shaping moves has at least this number of loops for each increase or decrease; a crown has fewer.
        if len(below) < 4 * abs(len(below) - int(fabric.n_top[list(run.faces)].sum())):
            return False
        start = _tile_start(fabric, run, below, tiles.width) if run.closed else 0
        turned = Course(run.faces[start:] + run.faces[:start], run.closed)
        faces = np.array(turned.faces)
        columns = np.roll(below, -int(fabric.n_bottom[list(run.faces[:start])].sum()))
        raw = np.repeat(_without_yarn_overs(np.roll(own, -start), fabric.n_bottom[faces]), fabric.n_top[faces])
        above = tiles.columns_above(columns, raw, self.new_tiles)
        if above is None:
            return False
        self.above[top_sides(fabric, turned.faces)] = above
        shaped = shaped_faces(columns, above, tiles.weights)
        if shaped:
            loops, stitch = shaped
            if not np.array_equal(loops, np.stack([fabric.n_bottom[faces], fabric.n_top[faces]], axis=1)):
                lines = line_below(fabric, turned), line_above(fabric, turned)
                self.plans.append(RunPlan(turned, *lines, loops, stitch))
        return True

    def _columns_below(self, number: int) -> tuple[IntArray, bool]:
        """Return the columns of the loops below a run, and whether any is known; set the level from the run below."""
        fabric = self.fabric
        bottoms = np.array(bottom_sides(fabric, self.runs[number].faces), dtype=np.int64)
        sides = sides_across(fabric, bottoms, TOP)
        columns = np.where(sides == BORDER, _UNKNOWN, self.above[sides])
        under = self.run_of[fabric.side_face[sides[columns != _UNKNOWN]]]
        if len(under):
            self.level[number] = self.level[under].max()
        return columns, len(under) > 0

    def _begin_tiles(self, below: IntArray, run: Course) -> IntArray:
        """Return the columns; new tiles begin where enough adjacent loops for a repeat lie outside the pattern."""
        width, outside = self.pattern.width, below == OUTSIDE
        if outside.all():
            whole = self._lay_out(np.array(bottom_sides(self.fabric, run.faces), dtype=np.int64), run)
            return below if (whole == OUTSIDE).all() else whole
        turn = int(np.argmin(outside)) if run.closed else 0
        columns = np.roll(below, -turn)
        places = np.flatnonzero(columns == OUTSIDE)
        for gap in np.split(places, np.flatnonzero(np.diff(places) > 1) + 1):
            if len(gap) >= width:
                columns[gap] = self._new_tiles(len(gap))
        return np.roll(columns, turn)

    def _new_tiles(self, loops: int) -> IntArray:
        """Return the columns of new tiles on a number of loops."""
        width = self.pattern.width
        tiles, rest = divmod(loops, width)
        numbers = np.array([next(self.new_tiles) for _ in range(tiles)])
        if self.remainder == "stretch":
            columns = spread_tiles(tiles, width, rest, closed=False)
        else:
            columns = np.concatenate([np.arange(tiles * width), np.full(rest, OUTSIDE)])
        tile, own = np.divmod(columns, width)
        return np.where(columns == OUTSIDE, OUTSIDE, numbers[np.where(columns == OUTSIDE, 0, tile)] * width + own)

    def _lay_out(self, loops: IntArray, run: Course) -> IntArray:
        """Return the columns of the loops at the course sides of a run."""
        fabric = self.fabric
        where = f"row {fabric.row[run.faces[0]]} (face {run.faces[0]})"
        ends = fabric.corner_position[loops], fabric.corner_position[fabric.side_next[loops]]
        middle = middle_of_front((ends[0] + ends[1]) / 2, run.closed) if self.centre else None
        return lay_out(
            self.pattern, len(loops), closed=run.closed, remainder=self.remainder, where=where, middle=middle
        )


def _tile_start(fabric: StitchMesh, run: Course, below: IntArray, width: int) -> int:
    """Return the place of a face of a ring that begins a tile; 0 if no face does.

    It prefers the first such face next to a limit of tiles to which no shaping moves.
    """
    low, high = fabric.n_bottom[list(run.faces)], fabric.n_top[list(run.faces)]
    tile = (below // width)[(np.cumsum(low) - low) % len(below)]
    begins = (tile != np.roll(tile, 1)) & (low > 0)
    starts, shaped = np.flatnonzero(begins), np.flatnonzero(low != high)
    if not len(starts):
        return 0
    ahead = shaped - starts[:, None]
    apart = np.minimum(ahead % len(low), (-1 - ahead) % len(low))
    return int(starts[np.argmin(np.isin(np.arange(len(starts)), apart.argmin(axis=0)))])


def _without_yarn_overs(own: IntArray, n_bottom: IntArray) -> IntArray:
    """Return the columns of faces; a face without a loop below continues the column of the face on its left."""
    worked = np.flatnonzero(n_bottom)
    if not len(worked):
        return own
    before = np.searchsorted(worked, np.arange(len(own)), side="right") - 1
    return own[worked[np.maximum(before, 0)]]


def _fill_unknown(columns: IntArray, closed: bool) -> IntArray:
    """Return the columns; unknown columns continue from the left, or from the right if none is known on the left."""
    known = np.flatnonzero(columns != _UNKNOWN)
    if len(known) == len(columns):
        return columns
    places = np.arange(len(columns))
    before = np.searchsorted(known, places, side="right") - 1
    source = known[before] - np.where((before < 0) & closed, len(columns), 0)
    source = np.where((before < 0) & (not closed), known[0], source)
    columns = columns[source % len(columns)]
    return np.where(is_tile(columns), columns + places - source, np.where(places == source, columns, OUTSIDE))


def _own_columns(fabric: StitchMesh, faces: IntArray, below: IntArray) -> IntArray:
    """Return the column of each face: the column of its loop, or of the visible loop of a decrease."""
    count = fabric.n_bottom[faces]
    shown = np.where(count > 1, _SHOWN[fabric.built_in[faces]], 0)
    places = np.minimum(np.cumsum(count) - count + shown, max(len(below) - 1, 0))
    return np.where(count > 0, below[places] if len(below) else OUTSIDE, OUTSIDE)


def _columns_made(fabric: StitchMesh, faces: IntArray, own: IntArray, closed: bool) -> IntArray:
    """Return the columns of all loops that a course makes, left to right."""
    count = fabric.n_top[faces]
    made = np.repeat(own, count)
    first = np.cumsum(count) - count
    for index in np.flatnonzero((count > 1) | ((count > 0) & (fabric.n_bottom[faces] == 0))):
        left = own[index - 1] if index or closed else OUTSIDE
        right = own[(index + 1) % len(own)] if index + 1 < len(own) or closed else OUTSIDE
        making = fabric.makings.get(int(fabric.stitch[faces[index]]))
        main = _main_loop(making) if making else 0
        made[first[index] : first[index] + count[index]] = [
            _column_beside(place, main, count[index], int(left), int(own[index]), int(right))
            for place in range(count[index])
        ]
    return made


def _main_loop(making: Making) -> int:
    """Return the index of the loop of an increase that keeps the column.

    The main loop is the first loop, the last loop if the first is a yarn-over, or the middle loop if both are
    yarn-overs.
    """
    if making.made[0] != "y":
        return 0
    return len(making.made) - 1 if making.made[-1] != "y" else len(making.made) // 2


def _column_beside(place: int, main: int, count: int, left: int, own: int, right: int) -> int:
    """Return the column of a loop of an increase.

    New columns left of the main loop continue the columns of the left neighbour, and new columns right of it those of
    the right one.

    Args:
        place: index of the loop in the increase.
        main: index of the loop that keeps the column.
        count: number of loops of the increase.
        left: column of the left neighbour.
        own: column of the increase.
        right: column of the right neighbour.
    """
    if place == main and own != OUTSIDE:
        return own
    neighbours = [(left, place + 1), (own, place - main), (right, place - count)]
    if place > main:
        neighbours.reverse()
    return next((column + steps for column, steps in neighbours if is_tile(np.array(column))), OUTSIDE)


def _shown_loops() -> IntArray:
    """Return the index of the loop in front of each decrease, as seen from the side on which it is knit."""
    shown = np.zeros(max(Stitch) + 1, dtype=np.int64)
    for stitch, making in VOCABULARY.items():
        if making.n_bottom > 1:
            shown[stitch] = (making.order[-1] if making.made == "p" else making.order[0]) - 1
    return shown


_SHOWN = _shown_loops()
