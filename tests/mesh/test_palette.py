# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours as text, and palettes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import LabelError, ParameterError
from stitchmesh.mesh.palette import (
    STOCK,
    WOOLS,
    colour_text,
    colours_of,
    empty_palette,
    linear_colour,
    make_palette,
    parse_colour,
    parse_yarn_colours,
    recolour_palette,
    srgb_colour,
)
from tests.editing.fabrics import flat


@pytest.mark.parametrize(
    ("text", "colour"),
    [
        ("#aa2233", (170, 34, 51)),  # by definition of the notation
        ("#A23", (170, 34, 51)),  # each digit stands twice
        ("navy", (0, 0, 128)),  # CSS Color Module 4
        (" Dark Olive Green ", (85, 107, 47)),
        ("cream", WOOLS["cream"]),
    ],
)
def test_a_text_names_a_colour(text, colour):
    assert parse_colour(text).tolist() == list(colour)


def test_a_colour_is_written_as_it_is_read():
    colours = np.random.default_rng(1).integers(0, 256, (40, 3))
    np.testing.assert_array_equal(make_palette([colour_text(colour) for colour in colours]), colours)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("navvy", "colour: got 'navvy'; expected #rrggbb or a name such as navy or cream; did you mean 'navy'?"),
        ("#12345", "colour: got '#12345'; expected #rrggbb"),
        ("#gg0000", "colour: got '#gg0000'"),
        ("rgb(1,2,3)", "colour: got 'rgb(1,2,3)'"),
        ("", "colour: got ''"),
    ],
)
def test_what_is_no_colour_is_refused(text, message):
    with pytest.raises(ParameterError) as error:
        parse_colour(text)
    assert str(error.value).startswith(message)


def test_numbers_beyond_the_palette_have_stock_colours():
    palette = make_palette(["navy", "red"])
    np.testing.assert_array_equal(colours_of([1, 0, 2, 7], palette), [palette[1], palette[0], STOCK[2], STOCK[0]])
    np.testing.assert_array_equal(colours_of([0, 1], np.zeros((0, 3), np.uint8)), STOCK[:2])


def test_a_stitch_mesh_has_no_palette_by_default_and_checks_one():
    fabric = flat()
    assert fabric.palette.shape == (0, 3)
    assert replace(fabric, palette=[[1, 2, 3]]).palette.dtype == np.uint8
    with pytest.raises(LabelError, match=r"palette: got shape \(3,\); expected \(P, 3\)"):
        replace(fabric, palette=[1, 2, 3])
    with pytest.raises(LabelError, match="palette: got values 0 to 256; expected whole numbers from 0 to 255"):
        replace(fabric, palette=[[0, 1, 256]])


def test_colours_of_yarn_numbers_are_read_and_fill_a_palette():
    colours = parse_yarn_colours(["2=navy", "0=#010203"])
    palette = recolour_palette(empty_palette(), colours)
    np.testing.assert_array_equal(palette, [[1, 2, 3], STOCK[1], [0, 0, 128]])
    np.testing.assert_array_equal(recolour_palette(palette, {1: parse_colour("red")})[1], [255, 0, 0])


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["navy"], "colour: got 'navy'; expected the number of a yarn and its colour, such as 0=navy"),
        (["9" * 5000 + "=navy"], f"colour: got '{'9' * 40}'; expected the number of a yarn"),
        (["a=navy"], "colour: got 'a=navy'; expected the number of a yarn"),
        (["300=navy"], "colour: got yarn 300; expected 0 to 255"),
        (["1=navy", "1=red"], "colour: got yarn 1 twice; expected each yarn once"),
        (["1=rde"], "colour: got 'rde'; expected #rrggbb or a name such as navy or cream; did you mean 'red'?"),
    ],
)
def test_what_is_no_colour_of_a_yarn_is_refused(texts, message):
    with pytest.raises(ParameterError) as error:
        parse_yarn_colours(texts)
    assert str(error.value).startswith(message)


def test_linear_light_and_back():
    values = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(srgb_colour(linear_colour(values)), values, atol=1e-6)  # 0.0031308 is rounded
