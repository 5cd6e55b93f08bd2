# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A pattern with colours keeps them on a fabric, whatever the numbers of its yarns are there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.editing.pattern_regions import PatternRegion
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.palette import colours_of, make_palette, parse_colour
from stitchmesh.patterns import apply_pattern, parse_pattern
from stitchmesh.pipeline.garment import Garment
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.stages import apply_pattern_stage
from stitchmesh.run import QUIET
from stitchmesh.shaping.options import ShapingOptions
from tests.editing.fabrics import around
from tests.patterns.fabrics import flat

RED, GREEN, CREAM = (tuple(parse_colour(name).tolist()) for name in ("red", "green", "cream"))
NUMBERED = parse_pattern("chart colours:\n01\n")
CHART = replace(NUMBERED, palette=(RED, GREEN))


def face_colours(fabric) -> list[tuple[int, ...]]:
    return [tuple(colour) for colour in colours_of(fabric.yarn, fabric.palette).tolist()]


def test_a_fabric_without_a_palette_takes_that_of_the_pattern():
    made = apply_pattern(flat(4, 3), CHART)
    assert made.palette.tolist() == [list(RED), list(GREEN)]
    assert face_colours(made)[-4:] == [RED, GREEN] * 2


def test_the_ground_is_the_commonest_colour_or_the_one_that_is_named():
    """The lower left stitch of this chart is red; the fabric is green around it, or red where that is asked for."""
    chart = replace(parse_pattern("chart colours:\n011\n"), palette=(RED, GREEN))
    made = apply_pattern(flat(4, 3), chart)
    assert face_colours(made)[:4] == [GREEN] * 4  # the cast-on row
    assert face_colours(made)[4:8] == [RED, GREEN, GREEN, GREEN]  # 4 stitches hold one repeat of 3, and one is left
    red = apply_pattern(flat(4, 3), chart, ground="red")
    assert face_colours(red)[:8] == [RED] * 4 + [RED, GREEN, GREEN, RED]
    with pytest.raises(ParameterError, match=r"ground 'cream': is no yarn of .*; expected one of #ff0000, #008000"):
        apply_pattern(flat(4, 3), chart, ground="cream")


def test_stitches_left_over_take_the_ground_on_a_fabric_of_another_colour():
    base = replace(flat(4, 3), palette=make_palette(["cream", "red"]))
    numbered = parse_pattern("chart colours:\n122\n")
    assert apply_pattern(base, numbered).yarn.tolist() == [0] * 4 + [1, 2, 2, 2] * (len(base.yarn) // 4 - 1)
    assert apply_pattern(base, numbered, ground="1").yarn.tolist()[4:8] == [1, 2, 2, 1]
    assert set(apply_pattern(base, parse_pattern("row 1 RS: k2, p")).yarn.tolist()) == {0}


@pytest.mark.parametrize(
    ("options", "proposed"),
    [
        ({}, ["rounds hold whole repeats of 4 stitches with --auto --multiple 4, or with --pattern-remainder stretch"]),
        ({"shaping": ShapingOptions()}, ["rounds hold whole repeats of 4 stitches with --multiple 4, or with"
                                         " --pattern-remainder stretch"]),
        ({"shaping": ShapingOptions(multiple=8)}, []),
    ],
)  # fmt: skip
def test_rounds_of_whole_repeats_are_proposed(options, proposed):
    fabric = around(9, 3)
    chosen = KnitOptions(patterns=(PatternRegion(parse_pattern("chart colours:\n0111\n")),), **options)
    report = apply_pattern_stage(Garment(mesh=fabric, options=chosen, values={StitchMesh: fabric}), QUIET).report
    assert report["patterns"]["laid"][0]["summary"][1:] == proposed


def test_a_fabric_with_a_palette_keeps_it_and_adds_what_is_new():
    base = replace(flat(4, 3), palette=make_palette(["cream", "green"]))
    made = apply_pattern(base, CHART)
    assert made.palette.tolist() == [list(CREAM), list(GREEN), list(RED)]
    assert face_colours(made)[-4:] == [RED, GREEN] * 2
    assert face_colours(made)[:4] == [CREAM] * 4  # the cast-on row


def test_a_pattern_that_only_numbers_its_yarns_takes_the_colours_of_the_fabric():
    base = replace(flat(4, 3), palette=make_palette(["cream", "green"]))
    made = apply_pattern(base, NUMBERED)
    assert face_colours(made)[-4:] == [CREAM, GREEN] * 2
    assert np.array_equal(made.palette, base.palette)


def test_a_yarn_is_recoloured_and_that_is_undone():
    base = flat(4, 3)
    edited = apply_edit(base, Edit("recolour", {"yarn": 1, "colour": "#112233"}))
    assert edited.fabric.palette.shape == (2, 3) and edited.fabric.palette[1].tolist() == [0x11, 0x22, 0x33]
    with pytest.raises(ParameterError, match="colour: got yarn -1; expected 0 to 255"):
        apply_edit(base, Edit("recolour", {"yarn": -1, "colour": "red"}))
    with pytest.raises(ParameterError, match="did you mean 'red'"):
        apply_edit(base, Edit("recolour", {"yarn": 0, "colour": "redd"}))
