# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A pattern with colours keeps them on a fabric, whatever the numbers of its yarns are there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.errors import ParameterError
from stitchmesh.mesh.palette import colours_of, make_palette, parse_colour
from stitchmesh.patterns import apply_pattern, parse_pattern
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
