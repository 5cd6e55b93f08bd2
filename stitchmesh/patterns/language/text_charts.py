# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Charts in text: one line for each row, seen from the right side, with the columns from left to right.

    chart [letters | leaf | colours] [upwards] [yarn N]:

The lines of the chart follow this statement. The top row comes first, or the bottom row with ``upwards``; a blank line
ends the chart. A chart without a kind holds words. ``letters`` and ``leaf`` hold one code after another without blanks.
``colours`` holds one digit or letter for each stitch: the number of its yarn. ``leaf`` reads the codes of Leaf et al.
2018, table 2; each code has as many characters as it has loops.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache

from stitchmesh.patterns.language.items import BAR, ItemParser
from stitchmesh.patterns.language.rows import DescribedRow
from stitchmesh.patterns.language.tokens import Line
from stitchmesh.patterns.language.words import NO_WORDS, OwnWords, WordStitches, read_word

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
