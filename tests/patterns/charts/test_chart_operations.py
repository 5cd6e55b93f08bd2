# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Operations on charts keep what they do not change, undo one another, and never leave half a cable."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.patterns.charts import chart_operations as operations
from stitchmesh.patterns.charts.grid import Box, Brush
from stitchmesh.patterns.charts.knit_chart import COVERED
from stitchmesh.patterns.charts.knit_chart_text import parse_knit_chart
from stitchmesh.periodic.weave.weave_chart import parse_weave_chart

KNIT = parse_knit_chart("chart:\np k2 k2tog yo@1 k\nk c4f p\nk6@2\nssk yo p4").chart
WEAVE = parse_weave_chart('colours "cream, navy"\nwefts colour: 0 1\n0110\n1001\n0011\n1100').chart
CHARTS = pytest.mark.parametrize("chart", [KNIT, WEAVE], ids=["knit", "weave"])


def state(chart):
    words = np.array([*chart.words, "covered"])
    return words[chart.squares].tolist(), np.asarray(chart.yarns).tolist()


@CHARTS
def test_resizing_keeps_the_old_squares(chart):
    larger = operations.resize(chart, chart.shape[0] + 3, chart.shape[1] + 2)
    assert larger.shape == (chart.shape[0] + 3, chart.shape[1] + 2)
    assert state(operations.resize(larger, *chart.shape)) == state(chart)


@CHARTS
@pytest.mark.parametrize("axis", ["rows", "columns"])
def test_what_is_inserted_can_be_removed(chart, axis):
    for place in (0, 2, chart.shape[axis == "columns"]):
        inserted = operations.insert(chart, axis, place, 2)
        if axis == "columns" and chart is KNIT and place == 2:
            continue  # it lies within a cable, which becomes knit
        assert state(operations.remove(inserted, axis, place, place + 2)) == state(chart)


@CHARTS
def test_a_mirror_undoes_itself(chart):
    for upwards in (False, True):
        assert state(operations.mirror(operations.mirror(chart, upwards=upwards), upwards=upwards)) == state(chart)
        box = Box(0, 0, 2, 3)
        once = operations.mirror(WEAVE, upwards=upwards, box=box)
        assert state(operations.mirror(once, upwards=upwards, box=box)) == state(WEAVE)


@CHARTS
def test_a_crop_of_copies_is_the_chart(chart):
    height, width = chart.shape
    copies = operations.repeat(chart, 2, 3)
    assert copies.shape == (2 * height, 3 * width)
    for row in range(2):
        for column in range(3):
            corner = row * height, column * width
            box = Box(*corner, corner[0] + height, corner[1] + width)
            assert state(operations.crop(copies, box)) == state(chart)


@CHARTS
def test_a_box_repeats_over_the_whole_chart_and_stays_where_it_is(chart):
    filled = operations.repeat_box(chart, Box(0, 0, 2, 2))
    words, _ = state(filled)
    whole = np.array(words)
    assert (whole == whole[np.ix_(np.arange(4) % 2, np.arange(chart.shape[1]) % 2)]).all()
    assert [row[:2] for row in words[:2]] == [row[:2] for row in state(chart)[0][:2]]


def test_a_move_leaves_plain_squares_and_a_copy_leaves_the_old_ones():
    box = Box(2, 1, 3, 5)  # the cable
    moved = operations.move(KNIT, box, -1, 1)
    assert [moved.word_at(1, column) for column in range(6)] == ["k", "k", "c4f", "c4f", "c4f", "c4f"]
    assert [moved.word_at(2, column) for column in range(6)] == ["k"] * 5 + ["p"]
    copied = operations.move(KNIT, box, -1, 1, keep=True)
    assert copied.word_at(2, 1) == copied.word_at(1, 2) == "c4f"
    assert state(operations.move(moved, Box(1, 2, 2, 6), 1, -1))[0][2] == state(KNIT)[0][2]


def test_fill_reaches_the_connected_equal_squares_alone():
    chart = parse_knit_chart("chart colours:\n00100\n00100\n11100").chart
    filled = operations.fill(chart, 0, 0, Brush(yarn=7))
    assert filled.yarns[::-1].tolist() == [[0, 0, 7, 0, 0], [0, 0, 7, 0, 0], [7, 7, 7, 0, 0]]
    other = operations.fill(chart, 2, 0, Brush("p", 3))
    assert other.yarns[::-1].tolist() == [[3, 3, 1, 0, 0], [3, 3, 1, 0, 0], [1, 1, 1, 0, 0]]


@pytest.mark.parametrize(
    "refused",
    [lambda: operations.resize(KNIT, 0, 0), lambda: operations.resize(KNIT, 501, 4),
     lambda: operations.insert(KNIT, "rows", 9), lambda: operations.remove(KNIT, "rows", 0, 4),
     lambda: operations.remove(KNIT, "columns", 3, 3), lambda: operations.fill(KNIT, 4, 0, Brush("p")),
     lambda: operations.crop(KNIT, Box(7, 0, 8, 1)), lambda: operations.repeat(KNIT, 200, 1),
     lambda: Box(0, 0, 0, 3), lambda: operations.paint(KNIT, [[0, 0]], Brush(yarn=-1)),
     lambda: operations.paint(WEAVE, [[0, 0]], Brush("1", 2))],
)  # fmt: skip
def test_refused_operations(refused):
    with pytest.raises(ParameterError, match=r"got .*; expected|got a colour"):
        refused()


def random_operation(chart, generator):
    rows, columns = chart.shape
    row, column = generator.integers(rows), generator.integers(columns)
    box = Box(row, column, generator.integers(row, rows) + 1, generator.integers(column, columns) + 1)
    word = str(generator.choice(["k", "p", "yo", "1/1lc", "t3f", "none"]))
    return [
        lambda: operations.paint(chart, [[row, column], [row, column + 1]], Brush(word, 2)),
        lambda: operations.fill_box(chart, box, Brush(word)),
        lambda: operations.mirror(chart, box=box),
        lambda: operations.mirror(chart, upwards=True),
        lambda: operations.repeat_box(chart, box),
        lambda: operations.move(chart, box, int(generator.integers(-3, 4)), int(generator.integers(-3, 4))),
        lambda: operations.insert(chart, "columns", int(column)),
        lambda: operations.remove(chart, "columns", int(column), int(column) + 1),
        lambda: operations.fill(chart, int(row), int(column), Brush(word, 1)),
    ][generator.integers(9)]


@pytest.mark.parametrize("seed", range(6))
def test_no_sequence_of_operations_leaves_half_a_cable(seed):
    generator, chart = np.random.default_rng(seed), KNIT
    for _ in range(40):
        try:
            chart = random_operation(chart, generator)()
        except ParameterError:
            continue  # no room for a cable, or the last column would be removed
        for row in range(chart.shape[0]):
            column = 0
            while column < chart.shape[1]:
                assert chart.squares[row, column] != COVERED
                width = chart.widths[chart.squares[row, column]]
                assert (chart.squares[row, column + 1 : column + width] == COVERED).all()
                column += width
            assert column == chart.shape[1]
