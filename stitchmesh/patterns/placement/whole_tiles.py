# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tiles that stay whole where a garment is shaped: new loops begin between tiles, and tiles lose loops at their limits.

A knitter works increased loops plainly between two repeats until they are enough for a repeat, and decreases such loops
first. If there are none, the repeat loses the less important of its two end columns. The shaping stitches of a row are
therefore moved to the nearest limit of a tile, and are worked together with the less important of the stitches beside
them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from stitchmesh.mesh import IntArray
from stitchmesh.mesh.shaping_stitches import Keeps, shaping_stitch
from stitchmesh.patterns.pattern import Pattern, crossings
from stitchmesh.patterns.placement.columns import OUTSIDE, TILE, is_tile
from stitchmesh.patterns.placement.rebuilt_runs import MOST_LOOPS, spread_loops
from stitchmesh.patterns.placement.units import Units


def column_weights(pattern: Pattern, units: Units) -> IntArray:
    """Return in how many rows each column of a tile is part of a crossing or of a unit of several stitches."""
    weights = np.zeros(pattern.width, dtype=np.int64)
    for number, row in enumerate(pattern.rows):
        crossed = {place for cable in crossings(row.loop_sections[TILE]) for place in cable}
        for column in range(pattern.width):
            weights[column] += column in crossed or (TILE, number, column) not in units.single
    return weights


@dataclass
class _Part:
    """Loops of one tile on a course line, or one loop of a border."""

    tile: int
    """Number of the tile, or the column of a border."""
    in_tile: bool
    """Whether the part belongs to a tile."""
    columns: list[int]
    """Columns of the loops, counted from the first column of the tile."""
    loops: int = 0
    """Number of loops that the part shall have."""
    near_left: bool = False
    """Whether its loops begin or end in the left half of the part."""


@dataclass
class _Line:
    """The parts of a course line from left to right."""

    parts: list[_Part] = field(default_factory=list)
    outside: list[int] = field(default_factory=lambda: [0])
    """Number of loops outside the pattern before each part, and after the last one."""


