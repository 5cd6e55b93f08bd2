# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts of rows that form a grid, with one character per stitch, as seen from the right side.

The rows of a chart follow one another upwards. If a chart is periodic in width or in height, one period is drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from stitchmesh.hand_knitting.pieces import Piece, PieceRow
from stitchmesh.hand_knitting.rows import CableCrossings, places_below, twist_worked
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


@dataclass(frozen=True)
class PieceChart:
    """One repeat of consecutive rows of a piece."""

    what: Literal["stitches", "colours"]
    """What the symbols stand for."""
    title: str
    """The rows of the chart, and how often the repeat is worked."""
    rows: tuple[int, ...]
    """Number of each row in its piece, from the bottom up."""
    from_right: tuple[bool, ...]
    """Whether each row begins at its right end, where its number stands."""
    symbols: tuple[tuple[str, ...], ...]
    """Symbols of each row from left to right, the lowest row first; letters of yarns in a chart of colours."""

    @property
    def legend(self) -> list[tuple[str, str]]:
        """The symbols of stitches that occur, each with its meaning."""
        used = {symbol for row in self.symbols for symbol in row}
        return [entry for entry in _legend() if entry[0] in used] if self.what == "stitches" else []

    def lines(self) -> list[str]:
        """The chart as text: title, rows with the highest one first, and legend."""
        lines = [self.title]
        for number, right, row in reversed(list(zip(self.rows, self.from_right, self.symbols, strict=True))):
            lines.append(f"  {'' if right else number:>4} {''.join(row)} {number if right else ''}".rstrip())
        return lines + [f"  {symbol} {meaning}" for symbol, meaning in self.legend]


def piece_charts(fabric: StitchMesh, piece: Piece, crossings: CableCrossings) -> list[PieceChart]:
    """Return the charts of a piece.

    There is one chart for each block of consecutive rows that form a grid with more than one kind of stitch or yarn.

    Args:
        fabric: the stitch mesh.
        piece: a piece of the fabric.
        crossings: the cables of the fabric.
    """
    found: list[PieceChart] = []
    block: list[tuple[int, list[str], list[str]]] = []
    for number, row in enumerate(piece.rows):
        symbols = _row_symbols(fabric, row, crossings)
        if block and (symbols is None or len(symbols[0]) != len(block[0][1])):
            found += _charts_of(piece, block)
            block = []
        if symbols is not None:
            block.append((number, *symbols))
    return found + _charts_of(piece, block)


def _row_symbols(fabric: StitchMesh, row: PieceRow, crossings: CableCrossings) -> tuple[list[str], list[str]] | None:
    """The symbols and the colours of a row; None if the row does not fit into a grid."""
    if row.passed or row.left_over or row.bound_off:
        return None
    symbols = [_symbol(fabric, face, crossings) for face in row.faces]
    if None in symbols:
        return None
    return [str(symbol) for symbol in symbols], [colour_letter(int(yarn)) for yarn in fabric.yarn[list(row.faces)]]


def _symbol(fabric: StitchMesh, face: int, crossings: CableCrossings) -> str | None:
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


def _charts_of(piece: Piece, block: Sequence[tuple[int, list[str], list[str]]]) -> list[PieceChart]:
    """Charts of stitches and of colours of a block of rows, each only if there is more than one kind."""
    numbers = [number for number, _, _ in block]
    stitches, colours = [symbols for _, symbols, _ in block], [colours for _, _, colours in block]
    found = []
    if _has_kinds(stitches):
        found.append(_one_repeat(piece, "stitches", numbers, stitches))
    if _has_kinds(colours):
        found.append(_one_repeat(piece, "colours", numbers, colours))
    return found


def _has_kinds(grid: list[list[str]]) -> bool:
    """Whether a grid has several rows and more than one kind of symbol."""
    return len(grid) > 1 and len({symbol for row in grid for symbol in row}) > 1


def _one_repeat(
    piece: Piece, what: Literal["stitches", "colours"], numbers: list[int], grid: list[list[str]]
) -> PieceChart:
    """One repeat of a grid of symbols."""
    width = _period(list(zip(*grid, strict=True)))
    height = _period([tuple(row) for row in grid])
    name = "rounds" if piece.in_rounds else "rows"
    counts = [f"{width} sts, {len(grid[0]) // width} times"] if width < len(grid[0]) else []
    counts += [f"{height} {name}, {len(grid) // height} times"] if height < len(grid) else []
    repeat = f" (one repeat: {', '.join(counts)})" if counts else ""
    return PieceChart(
        what=what,
        title=f"Chart of {what}, {name} {numbers[0]} to {numbers[-1]}{repeat}:",
        rows=tuple(numbers[:height]),
        from_right=tuple(piece.rows[number].right_side for number in numbers[:height]),
        symbols=tuple(tuple(row[len(row) - width :]) for row in grid[:height]),
    )


def _legend() -> list[tuple[str, str]]:
    return [*SYMBOLS.values(), *TWISTED.values(), *CROSSED.values()]


def _period(items: Sequence[tuple[str, ...]]) -> int:
    """Length of the shortest block whose repetition gives the whole sequence."""
    count = len(items)
    for length in range(1, count):
        if count % length == 0 and all(items[place] == items[place % length] for place in range(length, count)):
            return length
    return count
