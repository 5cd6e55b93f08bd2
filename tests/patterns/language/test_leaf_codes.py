# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Texts of tile codes: reading equals a chart of the codes, writing and reading agree, bad texts are refused."""

from __future__ import annotations

import random

import pytest

from stitchmesh.errors import PatternError
from stitchmesh.patterns import leaf_codes, parse_leaf_codes, parse_pattern, read_pattern
from stitchmesh.patterns.language.text_charts import LEAF

TEXT = "KPFB\nYS2U\nY3YK\n"
WRITTEN = ("slip-stitch-honeycomb", "stockinette-and-garter", "thunderbird")


@pytest.mark.parametrize("name", ["a.txt", "a.LEAF"])
def test_a_file_of_codes_equals_a_chart_of_the_codes(tmp_path, name):
    (tmp_path / name).write_text("\n" + TEXT.lower().replace("y3yk", "y3y K") + "\n\n")
    pattern = read_pattern(tmp_path / name)
    assert pattern.rows == parse_pattern(f"chart leaf:\n{TEXT}").rows
    assert (pattern.name, pattern.width, pattern.height) == ("a", 4, 3)


def test_the_top_line_is_the_last_row():
    assert parse_leaf_codes("PP\nKK").rows == parse_pattern("row 1 RS: k2\nrow 2 WS: k2").rows


@pytest.mark.parametrize(
    "first", ['pattern "x"', "rows 2 WS: p", "Rounds 2:k"]
)
def test_a_text_that_begins_with_a_statement_is_read_as_the_language(tmp_path, first):
    (tmp_path / "a.txt").write_text(f"# K\n\n{first}\nrow 1 RS: k\n")
    assert read_pattern(tmp_path / "a.txt").rows == parse_pattern(f"{first}\nrow 1 RS: k").rows
    (tmp_path / "b.txt").write_text("chart:\np k\n")
    assert read_pattern(tmp_path / "b.txt").rows == parse_pattern("row 1 RS: k p").rows


@pytest.mark.parametrize("name", WRITTEN)
def test_a_pattern_of_tile_codes_is_unchanged_after_writing_and_reading(tmp_path, name):
    pattern = read_pattern(name)
    text = leaf_codes(pattern)
    assert len(set(map(len, text.splitlines()))) == 1
    assert parse_leaf_codes(text).rows == pattern.rows
    (tmp_path / f"{name}.leaf").write_text(text)
    assert read_pattern(tmp_path / f"{name}.leaf").rows == pattern.rows


def test_any_sequence_of_tiles_is_unchanged_after_writing_and_reading():
    dice = random.Random(0)
    lines = ["".join(dice.choices(list(LEAF), k=30)).upper() for _ in range(40)]
    width = max(map(len, lines))
    text = "".join(f"{line}{'K' * (width - len(line))}\n" for line in lines)
    assert leaf_codes(parse_leaf_codes(text)) == text


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("KK\nKX", r"line 2, column 2: got 'X'; expected one of K P F B YS 2U Y3Y"),
        ("KYK", r"line 1, column 2: got 'YK'; expected one of"),
        ("Y\n3\nY", r"line 1, column 1: got 'Y'"),
        ("KKK\nKK\nKKK", r"line 2, column 1: got 2 columns where the chart's first line has 3; make them equal, add"),
        ("KK\n\nKK", r"line 2, column 1: got a blank line between rows"),
        ("\n \n", r"line 1, column 1: got no codes; expected a line such as KKPP"),
        ("0110", r"line 1, column 1: got '011'"),
    ],
)
def test_texts_that_hold_no_codes_are_refused(tmp_path, text, found):
    (tmp_path / "bad.leaf").write_text(text)
    with pytest.raises(PatternError, match=rf"bad\.leaf: {found}"):
        read_pattern(tmp_path / "bad.leaf")


@pytest.mark.parametrize(
    ("row", "found"),
    [
        ("k p | k | k", "row 1: has borders, cables or stitches through the back leg"),
        ("k c4f", "row 1: has borders, cables"),
        ("k2tog yo", "row 1, stitch 1: got y, no tile; expected one of K P F B YS 2U Y3Y"),
        ("k p k+1", "row 1, stitch 1: got k with a twist or another yarn, no tile"),
    ],
)
def test_patterns_without_codes_cannot_be_written(row, found):
    with pytest.raises(PatternError, match=found):
        leaf_codes(parse_pattern(f"row 1 RS: {row}"))