class WholeTiles:
    """The rules that tiles of one pattern obey where a garment is shaped."""

    def __init__(self, pattern: Pattern, units: Units) -> None:
        """Weigh the columns of the pattern."""
        self.width, self.weights = pattern.width, column_weights(pattern, units)

    def columns_above(self, below: IntArray, raw: IntArray, new_tiles: Iterator[int]) -> IntArray | None:
        """Return the columns of the loops above a shaped run; None if the tiles of the run are not in order.

        Args:
            below: columns of the loops below the run.
            raw: for each loop above, the column of the loop that it continues.
            new_tiles: numbers for tiles that begin in the run.
        """
        old, line = self._parts(below), self._parts(raw)
        before = {part.tile: part for part in old.parts}
        tiles = [part.tile for part in line.parts]
        in_order = len(before) == len(old.parts) and tiles == [part.tile for part in old.parts if part.tile in tiles]
        in_order &= all((np.diff(part.columns) == 1).all() for part in old.parts)
        if not in_order:
            return None
        for part in line.parts:
            part.loops, part.near_left = len(part.columns), _near_left(part.columns, before[part.tile].columns)
            part.columns = before[part.tile].columns
        for index in range(len(line.parts)):
            self._keep_whole(line, index)
        for index in reversed(range(len(line.parts))):
            self._begin_tile(line, index, new_tiles)
        for index, part in enumerate(line.parts):
            self._choose_columns(line, index, part)
        return self._columns(line)

    def _parts(self, columns: IntArray) -> _Line:
        line = _Line()
        for column, in_tile in zip(columns.tolist(), is_tile(columns).tolist(), strict=True):
            if column == OUTSIDE:
                line.outside[-1] += 1
                continue
            tile, own = divmod(column, self.width) if in_tile else (column, 0)
            if not (line.parts and line.parts[-1].tile == tile and not line.outside[-1]):
                line.parts.append(_Part(tile, in_tile, []))
                line.outside.append(0)
            line.parts[-1].columns.append(own)
        return line

    def _keep_whole(self, line: _Line, index: int) -> None:
        """Give a part the loops that it lacks: loops outside the pattern, and loops of cut tiles beside it."""
        part = line.parts[index]
        for side in _sides(part, index) if part.in_tile else ():
            missing = max(len(part.columns) - part.loops, 0)
            taken = min(missing, line.outside[side])
            line.outside[side] -= taken
            part.loops += taken
            beside = self._cut_tile_beside(line, index, side)
            if beside and len(part.columns) == self.width:
                taken = min(missing - taken, beside.loops)
                beside.loops -= taken
                part.loops += taken

    def _begin_tile(self, line: _Line, index: int, new_tiles: Iterator[int]) -> None:
        """Pass the excess loops of a tile to a cut tile beside it, or to a new tile."""
        part = line.parts[index]
        sides = _sides(part, index)
        surplus = part.loops - (self.width if part.in_tile else 1)
        for side in sides:
            beside = self._cut_tile_beside(line, index, side)
            if surplus > 0 and beside:
                passed = min(surplus, self.width - beside.loops)
                beside.loops += passed
                part.loops -= passed
                surplus -= passed
        if surplus > 0:
            part.loops -= surplus
            self._insert(line, index, surplus, sides[0] == index, next(new_tiles))

    def _insert(self, line: _Line, index: int, loops: int, on_left: bool, tile: int) -> None:
        """Insert a new tile that begins beside a part, or add the loops to those outside the pattern there."""
        side = index if on_left else index + 1
        if line.outside[side]:
            line.outside[side] += loops
            return
        columns = list(range(self.width - loops, self.width) if on_left else range(loops))
        line.parts.insert(side, _Part(tile, True, columns[: self.width], loops))
        line.outside.insert(side + on_left, 0)

    def _cut_tile_beside(self, line: _Line, index: int, side: int) -> _Part | None:
        """Return the tile directly beside a part on one side, if the tile is not whole."""
        beside = side - 1 if side == index else side
        if line.outside[side] or not 0 <= beside < len(line.parts):
            return None
        part = line.parts[beside]
        return part if part.in_tile and len(part.columns) < self.width and part.loops < self.width else None

    def _choose_columns(self, line: _Line, index: int, part: _Part) -> None:
        """Give the loops of a part adjacent columns.

        Loops outside the pattern that complete the part get columns too.
        """
        if not part.in_tile or not part.loops:
            part.columns = part.columns[: part.loops]
            return
        first, last = self._narrowed(part)
        for side in _sides(part, index):
            more = part.loops - (last - first + 1)
            first, last = (max(first - more, 0), last) if side == index else (first, min(last + more, self.width - 1))
        taken = min(first, line.outside[index]), min(self.width - 1 - last, line.outside[index + 1])
        line.outside[index] -= taken[0]
        line.outside[index + 1] -= taken[1]
        part.columns = list(range(first - taken[0], last + taken[1] + 1))

    def _narrowed(self, part: _Part) -> tuple[int, int]:
        """Return the first and the last remaining column of a tile that loses columns at its ends."""
        first, last = part.columns[0], part.columns[-1]
        while last - first + 1 > part.loops:
            left, right = self.weights[first], self.weights[last]
            if left < right or (left == right and part.near_left):
                first += 1
            else:
                last -= 1
        return first, last

    def _columns(self, line: _Line) -> IntArray:
        columns = [OUTSIDE] * line.outside[0]
        for part, outside in zip(line.parts, line.outside[1:], strict=True):
            columns += [part.tile * self.width + own if part.in_tile else part.tile for own in part.columns]
            columns += [OUTSIDE] * outside
        return np.array(columns, dtype=np.int64)


def _sides(part: _Part, index: int) -> tuple[int, int]:
    """Return the place before and the place after a part; the one nearer to the shaping of the part comes first."""
    return (index, index + 1) if part.near_left else (index + 1, index)


