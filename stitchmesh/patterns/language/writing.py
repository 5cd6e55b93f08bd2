# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns as text, written for flat knitting: odd rows on the right side, even rows on the wrong side.

Reading the text gives the same pattern. Two kinds of even rows are written from the right side: rows with a crossing
that has no word of its own, because turning it over would change its layers, and rows with a stitch of the user's own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby, pairwise

from stitchmesh.mesh.own_stitch import OwnStitch, StitchType
from stitchmesh.mesh.palette import colour_text
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.language.words import ABBREVIATIONS, NO_STITCH, TUCK, WordStitches, read_crossing
from stitchmesh.patterns.pattern import Cell, Loop, Pattern, Row, crossings


def format_pattern(pattern: Pattern) -> str:
    """Write a pattern as text, so that ``parse_pattern(format_pattern(pattern)) == pattern``."""
    lines = [f'pattern "{pattern.name}"', f'source "{pattern.source}"']
    if pattern.palette:
        lines.append(f'colours "{", ".join(map(colour_text, pattern.palette))}"')
    for number, row in enumerate(pattern.rows, start=1):
        lines.append(_row(row, number))
    return "\n".join(lines) + "\n"


def pieces_of(row: Row) -> list[WordStitches]:
    """Return the stitches of a row, left to right as seen from the right side; a cable is one piece."""
    pieces = []
    for cells, loops in _spans(row):
        pieces.append(WordStitches(row.cells[cells.start : cells.stop], row.loops[loops.start : loops.stop]))
    return pieces


def _spans(row: Row) -> Iterator[tuple[range, range]]:
    """Return the ranges of cells and loops of each piece."""
    starts = [0]
    for cell in row.cells:
        starts.append(starts[-1] + cell.n_bottom)
    cables = crossings(row.loops)
    first = 0
    while first < len(row.cells):
        last = _piece_end(starts, cables, first)
        yield range(first, last), range(starts[first], starts[last])
        first = last


def _piece_end(starts: list[int], cables: list[range], first: int) -> int:
    """Return the index after the last cell of the piece that begins at ``first``; no piece ends inside a cable."""
    last = first + 1
    while any(cable.start < starts[last] < cable.stop for cable in cables):
        last += 1
    return last


def _row(row: Row, number: int) -> str:
    pieces = pieces_of(row)
    yarns = {cell.yarn for cell in row.cells}
    yarn = yarns.pop() if len(yarns) == 1 else 0
    wrong = number % 2 == 0 and not any(_only_from_right(piece) for piece in pieces)
    bars = _bars(row, pieces)
    facing = [piece.turned() for piece in reversed(pieces)] if wrong else pieces
    places = {len(pieces) - bar for bar in bars} if wrong else set(bars)
    words = list(_words(facing[::-1], {len(pieces) - place for place in places}, yarn))
    head = f"row {number} {'WS' if wrong else 'RS'}{f' yarn {yarn}' if yarn else ''}:"
    return _wrapped([head, *words])


def _only_from_right(piece: WordStitches) -> bool:
    """Return whether a piece has no word for the wrong side: a stitch of the user's own or an unnamed crossing."""
    own = any(isinstance(cell.stitch, OwnStitch) for cell in piece.cells)
    return own or (_is_cable(piece) and not _cable_word(piece.turned()))


def _plain_word(stitch: StitchType) -> str | None:
    return None if isinstance(stitch, OwnStitch) else {Stitch.KNIT: "k", Stitch.PURL: "p"}.get(stitch)


def _bars(row: Row, pieces: list[WordStitches]) -> list[int]:
    """Return the number of pieces before each bar."""
    if not row.left and not row.right:
        return []
    counts = [0]
    for piece in pieces:
        counts.append(counts[-1] + len(piece.cells))
    return [counts.index(row.left), counts.index(len(row.cells) - row.right)]


def _words(pieces: list[WordStitches], bars: Iterable[int], yarn: int) -> Iterator[str]:
    """Return the words of pieces in the order of working; consecutive equal words become one word with a count."""
    cuts = sorted({0, len(pieces), *bars})
    if 0 in bars:
        yield "|"
    for start, end in pairwise(cuts):
        for word, run in groupby(_word(piece, yarn) for piece in pieces[start:end]):
            yield _counted(word, len(list(run)))
        if end in bars:
            yield "|"


