# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A knitting chart in the editor: a grid of stitches and a grid of yarns.

A chart may hold stitches that do not fit together; ``pattern`` checks it. Every square holds a word of the text
language that covers one column, or the beginning of a cable. The cable covers the squares on the right of that
beginning. A cable that loses some of its squares becomes knit stitches.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.mesh import IntArray
from stitchmesh.mesh.polygon_mesh import frozen_array
from stitchmesh.patterns.charts.grid import BLANK, LONGEST_SIDE, Box, Brush, check_chart_shape
from stitchmesh.patterns.language.items import ItemParser
from stitchmesh.patterns.language.rows import DescribedRow, finish_row, finish_rows
from stitchmesh.patterns.language.tokens import TextPlace, split_lines
from stitchmesh.patterns.language.words import NO_STITCH, WordStitches
from stitchmesh.patterns.language.writing import chart_word, pieces_of
from stitchmesh.patterns.moved import mirrored_cells, mirrored_loops
from stitchmesh.patterns.pattern import Pattern, Row, first_fault

COVERED = -1
"""Value of a square that is covered by the cable on its left."""
PLAIN = "k"
"""Word of a new square."""


@dataclass(frozen=True, eq=False)
class KnitChart:
    """A chart of stitches and yarns, seen from the right side.

    Raises:
        ParameterError: the chart is empty or too large, an array has a wrong shape, or a number has no word.
        PatternError: a word does not describe one stitch or one cable.
    """

    squares: IntArray
    """Index in ``words``, or ``COVERED``, shape (rows, columns); the lowest row first, columns from the left."""
    words: tuple[str, ...]
    """Words of stitches and cables, without yarns."""
    yarns: IntArray
    """Number of the yarn of each square, shape (rows, columns)."""
    left: int = 0
    """Number of columns of the left border, which does not repeat."""
    right: int = 0
    """Number of columns of the right border."""
    name: str = "pattern"
    source: str = ""
    palette: tuple[tuple[int, int, int], ...] = ()
    """Colour of each yarn number (sRGB, 0 to 255)."""

    def __post_init__(self) -> None:
        check_chart_shape(np.shape(self.squares))
        words = self.words if PLAIN in self.words else (*self.words, PLAIN)
        squares = np.array(self.squares, dtype=np.int64)
        if np.shape(self.yarns) != squares.shape or np.min(self.yarns) < 0:
            raise ParameterError(f"chart: got yarns of shape {np.shape(self.yarns)}; expected {squares.shape}, from 0")
        if squares.min() < COVERED or squares.max() >= len(words):
            found = f"words {squares.min()} to {squares.max()}"
            raise ParameterError(f"chart: got {found}; expected {COVERED} to {len(words) - 1}")
        if min(self.left, self.right) < 0 or self.left + self.right >= squares.shape[1]:
            found = f"borders of {self.left} and {self.right} columns of {squares.shape[1]}"
            raise ParameterError(f"chart: got {found}; expected them to leave columns that repeat")
        widths = np.array([read_square(word).columns for word in words])
        object.__setattr__(self, "words", words)
        whole = _without_cut_cables(squares, widths, words.index(PLAIN))
        object.__setattr__(self, "squares", frozen_array(whole, np.int64))
        object.__setattr__(self, "yarns", frozen_array(self.yarns, np.int64))

    def __repr__(self) -> str:
        """Return one line: the name and the size."""
        return f"KnitChart({self.name!r}, {self.shape[1]} columns x {self.shape[0]} rows)"

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and of columns."""
        return self.squares.shape[0], self.squares.shape[1]

    @property
    def yarn_count(self) -> int:
        """One more than the largest number of a yarn."""
        return int(self.yarns.max()) + 1

    @cached_property
    def widths(self) -> IntArray:
        """Number of columns of each word."""
        return np.array([read_square(word).columns for word in self.words])

    def word_at(self, row: int, column: int) -> str:
        """Return the word of a square; a covered square gives the word of its cable."""
        head = column
        while self.squares[row, head] == COVERED:
            head -= 1
        return self.words[self.squares[row, head]]

    def pattern(self, lines: Sequence[TextPlace] | None = None) -> Pattern:
        """Return the pattern that the chart describes.

        Args:
            lines: place of each row in a text, for the messages; by default a message names the row alone.

        Raises:
            PatternError: the rows do not fit together, or a cable lies across the limit of a border.
        """
        places = lines or [TextPlace(self.name, row + 1, 1) for row in range(self.shape[0])]
        tucks = any(read_square(self.words[number]).tuck for number in np.unique(self.squares) if number != COVERED)
        rows = self._rows_with_tucks(places) if tucks else self._rows(places)
        return Pattern(self.name, self.source, rows, self.palette)

    def _rows_with_tucks(self, places: Sequence[TextPlace]) -> tuple[Row, ...]:
        """Return the rows; each row over a tuck depends on the row below it."""
        return finish_rows([self.written_row(row, places[row]) for row in range(self.shape[0])])

    def _rows(self, places: Sequence[TextPlace]) -> tuple[Row, ...]:
        """Return the rows without tucks; a row is made once and kept until it changes."""
        rows = tuple(self._row(index, place) for index, place in enumerate(places))
        fault = first_fault(rows)
        if fault:
            raise places[fault[0]].error(f"row {fault[0] + 1}: {fault[1]}")
        return rows

    def _row(self, index: int, place: TextPlace) -> Row:
        squares, yarns = self.squares[index].tobytes(), self.yarns[index].tobytes()
        try:
            return _made_row(self.words, squares, yarns, self.left, self.right)
        except PatternError:
            return finish_row(self.written_row(index, place))  # raises the error with the place of the row

    def painted(self, places: IntArray, brush: Brush) -> KnitChart:
        """Paint squares one after another; see ``EditedChart``.

        Raises:
            PatternError: the word describes no stitch.
            ParameterError: no place has room for the word, or the yarn is negative.
        """
        squares, yarns, words = self.squares.copy(), self.yarns.copy(), self.words
        places = np.asarray(places, dtype=np.int64).reshape(-1, 2)
        width = 1
        if brush.word is not None:
            width = read_square(brush.word).columns
            words = words if brush.word in words else (*words, brush.word)
            places = places if width == 1 else self._with_room(places, brush.word, width)
            squares[places[:, 0], places[:, 1]] = words.index(brush.word)
        for step in range(1, width):
            squares[places[:, 0], places[:, 1] + step] = COVERED
        if brush.yarn is not None:
            for step in range(width):
                yarns[places[:, 0], places[:, 1] + step] = brush.yarn
        return replace(self, squares=squares, yarns=yarns, words=words)

    def taken(self, rows: IntArray, columns: IntArray) -> KnitChart:
        """Make a chart from rows and columns of this chart; a new square is a knit stitch of yarn 0."""
        check_chart_shape((len(rows), len(columns)))
        index = np.ix_(rows, columns)
        new = (np.asarray(rows) == BLANK)[:, None] | (np.asarray(columns) == BLANK)[None, :]
        squares = np.where(new, self.words.index(PLAIN), self.squares[index])
        keeps = self.left + self.right < len(columns)
        left, right = (self.left, self.right) if keeps else (0, 0)
        return replace(self, squares=squares, yarns=np.where(new, 0, self.yarns[index]), left=left, right=right)

    def pasted(self, part: KnitChart, row: int, column: int) -> KnitChart:
        """Put another chart over the squares that begin at a place; squares outside are dropped."""
        words = self.words + tuple(word for word in part.words if word not in self.words)
        number = np.array([*(words.index(word) for word in part.words), COVERED])
        squares, yarns = self.squares.copy(), self.yarns.copy()
        target, own = overlap(self.shape, part.shape, row, column)
        squares[target], yarns[target] = number[part.squares][own], part.yarns[own]
        return replace(self, squares=squares, yarns=yarns, words=words)

    def blanked(self, box: Box) -> KnitChart:
        """Return the chart with knit stitches of yarn 0 in a box."""
        return self.painted(box.within(self.shape).places(), Brush(PLAIN, 0))

    def mirrored(self, *, upwards: bool) -> KnitChart:
        """Mirror the whole chart; from left to right, stitches that lean then lean to the other side."""
        if upwards:
            return replace(self, squares=self.squares[::-1], yarns=self.yarns[::-1])
        squares = self.squares[:, ::-1].copy()
        rows, ends = np.nonzero(np.where(squares >= 0, self.widths[squares], 0) > 1)
        heads = squares[rows, ends]
        squares[rows, ends] = COVERED
        squares[rows, ends - self.widths[heads] + 1] = heads
        words = tuple(mirrored_word(word) for word in self.words)
        own = tuple(dict.fromkeys(words))
        number = np.array([*(own.index(word) for word in words), COVERED])
        left, right = self.right, self.left
        return replace(self, squares=number[squares], yarns=self.yarns[:, ::-1], words=own, left=left, right=right)

    def equal_squares(self, row: int, column: int) -> NDArray[np.bool_]:
        """Whether each square has the word and the yarn of a given square, shape (rows, columns)."""
        same = (self.squares == self.squares[row, column]) & (self.yarns == self.yarns[row, column])
        return np.asarray(same)

    def _with_room(self, places: IntArray, word: str, width: int) -> IntArray:
        """Return the places, in order, where a wide word fits: before the right edge, and clear of earlier ones."""
        taken = np.zeros(self.shape, dtype=np.bool_)
        kept = []
        for row, column in places.tolist():
            if column + width <= self.shape[1] and not taken[row, column : column + width].any():
                taken[row, column : column + width] = True
                kept.append((row, column))
        if not kept:
            room = self.shape[1] - int(places[0, 1])
            raise ParameterError(f"chart: {word} covers {width} columns; got {room} up to the right edge")
        return np.array(kept)

    def written_row(self, row: int, place: TextPlace) -> DescribedRow:
        """Return a row as its words describe it, with its place in a text.

        Raises:
            PatternError: a cable lies across the limit of a border.
        """
        starts = np.flatnonzero(self.squares[row] != COVERED).tolist()
        limits = [self.left, self.shape[1] - self.right] if self.left or self.right else []
        for limit in limits:
            if limit < self.shape[1] and self.squares[row, limit] == COVERED:
                found = f"a cable covers the limit between columns {limit} and {limit + 1}"
                raise place.error(f"got {found}; expected it on one side of the limit of the border")
        bars = tuple(sum(start < limit for start in starts) for limit in limits)
        return DescribedRow(tuple(self.pieces(row)), bars, place)

    def pieces(self, row: int) -> Iterator[WordStitches]:
        """Give the stitches of each word of a row, left to right."""
        squares, yarns = self.squares[row].tolist(), self.yarns[row].tolist()
        for column, number in enumerate(squares):
            if number != COVERED:
                width = int(self.widths[number])
                yield _dyed(self.words[number], tuple(yarns[column : column + width]))


def knit_chart(pattern: Pattern) -> KnitChart:
    """Return the chart of a pattern.

    Rows with fewer stitches have squares that hold no stitch, so that the wales of all rows lie in line.

    Raises:
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    check_chart_shape((pattern.height, max(len(row.cells) for row in pattern.rows)))
    rows = [_sections_of(pieces_of(row), row.left, row.right) for row in pattern.rows]
    return chart_of_sections(rows, pattern.name, pattern.source, pattern.palette)


