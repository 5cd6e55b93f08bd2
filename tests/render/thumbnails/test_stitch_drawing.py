# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drawings of stitches as SVG."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.palette import colour_text
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.render.palette import stitch_colour
from stitchmesh.render.thumbnails.stitch_drawing import OTHER, OTHER_ON_PALE, OWN, draw_stitch

DRAWN = [stitch for stitch in Stitch if stitch != Stitch.PANEL]
SVG = "{http://www.w3.org/2000/svg}"


def lines(stitch: Stitch) -> list[tuple[str, str]]:
    """The colour and the path of each line, in the order in which they are drawn."""
    return [(line.attrib["stroke"], line.attrib["d"]) for line in ET.fromstring(draw_stitch(stitch)).iter(f"{SVG}path")]


def test_the_inks_are_those_of_the_row_and_of_the_loops_that_the_stitch_is_worked_on():
    for stitch in DRAWN:
        found = {colour for colour, _ in lines(stitch)} - {colour_text(stitch_colour(stitch))}
        others = found - {OWN}
        has_loops_below = stitch not in VOCABULARY or VOCABULARY[stitch].n_bottom > 0
        assert OWN in found and others <= {OTHER, OTHER_ON_PALE} and len(others) <= 1, stitch
        assert len(others) == (has_loops_below and stitch != Stitch.CAST_ON), stitch


def test_the_yarn_of_a_slip_with_the_yarn_in_front_is_drawn_last_and_behind_first():
    assert lines(Stitch.SLIP_FRONT)[-1][0] == OWN
    assert lines(Stitch.SLIP_BACK)[-1][0] != OWN


def test_no_two_stitches_have_the_same_drawing():
    assert len({draw_stitch(stitch) for stitch in DRAWN}) == len(DRAWN)


def test_a_panel_has_no_yarn_to_draw():
    with pytest.raises(ParameterError, match="draw_stitch: got a panel, which has no yarn; expected a stitch"):
        draw_stitch(Stitch.PANEL)
