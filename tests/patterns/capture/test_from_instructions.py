# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Written instructions of one piece are read as the pattern that was knitted."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.errors import PatternError
from stitchmesh.hand_knitting import knitting_instructions, parse_instructions
from stitchmesh.hand_knitting.words import without_yarn_overs
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import pattern_mesh, read_pattern, smallest_repeat
from stitchmesh.patterns.pattern import Cell, Row
from tests.chosen_patterns import CHOSEN_PATTERNS
from tests.patterns.fabrics import flat


def apart(row: Row) -> Row:
    """The row with the yarn-overs at the sides of its increases as stitches by themselves, as words say them."""
    cells: list[Cell] = []
    for cell in row.cells:
        left, inner, right = without_yarn_overs(cell.stitch)
        over = [Cell(Stitch.YARN_OVER, (twist,), cell.yarn) for twist in cell.twist]
        own = cell.twist[left : cell.n_top - right]
        cells += [*over[:left], *([] if inner is None else [Cell(inner, own, cell.yarn)]), *over[cell.n_top - right :]]
    return replace(row, cells=tuple(cells))


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_the_instructions_of_a_pattern_are_the_pattern(tmp_path, name):
    piece = pattern_mesh(read_pattern(name), 2, 1, stitch_width=1.0, stitch_height=1.0)
    (tmp_path / "words.txt").write_text(knitting_instructions(piece))
    expected = tuple(apart(row) for row in smallest_repeat(read_pattern(name)).rows)
    assert smallest_repeat(read_pattern(tmp_path / "words.txt")).rows == expected


UNREADABLE = {
    "Row 1 (RS): k3, kk2.": r"line 3: got the word 'kk2'",
    "Row 1 (RS): k3, p2": r"line 3: got .* expected words such as",
    "Row 1 (RS) k3.": r"line 3: got .* expected a row such as",
    "Row 2: as row 1.": r"line 3: got a repeat of row 1; expected rows that are written above",
    "Row 1 (RS): [k3] 999999 times.": r"line 3: got more than 100000 stitches",
    "Row 1 (RS): " + "[" * 20 + "k" + "] 1 times" * 20 + ".": r"line 3: got brackets in more than 16 brackets",
    "Row 1 (RS): cross 2/3 front, k4.": r"line 3: got stitches on 4 loops, 5 of them to be crossed",
    "Row 1 (RS): k2tog turning R3.": r"line 3: got a turn of st 3 for k2tog; it is worked on 2",
    "Row 1 (RS): cross to 1-1 front to back 1-2, k2.": r"line 3: got .* expected each st once",
}


@pytest.mark.parametrize("line", UNREADABLE)
def test_a_line_that_cannot_be_read_is_refused_with_its_number(line):
    with pytest.raises(PatternError, match=UNREADABLE[line]):
        parse_instructions(f"Piece 1, worked to and fro\nCast on 5 sts.\n{line}\n")


def test_a_text_without_pieces_and_a_piece_that_is_no_pattern_are_refused(tmp_path):
    with pytest.raises(PatternError, match="expected written instructions"):
        parse_instructions("knit as you like")
    words = tmp_path / "words.txt"
    bobble = apply_edit(flat(5, 5), Edit("bobble", {"face": 12})).fabric
    words.write_text(knitting_instructions(bobble))
    with pytest.raises(PatternError, match=r"got loops that it leaves unworked or binds off|got . pieces"):
        read_pattern(words)
