# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conversion of written rows to rows of a pattern; a stitch above a tuck works the two loops of the tuck together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from stitchmesh.errors import PatternError
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.language.tokens import TextPlace
from stitchmesh.patterns.language.words import WordStitches, single
from stitchmesh.patterns.pattern import Cell, Loop, Row, first_fault

_TOGETHER = {Stitch.KNIT: Stitch.D12K, Stitch.PURL: Stitch.D12P}


@dataclass(frozen=True)
class DescribedRow:
    """A row as its words describe it, left to right as seen from the right side."""

    pieces: tuple[WordStitches, ...]
    """The stitches of each word."""
    bars: tuple[int, ...]
    """Number of pieces before each bar; a row has no bars or two."""
    place: TextPlace
    """Place of the row in the text."""

    def turned(self) -> DescribedRow:
        """Return the row as seen from the other side of the fabric."""
        count = len(self.pieces)
        pieces = tuple(piece.turned() for piece in reversed(self.pieces))
        return replace(self, pieces=pieces, bars=tuple(count - bar for bar in reversed(self.bars)))


def finish_rows(written: Sequence[DescribedRow]) -> tuple[Row, ...]:
    """Convert written rows to the rows of a pattern, from the bottom up.

    The first row works the tucks of the last row together, because the pattern repeats upwards.

    Raises:
        PatternError: the stitch above a tuck cannot work two loops together, or the numbers of loops of two rows
            differ; the message gives the place of the row.
    """
    rows = [finish_row(_with_tucks(written[index - 1], row)) for index, row in enumerate(written)]
    fault = first_fault(rows)
    if fault:
        raise written[fault[0]].place.error(f"row {fault[0] + 1}: {fault[1]}")
    return tuple(rows)


def finish_row(row: DescribedRow) -> Row:
    """Convert one written row that lies over no tuck.

    Raises:
        PatternError: its stitches do not fit its loops; the message gives the place of the row.
    """
    counts = [len(piece.cells) for piece in row.pieces]
    left = sum(counts[: row.bars[0]]) if row.bars else 0
    right = sum(counts[row.bars[1] :]) if row.bars else 0
    cells = tuple(cell for piece in row.pieces for cell in piece.cells)
    loops = tuple(loop for piece in row.pieces for loop in piece.loops)
    try:
        return Row(cells, loops, left, right)
    except PatternError as error:
        raise row.place.error(str(error)) from None


def _with_tucks(below: DescribedRow, row: DescribedRow) -> DescribedRow:
    """Return the row with one decrease through both loops of every tuck in the row below."""
    sizes = [size for piece in below.pieces for size in _stitch_sizes(piece)]
    if 2 not in sizes:
        return row
    pieces, start = [], 0
    for piece in row.pieces:
        end = start + len(piece.loops)
        pieces.append(_decrease_over_tuck(piece, row.place) if 2 in sizes[start:end] else piece)
        start = end
    return replace(row, pieces=tuple(pieces))


def _stitch_sizes(piece: WordStitches) -> list[int]:
    """Return the number of loops on which each stitch of the next row is worked: two above a tuck, otherwise one."""
    return [2] if piece.tuck else [1] * sum(cell.n_top for cell in piece.cells)


def _decrease_over_tuck(piece: WordStitches, place: TextPlace) -> WordStitches:
    stitch = piece.cells[0].stitch
    if len(piece.cells) != 1 or stitch not in _TOGETHER or piece.loops != (Loop(),):
        found = " ".join(stitch_name(cell.stitch) for cell in piece.cells)
        raise place.error(f"got {found} above a tuck; only a plain k or p works its two loops together")
    return single(Cell(_TOGETHER[stitch], piece.cells[0].twist, piece.cells[0].yarn))
