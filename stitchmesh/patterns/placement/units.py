# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The units of a pattern: its smallest parts that leave as many loops as they are worked on.

A knit stitch is a unit, and so are a yarn-over and the decrease that makes up for it. If shaping or the end of a row
cuts a repeat, a knitter works the units whose loops are all there, and works the other stitches plain.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

from stitchmesh.patterns.pattern import Cell, Loop, Pattern, crossings
from stitchmesh.patterns.placement.block import Block, build_block
from stitchmesh.patterns.placement.columns import keeps_counts


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
    """Whole sections if they hold increases or decreases, then the units of more than one stitch."""
    single: dict[tuple[int, int, int], Cell]
    """Units of one stitch, by section, row and column."""


@lru_cache(maxsize=32)
def units_of(pattern: Pattern) -> Units:
    """Divide a pattern into units; in each section, the last row makes as many loops as the first is worked on."""
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
"""A line between two columns: its place in the loops of each course line, from below."""


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
    """Return a cut between stitches from one place of a course line to the same place of a higher one, if any exists.

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
