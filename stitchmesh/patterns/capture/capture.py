# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Capture: a region of a fabric becomes a pattern, which can be laid elsewhere.

The region is a rectangle in wales and courses. Its stitches, loops, cables and yarns become one tile without borders.
The row above a loop decides how the loop is crossed. The marks of the loops below the region therefore belong to the
pattern, and the marks of the loops on top of it do not. A half turn belongs to the stitch that works the loop if that
stitch is knit or purled through the back leg, and otherwise to the stitch that makes the loop.

Stacked rings are cut open along a line between stitches from the lowest to the highest ring. It meets each course line
between two loops, and no cable may cross it there. Where a yarn-over lies at the cut, the cut can pass on either side
of it.

Source: Yuksel et al. 2012, section 5.3, read backwards.

The smallest repeat of a pattern is the shortest tile, with the fewest rows, that gives the same fabric.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import gcd

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, PatternError, check_kind, first_few
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh import BORDER, BOTTOM, TOP, IntArray, StitchMesh
from stitchmesh.mesh.courses import faces_across, sides_across
from stitchmesh.mesh.palette import filled_palette
from stitchmesh.mesh.stitch import VOCABULARY
from stitchmesh.patterns.pattern import Cell, Loop, Pattern, Row, check_closes
from stitchmesh.patterns.placement.placement import find_runs, held_twist, is_worked, region_of


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


MOST_TOPS = max(making.n_top for making in VOCABULARY.values())


def capture_pattern(
    fabric: StitchMesh, faces: Iterable[int] | None = None, *, name: str = "captured", source: str = ""
) -> Pattern:
    """Return the pattern of a region of a fabric, seen from the right side, with its lowest row first.

    ``apply_pattern`` lays this pattern elsewhere with the same stitches. ``smallest_repeat`` reduces it to one repeat.

    Args:
        fabric: a mesh of stitches, relaxed or not.
        faces: numbers of the faces of the region, in any order; None for the whole fabric. The rows of the region are
            flat, or whole rings of a tube. The rings are cut open at the face with the lowest number of the lowest
            ring, if stitches and cables allow it.
        name: name of the pattern.
        source: where the pattern comes from.

    Raises:
        ParameterError: the region is no rectangle in wales and courses, a face holds no stitch of a pattern, or the
            fabric repeats on a lattice.
        PatternError: a cable crosses the limit of the region, or the highest row leaves another number of loops than
            the lowest row takes.
    """
    check_kind("capture_pattern", fabric, StitchMesh)
    if fabric.lattice is not None:
        raise ParameterError("fabric: repeats on a lattice; the chart from which it was made is its pattern")
    rows = stacked_rows(fabric, region_of(fabric, faces))
    if rows[0].closed:
        rows = cut_rings(fabric, rows)
    pattern = Pattern(name, source, tuple(_Rows(fabric, rows).rows()), _colours(fabric, rows))
    check_closes(pattern)
    return pattern