def _near_left(columns: list[int], before: list[int]) -> bool:
    """Return whether the loops of a tile begin or end in its left half."""
    steps = np.diff(columns) != 1
    if not steps.any():
        return columns[0] > before[0]
    return 2 * (int(np.argmax(steps)) + 1) <= len(columns)


def shaped_faces(below: IntArray, above: IntArray, weights: IntArray) -> tuple[IntArray, IntArray] | None:
    """Return the faces of a run. Columns continue upwards, and all increases and decreases lie between them.

    Args:
        below: columns of the loops below the run.
        above: columns of the loops above the run.
        weights: weight of each column of a tile (``column_weights``).

    Returns:
        The numbers of loops below and above each face, shape (n, 2), and the stitches, shape (n,); None if there are
        too many loops at one place for a stitch.
    """
    builder = _Faces()
    places = {column: place for place, column in enumerate(above.tolist()) if column != OUTSIDE}
    i = j = 0
    for place, column in enumerate([*below.tolist(), None]):
        if column is not None and column not in places:
            continue
        end = len(above) if column is None else places[column]
        if end < j or (column is None and i == place == 0):
            return None
        gap = [*below[i:place].tolist(), *above[j:end].tolist()]
        left = below[i - 1 : i].tolist()
        on_right = bool(gap) and column is not None and _belongs_right(left, gap[-1], column, weights)
        if not builder.fill(place - i, end - j, on_right=on_right, last=column is None):
            return None
        if column is not None:
            builder.add(1, 1, "left")
        i, j = place + 1, end + 1
    if builder.pending or (np.array(builder.loops).max() > MOST_LOOPS):
        return None
    faces = zip(builder.loops, builder.keeps, strict=True)
    stitches = [int(shaping_stitch(low, high, keeps=keeps)) for (low, high), keeps in faces]
    return np.array(builder.loops), np.array(stitches)


def _belongs_right(left: list[int], gap: int, right: int, weights: IntArray) -> bool:
    """Return whether a column that begins or ends is worked with the column on its right, and not on its left.

    It is worked with the column of less weight; if both weigh the same, with the column of its own tile.
    """
    width = len(weights)
    if left and is_tile(np.array([*left, right])).all() and weights[left[0] % width] != weights[right % width]:
        return bool(weights[right % width] < weights[left[0] % width])
    return gap != OUTSIDE and gap // width == right // width


@dataclass
class _Faces:
    """Faces of a run, from left to right."""

    loops: list[list[int]] = field(default_factory=list)
    keeps: list[Keeps] = field(default_factory=list)
    pending: list[int] = field(default_factory=list)
    """Loops below and above that wait for the next face, which takes them at its left."""

    def add(self, below: int, above: int, keeps: Keeps) -> None:
        """Add a face that takes the pending loops."""
        if self.pending:
            below, above, keeps, self.pending = below + self.pending[0], above + self.pending[1], "right", []
        self.loops.append([below, above])
        self.keeps.append(keeps)

    def fill(self, below: int, above: int, *, on_right: bool, last: bool) -> bool:
        """Add the faces between two columns of the pattern; return whether there are stitches with so many loops."""
        if below and above:
            if max(below, above) > MOST_LOOPS * min(below, above):
                return False
            for low, high in spread_loops(below, above).tolist():
                self.add(low, high, "left")
        elif below or above:
            on_left = bool(self.loops) and self.loops[-1] == [1, 1]
            if on_left and (last or not on_right or below + above > 1):
                shared = 1 if below + above > 1 and not last else max(below, above)
                taken = min(below, shared), min(above, shared)
                self.loops[-1] = [1 + taken[0], 1 + taken[1]]
                self.keeps[-1] = "left"
                below, above = below - taken[0], above - taken[1]
            if (below or above) and last:
                return False
            self.pending = [below, above] if below or above else []
        return True
