# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Weaves that are edited as charts: with their threads, their layers and their text."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.patterns.charts import chart_operations as operations
from stitchmesh.patterns.charts.grid import Box, Brush
from stitchmesh.patterns.library import pattern_folder
from stitchmesh.periodic.weave.library import read_weave, weave_names
from stitchmesh.periodic.weave.weave_chart import WeaveChart, parse_weave_chart, weave_chart, write_weave_chart

DOUBLE = weave_chart(read_weave("double-plain-stitched"))


@pytest.mark.parametrize("name", weave_names())
def test_chart_text_and_weave_hold_the_same_fabric(name):
    weave = read_weave(name)
    assert weave_chart(weave).weave() == weave
    assert parse_weave_chart(write_weave_chart(weave_chart(weave)).text).pattern() == weave
    written = parse_weave_chart((pattern_folder() / f"{name}.weave").read_text(), name)
    assert written.pattern() == weave


@pytest.mark.parametrize("name", ["twill-3x2", "double-plain-stitched"])
def test_the_place_of_each_weft_is_its_line(name):
    written = write_weave_chart(weave_chart(read_weave(name)))
    lines = written.text.splitlines()
    rows = ["".join(map(str, row)) for row in written.chart.squares]
    assert [lines[place.line - 1] for place in written.places] == rows


def test_colours_are_kept_in_the_text():
    chart = parse_weave_chart('colours "cream, #102030"\nwarps colour: 0 1\n01\n10').chart
    assert chart.palette == ((236, 226, 206), (16, 32, 48))
    assert chart.yarns.tolist() == [[0, 0], [0, 1]]
    assert parse_weave_chart(write_weave_chart(chart).text).chart.palette == chart.palette


def test_more_wefts_and_warps_repeat_the_weave_with_its_layers():
    larger = operations.resize(DOUBLE, 16, 16)
    assert larger.weave().matrix == operations.repeat(DOUBLE, 2, 2).weave().matrix
    assert [thread.layer for thread in larger.wefts] == [0, 1] * 8


def test_a_layer_is_painted_alone():
    layer = DOUBLE.layer_chart(1)
    assert layer.shape == (4, 4)
    assert DOUBLE.with_layer(1, layer).weave() == DOUBLE.weave()
    painted = DOUBLE.with_layer(1, layer.painted(np.array([[0, 1]]), Brush("1")))
    changed = np.argwhere(painted.squares != DOUBLE.squares)
    assert changed.tolist() in ([], [[1, 3]])
    assert painted.squares[1, 3] == 1
    with pytest.raises(ParameterError, match="layer 2: got 2 x 4 crossings; expected 4 x 4"):
        DOUBLE.with_layer(1, operations.crop(layer, Box(0, 0, 2, 4)))
    with pytest.raises(ParameterError, match="got 0 wefts and 0 warps in layer 3"):
        DOUBLE.layer_chart(2)


def test_blank_squares_are_plain_weave_with_the_layers_one_behind_another():
    plain = DOUBLE.blanked(Box(0, 0, 8, 8))
    assert not np.array_equal(plain.squares, DOUBLE.squares)
    for layer in (0, 1):
        squares = plain.layer_chart(layer).squares
        assert (squares == np.add.outer(np.arange(4), np.arange(4)) % 2).all()
    front, back = plain.squares[::2, 1::2], plain.squares[1::2, ::2]
    assert (front == 1).all()
    assert (back == 0).all()


def test_threads_are_dyed_and_mirrored_with_the_chart():
    chart = WeaveChart(np.eye(3, dtype=int)).dyed("wefts", [0], 2).dyed("warps", [2, 9], 1)
    assert [thread.colour for thread in chart.wefts] == [2, 0, 0]
    assert [thread.colour for thread in chart.mirrored(upwards=True).wefts] == [0, 0, 2]
    assert [thread.colour for thread in chart.mirrored(upwards=False).warps] == [1, 0, 0]
    assert chart.yarns.tolist() == [[2, 0, 1], [0, 0, 1], [0, 0, 0]]


def test_a_weft_that_never_interlaces_has_its_line():
    written = parse_weave_chart('weave "x"\n\n0110\n1111\n1001')
    with pytest.raises(PatternError, match="weft 2 passes over every warp") as caught:
        written.pattern()
    assert (caught.value.line, caught.value.row) == (4, 1)


def test_layers_in_the_text_have_the_lines_of_their_own_matrix():
    written = parse_weave_chart("layer 1:\n01\n10\nlayer 2:\n01\n10\nstitch warp 2.1 over weft 1.1")
    assert [place.line for place in written.places] == [2, 5, 3, 6]


@pytest.mark.parametrize("squares", [np.zeros((2, 501)), np.full((2, 2), 3)])
def test_refused_charts(squares):
    with pytest.raises(ParameterError, match="got"):
        WeaveChart(squares)


def test_a_short_text_of_many_layers_is_refused_before_it_fills_the_memory():
    text = "".join(f"layer {number}:\n01\n10\n" for number in range(1, 3001))
    with pytest.raises(PatternError, match="got 6000 wefts and 6000 warps; expected at most 4000000 crossings"):
        parse_weave_chart(text)
