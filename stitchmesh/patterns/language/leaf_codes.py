# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Texts that hold one chart alone: one line for each row, the last row first, without a statement of the language.

Lines of digits hold the yarn numbers of knit stitches. Lines of letters hold tile codes, as Leaf et al. 2018, section
4, write patterns. The codes are those of table 2 of the paper; each code has as many characters as it has loops:
``K P F B YS 2U Y3Y`` (``text_charts.LEAF``).
"""

from __future__ import annotations

from pathlib import Path

from stitchmesh.errors import PatternError
from stitchmesh.patterns.language.rows import DescribedRow, finish_rows
from stitchmesh.patterns.language.text_charts import LEAF, leaf_pieces, read_chart
from stitchmesh.patterns.language.tokens import Line, TextPlace, split_lines
from stitchmesh.patterns.pattern import Cell, Loop, Pattern

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
