# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns moved or mirrored before they are laid.

A moved pattern is the same fabric, but its repeat begins elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.own_stitch import built_in
from stitchmesh.mesh.stitch import mirrored as mirrored_stitch
from stitchmesh.patterns.pattern import Cell, Loop, Pattern, Row


def mirrored_pattern(pattern: Pattern) -> Pattern:
    """Return a pattern with left and right exchanged, its borders too.

    Raises:
        ParameterError: the pattern has a stitch of the user's own, whose mirror image is not drawn.
    """
    if pattern.own_stitches:
        code = pattern.own_stitches[0].code
        raise ParameterError(f"pattern {pattern.name!r}: stitch {code} has no mirror image; leave mirror out")
    return replace(pattern, rows=tuple(map(_mirrored_row, pattern.rows)))


def _mirrored_row(row: Row) -> Row:
    return Row(mirrored_cells(row.cells), mirrored_loops(row.loops), left=row.right, right=row.left)


def mirrored_cells(cells: Sequence[Cell]) -> tuple[Cell, ...]:
    """Return stitches with left and right exchanged; each of them is a stitch of the vocabulary."""
    return tuple(
        Cell(mirrored_stitch(built_in(cell.stitch)), tuple(-twist for twist in cell.twist[::-1]), cell.yarn)
        for cell in cells[::-1]
    )


def mirrored_loops(loops: Sequence[Loop]) -> tuple[Loop, ...]:
    """Return the loops below stitches with left and right exchanged."""
    return tuple(Loop(-loop.shift, loop.layer, -loop.twist) for loop in loops[::-1])


def shifted_pattern(pattern: Pattern, columns: int = 0, rows: int = 0) -> Pattern:
    """Return a pattern whose tile begins elsewhere, so that its stitches lie further to the right and higher up.

    Args:
        pattern: the pattern; its borders stay.
        columns: number of loops to the right; negative to the left.
        rows: number of rows upwards; negative downwards.

    Raises:
        ParameterError: a stitch or a cable would lie across the new limit of the tile, or the pattern does not repeat
            upwards and cannot be moved there.
    """
    up = rows % pattern.height
    if up and not pattern.closes:
        raise ParameterError(f"pattern {pattern.name!r}: does not repeat upwards; shift it by columns only")
    cut = first = -columns % pattern.width
    made = []
    for number, row in enumerate(pattern.rows if first else (), start=1):
        where = f"pattern {pattern.name!r}, row {number}"
        turned, cut = _turned_row(row, cut, f"{where}: cannot be shifted by {columns} columns")
        made.append(turned)
    if cut != first:
        raise ParameterError(f"pattern {pattern.name!r}: its wales drift; shift it by rows only")
    turned_rows = tuple(made) or pattern.rows
    return replace(pattern, rows=(*turned_rows[pattern.height - up :], *turned_rows[: pattern.height - up]))


def possible_shifts(pattern: Pattern) -> tuple[int, ...]:
    """Return the numbers of columns, less than a repeat, by which a pattern can be shifted, in ascending order."""
    return tuple(columns for columns in range(1, pattern.width) if _can_shift(pattern, columns))


def _can_shift(pattern: Pattern, columns: int) -> bool:
    try:
        shifted_pattern(pattern, columns)
    except ParameterError:
        return False
    return True


def _turned_row(row: Row, cut: int, refusal: str) -> tuple[Row, int]:
    """Return a row whose tile begins with a later loop, and the number of loops on top of the stitches before it."""
    left, tile, right = row.sections
    below, above, place = 0, 0, 0
    while below < cut:
        below, above, place = below + tile[place].n_bottom, above + tile[place].n_top, place + 1
    loops_left, loops, loops_right = row.loop_sections
    crosses = any((at < cut) != (at + loop.shift < cut) for at, loop in enumerate(loops))
    if below > cut or crosses:
        raise ParameterError(f"{refusal}, because a stitch or a cable lies there; expected another number")
    cells = (*left, *tile[place:], *tile[:place], *right)
    held = (*loops_left, *loops[cut:], *loops[:cut], *loops_right)
    return replace(row, cells=cells, loops=held), above % row.tops[1]