def chart_of_written(
    rows: Sequence[DescribedRow], name: str, source: str, palette: tuple[tuple[int, int, int], ...]
) -> KnitChart:
    """Return the chart of rows as their words describe them, from the bottom up.

    Raises:
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    parts = []
    for row in rows:
        first, second = row.bars or (0, len(row.pieces))
        parts.append((row.pieces[:first], row.pieces[first:second], row.pieces[second:]))
    return chart_of_sections(parts, name, source, palette)


Sections = tuple[Sequence[WordStitches], Sequence[WordStitches], Sequence[WordStitches]]


def chart_of_sections(
    rows: Sequence[Sections], name: str, source: str, palette: tuple[tuple[int, int, int], ...]
) -> KnitChart:
    """Return the chart of rows from the bottom up, each given as pieces of left border, tile and right border.

    Raises:
        ParameterError: the chart is larger than ``grid.LONGEST_SIDE``.
    """
    counts = np.array([[sum(piece.columns for piece in part) for part in row] for row in rows])
    left, tile, right = counts.max(axis=0).tolist()
    check_chart_shape((len(rows), left + tile + right))
    sheet = _Sheet()
    laid = [[sheet.lay(part, room) for part, room in zip(row, (left, tile, right), strict=True)] for row in rows]
    squares, yarns = (
        np.array([[number for part in row for number in part[which]] for row in laid], dtype=np.int64)
        for which in (0, 1)
    )
    return KnitChart(squares, tuple(sheet.words), yarns, left, right, name, source, palette)


class _Sheet:
    """The squares of rows of pieces, and the words that they need."""

    def __init__(self) -> None:
        self.words: dict[str, int] = {}
        self._known: dict[int, tuple[WordStitches, list[int], list[int]]] = {}

    def lay(self, pieces: Sequence[WordStitches], room: int) -> tuple[list[int], list[int]]:
        """Return the squares and yarns of a part of a row, with squares without a stitch up to ``room`` columns."""
        parts = [self._squares_of(piece) for piece in pieces]
        if sum(piece.columns for piece in pieces) == room:
            return [number for part in parts for number in part[0]], [yarn for part in parts for yarn in part[1]]
        squares, yarns = [self._number(NO_STITCH)] * room, [0] * room
        for column, (own, dyed) in zip(_columns_of(pieces, room), parts, strict=True):
            squares[column : column + len(own)], yarns[column : column + len(own)] = own, dyed
        return squares, yarns

    def _squares_of(self, piece: WordStitches) -> tuple[list[int], list[int]]:
        """Return the squares and yarns of a piece; many pieces of a row are the same object."""
        known = self._known.get(id(piece))
        if known is None:
            word, yarns = _word_and_yarns(piece)
            squares = [self._number(word), *[COVERED] * (piece.columns - 1)]
            known = self._known[id(piece)] = piece, squares, list(yarns)
        return known[1], known[2]

    def _number(self, word: str) -> int:
        return self.words.setdefault(word, len(self.words))


def _columns_of(pieces: Sequence[WordStitches], room: int) -> list[int]:
    """Return the first column of each piece, above its loops, so that the wales of all rows lie in line."""
    left = sum(piece.columns for piece in pieces)
    columns: list[int] = []
    free = below = above = 0
    for piece in pieces:
        made = sum(cell.n_top for cell in piece.cells)
        middle = (2 * below + len(piece.loops) + 2 * above + made) / 4
        columns.append(min(max(round(middle - piece.columns / 2), free), room - left))
        free, left = columns[-1] + piece.columns, left - piece.columns
        below, above = below + len(piece.loops), above + made
    return columns


@lru_cache(maxsize=4096)
def _word_and_yarns(piece: WordStitches) -> tuple[str, tuple[int, ...]]:
    yarns = tuple(cell.yarn for cell in piece.cells) or (0,)
    return chart_word(_with_yarns(piece, (0,) * len(piece.cells))), yarns + yarns[-1:] * (piece.columns - len(yarns))


def _sections_of(pieces: Sequence[WordStitches], left: int, right: int) -> Sections:
    """Return the pieces of a row of a pattern by sections; each piece covers its columns of a chart."""
    sized = []
    for piece in pieces:
        crossed = any(loop.shift for loop in piece.loops)
        sized.append(replace(piece, columns=max(len(piece.loops), len(piece.cells)) if crossed else 1))
    starts = np.cumsum([0, *(len(piece.cells) for piece in sized)])
    first, second = (int(np.searchsorted(starts, limit)) for limit in (left, int(starts[-1]) - right))
    return sized[:first], sized[first:second], sized[second:]


@lru_cache(maxsize=4096)
def read_square(word: str) -> WordStitches:
    """Return the stitches of the word of a square, in yarn 0.

    Raises:
        PatternError: the word is unknown, names a yarn, or describes more than one stitch or cable.
    """
    lines = split_lines(word, "chart")
    if not lines or "@" in word:
        raise PatternError(f"chart: got the word {word!r}; expected a stitch such as k, yo or c4f, without its yarn")
    if word == NO_STITCH:
        return WordStitches((), ())
    pieces, bars = ItemParser(lines[0].tokens(), 0, leftwards=False).parse_row()
    if len(pieces) != 1 or bars or len(lines) > 1:
        raise PatternError(f"chart: got {word!r}; expected one stitch or one cable for a square")
    return pieces[0]


@lru_cache(maxsize=4096)
def mirrored_word(word: str) -> str:
    """Return the word of a square with left and right exchanged."""
    piece = read_square(word)
    return chart_word(replace(piece, cells=mirrored_cells(piece.cells), loops=mirrored_loops(piece.loops)))


@lru_cache(maxsize=2 * LONGEST_SIDE)
def _made_row(words: tuple[str, ...], squares: bytes, yarns: bytes, left: int, right: int) -> Row:
    """Return a row without tucks; an edit of a chart changes few of its rows, so the others come from the cache."""
    numbers, colours = (np.frombuffer(values, dtype=np.int64)[None] for values in (squares, yarns))
    return finish_row(KnitChart(numbers, words, colours, left, right).written_row(0, TextPlace("chart", 1, 1)))


@lru_cache(maxsize=4096)
def _dyed(word: str, yarns: tuple[int, ...]) -> WordStitches:
    """Return the stitches of the word of a square in the yarns of its columns."""
    piece = read_square(word)
    return _with_yarns(piece, yarns)


def _with_yarns(piece: WordStitches, yarns: Sequence[int]) -> WordStitches:
    return replace(piece, cells=tuple(replace(cell, yarn=yarn) for cell, yarn in zip(piece.cells, yarns, strict=False)))


def _without_cut_cables(squares: IntArray, widths: IntArray, plain: int) -> IntArray:
    """Return the squares, with plain stitches for incomplete cables and for covered squares without a cable."""
    covered = squares == COVERED
    wide = np.where(covered, 1, widths[squares]) > 1
    for row in np.flatnonzero((covered | wide).any(axis=1)).tolist():
        held = np.zeros(squares.shape[1], dtype=np.bool_)
        for head in np.flatnonzero(wide[row]).tolist():
            rest = slice(head + 1, head + int(widths[squares[row, head]]))
            whole = rest.stop <= len(held) and bool(covered[row, rest].all())
            held[rest] = whole
            if not whole:
                squares[row, head] = plain
        squares[row, covered[row] & ~held] = plain
    return squares


def overlap(
    shape: tuple[int, int], part: tuple[int, int], row: int, column: int
) -> tuple[tuple[slice, slice], tuple[slice, slice]]:
    """Return the part of a chart that a second chart covers from a place on, and the part of the second one there."""
    target, own = [], []
    for start, size, limit in zip((row, column), part, shape, strict=True):
        first, last = max(start, 0), max(min(start + size, limit), start, 0)
        target.append(slice(first, last))
        own.append(slice(first - start, last - start))
    return (target[0], target[1]), (own[0], own[1])
