# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows that are shaped in a rhythm are one line, which is read back and knitted to the same stitches."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stitchmesh.errors import PatternError
from stitchmesh.hand_knitting import knitting_instructions, parse_instructions
from stitchmesh.mesh.shaping_stitches import with_increases
from tests.hand_knitting.stitch_charts import chart_fabric
from tests.hand_knitting.test_instructions import Comparison


def rows_of(parts: list[int], row: str, *, apart: int, times: int) -> list[str]:
    """Rows of a chart from the first one up, with shaped rows at equal distances.

    Args:
        parts: plain stitches of each part at first, in the places of {0}, {1} ... of ``row``.
        row: words of a shaped row from left to right.
        apart: rows from one shaped row to the next.
        times: number of shaped rows.
    """
    step = 2 if "yk" in row else -2
    rows = [" ".join(["co"] * _loops(row, parts))]
    for _ in range(times):
        rows.append(row.format(*(" ".join(["k"] * part) for part in parts)))
        parts = [part + step for part in parts]
        rows += [" ".join(["k"] * _loops(row, parts))] * (apart - 1)
    return rows


def _loops(row: str, parts: list[int]) -> int:
    """Loops that a shaped row takes."""
    words = [word for word in row.split() if "{" not in word]
    return sum(parts) + sum(2 if word.startswith("d") else 1 for word in words)


DECREASES = "k d12k {0} d21k k"
TWO_GORES = "k d12k {0} d21k k k d12k {1} d21k k"


def lines_of(rows: list[str], *, ring: bool = False) -> list[str]:
    fabric = with_increases(chart_fabric(rows, ring=ring))
    Comparison(fabric).check()
    return knitting_instructions(fabric).split("\n")


@pytest.mark.parametrize(("apart", "every"), [(1, "every round"), (4, "every 4th round")])
def test_a_tube_that_narrows_is_one_line(apart, every):
    lines = lines_of(rows_of([9], DECREASES, apart=apart, times=4), ring=True)
    others = "" if apart == 1 else "; k the other rounds"
    last = 1 + 3 * apart
    assert (
        f"Rounds 1 to {last}: decrease 1 st at each side {every}, 4 times: k1, ssk, k to last 3, k2tog, k1{others}. "
        "(15 to 7 sts)" in lines
    )
    assert any(line.startswith("  k to last 3: knit until 3 sts") for line in lines)


def test_a_flat_piece_that_widens_is_one_line():
    lines = lines_of(rows_of([5], "ky {0} yk", apart=4, times=3))
    words = "k1, m1l, k to last 1, m1r, k1"
    line = f"Rows 1 to 9 (RS): increase 1 st at each side every 4th row, 3 times: {words}; work the other rows plain."
    assert f"{line} (7 to 13 sts)" in lines


def test_rows_on_both_sides_are_no_rhythm():
    """Every third row is worked on the right side and on the wrong side in turn, in other words."""
    assert not any(" times: " in line for line in lines_of(rows_of([9], DECREASES, apart=3, times=4)))


def test_gores_of_a_tube_have_markers_between_them():
    lines = lines_of(rows_of([9, 13], TWO_GORES, apart=2, times=4), ring=True)
    assert (
        "Rounds 1 to 7: decrease 1 st at each side of each marker and of the start of the round every 2nd round, "
        "4 times: k1, ssk, k to 3 before marker, k2tog, k1, sm, k1, ssk, k to last 3, k2tog, k1; k the other rounds. "
        "Marker after st 19. (34 to 18 sts)" in lines
    )
    assert any(line.startswith("  sm: slip the marker") for line in lines)


def test_two_shaped_rows_and_rows_of_other_words_are_written_one_by_one():
    assert not any(" times: " in line for line in lines_of(rows_of([9], DECREASES, apart=2, times=2), ring=True))
    rows = rows_of([9], DECREASES, apart=2, times=4)
    lines = lines_of([*rows[:4], rows[4].replace("k", "p", 1), *rows[5:]], ring=True)
    assert sum(" times: " in line for line in lines) == 0


def test_a_rhythm_in_another_yarn_names_it():
    rows = rows_of([9], DECREASES, apart=2, times=3)
    fabric = chart_fabric(rows, ring=True)
    fabric = replace(fabric, yarn=(fabric.row > 0).astype(int))
    Comparison(fabric).check()
    assert "Rounds 1 to 5 in yarn B: decrease 1 st at each side every 2nd round" in knitting_instructions(fabric)


GOOD = (
    "Rounds 1 to 5: decrease 1 st at each side every 2nd round, 3 times: k1, ssk, k to last 3, k2tog, k1; "
    "k the other rounds. (15 to 9 sts)"
)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (GOOD.replace("3 times", "4 times"), "got rows 1 to 5, 4 times every 2; expected as many rows"),
        (GOOD.replace("to 9 sts", "to 11 sts"), "got 11 sts in the end; expected 9"),
        (GOOD.replace("(15 to", "(4 to"), "got the word 'k'"),
        (GOOD.replace("k to last 3", "k9, sm"), "got a marker after 12 sts; expected one where the line says"),
        (GOOD.replace("k to last 3", "k3"), "got words on 9 sts for 15 sts; expected as many"),
        (GOOD.replace("(15 to", "(999999 to"), "got 3 rows of 999999 sts in one line; expected 1,000,000 sts at most"),
    ],
)
def test_lines_that_make_no_sense_are_refused(line, words):
    head = "Piece 1, worked in rounds\nCast on 15 sts; join in the round.\n"
    assert len(parse_instructions(head + GOOD)[0].rows) == 5
    with pytest.raises(PatternError, match="line 3: ") as refused:
        parse_instructions(head + line)
    assert words in str(refused.value)
