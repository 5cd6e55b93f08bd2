# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts in text: one line for each row, seen from the right side, with the columns from left to right.

    chart [letters | leaf | colours] [upwards] [yarn N]:

The lines of the chart follow this statement. The top row comes first, or the bottom row with ``upwards``; a blank line
ends the chart. A chart without a kind holds words. ``letters`` and ``leaf`` hold one code after another without blanks.
``colours`` holds one digit or letter for each stitch: the number of its yarn. ``leaf`` reads the codes of Leaf et al.
2018, table 2; each code has as many characters as it has loops.

A text may also hold one chart alone, without a statement of the language: one line for each row, the last row first.
Lines of digits hold the yarn numbers of knit stitches. Lines of letters hold tile codes, as Leaf et al. 2018, section
4, write patterns: ``K P F B YS 2U Y3Y``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from pathlib import Path

from stitchmesh.errors import PatternError
from stitchmesh.patterns.language.items import BAR, ItemParser
from stitchmesh.patterns.language.rows import DescribedRow, finish_rows
from stitchmesh.patterns.language.tokens import Line, TextPlace, split_lines
from stitchmesh.patterns.language.words import NO_WORDS, OwnWords, WordStitches, read_word
from stitchmesh.patterns.pattern import Cell, Loop, Pattern

LETTERS: dict[str, str] = {
    "k": "k", "p": "p", "b": "b", "f": "f", "x": "x", "t": "t",
    "o": "yo", "/": "k2tog", "\\": "ssk", "^": "s2kp", ".": "none",
}  # fmt: skip
"""The word for each sign of a ``letters`` chart."""

LEAF: dict[str, tuple[str, ...]] = {
    "k": ("k",), "p": ("p",), "f": ("f",), "b": ("b",),
    "ys": ("yo", "ssk"), "2u": ("k2tog", "yo"), "y3y": ("yo", "sk2p", "yo"),
}  # fmt: skip
"""The words for each code of Leaf et al. 2018, table 2, left to right."""

FIGURES = "0123456789abcdefghijklmnopqrstuvwxyz"
"""Signs of a ``colours`` chart; the position of a sign is the number of its yarn."""

_Split = Callable[[Line, int, int], tuple[int, list[WordStitches]]]


def read_chart(
    kind: str, lines: list[Line], yarn: int, *, upwards: bool, own: OwnWords = NO_WORDS
) -> list[DescribedRow]:
    """Read the rows of a chart and return them from the bottom up.

    Args:
        kind: ``words``, ``letters``, ``leaf`` or ``colours``.
        lines: the lines of the chart in the order of the text.
        yarn: the yarn of stitches that name no yarn.
        upwards: whether the bottom row comes first.
        own: stitches of the user's own by their codes, which a chart of words may hold.

    Raises:
        PatternError: a code is unknown, or the lines differ in width; the message gives the place.
    """
    if kind == "words":
        rows = [_read_words(line, yarn, own) for line in lines]
    else:
        split = {"letters": _letter, "leaf": _leaf, "colours": _figure}[kind]
        rows = [_read_codes(line, yarn, split) for line in lines]
    _check_widths(rows, "add what is missing" if kind == "leaf" else "use none or . for a square without a stitch")
    return rows if upwards else rows[::-1]


def _read_words(line: Line, yarn: int, own: OwnWords) -> DescribedRow:
    pieces, bars = ItemParser(line.tokens(), yarn, leftwards=False, own=own).parse_row()
    return DescribedRow(tuple(pieces), tuple(bars), line.place)


def _read_codes(line: Line, yarn: int, split: _Split) -> DescribedRow:
    pieces: list[WordStitches] = []
    bars = []
    column = 0
    while column < len(line.text):
        if line.text[column] == BAR:
            bars.append(len(pieces))
        if line.text[column] == BAR or line.text[column].isspace():
            column += 1
            continue
        column, found = split(line, column, yarn)
        pieces += found
    if len(bars) not in (0, 2):
        raise line.place.error(f"got {len(bars)} bars; expected none, or two around the stitches that repeat")
    return DescribedRow(tuple(pieces), tuple(bars), line.place)


@lru_cache(maxsize=4096)
def _one_word(word: str, yarn: int) -> list[WordStitches]:
    """Return the stitches of a word; the result is kept, because a chart has few words and many squares."""
    return read_word(word, yarn)


def _letter(line: Line, column: int, yarn: int) -> tuple[int, list[WordStitches]]:
    sign = line.text[column].lower()
    if sign not in LETTERS:
        raise line.at(column).error(f"got {line.text[column]!r}; expected one of {' '.join(LETTERS)}")
    return column + 1, _one_word(LETTERS[sign], yarn)


def _leaf(line: Line, column: int, yarn: int) -> tuple[int, list[WordStitches]]:
    for width in (3, 2, 1):
        code = line.text[column : column + width].lower()
        if code in LEAF:
            return column + width, list(leaf_pieces(code, yarn))
    found = line.text[column : column + 3]
    raise line.at(column).error(f"got {found!r}; expected one of {' '.join(LEAF).upper()}")


