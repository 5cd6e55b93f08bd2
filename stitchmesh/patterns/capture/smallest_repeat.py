# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The smallest repeat of a pattern: the shortest tile, and the fewest rows, that give the same fabric."""

from __future__ import annotations

from dataclasses import replace
from math import gcd

from stitchmesh.errors import PatternError
from stitchmesh.patterns.pattern import Pattern, Row


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
    """Return the rows with the tile divided by the largest number of equal parts."""
    parts = gcd(*(count for row in rows for count in (len(row.sections[1]), row.bottoms[1])))
    for number in _divisors(parts)[:0:-1]:
        divided = [_divided(row, number) for row in rows]
        whole = tuple(row for row in divided if row is not None)
        if len(whole) == len(rows):
            return whole
    return rows


def _divided(row: Row, parts: int) -> Row | None:
    """Return a row with one of the equal parts of its tile; None if the parts differ, or if a cable joins two parts."""
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
