# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knitting charts that are edited: pattern and chart hold the same fabric, and cables stay whole or become knit."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.patterns import parse_pattern, read_pattern
from stitchmesh.patterns.charts.grid import LONGEST_SIDE, Brush
from stitchmesh.patterns.charts.knit_chart import COVERED, KnitChart, knit_chart, mirrored_word, read_square
from stitchmesh.patterns.charts.knit_chart_text import parse_knit_chart, write_knit_chart
from stitchmesh.patterns.library import pattern_folder
from tests.chosen_patterns import CHOSEN_PATTERNS


def chart(text):
    return parse_knit_chart(text).chart


def words(edited):
    return [[edited.word_at(row, column) for column in range(edited.shape[1])] for row in range(edited.shape[0])]


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_chart_text_and_pattern_hold_the_same_fabric(name):
    pattern = read_pattern(name)
    assert knit_chart(pattern).pattern() == pattern
    assert parse_knit_chart(write_knit_chart(knit_chart(pattern)).text).pattern() == pattern
    written = (pattern_folder() / f"{name}.knit").read_text()
    assert parse_knit_chart(written, name).pattern() == pattern


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_a_chart_that_is_mirrored_twice_is_the_same_and_mirrored_once_it_still_fits(name):
    edited = knit_chart(read_pattern(name))
    mirrored = edited.mirrored(upwards=False)
    rows, other = edited.pattern().rows, mirrored.pattern().rows
    assert [(row.n_bottom, row.n_top) for row in rows] == [(row.n_bottom, row.n_top) for row in other]
    assert mirrored.mirrored(upwards=False).pattern() == edited.pattern()


@pytest.mark.parametrize(
    ("word", "mirror"),
    [("k2tog", "ssk"), ("c4f", "c4b"), ("2/1lc", "2/1rc"), ("sk", "ks"), ("k+1", "k-1"), ("yo", "yo"),
     ("s2kp", "d213k"), ("t", "t"), ("cross(1 2 0; 0 0 1: k3)", "1/2rc")],
)  # fmt: skip
def test_leaning_stitches_lean_to_the_other_side_in_the_mirror(word, mirror):
    assert mirrored_word(word) == mirror


def test_borders_stay_borders_and_change_sides_in_the_mirror():
    edited = chart("chart:\np k | k2 yo k2tog | k\np k | k4 | k")
    assert (edited.left, edited.right) == (2, 1)
    assert parse_knit_chart(write_knit_chart(edited).text).pattern() == edited.pattern()
    mirrored = edited.mirrored(upwards=False)
    assert (mirrored.left, mirrored.right) == (1, 2)
    assert [row.left for row in mirrored.pattern().rows] == [1, 1]


def test_rows_of_unequal_widths_have_squares_without_a_stitch_that_keep_the_wales_in_line():
    edited = chart("row 1 RS: k4\nrow 2 WS: p2tog p2\nrow 3 RS: k yo k2")
    assert words(edited) == [["k"] * 4, ["k2tog", "none", "k", "k"], ["k", "k", "yo", "k"]]
    assert edited.pattern().rows == parse_pattern("row 1 RS: k4\nrow 2 WS: p2tog p2\nrow 3 RS: k yo k2").rows


def test_decreases_and_increases_stand_at_their_wales():
    assert words(knit_chart(read_pattern("openwork-trellis")))[2] == "yk none k2tog k k ssk none yk".split()


def test_a_cable_covers_its_columns_and_keeps_the_yarn_of_each_stitch():
    edited = chart("chart:\nk4\nc4f@2").painted(np.array([[0, 1]]), Brush(yarn=5))
    assert edited.squares[0].tolist()[1:] == [COVERED] * 3
    assert edited.yarns[0].tolist() == [2, 5, 2, 2]
    assert [cell.yarn for cell in edited.pattern().rows[0].cells] == [2, 5, 2, 2]
    assert parse_knit_chart(write_knit_chart(edited).text).pattern() == edited.pattern()


def test_a_cable_is_painted_where_it_has_room_and_refused_where_it_has_none():
    edited = chart("chart letters:\nkkkkkk")
    painted = edited.painted(np.array([[0, 0], [0, 1], [0, 5]]), Brush("c4f", 1))
    assert words(painted)[0] == ["c4f"] * 4 + ["k", "k"]
    assert painted.yarns[0].tolist() == [1, 1, 1, 1, 0, 0]
    with pytest.raises(ParameterError, match="c4f covers 4 columns; got 3 up to the right edge"):
        edited.painted(np.array([[0, 3]]), Brush("c4f"))


def test_tucks_are_kept_on_the_right_side_and_resolved_on_the_wrong_side():
    assert words(chart("chart letters upwards:\nkt\nkk"))[0] == ["k", "t"]
    text = "row 1 RS: k2\nrow 2 WS: p t"
    assert parse_knit_chart(text).pattern().rows == parse_pattern(text).rows


@pytest.mark.parametrize("word", ["k2", "k@1", "k p", "", "[k p]", "k | k", "c3f", "x9"])
def test_a_square_holds_one_stitch_or_one_cable_without_its_yarn(word):
    with pytest.raises(PatternError):
        read_square(word)


@pytest.mark.parametrize("shape", [(0, 4), (1, LONGEST_SIDE + 1)])
def test_empty_and_too_large_charts_are_refused(shape):
    with pytest.raises(ParameterError, match=rf"got {shape[0]} x {shape[1]} \(rows x columns\); expected 1 to 500"):
        KnitChart(np.zeros(shape), ("k",), np.zeros(shape))


def test_an_error_of_rows_has_the_line_of_its_row():
    written = write_knit_chart(chart("chart letters:\nkkk\nk/k"))
    with pytest.raises(PatternError, match="row 2: its tile is worked on 3 loops, but the row below") as caught:
        parse_knit_chart(written.text.replace("k/k", "k/.")).pattern()
    assert written.text.splitlines()[caught.value.line - 1] == "kkk"


def test_an_error_of_a_word_has_its_line_and_column():
    with pytest.raises(PatternError) as caught:
        parse_knit_chart("chart letters:\nkkk\nkqk")
    assert (caught.value.line, caught.value.column) == (3, 2)


@pytest.mark.parametrize("text", ["rows 1-10000 RS: k100000", "rounds 1-600: t2"])
def test_short_texts_of_large_charts_are_refused(text):
    with pytest.raises(ParameterError, match=r"\(rows x columns\); expected 1 to 500"):
        parse_knit_chart(text)
