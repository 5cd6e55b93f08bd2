# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Columns of a pattern as numbers, and their arrangement along a row of loops.

A column of the tile is a whole number that increases from tile to tile. The columns of the two borders are counted
from ``LEFT_BASE`` and ``RIGHT_BASE``. A loop that stays unchanged has the column ``OUTSIDE``.
"""

from __future__ import annotations

import math
from typing import Literal, cast, get_args

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray
from stitchmesh.patterns.pattern import Pattern

Remainder = Literal["centre", "stretch", "refuse"]
"""What happens to the loops of a row that whole tiles do not cover."""
DEFAULT_REMAINDER: Remainder = "centre"

LEFT_BASE, RIGHT_BASE = 1 << 40, 1 << 41
OUTSIDE = -(1 << 42)
LEFT_BORDER, TILE, RIGHT_BORDER = range(3)
"""Indices of the sections of a row, in the order of ``pattern.SECTIONS``."""


def is_tile(columns: IntArray) -> np.ndarray:
    """Whether columns belong to a tile."""
    return np.abs(columns) < LEFT_BASE // 2


def columns_of(section: int, columns: IntArray) -> IntArray:
    """Return the columns of one section, counted from its first column; the others become ``OUTSIDE``."""
    if section == TILE:
        return np.where(is_tile(columns), columns, OUTSIDE)
    base = LEFT_BASE if section == LEFT_BORDER else RIGHT_BASE
    return np.where((columns >= base) & (columns < base + LEFT_BASE), columns - base, OUTSIDE)


def check_remainder(remainder: str) -> Remainder:
    """Check a word and return it as a ``Remainder``.

    Raises:
        ParameterError: the word is not one of ``Remainder``.
    """
    if remainder not in get_args(Remainder):
        raise ParameterError(f"remainder {remainder!r}: is unknown; expected one of {', '.join(get_args(Remainder))}")
    return cast(Remainder, remainder)


def keeps_counts(pattern: Pattern) -> bool:
    """Whether every stitch of a pattern has one loop below and one above."""
    return all(cell.n_bottom == cell.n_top == 1 for row in pattern.rows for cell in row.cells)


def is_elastic(pattern: Pattern) -> bool:
    """Whether columns of a pattern may be repeated or left out: all stitches have one loop, and no loops cross."""
    return keeps_counts(pattern) and not any(loop.shift for row in pattern.rows for loop in row.loops)


def lay_out(
    pattern: Pattern, count: int, *, closed: bool, remainder: Remainder, where: str, middle: float | None = None
) -> IntArray:
    """Return the column of each loop of a row, left to right, shape (count,).

    Args:
        pattern: the pattern along the row; its borders are used only if the row is not a ring.
        count: number of loops of the row.
        closed: whether the row is a ring.
        remainder: ``centre`` puts whole tiles in the middle of the row, or after the start of a ring, and leaves the
            other loops outside. ``stretch`` stretches the tiles over all loops, or spreads the other loops between the
            tiles. ``refuse`` raises an error if the tiles do not cover the row.
        where: the name of the row in messages.
        middle: number of loops of a ring before the place for the middle of a tile; in an open row a tile lies in the
            middle. None if the tiles lie as ``remainder`` says.

    Raises:
        ParameterError: ``remainder`` is ``refuse`` and whole tiles do not cover the row.
    """
    left, width, right = pattern.rows[0].bottoms
    if closed:
        left = right = 0
    tiles = (count - left - right) // width
    rest = count - left - right - tiles * width
    if remainder == "refuse" and (tiles < 1 or rest):
        fits = f"{left + right + max(tiles, 1) * width} or {left + right + max(tiles + 1, 2) * width}"
        raise ParameterError(
            f"{where}: got {count} loops for pattern {pattern.name!r}; expected a number such as {fits}, "
            "or another remainder"
        )
    if tiles < 1:
        return np.full(count, OUTSIDE)
    if middle is not None and not closed and tiles % 2 == 0 and remainder != "refuse":
        tiles, rest = tiles - 1, rest + width
    if remainder == "stretch" and is_elastic(pattern):
        inner, before, after = _resampled(count - left - right, width), 0, 0
    elif remainder == "stretch":
        inner, before, after = spread_tiles(tiles, width, rest, closed=closed), 0, 0
    else:
        inner, before = np.arange(tiles * width), rest if closed else rest // 2
        after = rest - before
    borders = LEFT_BASE + np.arange(left), RIGHT_BASE + np.arange(right)
    columns = np.concatenate([np.full(before, OUTSIDE), borders[0], inner, borders[1], np.full(after, OUTSIDE)])
    return columns if middle is None or not closed else _turned_to(middle, columns, tiles // 2, width)


def _turned_to(middle: float, columns: IntArray, tile: int, width: int) -> IntArray:
    """Return the columns of a ring, turned until the middle of a tile lies at a place."""
    own = np.flatnonzero(columns // width == tile)
    return np.roll(columns, math.floor(middle - (own[0] + own[-1] + 1) / 2 + 0.5))


def _resampled(count: int, width: int) -> IntArray:
    """Return the columns of the nearest whole number of tiles, stretched or compressed to the number of loops."""
    tiles = max(1, round(count / width))
    return (2 * np.arange(count) + 1) * (tiles * width) // (2 * count)


def spread_tiles(tiles: int, width: int, rest: int, *, closed: bool) -> IntArray:
    """Return the columns of whole tiles, and spread the remaining loops evenly between them and at the ends of a row.

    Args:
        tiles: number of tiles.
        width: loops of a tile.
        rest: number of remaining loops; their column is ``OUTSIDE``.
        closed: whether the row is a ring.
    """
    gaps = tiles if closed else tiles + 1
    gap = np.diff(np.arange(gaps + 1) * rest // gaps)
    columns = np.full(tiles * width + rest, OUTSIDE)
    tile = np.repeat(np.arange(tiles), width)
    columns[np.arange(tiles * width) + np.cumsum(gap)[tile]] = np.arange(tiles * width)
    return columns
