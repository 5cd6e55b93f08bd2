# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Capture: a region of a fabric becomes a pattern, which can be laid elsewhere.

The region is a rectangle in wales and courses. Its stitches, loops, cables and yarns become one tile without borders.
The row above a loop decides how the loop is crossed. The marks of the loops below the region therefore belong to the
pattern, and the marks of the loops on top of it do not. A half turn belongs to the stitch that works the loop if that
stitch is knit or purled through the back leg, and otherwise to the stitch that makes the loop.

Source: Yuksel et al. 2012, section 5.3, read backwards.

The smallest repeat of a pattern is the shortest tile, with the fewest rows, that gives the same fabric.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import gcd

import numpy as np

from stitchmesh.errors import ParameterError, PatternError, check_kind
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.palette import filled_palette
from stitchmesh.mesh.stitch import VOCABULARY
from stitchmesh.patterns.capture.region_rows import RegionRow, cut_rings, stacked_rows
from stitchmesh.patterns.pattern import Cell, Loop, Pattern, Row, check_closes
from stitchmesh.patterns.placement.placement import held_twist, region_of

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