@cache
def leaf_pieces(code: str, yarn: int) -> tuple[WordStitches, ...]:
    """Return the stitches of a code of ``LEAF``, left to right."""
    return tuple(piece for word in LEAF[code] for piece in read_word(word, yarn))


def _figure(line: Line, column: int, yarn: int) -> tuple[int, list[WordStitches]]:
    number = FIGURES.find(line.text[column].lower())
    if number < 0:
        raise line.at(column).error(f"got {line.text[column]!r}; expected the number of a yarn, 0 to 9 or a to z")
    return column + 1, _one_word(f"k@{number}", yarn)


def _check_widths(rows: list[DescribedRow], remedy: str) -> None:
    widths = [sum(piece.columns for piece in row.pieces) for row in rows]
    for row, width in zip(rows, widths, strict=True):
        if width != widths[0]:
            found = f"got {width} columns where the chart's first line has {widths[0]}"
            raise row.place.error(f"{found}; make them equal, {remedy}")


TILES: dict[tuple[Cell, ...], str] = {
    tuple(cell for piece in leaf_pieces(code, 0) for cell in piece.cells): code.upper() for code in LEAF
}
"""Code of each sequence of stitches, left to right; no sequence is the beginning of another."""


def parse_leaf_codes(text: str, name: str = "pattern") -> Pattern:
    """Read a pattern from lines of codes.

    Args:
        text: one line for each row, the last row first; blank lines before the first and after the last are ignored.
        name: the name of the text in messages; without its folder and suffixes it becomes the name of the pattern.

    Raises:
        PatternError: a code is unknown, the lines differ in width, or a blank line lies between them; the message gives
            the line and the column.
    """
    return _bare_chart("leaf", text, name)


def parse_colour_digits(text: str, name: str = "pattern") -> Pattern:
    """Read a pattern from lines of yarn numbers alone, one digit for each knit stitch, the last row first.

    Args:
        text: one line for each row; blank lines before the first and after the last are ignored.
        name: the name of the text in messages; without its folder and suffix it becomes the name of the pattern.

    Raises:
        PatternError: an error of ``parse_leaf_codes``.
    """
    return _bare_chart("colours", text, name)


def holds_digits(text: str) -> bool:
    """Whether the first line of a text that is not blank consists of digits alone."""
    first = next((line.text for line in split_lines(text, "") if line.text.strip()), "")
    return "".join(first.split()).isdecimal()


def bare_chart_rows(kind: str, text: str, name: str) -> list[DescribedRow]:
    """Read the rows of a text that holds one chart alone, from the bottom up, whether or not they fit together.

    Args:
        kind: ``leaf`` or ``colours``.
        text: one line for each row, the last row first.
        name: the name of the text in messages.

    Raises:
        PatternError: an error of ``parse_leaf_codes``.
    """
    return read_chart(kind, _rows(split_lines(text, name), name), 0, upwards=False)


def bare_chart_name(name: str) -> str:
    """Return the name of a pattern from the name of its text."""
    return Path(name).stem.removesuffix(".leaf").replace('"', "'")


def _bare_chart(kind: str, text: str, name: str) -> Pattern:
    return Pattern(bare_chart_name(name), "", finish_rows(bare_chart_rows(kind, text, name)))


def leaf_codes(pattern: Pattern) -> str:
    """Write a pattern as lines of codes, so that ``parse_leaf_codes(leaf_codes(pattern)).rows == pattern.rows``.

    Raises:
        PatternError: the pattern has borders, twists, cables, a yarn other than 0, or a stitch without a code; the
            message gives the row and the stitch.
    """
    return "".join(f"{_line(pattern, index)}\n" for index in reversed(range(pattern.height)))


def _rows(lines: list[Line], name: str) -> list[Line]:
    """Return the lines of the rows, without the blank lines before and after them."""
    filled = [index for index, line in enumerate(lines) if line.text.strip()]
    if not filled:
        raise TextPlace(name, 1, 1).error("got no codes; expected a line such as KKPP for each row")
    rows = lines[filled[0] : filled[-1] + 1]
    for line in rows:
        if not line.text.strip():
            raise line.place.error("got a blank line between rows; expected the codes of a row")
    return rows


def _line(pattern: Pattern, index: int) -> str:
    row = pattern.rows[index]
    where = f"pattern {pattern.name!r}, row {index + 1}"
    if row.left or row.right or any(loop != Loop() for loop in row.loops):
        raise PatternError(f"{where}: has borders, cables or stitches through the back leg; tile codes have none")
    codes, start = "", 0
    while start < len(row.cells):
        width, code = _tile(row.cells, start, where)
        codes += code
        start += width
    return codes


def _tile(cells: tuple[Cell, ...], start: int, where: str) -> tuple[int, str]:
    """Return the number of cells of the next tile, and its code."""
    for tile, code in TILES.items():
        if cells[start : start + len(tile)] == tile:
            return len(tile), code
    found = cells[start].making.code
    if cells[start] != Cell(cells[start].stitch):
        found += " with a twist or another yarn"
    raise PatternError(f"{where}, stitch {start + 1}: got {found}, no tile; expected one of {' '.join(TILES.values())}")
