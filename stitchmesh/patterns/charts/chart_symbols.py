# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Symbols of the squares of a chart, as lines, rings and dots that any drawing program can draw.

The symbols follow the usual charts of hand knitting: an empty square is a knit stitch, a dot a purl stitch, a ring a
yarn-over, and lines show how loops lean, come together, divide and cross. They are made from the properties of the
stitch, so that every stitch of the vocabulary has one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

from stitchmesh.mesh.own_stitch import StitchType
from stitchmesh.mesh.stitch import Making, Stitch
from stitchmesh.patterns.charts.knit_chart import read_square
from stitchmesh.patterns.language.words import WordStitches
from stitchmesh.patterns.pattern import Cell

Point = tuple[float, float]
DOT, RING = 0.1, 0.2
"""Radius of a dot, and radius of a ring, in squares."""
LOW, HIGH = 0.12, 0.88
"""Heights of the ends of lines."""


@dataclass(frozen=True)
class Mark:
    """A part of a symbol; x to the right and y upwards, in squares, from the lower left corner of the first square."""

    kind: Literal["line", "ring", "dot", "shade", "strand"]
    """A line, a ring or a dot at its only point, a whole grey square, or a strand of a cable, which covers the marks
    below it."""
    points: tuple[Point, ...] = ()


@dataclass(frozen=True)
class Symbol:
    """The symbol of a word."""

    columns: int
    """Number of squares that the symbol covers."""
    marks: tuple[Mark, ...]
    """The marks of the symbol, from the back to the front."""


WEFT_OVER = Symbol(1, (Mark("line", ((0.0, 0.5), (1.0, 0.5))),))
WARP_OVER = Symbol(1, (Mark("line", ((0.5, 0.0), (0.5, 1.0))),))
"""Symbols of the squares of a weave, which show the yarn on top."""


@lru_cache(maxsize=4096)
def chart_symbol(word: str) -> Symbol:
    """Return the symbol of a word of a knitting chart.

    Raises:
        PatternError: the word is unknown, or describes more than one stitch or cable.
    """
    piece = read_square(word)
    if not piece.cells:
        return Symbol(1, (Mark("shade"),))
    if any(loop.shift for loop in piece.loops):
        return Symbol(piece.columns, tuple(_cable(piece)))
    return Symbol(1, (*_stitch(piece.cells[0], tuck=piece.tuck), *_back_leg(piece)))


def word_instruction(word: str) -> str:
    """Return the instruction to a hand knitter for a word of a chart.

    Raises:
        PatternError: the word is unknown, or describes more than one stitch or cable.
    """
    piece = read_square(word)
    if not piece.cells:
        return "no stitch"
    if any(loop.shift for loop in piece.loops):
        first = max(range(len(piece.loops)), key=lambda place: piece.loops[place].layer)
        side = "right" if piece.loops[first].shift > 0 else "left"
        return f"cable of {len(piece.loops)} loops, the loops in front cross to the {side}"
    if piece.tuck:
        return "tuck: slip the loop with a yarn-over; the next row works both together"
    through = " through the back leg" if piece.loops and any(loop.twist for loop in piece.loops) else ""
    return piece.cells[0].making.instruction + through


def _stitch(cell: Cell, *, tuck: bool) -> Iterator[Mark]:
    making = cell.making
    if tuck:
        yield Mark("line", ((0.28, LOW), (0.28, 0.6), (0.36, 0.8), (0.5, HIGH), (0.64, 0.8), (0.72, 0.6), (0.72, LOW)))
    elif making.made == "s":
        yield from _slipped(cell.stitch)
    elif making.n_bottom > 1:
        yield from _decrease(making)
    elif making.n_top > 1:
        yield from _increase(making)
    else:
        yield from _loop(making.made, (0.5, 0.5))
    for place, twist in enumerate(cell.twist):
        if twist:
            x = (place + 0.5) / cell.n_top
            yield Mark("line", ((x - 0.1 * twist, 0.98), (x + 0.1 * twist, 0.8)))


def _loop(kind: str, at: Point) -> Iterator[Mark]:
    """A knit loop has no mark."""
    if kind == "p":
        yield Mark("dot", (at,))
    elif kind == "y":
        yield Mark("ring", (at,))


def _slipped(stitch: StitchType) -> Iterator[Mark]:
    yield Mark("line", ((0.25, 0.85), (0.5, 0.2), (0.75, 0.85)))
    if stitch == Stitch.SLIP_FRONT:
        yield Mark("line", ((0.2, 0.5), (0.8, 0.5)))
    elif stitch == Stitch.WRAP:
        yield Mark("ring", ((0.5, 0.45),))


def _decrease(making: Making) -> Iterator[Mark]:
    """The front loop leads to the other side; the loops behind it end at it."""
    count = making.n_bottom
    place = {loop: (loop - 0.5) / count if count > 2 else (0.15 + 0.7 * (loop - 1)) for loop in making.order}
    front = place[making.order[0]]
    top = 1.0 - front
    yield Mark("line", ((front, LOW), (top, HIGH)))
    for order, loop in enumerate(making.order[1:]):
        height = 0.55 - 0.17 * order
        share = (height - LOW) / (HIGH - LOW)
        meets = front + (top - front) * share
        if count > 2:
            yield Mark("line", ((place[loop], LOW), (meets, height)))
    if making.made == "p":
        yield Mark("dot", ((0.5 if count == 2 else 0.8, 0.78 if count > 2 else 0.22),))


def _increase(making: Making) -> Iterator[Mark]:
    """Lines lead from the loop below to the loops above, whose marks stand at their ends."""
    count = making.n_top
    for place, kind in enumerate(making.made):
        end = (0.2 + 0.6 * place / (count - 1), 0.72)
        yield Mark("line", ((0.5, LOW), end))
        if kind == "s":
            yield Mark("line", ((end[0] - 0.12, 0.9), (end[0], 0.72), (end[0] + 0.12, 0.9)))
        else:
            yield from _loop(kind, end)


def _back_leg(piece: WordStitches) -> Iterator[Mark]:
    """A stitch through the back leg has a loop whose legs cross below."""
    if any(loop.twist for loop in piece.loops):
        yield Mark("line", ((0.3, LOW), (0.62, 0.5), (0.62, 0.72), (0.5, 0.82), (0.38, 0.72), (0.38, 0.5), (0.7, LOW)))


def _cable(piece: WordStitches) -> Iterator[Mark]:
    """A strand for each loop, the loops behind first; a dot marks each purl stitch."""
    scale = piece.columns / len(piece.loops)
    for place in sorted(range(len(piece.loops)), key=lambda place: piece.loops[place].layer):
        end = place + piece.loops[place].shift
        yield Mark("strand", (((place + 0.5) * scale, 0.04), ((end + 0.5) * scale, 0.96)))
    start = 0.0
    for cell in piece.cells:
        if cell.making.made == "p":
            yield Mark("dot", ((start + 0.5 * cell.n_bottom * scale, 0.8),))
        start += cell.n_bottom * scale
