# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The text language of weaves: reading, writing and reading again, and the places that errors give."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import PatternError
from stitchmesh.periodic.weave.library import read_weave, weave_names
from stitchmesh.periodic.weave.text import format_weave, parse_weave
from stitchmesh.periodic.weave.weave import Thread, Weave
from tests.periodic.weave.test_weave import stitching

LAYERS = "layer 1:\n01\n10\nlayer 2:\n01\n10\n"
TWILL = "110\n011\n101\n"


@pytest.mark.parametrize("name", weave_names())
def test_a_weave_is_unchanged_after_writing_and_reading(name):
    weave = read_weave(name)
    assert parse_weave(format_weave(weave)) == weave


def test_threads_are_unchanged_after_writing_and_reading():
    wefts = (Thread(radius=1 / 3, length=1e-5), Thread(spacing=2.5, colour=7), Thread(layer=4))
    weave = Weave(((1, 1, 0), (0, 1, 1), (1, 0, 1)), wefts=wefts, warps=(Thread(colour=1),) * 3, name="Odd")
    assert parse_weave(format_weave(weave)) == weave


def test_lines_are_wefts_and_signs_are_warps():
    weave = parse_weave("1 1 0 # floats\n\n  011\n101")
    assert weave.matrix == ((1, 1, 0), (0, 1, 1), (1, 0, 1))
    assert (weave.name, weave.source) == ("weave", "")


def test_numbers_of_threads_repeat():
    weave = parse_weave("wefts radius: 1 1.5\nwarps colour: 3\n1100\n1001\n0011\n0110")
    assert [thread.radius for thread in weave.wefts] == [1.0, 1.5, 1.0, 1.5]
    assert {thread.colour for thread in weave.warps} == {3}


def test_layers_lie_one_behind_another_except_at_their_stitches():
    weave = parse_weave(LAYERS + "stitch warp 2.1 over weft 1.2\nstitch weft 2.2 over warp 1.2")
    front, back = np.arange(0, 4, 2), np.arange(1, 4, 2)
    assert weave.over[np.ix_(front, front)].tolist() == weave.over[np.ix_(back, back)].tolist() == [[0, 1], [1, 0]]
    assert weave.over[np.ix_(front, back)].tolist() == [[1, 1], [0, 1]]
    assert weave.over[np.ix_(back, front)].tolist() == [[0, 0], [0, 1]]
    assert stitching(weave) == [[2, 1], [3, 2]]
    assert {thread.spacing for thread in weave.wefts + weave.warps} == {0.5}


def test_yarns_of_layers_with_different_counts_are_distributed_evenly():
    """With four front wefts and two back wefts, each back weft lies in the middle of a pair of front wefts."""
    weave = parse_weave("layer 1:\n01\n10\n01\n10\nlayer 2:\n01\n10\nstitch warp 2.1 over weft 1.2")
    assert [thread.layer for thread in weave.wefts] == [0, 1, 0, 0, 1, 0]
    assert sum(thread.spacing for thread in weave.wefts) == pytest.approx(4.0)  # rounding of six thirds


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1, column 1: got the end of a weave without a matrix"),
        ('weave "Plain"\n', "line 1, column 1: got the end of a weave without a matrix"),
        ("01\n100\n", "line 2, column 1: got 3 numbers where the first line has 2"),
        ("01\n1x\n", r"line 2, column 2: got 'x'; expected 1 \(weft over\) or 0 \(warp over\)"),
        ("01\n1 2\n", "line 2, column 3: got '2'"),
        ("xo\nox\n", "line 1, column 1: got 'xo'; expected weave, source, colours, layer, stitch, wefts, warps or"),
        ("weave Plain\n01\n10", "line 1, column 7: got 'Plain'; expected a text in quotes"),
        ('weave "Plain" 3\n01\n10', "line 1, column 15: got '3'; expected the end of the line"),
        ("layer 2:\n01\n10", "line 1, column 7: got '2'; expected 1, as layers are numbered from the front"),
        ("layer 1\n01\n10", "line 1, column 8: got the end of the line; expected ':'"),
        ("layer 1: 01\n10", "line 1, column 10: got '01'; expected the matrix of the layer on the lines below"),
        ("layer 1:\nlayer 2:\n01\n10", "line 2, column 1: got 'layer'; expected a line of 0 and 1 for each weft of"),
        (LAYERS + "layer 3:\n", "line 7, column 1: got the end of a weave without a matrix"),
        ("01\n10\nlayer 2:\n01\n10", "line 3, column 1: got 'layer'; expected no layer after a matrix without a layer"),
        (LAYERS, r"falls apart: wefts 1\.1, 1\.2 and warps 1\.1, 1\.2 lie over"),
        (LAYERS + "stitch yarn 2.1", "line 7, column 8: got 'yarn'; expected warp or weft"),
        (LAYERS + "stitch", "line 7, column 7: got the end of the line; expected warp or weft"),
        (LAYERS + "stitch warp 2", "line 7, column 13: got '2'; expected layer and number of a warp, such as 2.1"),
        (LAYERS + "stitch warp 2.1 under weft 1.1", "line 7, column 17: got 'under'; expected over"),
        (LAYERS + "stitch warp 2.1 over warp 1.1", "line 7, column 22: got 'warp'; expected weft"),
        (LAYERS + "stitch warp 2.3 over weft 1.1", "got '2.3'; expected a warp of the weave: 1.1 to 1.2, 2.1 to 2.2"),
        (LAYERS + "stitch warp 2.1 over weft 1.0", "column 27: got '1.0'; expected a weft of the weave"),
        (LAYERS + "stitch warp 1.1 over weft 2.1", "column 13: got '1.1'; expected a yarn of a layer behind"),
        (LAYERS + "stitch warp 2.1 over weft 2.2", "column 13: got '2.1'; expected a yarn of a layer behind"),
        (LAYERS + "stitch warp 2.1 over weft 1.2 1", "column 31: got '1'; expected the end of the line"),
        (TWILL + "wefts mass: 1", "line 4, column 7: got 'mass'; expected layer, radius, spacing, length, colour"),
        (TWILL + "wefts radius:", "line 4, column 14: got the end of the line; expected a number for each"),
        (TWILL + "wefts radius: 0", "line 4, column 15: got '0'; expected a positive factor of the radius"),
        (TWILL + "wefts radius: 1e999", "got '1e999'; expected a positive factor"),
        (TWILL + "wefts radius: nan", "got 'nan'; expected a positive factor"),
        (TWILL + "warps colour: 1.5", "got '1.5'; expected the number of a colour, from 0"),
        (TWILL + "warps layer: 0", "got '0'; expected the number of a layer, from 1"),
        (TWILL + "warps colour: 1 2", "line 4, column 15: got 2 numbers for 3 warps; expected as many as"),
        (TWILL + "warps colour: 1\nwarps colour: 2", "line 5, column 7: got 'colour'; expected the colour of warps"),
        ("011\n111\n101", "weft 2 passes over every warp and never interlaces"),
    ],
)
def test_errors_give_the_place_and_what_was_expected(text, message):
    with pytest.raises(PatternError, match=message) as caught:
        parse_weave(text, "cloth.weave")
    assert str(caught.value).startswith("cloth.weave: ")
