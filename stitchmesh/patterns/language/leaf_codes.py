# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files of tile codes alone, as Leaf et al. 2018, section 4, writes patterns: one line a row, the top line the last.

The codes are those of their table 2, as many characters as loops: ``K P F B YS 2U Y3Y`` (``charts.LEAF``).
"""

from __future__ import annotations

from pathlib import Path

from stitchmesh.errors import PatternError
from stitchmesh.mesh.stitch import VOCABULARY
from stitchmesh.patterns.language.rows import finish_rows
from stitchmesh.patterns.language.text_charts import LEAF, leaf_pieces, read_chart
from stitchmesh.patterns.language.tokens import Line, Place, split_lines
from stitchmesh.patterns.pattern import Cell, Loop, Pattern

TILES: dict[tuple[Cell, ...], str] = {
    tuple(cell for piece in leaf_pieces(code, 0) for cell in piece.cells): code.upper() for code in LEAF
}
"""The code of stitches that stand side by side, left to right; none is the beginning of another."""


def parse_leaf_codes(text: str, name: str = "pattern") -> Pattern:
    """Read a pattern from lines of codes.

    Args:
        text: one line for each row, the last row first; blank lines before and after them do not count.
        name: what messages call the text; without folder and suffixes it is the pattern's name.

    Raises:
        PatternError: a code means nothing, the lines differ in width, or a blank one stands between them; with line
            and column.
    """
    rows = finish_rows(read_chart("leaf", _rows(split_lines(text, name), name), 0, upwards=False))
    return Pattern(Path(name).stem.removesuffix(".leaf").replace('"', "'"), "", rows)


def leaf_codes(pattern: Pattern) -> str:
    """The lines of codes of a pattern: ``parse_leaf_codes(leaf_codes(pattern)).rows == pattern.rows``.

    Raises:
        PatternError: it has borders, twists, cables, more than yarn 0 or a stitch without a code; with row and stitch.
    """
    return "".join(f"{_line(pattern, index)}\n" for index in reversed(range(pattern.height)))


def _rows(lines: list[Line], name: str) -> list[Line]:
    """The lines that hold something, which stand together."""
    held = [index for index, line in enumerate(lines) if line.text.strip()]
    if not held:
        raise Place(name, 1, 1).error("got no codes; expected a line such as KKPP for each row")
    rows = lines[held[0] : held[-1] + 1]
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
    """How many cells the next tile takes, and its code."""
    for tile, code in TILES.items():
        if cells[start : start + len(tile)] == tile:
            return len(tile), code
    found = VOCABULARY[cells[start].stitch].code
    if cells[start] != Cell(cells[start].stitch):
        found += " with a twist or another yarn"
    raise PatternError(f"{where}, stitch {start + 1}: got {found}, no tile; expected one of {' '.join(TILES.values())}")
