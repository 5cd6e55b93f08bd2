# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts: where the rows of a piece form a grid, one character for each stitch, as seen from the right side.

Rows run upwards. Where a chart repeats, in width or in height, one repeat is drawn.
"""

from __future__ import annotations

from collections.abc import Sequence

from stitchmesh.hand_knitting.pieces import Piece, PieceRow
from stitchmesh.hand_knitting.rows import places_below
from stitchmesh.hand_knitting.words import colour_letter
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch

SYMBOLS = {
    Stitch.KNIT: (".", "knit on the right side"),
    Stitch.PURL: ("-", "purl on the right side"),
    Stitch.SLIP_BACK: ("v", "slip, yarn on the wrong side"),
    Stitch.SLIP_FRONT: ("^", "slip, yarn on the right side"),
    Stitch.WRAP: ("w", "slip and wrap"),
}
"""Stitches of one loop below and one on top."""
TWISTED = {Stitch.KNIT: ("t", "knit through the back loop"), Stitch.PURL: ("T", "purl through the back loop")}
"""The same worked on a loop whose right leg is in front."""


def charts(fabric: StitchMesh, piece: Piece) -> list[str]:
    """Lines of the charts of a piece: one for each stretch of rows that is a grid of more than one kind of stitch."""
    lines: list[str] = []
    stretch: list[tuple[int, list[str], list[str]]] = []
    for number, row in enumerate(piece.rows):
        drawn = _drawn(fabric, row)
        if stretch and (drawn is None or len(drawn[0]) != len(stretch[0][1])):
            lines += _chart(piece, stretch)
            stretch = []
        if drawn is not None:
            stretch.append((number, *drawn))
    return lines + _chart(piece, stretch)


def _drawn(fabric: StitchMesh, row: PieceRow) -> tuple[list[str], list[str]] | None:
    """The symbols and the colours of a row; None where it does not fit a grid."""
    if row.passed or row.left_over or row.bound_off:
        return None
    symbols = []
    for face in row.faces:
        stitch = Stitch(int(fabric.stitch[face]))
        if stitch not in SYMBOLS:
            return None
        below = places_below(fabric, face)
        twisted = bool(below) and fabric.twist[below[0]] == -1
        symbols.append((TWISTED.get(stitch, SYMBOLS[stitch]) if twisted else SYMBOLS[stitch])[0])
    return symbols, [colour_letter(int(yarn)) for yarn in fabric.yarn[list(row.faces)]]


def _chart(piece: Piece, stretch: Sequence[tuple[int, list[str], list[str]]]) -> list[str]:
    """Charts of stitches and of colours, each only where there is more than one kind."""
    lines = []
    grids = {"stitches": [symbols for _, symbols, _ in stretch], "colours": [colours for _, _, colours in stretch]}
    for what, grid in grids.items():
        kinds = {symbol for row in grid for symbol in row}
        if len(grid) > 1 and len(kinds) > 1:
            lines += _drawing(piece, what, [row[0] for row in stretch], grid)
            if what == "stitches":
                lines += [f"  {symbol} {meaning}" for symbol, meaning in _legend() if symbol in kinds]
    return lines


def _drawing(piece: Piece, what: str, numbers: list[int], grid: list[list[str]]) -> list[str]:
    width = _period(list(zip(*grid, strict=True)))
    height = _period([tuple(row) for row in grid])
    name = "rounds" if piece.in_rounds else "rows"
    told = [f"{width} sts, {len(grid[0]) // width} times"] if width < len(grid[0]) else []
    told += [f"{height} {name}, {len(grid) // height} times"] if height < len(grid) else []
    repeat = f" (one repeat: {', '.join(told)})" if told else ""
    lines = [f"Chart of {what}, {name} {numbers[0]} to {numbers[-1]}{repeat}:"]
    for number, row in reversed(list(zip(numbers[:height], grid, strict=False))):
        text = "".join(row[len(row) - width :])
        right = piece.rows[number].right_side
        lines.append(f"  {'' if right else number:>4} {text} {number if right else ''}".rstrip())
    return lines


def _legend() -> list[tuple[str, str]]:
    return [*SYMBOLS.values(), *TWISTED.values()]


def _period(items: Sequence[tuple[str, ...]]) -> int:
    """Length of the shortest block that the whole sequence repeats."""
    count = len(items)
    for length in range(1, count):
        if count % length == 0 and all(items[place] == items[place % length] for place in range(length, count)):
            return length
    return count
