# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scales of colours, and the colours of yarns by contact force, distance and stretch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.render import render
from stitchmesh.render.colour_scale import DIVERGING, SEQUENTIAL, ColourScale, diverging_scale, sequential_scale
from stitchmesh.render.colouring import colour_yarns
from tests.render.test_pictures import fabric, rings
from tests.yarn.test_strand_distance import lines
from tests.yarnrelax.test_contact_load import floor


def test_a_scale_has_its_colours_at_its_ends_and_beyond_them():
    scale = ColourScale(SEQUENTIAL, 2.0, 6.0)
    colours = scale.of(np.array([-9.0, 2.0, 6.0, 40.0]))
    np.testing.assert_array_equal(colours, SEQUENTIAL[[0, 0, -1, -1]])


def test_outliers_do_not_take_the_scale_and_equal_numbers_have_one_too():
    values = np.concatenate([np.linspace(0.0, 1.0, 999), [1e9]])
    assert sequential_scale(values, 0.1).high < 1.1
    assert diverging_scale(values, 0.1).high < 1.1
    equal = sequential_scale(np.full(10, 4.0), 0.5)
    assert (equal.low, equal.high) == (4.0, 4.5)


def test_yarns_that_touch_differ_from_those_that_do_not():
    yarns = lines(0.0, 0.18, 1.0)  # the first two overlap by a tenth of their diameter
    for colour in ("contact", "distance"):
        coloured = colour_yarns(yarns, colour)
        drawn = coloured.points.reshape(3, 30, 3)
        np.testing.assert_array_equal(drawn[0, 15], drawn[1, 15])
        assert (drawn[0, 15] != drawn[2, 15]).any()
        assert len(coloured.key) == 5
    assert colour_yarns(yarns, "contact").key[-1][0] == "0 dyn/cm contact"
    low = float(colour_yarns(yarns, "distance").key[-1][0].split()[0])
    assert low == pytest.approx(-0.2, abs=0.005)  # 0.02 cm of overlap, in mm with two digits


def test_distance_from_a_body_grows_with_the_height():
    yarns = lines(0.1, 0.5, 1.0)
    first, _, last = colour_yarns(yarns, "body-distance", body=floor()).points.reshape(3, 30, 3)[:, 15]
    np.testing.assert_array_equal(first, SEQUENTIAL[0])
    np.testing.assert_array_equal(last, SEQUENTIAL[-1])


def test_stretch_is_that_of_the_stitches():
    cloth = fabric()
    stretched = replace(cloth, stretch=np.full(int(cloth.side_edge.max()) + 1, 1.25))
    yarns = replace(rings(), face=np.repeat(np.arange(9), 30))
    coloured = colour_yarns(yarns, "stretch", fabric=stretched)
    np.testing.assert_array_equal(coloured.points, np.tile(DIVERGING[-1], (len(yarns.points), 1)))
    assert coloured.key[0][0] == "+25.0 % stretch"


@pytest.mark.parametrize(
    ("colour", "options", "message"),
    [
        ("stretch", {}, "colour: got 'stretch' for yarns without their stitch mesh; give the stitch mesh too"),
        ("body-distance", {}, "colour: got 'body-distance' without a body; give the mesh of the body too"),
        ("contct", {}, "did you mean 'contact'?"),
    ],
)
def test_what_is_missing_is_said(colour, options, message):
    with pytest.raises(ParameterError) as error:
        colour_yarns(rings(), colour, **options)
    assert message in str(error.value) and "\n" not in str(error.value)


def test_what_no_relaxation_made_or_no_mesh_has_is_refused(tmp_path):
    yarns = replace(rings(), face=np.repeat(np.arange(9), 30))
    with pytest.raises(ParameterError, match="got 'stretch' and a stitch mesh that was not relaxed"):
        colour_yarns(yarns, "stretch", fabric=replace(fabric(), stretch=None))
    with pytest.raises(ParameterError, match="got 'contact' for a stitch mesh; only yarns have it"):
        render(fabric(), tmp_path / "a.png", colour="contact")
