# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossings: the new places of loops, the loops in front, and crossings that are refused."""

from __future__ import annotations

import pytest

from stitchmesh.errors import PatternError
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import Cell, Loop, Row, parse_pattern


def crossing(words: str, side: str = "RS") -> tuple[list[int], list[int], str]:
    """Return the shifts and layers of the loops, and the stitches as k and p, all from left to right."""
    row = parse_pattern(f"row 1 {side}: {words}").rows[0]
    made = "".join("k" if cell.stitch == Stitch.KNIT else "p" for cell in row.cells)
    return [loop.shift for loop in row.loops], [loop.layer for loop in row.loops], made


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        # the two loops on the right are worked first; if they are held in front, they move left
        ("c4f", ([2, 2, -2, -2], [0, 0, 1, 1], "kkkk")),
        ("c4b", ([2, 2, -2, -2], [1, 1, 0, 0], "kkkk")),
        ("c2f", ([1, -1], [0, 1], "kk")),
        ("lt", ([1, -1], [0, 1], "kk")),
        ("rt", ([1, -1], [1, 0], "kk")),
        ("t3f", ([2, -1, -1], [0, 1, 1], "kkp")),
        ("t3b", ([1, 1, -2], [1, 1, 0], "pkk")),
        ("t4b", ([2, 2, -2, -2], [1, 1, 0, 0], "ppkk")),
        ("1/2lc", ([1, 1, -2], [0, 0, 1], "kkk")),
        ("1/2rpc", ([2, -1, -1], [1, 0, 0], "ppk")),
    ],
)
def test_crossings_as_seen_from_the_right_side(words, expected):
    assert crossing(words) == expected


@pytest.mark.parametrize(("word", "seen"), [("c4f", "c4f"), ("c6b", "c6b"), ("2/1lc", "1/2lc"), ("3/1rc", "1/3rc")])
def test_a_crossing_keeps_its_handedness_when_worked_from_the_wrong_side(word, seen):
    # a screw has the same hand from both ends: loops behind for the knitter lie in front on the right side
    assert crossing(word, "WS")[:2] == crossing(seen)[:2]


def test_a_crossing_written_with_places_equals_its_word():
    assert crossing("cross(2 3 0 1; 1 1 0 0: k4)") == crossing("c4f")
    assert crossing("cross(1 2 0; 0 0 1: p k2)", "WS") == crossing("cross(2 0 1; 0 1 1: p2 k)")
    chart = parse_pattern("chart:\n cross(2 3 0 1; 0 0 1 1: k4)").rows[0]
    assert chart == parse_pattern("row 1 RS: c4f").rows[0]


def test_decreases_and_back_legs_after_a_crossing():
    row = parse_pattern("row 1 RS: cross(1 2 0; 1 1 0: ktbl k2tog)").rows[0]
    assert [cell.stitch for cell in row.cells] == [Stitch.D12K, Stitch.KNIT]
    # the leftmost loop goes to the right end, where the twisted stitch is worked
    assert row.loops == (Loop(2, 0, -1), Loop(-1, 1), Loop(-1, 1))


@pytest.mark.parametrize(
    ("words", "found"),
    [
        ("cross(1 0; 0 0: k2)", "loops 1 and 2 from the left cross in one layer"),
        ("cross(0 0; 0 1: k2)", "cables must not overlap"),
        ("cross(0 2; 0 1: k2)", "is crossed to place 0 of 2"),
        ("cross(1 0; 0 1: k3)", "got 2 places, 2 layers and stitches on 3 loops; expected equal numbers"),
        ("cross(1 0; 0: k2)", "got 2 places, 1 layers"),
        ("cross(1 0; 0 1: lt)", "a cable within a crossing; cables must not overlap"),
        ("cross(1 0; 0 1: cross(1 0; 0 1: k2))", "a crossing within a crossing; cables must not overlap"),
        ("cross(1 0; 0 1: k t)", "a tuck within a crossing"),
        ("cross(1 0; 0 1: k k", r"cross\( without its partner"),
        ("cross 1 0", r"expected '\(' after cross"),
        ("cross(1 k; 0 1: k2)", "got 'k'; expected places or layers counted from 0"),
    ],
)
def test_invalid_crossings_are_refused(words, found):
    with pytest.raises(PatternError, match=r"line 1, column \d+: .*" + found):
        parse_pattern(f"row 1 RS: {words}")


def test_a_cable_wider_than_the_row_below_is_refused():
    with pytest.raises(PatternError, match=r"line 2, column 1: row 2: its tile is worked on 6 loops, .* leaves 4"):
        parse_pattern("row 1 RS: k4\nrow 2 RS: c6f")


def test_a_cable_stays_in_its_section():
    knit, shifts = Cell(Stitch.KNIT), (Loop(1, 0), Loop(-1, 1), Loop())
    assert Row((knit,) * 3, shifts, right=1).loops == shifts
    with pytest.raises(PatternError, match="loop 1 of the left border is crossed to place 2 of 1; a cable stays"):
        Row((knit,) * 3, shifts, left=1)