class _Rows:
    """The rows of the pattern; equal rows are made once."""

    def __init__(self, fabric: StitchMesh, region: list[RegionRow]) -> None:
        self.fabric, self.region = fabric, region
        self.held = held_twist(fabric)
        self.cells: dict[tuple[int, ...], Cell] = {}
        self.loops: dict[tuple[int, int, int], Loop] = {}
        self.known: dict[tuple[bytes, bytes], Row] = {}

    def rows(self) -> list[Row]:
        """Return the rows from the bottom up.

        Raises:
            PatternError: a cable crosses the limit of the region; the message names the row.
        """
        return [self._row(row) for row in self.region]

    def _row(self, row: RegionRow) -> Row:
        cells, loops = self._cell_numbers(row), self._loop_numbers(row)
        key = cells.tobytes(), loops.tobytes()
        if key not in self.known:
            try:
                self.known[key] = Row(self._cells(cells), self._loops(loops))
            except PatternError as error:
                where = f"region: row {self.fabric.row[row.faces[0]]} (face {row.faces[0]})"
                raise PatternError(f"{where}: {error}; widen the region or clear the cable") from None
        return self.known[key]

    def _cell_numbers(self, row: RegionRow) -> IntArray:
        """Return the stitch, the yarn and the twists of each face, shape (n, 2 + ``MOST_TOPS``)."""
        fabric, count = self.fabric, self.fabric.n_top[row.faces]
        numbers = np.zeros((len(row.faces), 2 + MOST_TOPS), dtype=np.int64)
        numbers[:, 0], numbers[:, 1] = fabric.stitch[row.faces], fabric.yarn[row.faces]
        face = np.repeat(np.arange(len(count)), count)
        place = np.arange(len(row.tops)) - np.repeat(np.cumsum(count) - count, count)
        numbers[face, 2 + place] = fabric.twist[row.tops] - self.held[row.tops]
        return numbers

    def _loop_numbers(self, row: RegionRow) -> IntArray:
        """Return shift, layer and twist of each loop below, shape (b, 3)."""
        fabric = self.fabric
        marks = np.stack([each[row.below] for each in (fabric.cable_shift, fabric.cable_layer, self.held)], axis=1)
        marks[row.below == BORDER] = 0
        return marks

    def _cells(self, numbers: IntArray) -> tuple[Cell, ...]:
        keys = list(map(tuple, numbers.tolist()))
        for key in set(keys) - self.cells.keys():
            n_top = self.fabric.makings[key[0]].n_top
            self.cells[key] = Cell(self.fabric.stitch_type(key[0]), key[2 : 2 + n_top], key[1])
        return tuple(self.cells[key] for key in keys)

    def _loops(self, numbers: IntArray) -> tuple[Loop, ...]:
        keys = [(shift, layer, twist) for shift, layer, twist in numbers.tolist()]
        for key in set(keys) - self.loops.keys():
            self.loops[key] = Loop(*key)
        return tuple(self.loops[key] for key in keys)


def _colours(fabric: StitchMesh, rows: list[RegionRow]) -> tuple[tuple[int, int, int], ...]:
    """Return the colours of the yarns of a region; empty if the fabric numbers its yarns only."""
    if not len(fabric.palette):
        return ()
    last = max(int(fabric.yarn[row.faces].max()) for row in rows)
    colours = filled_palette(fabric.palette, last + 1)[: last + 1].tolist()
    return tuple((red, green, blue) for red, green, blue in colours)


def smallest_repeat(pattern: Pattern) -> Pattern:
    """Return the pattern whose repeats give the same fabric as the repeats of a given pattern, with the fewest loops.

    A pattern that does not close keeps all its rows.
    """
    rows = _narrowest(pattern.rows)
    height = pattern.height
    if pattern.closes:
        height = next(count for count in _divisors(height) if rows[count:] == rows[: height - count])
    return replace(pattern, rows=rows[:height])


def _narrowest(rows: tuple[Row, ...]) -> tuple[Row, ...]:
    """Return the rows, with the tile divided into the largest possible number of equal parts."""
    parts = gcd(*(count for row in rows for count in (len(row.sections[1]), row.bottoms[1])))
    for number in _divisors(parts)[:0:-1]:
        divided = [_divided(row, number) for row in rows]
        whole = tuple(row for row in divided if row is not None)
        if len(whole) == len(rows):
            return whole
    return rows


def _divided(row: Row, parts: int) -> Row | None:
    """Return a row with one part of its tile; None if the parts differ, or if a cable joins two parts."""
    (left, tile, right), (before, held, after) = row.sections, row.loop_sections
    cells, loops = tile[: len(tile) // parts], held[: len(held) // parts]
    if cells * parts != tile or loops * parts != held:
        return None
    try:
        return Row((*left, *cells, *right), (*before, *loops, *after), row.left, row.right)
    except PatternError:
        return None


def _divisors(number: int) -> list[int]:
    return [count for count in range(1, number + 1) if number % count == 0]
