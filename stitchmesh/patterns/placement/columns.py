# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Columns of a pattern as numbers, and how they are laid along a row of loops.

A column of the tile is any whole number, counted on from tile to tile; columns of the two borders are counted from
``LEFT_BASE`` and ``RIGHT_BASE``. Loops that stay as they are have the column ``OUTSIDE``.
"""

from __future__ import annotations

from typing import Literal, cast, get_args

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray
from stitchmesh.patterns.pattern import Pattern

Remainder = Literal["centre", "stretch", "refuse"]
"""What is done with loops that whole tiles leave over."""
DEFAULT_REMAINDER: Remainder = "centre"

LEFT_BASE, RIGHT_BASE = 1 << 40, 1 << 41
OUTSIDE = -(1 << 42)
LEFT_BORDER, TILE, RIGHT_BORDER = range(3)
"""Sections of a pattern's rows, as ``pattern.SECTIONS`` lists them."""


def is_tile(columns: IntArray) -> np.ndarray:
    """Whether columns belong to a tile."""
    return np.abs(columns) < LEFT_BASE // 2


def columns_of(section: int, columns: IntArray) -> IntArray:
    """The columns of one section, counted from its first; ``OUTSIDE`` for those of others."""
    if section == TILE:
        return np.where(is_tile(columns), columns, OUTSIDE)
    base = LEFT_BASE if section == LEFT_BORDER else RIGHT_BASE
    return np.where((columns >= base) & (columns < base + LEFT_BASE), columns - base, OUTSIDE)


def check_remainder(remainder: str) -> Remainder:
    """The word, if it is one of ``Remainder``.

    Raises:
        ParameterError: it is not.
    """
    if remainder not in get_args(Remainder):
        raise ParameterError(f"remainder {remainder!r}: is unknown; expected one of {', '.join(get_args(Remainder))}")
    return cast(Remainder, remainder)


def keeps_counts(pattern: Pattern) -> bool:
    """Whether every stitch of a pattern takes one loop and makes one."""
    return all(cell.n_bottom == cell.n_top == 1 for row in pattern.rows for cell in row.cells)


def is_elastic(pattern: Pattern) -> bool:
    """Whether columns of a pattern may be doubled or left out: all its stitches are plain, and none crosses."""
    return keeps_counts(pattern) and not any(loop.shift for row in pattern.rows for loop in row.loops)


def lay_out(pattern: Pattern, count: int, *, closed: bool, remainder: Remainder, where: str) -> IntArray:
    """The column of each loop of a row, left to right, shape (count,).

    Args:
        pattern: what is laid along the row; its borders only where the row has ends.
        count: loops of the row.
        closed: whether the row is a ring.
        remainder: ``centre``: whole tiles in the middle, of a ring after its start, and the rest outside;
            ``stretch``: tiles are drawn out over all loops, or loops outside stand between them; ``refuse``.
        where: how a message names the row.

    Raises:
        ParameterError: loops are left over that must not be.
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
    if remainder == "stretch" and is_elastic(pattern):
        middle, before, after = _resampled(count - left - right, width), 0, 0
    elif remainder == "stretch":
        middle, before, after = part(tiles, width, rest, closed=closed), 0, 0
    else:
        middle, before = np.arange(tiles * width), rest if closed else rest // 2
        after = rest - before
    borders = LEFT_BASE + np.arange(left), RIGHT_BASE + np.arange(right)
    return np.concatenate([np.full(before, OUTSIDE), borders[0], middle, borders[1], np.full(after, OUTSIDE)])


def _resampled(count: int, width: int) -> IntArray:
    """As many tiles as come nearest, drawn out or in over all loops."""
    tiles = max(1, round(count / width))
    return (2 * np.arange(count) + 1) * (tiles * width) // (2 * count)


def part(tiles: int, width: int, rest: int, *, closed: bool) -> IntArray:
    """Whole tiles with the rest spread evenly between them, and at the ends where the row has any."""
    gaps = tiles if closed else tiles + 1
    gap = np.diff(np.arange(gaps + 1) * rest // gaps)
    columns = np.full(tiles * width + rest, OUTSIDE)
    tile = np.repeat(np.arange(tiles), width)
    columns[np.arange(tiles * width) + np.cumsum(gap)[tile]] = np.arange(tiles * width)
    return columns
