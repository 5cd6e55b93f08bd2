# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The units of a pattern: its smallest parts that make as many loops as they take.

A knit stitch is a unit, and so is a yarn-over together with the decrease that makes up for it. Where shaping or the end
of a row cuts a repeat, a knitter works the units whose loops are all there, and works the other stitches plain.

The module also finds the sites of the units: the rectangles of plain stitches that take them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.mesh.courses import right_neighbours
from stitchmesh.patterns.pattern import Cell, Loop, Pattern, crossings
from stitchmesh.patterns.placement.block import Block, build_block
from stitchmesh.patterns.placement.columns import LEFT_BORDER, OUTSIDE, RIGHT_BORDER, TILE, columns_of, keeps_counts
from stitchmesh.patterns.placement.placement import Placement, is_plain, plain_above


@dataclass(frozen=True, eq=False)
class Unit:
    """A part of one section of a pattern."""

    section: int
    """Section of the pattern, as in ``columns.py``."""
    row: int
    """First row of the unit."""
    column: int
    """First column of the unit."""
    block: Block
    """Faces of the unit."""


@dataclass(frozen=True, eq=False)
class Units:
    """All units of a pattern."""

    larger: tuple[Unit, ...]
    """Whole sections that hold increases or decreases come first, then the units of more than one stitch."""
    single: dict[tuple[int, int, int], Cell]
    """Units of one stitch, by section, row and column."""


@lru_cache(maxsize=32)
def units_of(pattern: Pattern) -> Units:
    """Divide a pattern into units; in each section, the last row makes as many loops as the first takes."""
    larger: list[Unit] = []
    single: dict[tuple[int, int, int], Cell] = {}
    sections = [section for section in range(3) if min(row.bottoms[section] for row in pattern.rows) >= 1]
    if not keeps_counts(pattern):
        larger += [_unit(pattern, section, 0, _whole(pattern, section)) for section in sections]
    for section in sections:
        for start, cuts in _parts(pattern, section):
            for left, right in pairwise(cuts):
                cells = _cells_between(pattern, section, start, left, right)
                if len(cells) == len(cells[0]) == cells[0][0].n_bottom == cells[0][0].n_top == 1:
                    single[section, start, left[0]] = cells[0][0]
                else:
                    larger.append(_unit(pattern, section, start, (left, right)))
    return Units(tuple(larger), single)


Cut = tuple[int, ...]
"""A line between two columns, as its place in the loops of each course line, from below."""


def _whole(pattern: Pattern, section: int) -> tuple[Cut, Cut]:
    counts = _counts(pattern, section)
    return (0,) * len(counts), counts


def _counts(pattern: Pattern, section: int) -> Cut:
    """Return the number of loops of a section on each course line, from below its first row to above its last row."""
    return (*(row.bottoms[section] for row in pattern.rows), pattern.rows[0].bottoms[section])


def _parts(pattern: Pattern, section: int) -> list[tuple[int, list[Cut]]]:
    """Return the first row of each part with equal numbers of loops below and above, and the cuts between its units."""
    counts = _counts(pattern, section)
    levels = [level for level, count in enumerate(counts) if count == counts[0]]
    result = []
    for start, end in pairwise(levels):
        cuts = [_cut(pattern, section, start, end, place) for place in range(counts[0] + 1)]
        result.append((start, [cut for cut in cuts if cut]))
    return result


def _cut(pattern: Pattern, section: int, start: int, end: int, place: int) -> Cut | None:
    """Return a cut between stitches from a place on one course line to the same place on a higher one, if there is one.

    A cut does not pass through a crossing on the lines between the two.
    """
    cuts: list[Cut] = [(place,)]
    for row in range(start, end):
        limits = _limits(pattern.rows[row].sections[section])
        cuts = [(*cut, above) for cut in cuts for below, above in limits if below == cut[-1]]
        if row + 1 < end:
            crossed = crossings(pattern.rows[row + 1].loop_sections[section])
            cuts = [cut for cut in cuts if not any(cable.start < cut[-1] < cable.stop for cable in crossed)]
    return next((cut for cut in cuts if cut[-1] == place), None)


def _limits(cells: tuple[Cell, ...]) -> list[tuple[int, int]]:
    """Return the numbers of loops below and above to the left of each limit between stitches."""
    limits = [(0, 0)]
    for cell in cells:
        limits.append((limits[-1][0] + cell.n_bottom, limits[-1][1] + cell.n_top))
    return limits


