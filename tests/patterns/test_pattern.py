# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns check themselves when they are made, and every valid pattern can be written as text."""

from __future__ import annotations

import random

import pytest

from stitchmesh.errors import PatternError
from stitchmesh.mesh.stitch import CODES, Stitch
from stitchmesh.patterns import Cell, Loop, Pattern, Row, check_closes, format_pattern, parse_pattern

KNIT = Cell(Stitch.KNIT)


@pytest.mark.parametrize(
    ("make", "found"),
    [
        (lambda: Cell(Stitch.PANEL), "cannot occur in a pattern"),
        (lambda: Cell(Stitch.KY, (1,)), r"in 1 st has twists \(1,\); expected -1, 0 or 1 for each of its 2 loops"),
        (lambda: Cell(Stitch.KNIT, (2,)), "expected -1, 0 or 1"),
        (lambda: Cell(Stitch.KNIT, yarn=-1), "got yarn -1"),
        (lambda: Row(()), "a tile on 0 loops that leaves 0"),
        (lambda: Row((KNIT,), left=1, right=1), "borders of 1 and 1 stitches in a row of 1"),
        (lambda: Row((KNIT,), (Loop(), Loop())), "got 2 loops; the stitches are worked on 1"),
        (lambda: Row((KNIT,), (Loop(layer=-1),)), "loop 1 of the tile: got layer -1"),
        (lambda: Pattern("x", "", ()), "got no rows"),
        (lambda: Pattern('a"b', "", (Row((KNIT,)),)), "got quotes or line ends"),
        (lambda: Pattern("x", "a\nb", (Row((KNIT,)),)), "got quotes or line ends"),
        (lambda: Pattern("x", "", (Row((KNIT,)), Row((KNIT, KNIT)))), "pattern 'x', row 2: its tile is worked on 2"),
    ],
)
def test_invalid_patterns_are_refused(make, found):
    with pytest.raises(PatternError, match=found):
        make()


def test_marks_above_a_row_are_its_twists_and_how_the_next_row_holds_them():
    rows = (Row((Cell(Stitch.KY, (0, 1)),)), Row((KNIT, KNIT), (Loop(1, 0, -1), Loop(-1, 1, -1))))
    pattern = Pattern("x", "", rows)
    assert pattern.loops_above(0) == (Loop(1, 0, -1), Loop(-1, 1, 0))
    assert not pattern.closes
    assert pattern.loops_above(1) == (Loop(), Loop())


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("round 1: k8\nround 2: p8\nround 3: k8 yo",
         r"row 3: its tile leaves 9 loops, but row 1 is worked on 8; .* correct the rows .*: row 3 by \+1$"),
        ("round 1: k2tog k4 yo\nround 2: k2tog k4\nround 3: k2tog k3",
         "row 3: its tile leaves 4 loops, but row 1 is worked on 6; .*: row 2 by -1, row 3 by -1$"),
        ("round 1: k | k | yo k", r"row 1: its left border leaves 2 loops, but row 1 is worked on 1; .*row 1 by \+1"),
    ],
)  # fmt: skip
def test_a_pattern_that_does_not_close_is_refused_with_the_rows_that_change_counts(text, found):
    with pytest.raises(PatternError, match=rf"^pattern 'x', {found}"):
        check_closes(parse_pattern(text, "x"))


def test_a_loop_that_crosses_no_other_has_no_layer():
    knits = (KNIT,) * 3
    assert Row(knits, (Loop(layer=3), Loop(1, 2), Loop(-1, 4))) == Row(knits, (Loop(), Loop(1, 2), Loop(-1, 4)))


def random_row(dice: random.Random) -> Row:
    """Make a row with random stitches, twists, yarns and borders, and one random crossing."""
    cells = [KNIT]
    for _ in range(dice.randint(1, 6)):
        stitch = dice.choice(list(CODES.values()))
        twist = tuple(dice.choice([-1, 0, 0, 1]) for _ in range(Cell(stitch).n_top))
        cells.append(Cell(stitch, twist, dice.choice([0, 0, 2])))
    cells.append(KNIT)
    width = sum(cell.n_bottom for cell in cells)
    start = dice.randrange(width)
    target = list(range(start, dice.randint(start, min(width, start + 4))))
    dice.shuffle(target)
    loops = [Loop(twist=dice.choice([-1, 0, 0, 1])) for _ in range(width)]
    for place, end in enumerate(target, start=start):
        loops[place] = Loop(end - place, place - start, loops[place].twist)
    return Row(tuple(cells), tuple(loops))


@pytest.mark.parametrize("seed", range(12))
def test_a_pattern_that_is_written_and_read_is_unchanged(seed):
    dice = random.Random(seed)
    row = random_row(dice)
    plain = Row((Cell(Stitch.PURL, yarn=seed % 3),) * row.n_top)
    gather = Row((Cell(Stitch.KNIT, yarn=1),) * row.n_top)
    if row.n_top == row.n_bottom and any(twist for cell in row.cells for twist in cell.twist):
        row = Row(row.cells, tuple(Loop(loop.shift, loop.layer) for loop in row.loops))
    pattern = Pattern("Random", "dice", (row, plain, gather))
    assert parse_pattern(format_pattern(pattern)) == pattern


@pytest.mark.parametrize(("left", "right"), [(0, 2), (1, 0), (2, 1)])
def test_borders_are_written_and_read(left, right):
    cells = (Cell(Stitch.PURL),) * left + (KNIT, KNIT, Cell(Stitch.PURL)) + (KNIT,) * right
    pattern = Pattern("Borders", "", (Row(cells, left=left, right=right),) * 2)
    assert parse_pattern(format_pattern(pattern)) == pattern


def test_long_rows_are_written_in_short_lines():
    cells = tuple(Cell(Stitch.KNIT if place % 2 else Stitch.PURL) for place in range(400))
    pattern = Pattern("Long", "", (Row(cells),))
    text = format_pattern(pattern)
    assert max(len(line) for line in text.splitlines()) <= 120
    assert parse_pattern(text) == pattern


def test_text_is_what_a_knitter_would_write():
    text = 'pattern "Lace"\nsource ""\nrow 1 RS: p2 c4f k2tog*2 yo2 k3tbl\nrow 2 WS: p11 k2\n'
    assert format_pattern(parse_pattern(text)) == text
