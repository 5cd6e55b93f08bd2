# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Increases and decreases mirror each other in pairs, and increases close in every form but the open one."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import stitch_word
from stitchmesh.mesh.courses import top_sides
from stitchmesh.mesh.shaping_stitches import Increase, closing_half_turns, shaping_stitch, with_increases
from stitchmesh.mesh.stitch import VOCABULARY, Stitch, mirrored
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from tests.hand_knitting.stitch_charts import chart_fabric

FORMS = get_args(Increase)
ROWS = ["co co co co co co", "k yk k k ky k", "k k k k k k k k", "kyk k k k k k k kyk", " ".join(["k"] * 12)]


@pytest.mark.parametrize("loops", [(1, 2), (3, 1)])
def test_the_two_ends_of_a_row_are_shaped_by_mirrored_stitches(loops):
    left, right = (shaping_stitch(*loops, keeps=side) for side in ("left", "right"))
    assert mirrored(left) == right
    assert closing_half_turns(right) == tuple(-turn for turn in closing_half_turns(left)[::-1])


@pytest.mark.parametrize("loops", [(2, 1), (3, 1)])
def test_the_loop_that_continues_the_wale_is_in_front_in_a_decrease(loops):
    """So k2tog, whose left loop is in front, leans to the right along the left edge, and ssk to the left along the
    right edge."""
    for keeps, front in (("left", 1), ("right", loops[0])):
        assert VOCABULARY[shaping_stitch(*loops, keeps=keeps)].order[0] == front


def test_only_yarn_overs_at_the_sides_of_an_increase_close():
    assert closing_half_turns(Stitch.YKY) == (-1, 0, 1)
    for stitch in (Stitch.KYK, Stitch.YARN_OVER, Stitch.SY, Stitch.KS, Stitch.KP, Stitch.KNIT):
        assert not any(closing_half_turns(stitch))


# A stitch that is knit front and back does not tell on which side the loop before it was.
@pytest.mark.parametrize(("first", "second"), [("m1", "kfb"), ("lifted", "m1"), ("yo", "lifted")])
def test_the_form_of_increases_changes_without_a_trace_of_the_form_before(first, second):
    fabric = chart_fabric(ROWS)
    there, direct = with_increases(with_increases(fabric, first), second), with_increases(fabric, second)
    np.testing.assert_array_equal(there.stitch, direct.stitch)
    np.testing.assert_array_equal(there.twist, direct.twist)


def test_knit_front_and_back_is_the_same_stitch_at_both_edges_with_its_bump_on_the_left():
    fabric = with_increases(chart_fabric(ROWS), "kfb")
    shaped = fabric.stitch[(fabric.n_bottom == 1) & (fabric.n_top == 2)]
    assert shaped.tolist() == [Stitch.PK, Stitch.PK]
    assert stitch_word(Stitch.PK, right_side=True) == stitch_word(Stitch.PK, right_side=False) == "kfb"
    again = with_increases(fabric, "m1").stitch
    assert again[(fabric.n_bottom == 1) & (fabric.n_top == 2)].tolist() == [Stitch.YK, Stitch.YK]


@pytest.mark.parametrize(("increase", "ring"), [("m1", False), ("m1", True), *((form, False) for form in FORMS[1:])])
def test_every_form_holds_its_loops(increase, ring):
    """The yarns interlock as the stitches say, and only the form ``yo`` leaves loops whose legs do not cross."""
    fabric = with_increases(chart_fabric(ROWS, ring=ring), increase)
    check_loops(fabric, generate_yarns(fabric, quality="draft"))
    shaped = np.flatnonzero((fabric.n_bottom == 1) & (fabric.n_top > 1)).tolist()
    assert len(shaped) == 4
    for face in shaped:
        made = VOCABULARY[Stitch(int(fabric.stitch[face]))].made
        turns = fabric.twist[top_sides(fabric, (face,))].tolist()
        is_open = [letter == "y" and turn == 0 for letter, turn in zip(made, turns, strict=True)]
        assert any(is_open) == (increase == "yo")


def test_an_unknown_form_is_refused():
    with pytest.raises(ParameterError, match="increase: got 'm2'; expected one of m1, kfb, lifted, yo"):
        with_increases(chart_fabric(ROWS), "m2")