def _counted(word: str, count: int) -> str:
    if count == 1:
        return word
    name, at, yarn = word.partition("@")
    if name in ("ktbl", "ptbl", "slwyib", "slwyif"):
        start = 1 if name.endswith("tbl") else 2
        return f"{name[:start]}{count}{name[start:]}{at}{yarn}"
    if name.isalpha():
        return f"{name}{count}{at}{yarn}"
    return f"{word}*{count}"


def _is_cable(piece: WordStitches) -> bool:
    return any(loop.shift for loop in piece.loops)


def chart_word(piece: WordStitches, yarn: int = 0) -> str:
    """Return the word of a piece in a chart, whose words run from left to right.

    Args:
        piece: the stitches, left to right as seen from the right side.
        yarn: the yarn of the chart; the word does not name it.
    """
    if not piece.cells:
        return NO_STITCH
    word = _word(piece, yarn, leftwards=False)
    return TUCK + word[2:] if piece.tuck else word  # a tuck is the stitch sy; the next row works both of its loops


def _word(piece: WordStitches, yarn: int, *, leftwards: bool = True) -> str:
    if not _is_cable(piece):
        return _stitch_word(piece.cells[0], piece.loops, yarn)
    word = _cable_word(piece)
    if word:
        return word + _at(piece.cells[0].yarn, yarn)
    width = len(piece.loops)
    target = [place + loop.shift for place, loop in enumerate(piece.loops)]
    twists = [0] * width
    for end, loop in zip(target, piece.loops, strict=True):
        twists[end] = loop.twist
    layers, words = [loop.layer for loop in piece.loops], _crossed_words(piece.cells, twists, yarn)
    if leftwards:
        target, layers, words = [width - 1 - end for end in reversed(target)], layers[::-1], words[::-1]
    runs = [_counted(word, len(list(run))) for word, run in groupby(words)]
    return f"cross({' '.join(map(str, target))}; {' '.join(map(str, layers))}: {' '.join(runs)})"


def _crossed_words(cells: tuple[Cell, ...], twists: list[int], yarn: int) -> list[str]:
    """Return the words of the stitches within a crossing, left to right."""
    words, start = [], 0
    for cell in cells:
        end = start + cell.n_bottom
        words.append(_stitch_word(cell, tuple(Loop(twist=twist) for twist in twists[start:end]), yarn))
        start = end
    return words


def _cable_word(piece: WordStitches) -> str | None:
    """Return the word for a cable, or None if no single word describes the cable."""
    width = len(piece.loops)
    words = {2: ["lt", "rt"]}.get(width, [f"c{width}f", f"c{width}b"] if width % 2 == 0 else [])
    for front in range(1, width):
        words += [f"{front}/{width - front}{hand}c" for hand in ("l", "r", "lp", "rp")]
    for word in words:
        known = read_crossing(word, piece.cells[0].yarn)
        if known and known.cells == piece.cells and known.loops == piece.loops:
            return word
    return None


def _stitch_word(cell: Cell, loops: tuple[Loop, ...], yarn: int) -> str:
    below = tuple(loop.twist for loop in loops)
    for word, meaning in ABBREVIATIONS.items():
        plain = (meaning.twist,) * cell.n_top, (meaning.below,) * cell.n_bottom
        if meaning.stitch == cell.stitch and plain == (cell.twist, below):
            return word + _at(cell.yarn, yarn)
    text = _plain_word(cell.stitch) or cell.making.code
    if any(cell.twist):
        text += "".join(f"{twist:+d}" for twist in cell.twist)
    if any(below):
        text += "~" + "".join(f"{twist:+d}" for twist in below)
    return text + _at(cell.yarn, yarn)


def _at(yarn: int, common: int) -> str:
    return f"@{yarn}" if yarn != common else ""


def _wrapped(words: list[str]) -> str:
    lines, line = [], words[0]
    for word in words[1:]:
        if len(line) + len(word) > 110 and line != words[0]:
            lines.append(line + ",")
            line = "  " + word
        else:
            line += " " + word
    return "\n".join([*lines, line])
