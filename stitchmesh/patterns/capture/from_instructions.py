# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pattern from written instructions of one piece, if all its rows run from one end to the other."""

from __future__ import annotations

from dataclasses import replace

from stitchmesh.errors import PatternError
from stitchmesh.hand_knitting.parse import parse_instructions
from stitchmesh.hand_knitting.rows import WrittenStitch
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.hand_knitting.written_pieces import WrittenPiece, WrittenRow
from stitchmesh.mesh.own_stitch import StitchType
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.patterns.pattern import Cell, Loop, Pattern, Row
from stitchmesh.patterns.placement.placement import THROUGH_BACK


def pattern_from_instructions(text: str, name: str = "instructions") -> Pattern:
    """Return the pattern from written instructions; its first row is the row above the cast-on.

    Args:
        text: a text of ``knitting_instructions``.
        name: name of the text in messages, and of the pattern.

    Raises:
        PatternError: the text cannot be read, has several pieces or short rows, or holds stitches of no pattern.
    """
    pieces = parse_instructions(text, name)
    if len(pieces) > 1:
        raise PatternError(
            f"{name}: got {len(pieces)} pieces; a pattern is one piece: capture a part of the stitch mesh"
        )
    _check_rows(pieces[0], name)
    written = pieces[0].rows
    cells = [[_cell(stitch) for stitch in row.stitches] for row in written]
    held = [_loops(row) for row in written]
    for number in range(1, len(written)):
        _give_to_makers(cells[number - 1], held[number], written[number])
    try:
        rows = tuple(Row(tuple(row), tuple(loops)) for row, loops in zip(cells, held, strict=True))
        return Pattern(name.replace('"', "'"), "", rows)
    except PatternError as error:
        raise PatternError(f"{name}: {error}") from None


def _check_rows(piece: WrittenPiece, name: str) -> None:
    if not piece.rows:
        raise PatternError(f"{name}: got a piece without rows; expected rows after the cast-on row")
    for number, row in enumerate(piece.rows, start=1):
        found = next((stitch_name(stitch.stitch) for stitch in row.stitches if stitch.stitch not in VOCABULARY), None)
        if found or row.turned or row.bound_off or (row.passed and not piece.in_rounds):
            what = found or "loops that it leaves unworked or binds off"
            raise PatternError(f"{name}: row {number}: got {what}; expected rows of stitches from end to end")


def _cell(written: WrittenStitch) -> Cell:
    return Cell(written.stitch, (written.made,) if written.made else (), written.yarn)


def _loops(row: WrittenRow) -> list[Loop]:
    """Return the loops below a row from left to right, before any crossing, with their half turns."""
    twists = [twist for stitch in row.stitches for twist in stitch.twists]
    loops = [Loop(twist=twist) for twist in twists]
    for crossing in row.crossings:
        layers = _layers(len(crossing.destination), crossing.over)
        for place, end in enumerate(crossing.destination):
            start = crossing.first + place
            if not 0 <= start < len(loops):
                raise PatternError(f"got a crossing of loop {start + 1} of {len(loops)}; expected it within the row")
            loops[start] = Loop(end - place, layers[place], twists[crossing.first + end])
    return loops


def _layers(count: int, over: frozenset[tuple[int, int]]) -> list[int]:
    """Return a layer for each loop: one more than the highest layer of the loops behind it."""
    layers = [0] * count
    for _ in range(count):
        for front, behind in over:
            layers[front] = max(layers[front], layers[behind] + 1)
    return layers


def _give_to_makers(below: list[Cell], held: list[Loop], row: WrittenRow) -> None:
    """Move each half turn that no stitch through the back leg gives to the stitch that makes the loop."""
    workers = [stitch.stitch for stitch in row.stitches for _ in stitch.twists]
    place = 0
    for index, cell in enumerate(below):
        own = held[place : place + cell.n_top]
        if any(cell.twist):  # the word of a make one says its half turn
            place += cell.n_top
            continue
        taken = [_is_through_back(cell, loop, workers[place + top]) for top, loop in enumerate(own)]
        made = tuple(0 if above else loop.twist for above, loop in zip(taken, own, strict=True))
        below[index] = replace(cell, twist=made)
        for top, twist in enumerate(made):
            held[place + top] = replace(own[top], twist=own[top].twist - twist)
        place += cell.n_top


def _is_through_back(maker: Cell, loop: Loop, worker: StitchType) -> bool:
    """Whether a half turn belongs to the stitch above, as ``capture_pattern`` divides half turns."""
    plain = worker in (Stitch.KNIT, Stitch.PURL) and maker.stitch != Stitch.YARN_OVER
    return plain and loop.twist == THROUGH_BACK and not loop.shift