def _cells_between(pattern: Pattern, section: int, start: int, left: Cut, right: Cut) -> list[tuple[Cell, ...]]:
    """Return the stitches of each row between two cuts."""
    result = []
    for row in range(len(left) - 1):
        cells = pattern.rows[start + row].sections[section]
        limits = _limits(cells)
        first, last = (limits.index((cut[row], cut[row + 1])) for cut in (left, right))
        result.append(cells[first:last])
    return result


def _unit(pattern: Pattern, section: int, start: int, cuts: tuple[Cut, Cut]) -> Unit:
    left, right = cuts
    height = len(left) - 1
    held: list[tuple[Loop, ...]] = []
    for row in range(height):
        held.append(pattern.rows[start + row].loop_sections[section][left[row] : right[row]])
    loops = [after - before for before, after in zip(left, right, strict=True)]
    cells = _cells_between(pattern, section, start, left, right)
    return Unit(section, start, left[0], build_block(cells, loops, held, pattern))


@dataclass(frozen=True, eq=False)
class Site:
    """The places of all copies of a unit."""

    unit: Unit
    """The unit that is copied."""
    grids: IntArray
    """Plain faces that each copy replaces, from the lower left, shape (copies, rows, columns)."""

    @property
    def block(self) -> Block:
        """Faces of the unit."""
        return self.unit.block

    @property
    def face_count(self) -> int:
        """Number of faces of all copies."""
        return len(self.grids) * len(self.block.stitch)


class CellNumbers:
    """The number of each face's cell in a pattern whose cells are counted by base column and row."""

    def __init__(self, pattern: Pattern, placement: Placement) -> None:
        """Find the cell of each face; ``BORDER`` outside the pattern."""
        self._height = pattern.height
        self._first = np.cumsum([0, *pattern.rows[0].bottoms])
        self.of_face = np.full(len(placement.column), BORDER)
        for section in (LEFT_BORDER, TILE, RIGHT_BORDER):
            columns = columns_of(section, placement.column)
            own = np.flatnonzero(columns != OUTSIDE)
            width = max(pattern.rows[0].bottoms[section], 1)
            self.of_face[own] = self.number(section, placement.row[own], columns[own] % width)

    def number(self, section: int, row: IntArray | int, column: IntArray | int) -> IntArray:
        """Return the number of a cell."""
        number: IntArray = np.asarray(row * self._first[-1] + self._first[section] + column)
        return number


def find_sites(
    fabric: StitchMesh, placement: Placement, cells: CellNumbers, units: tuple[Unit, ...]
) -> tuple[list[Site], NDArray[np.bool_]]:
    """Find the sites of units; earlier units choose first.

    Args:
        fabric: the mesh.
        placement: the pattern's row and column of each face.
        cells: the number of each face's cell.
        units: units of the pattern, whole sections first.

    Returns:
        The sites that have copies, and whether each face belongs to a site, shape (F,).
    """
    free = is_plain(fabric) & (cells.of_face != BORDER)
    taken = np.zeros(fabric.face_count, dtype=bool)
    right, above = right_neighbours(fabric), plain_above(fabric)
    faces = np.flatnonzero(free)
    faces = faces[np.argsort(cells.of_face[faces], kind="stable")]
    numbers = cells.of_face[faces]
    sites = []
    for unit in units:
        number = cells.number(unit.section, unit.row, unit.column)
        first = faces[np.searchsorted(numbers, number) : np.searchsorted(numbers, number, side="right")]
        grids = _grids(first, unit.block, right, above)
        columns = placement.column[grids]
        whole = (grids != BORDER).all(axis=(1, 2)) & (free & ~taken)[grids].all(axis=(1, 2))
        whole &= (columns == columns[:, :1, :1] + np.arange(unit.block.width)).all(axis=(1, 2))
        whole &= (placement.row[grids] == unit.row + np.arange(unit.block.height)[:, None]).all(axis=(1, 2))
        whole &= (right[grids[:, :, :-1]] == grids[:, :, 1:]).all(axis=(1, 2))
        if whole.any():
            sites.append(Site(unit, grids[whole]))
            taken[grids[whole].ravel()] = True
    return sites, taken


def _grids(first: IntArray, block: Block, right: IntArray, above: IntArray) -> IntArray:
    """Return the faces to the right of and above each given face, shape (n, rows, columns)."""
    lowest = [first]
    for _ in range(block.width - 1):
        lowest.append(_neighbours(right, lowest[-1]))
    rows = [np.stack(lowest, axis=1)]
    for _ in range(block.height - 1):
        rows.append(_neighbours(above, rows[-1]))
    return np.stack(rows, axis=1)


def _neighbours(step: IntArray, faces: IntArray) -> IntArray:
    return np.where(faces == BORDER, BORDER, step[faces])
