# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts of rows that form a grid, with one character per stitch, as seen from the right side.

The rows of a chart follow one another upwards. If a chart is periodic in width or in height, one period is drawn.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.hand_knitting.pieces import Piece, PieceRow
from stitchmesh.hand_knitting.rows import Crossings, places_below, twist_worked
from stitchmesh.hand_knitting.words import colour_letter
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.cable_groups import CableGroup
from stitchmesh.mesh.own_stitch import OwnStitch
from stitchmesh.mesh.stitch import Stitch

SYMBOLS = {
    Stitch.KNIT: (".", "knit on the right side"),
    Stitch.PURL: ("-", "purl on the right side"),
    Stitch.SLIP_BACK: ("v", "slip, yarn on the wrong side"),
    Stitch.SLIP_FRONT: ("^", "slip, yarn on the right side"),
    Stitch.WRAP: ("w", "slip and wrap"),
}
"""Symbols and explanations of stitches with one loop below and one loop on top."""
CROSSED = {
    ("left", Stitch.KNIT): ("\\", "knit, crosses to the left in front of the others"),
    ("right", Stitch.KNIT): ("/", "knit, crosses to the right in front of the others"),
    ("behind", Stitch.KNIT): ("x", "knit, crosses behind"),
    ("left", Stitch.PURL): ("{", "purl, crosses to the left in front of the others"),
    ("right", Stitch.PURL): ("}", "purl, crosses to the right in front of the others"),
    ("behind", Stitch.PURL): ("X", "purl, crosses behind"),
}
"""Symbols and explanations of stitches whose loop crosses others, by the motion of the loop on the right side."""
TWISTED = {Stitch.KNIT: ("t", "knit through the back loop"), Stitch.PURL: ("T", "purl through the back loop")}
"""Symbols and explanations of stitches on a loop whose right leg is in front."""


def charts(fabric: StitchMesh, piece: Piece, crossings: Crossings) -> list[str]:
    """Return the lines of the charts of a piece.

    There is one chart for each block of consecutive rows that form a grid with more than one kind of stitch or yarn.

    Args:
        fabric: the stitch mesh.
        piece: a piece of the fabric.
        crossings: the cables of the fabric.
    """
    lines: list[str] = []
    block: list[tuple[int, list[str], list[str]]] = []
    for number, row in enumerate(piece.rows):
        symbols = _row_symbols(fabric, row, crossings)
        if block and (symbols is None or len(symbols[0]) != len(block[0][1])):
            lines += _chart(piece, block)
            block = []
        if symbols is not None:
            block.append((number, *symbols))
    return lines + _chart(piece, block)


def _row_symbols(fabric: StitchMesh, row: PieceRow, crossings: Crossings) -> tuple[list[str], list[str]] | None:
    """The symbols and the colours of a row; None if the row does not fit into a grid."""
    if row.passed or row.left_over or row.bound_off:
        return None
    symbols = [_symbol(fabric, face, crossings) for face in row.faces]
    if None in symbols:
        return None
    return [str(symbol) for symbol in symbols], [colour_letter(int(yarn)) for yarn in fabric.yarn[list(row.faces)]]


def _symbol(fabric: StitchMesh, face: int, crossings: Crossings) -> str | None:
    """The symbol of a stitch; None if there is none."""
    stitch = fabric.stitch_type(int(fabric.stitch[face]))
    if isinstance(stitch, OwnStitch) or stitch not in SYMBOLS:
        return None
    below = places_below(fabric, face)
    group = crossings.group_at.get(below[0]) if below else None
    motion = None if group is None else motion_to(group, group.sides.tolist().index(below[0]))
    twisted = bool(below) and twist_worked(fabric, crossings.loop_at.get(below[0], below[0])) == -1
    if motion is not None:
        return None if twisted or (motion, stitch) not in CROSSED else CROSSED[motion, stitch][0]
    return (TWISTED.get(stitch, SYMBOLS[stitch]) if twisted else SYMBOLS[stitch])[0]


def motion_to(group: CableGroup, place: int) -> str | None:
    """Return how the loop that comes to a place of a cable moves, as seen from the right side.

    Args:
        group: the cable.
        place: a place of the group, from the left.

    Returns:
        ``left`` or ``right`` if the loop passes in front of all loops that it crosses, ``behind`` if it passes behind a
        loop, None if it crosses no loop.
    """
    loop = int(np.flatnonzero(group.destination == place)[0])
    others = np.arange(len(group.destination))
    crossed = (others - loop) * (group.destination - place) < 0
    if not crossed.any():
        return None
    if (group.layer[crossed] > group.layer[loop]).any():
        return "behind"
    return "left" if place < loop else "right"


def _chart(piece: Piece, block: Sequence[tuple[int, list[str], list[str]]]) -> list[str]:
    """Charts of stitches and of colours of a block of rows, each only if there is more than one kind."""
    lines = []
    grids = {"stitches": [symbols for _, symbols, _ in block], "colours": [colours for _, _, colours in block]}
    for what, grid in grids.items():
        kinds = {symbol for row in grid for symbol in row}
        if len(grid) > 1 and len(kinds) > 1:
            lines += _drawing(piece, what, [row[0] for row in block], grid)
            if what == "stitches":
                lines += [f"  {symbol} {meaning}" for symbol, meaning in _legend() if symbol in kinds]
    return lines


def _drawing(piece: Piece, what: str, numbers: list[int], grid: list[list[str]]) -> list[str]:
    """Title and rows of one chart; the number of a row is written on the side where the row starts."""
    width = _period(list(zip(*grid, strict=True)))
    height = _period([tuple(row) for row in grid])
    name = "rounds" if piece.in_rounds else "rows"
    counts = [f"{width} sts, {len(grid[0]) // width} times"] if width < len(grid[0]) else []
    counts += [f"{height} {name}, {len(grid) // height} times"] if height < len(grid) else []
    repeat = f" (one repeat: {', '.join(counts)})" if counts else ""
    lines = [f"Chart of {what}, {name} {numbers[0]} to {numbers[-1]}{repeat}:"]
    for number, row in reversed(list(zip(numbers[:height], grid, strict=False))):
        text = "".join(row[len(row) - width :])
        right = piece.rows[number].right_side
        lines.append(f"  {'' if right else number:>4} {text} {number if right else ''}".rstrip())
    return lines


def _legend() -> list[tuple[str, str]]:
    return [*SYMBOLS.values(), *TWISTED.values(), *CROSSED.values()]


def _period(items: Sequence[tuple[str, ...]]) -> int:
    """Length of the shortest block of which the whole sequence is a repetition."""
    count = len(items)
    for length in range(1, count):
        if count % length == 0 and all(items[place] == items[place % length] for place in range(length, count)):
            return length
    return count
