# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Views, close-ups, colours, bodies and strands of pictures; what is not possible is refused in one line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.palette import make_palette, parse_colour
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.render import render
from stitchmesh.render.camera import camera_around
from stitchmesh.render.close_up import CloseUpPoints, close_up_patch, outward_normal, place_of
from stitchmesh.render.colouring import blend_colours, colour_yarns
from stitchmesh.render.palette import stitch_colour
from stitchmesh.render.view import VIEWS, view_directions
from tests.gallery import tube
from tests.render.test_pictures import SIZE, fabric, rings
from tests.yarnrelax.stockinette import woven_cell


def pixels(path) -> np.ndarray:
    return np.asarray(Image.open(path)).astype(int)


def box() -> np.ndarray:
    return (np.random.default_rng(1).random((400, 3)) - 0.5) * [30, 60, 20]


def test_named_views_look_along_the_axes():
    """Front and back differ by half a turn about the vertical, and so do left and right; top looks straight down."""
    directions = {view: view_directions(box(), view)[0] for view in VIEWS}
    half_turn = np.array([-1.0, 1.0, -1.0])
    np.testing.assert_allclose(directions["back"], half_turn * directions["front"], atol=1e-12)
    np.testing.assert_allclose(directions["left"], half_turn * directions["right"], atol=1e-12)
    np.testing.assert_allclose(directions["top"], [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(directions["bottom"], [0, -1, 0], atol=1e-12)
    assert directions["right"][0] > 0.9  # the picture of the front has x to the right
    towards, up = view_directions(box(), "top")
    assert up @ [0, 0, 1] < -0.9  # the front is at the lower border of a view from the top
    np.testing.assert_allclose(view_directions(box(), (30.0, 0.0))[0], [0.5, 0, np.sqrt(0.75)], atol=1e-12)
    np.testing.assert_array_equal(view_directions(box(), "30,0")[0], view_directions(box(), (30.0, 0.0))[0])
    assert towards @ up == pytest.approx(0.0, abs=1e-12)
    flat = box() * [1, 1, 1e-3]
    np.testing.assert_allclose(view_directions(flat, "back")[0], [0, 0, -1], atol=1e-12)  # It is seen straight.


def tube_surface() -> CloseUpPoints:
    """A tube around y of radius 5 with 40 points in each of 20 rows; a point is a face."""
    row, place = (index.ravel() for index in np.indices((20, 40)))
    angle = 2 * np.pi * place / 40
    points = np.stack([5 * np.sin(angle), row - 9.5, 5 * np.cos(angle)], axis=1)
    return CloseUpPoints(points, np.arange(800), row)


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ("face 410", 410), (410, 410), ([410], 410), ("row 12", 12 * 40), ("point 5 0.5 0.1", 410),
        ("share 0.5 0.5", 400),
    ],
)  # fmt: skip
def test_a_close_up_finds_its_place_and_looks_at_it_from_outside(place, expected):
    """A row of a tube is seen where it is nearest to the camera; the middle of the picture shows the middle row."""
    surface = tube_surface()
    whole = camera_around(surface.points, np.array([0, 0, 1.0]), np.array([0, 1.0, 0]), 1.6)
    middle, patch = close_up_patch(surface, place_of(place), whole, 1.6, 8.0)
    near = np.linalg.norm(surface.points[middle] - surface.points[expected])
    assert near <= 1.0 + 1e-9  # at most one row or one place beside it
    outward = surface.points[middle] * [0.2, 0, 0.2]
    normal = outward_normal(surface.points, patch, np.array([0, 0, -1.0]))
    assert normal @ outward > 0.97  # the patch is a cap of 2 cm of a tube of 5 cm, so its normal is that of the middle


@pytest.mark.parametrize("text", ["face 1e400", "face 1.5", "point 0 0 inf"])
def test_places_that_are_no_numbers_are_refused(text):
    with pytest.raises(ParameterError, match="close-up: got"):
        place_of(text)


def test_pictures_differ_by_view_colour_place_and_strands(display, tmp_path):
    yarns = replace(rings(), palette=make_palette(["navy"]))
    choices = {
        "front": {}, "left": {"view": "left"}, "row": {"colour": "row"}, "red": {"colour": "red"},
        "mohair": {"look": "mohair"}, "close": {"close_up": "row 4"}, "ground": {"background": "#203040"},
        "flat": {"occlusion": False}, "body": {"body": tube(12, 5)},
    }  # fmt: skip
    drawn = {}
    for name, options in choices.items():
        render(yarns, tmp_path / f"{name}.png", size=(160, 100), inset=False, **options)
        drawn[name] = pixels(tmp_path / f"{name}.png")
        assert drawn[name].shape == (100, 160, 3)
    names = list(choices)
    for index, first in enumerate(names):
        for second in names[index + 1 :]:
            changed = (np.abs(drawn[first] - drawn[second]).max(axis=2) > 8).mean()
            assert changed > 0.01, (first, second)  # a hundredth of the picture looks different
    assert drawn["ground"][0, 0].tolist() == [0x20, 0x30, 0x40]
    blue = drawn["front"][..., 2] - drawn["front"][..., 0]
    red = drawn["red"][..., 0] - drawn["red"][..., 2]
    assert blue.max() > 60 and red.max() > 150  # navy and red yarn
    rows = drawn["row"][..., 0] - drawn["row"][..., 2]
    assert rows.max() > 50 and rows.min() < -10  # The colours change from madder (red) to heather (blue).


def test_a_transparent_background_lets_the_page_show_through(display, tmp_path):
    render(rings(), tmp_path / "a.png", size=SIZE, background="transparent", inset=False)
    image = Image.open(tmp_path / "a.png")
    assert image.mode == "RGBA"
    opacity = np.asarray(image)[..., 3]
    assert opacity[0, 0] == 0 and opacity.max() == 255


def test_a_chart_in_red_and_green_is_drawn_in_red_and_green(display, tmp_path):
    cell = replace(woven_cell(), palette=make_palette(["red", "green"]))
    cell = replace(cell, colour=np.arange(cell.yarn_count) % 2)
    render(cell, tmp_path / "a.png", tiles=(2, 2), size=(200, 200), background="black", scale_bar=False)
    red, green, blue = np.moveaxis(pixels(tmp_path / "a.png"), 2, 0)
    assert ((red > 100) & (green < 60)).mean() > 0.1 and ((green > 50) & (red < 40)).mean() > 0.1
    assert blue.max() < 60  # neither colour has any blue, but yarn reflects 3 % of all light, which is 49 in sRGB


def test_yarns_have_the_colours_of_their_palette_rows_stitches_or_one():
    yarns = replace(rings(), palette=make_palette(["navy"]), face=np.repeat(np.arange(9), 30))
    codes = np.resize([Stitch.KNIT, Stitch.PURL], 60)
    assert (colour_yarns(yarns, "yarn").points == parse_colour("navy")).all()
    assert (colour_yarns(yarns, "#010203").points == [1, 2, 3]).all()
    stitched = colour_yarns(yarns, "stitch", fabric=fabric())
    expected = np.array([stitch_colour(code) for code in codes[yarns.face]])
    assert (np.abs(stitched.points - expected) <= 1).all()  # rounding from linear light and back
    assert [name for name, _ in stitched.key] == ["knit", "purl"]
    none = colour_yarns(yarns, "stitch", fabric=fabric(), blend=0.0).points
    assert (none == parse_colour("navy")).all()
    # Half of black and white has half of the light: 0.5^(1/2.4) 1.055 - 0.055 = 0.735 in sRGB.
    black, white = np.zeros((1, 3), np.uint8), np.full((1, 3), 255, np.uint8)
    assert blend_colours(black, white, 0.5).tolist() == [[188, 188, 188]]


def test_strain_is_shown_around_zero():
    yarns = rings()
    stretched = replace(yarns, rest_length=yarns.lengths / np.where(yarns.segment_yarn == 4, 1.1, 1.0))
    coloured = colour_yarns(stretched, "strain")
    assert [name for name, _ in coloured.key][::4] == ["+10.0 % strain", "-10.0 % strain"]
    red = coloured.points[stretched.point_yarn == 4].astype(int)
    assert (red[:, 0] > red[:, 2] + 100).all()
    assert np.ptp(coloured.points[stretched.point_yarn != 4].astype(int)) < 20  # the pale middle of the scale


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"view": "frnt"}, "view: got 'frnt'; expected front, back, left, right, top, bottom, or azimuth,elevation"),
        ({"view": "nan,3"}, "view: got an azimuth of nan degrees; expected a finite number"),
        ({"view": "10,95"}, "view: got an elevation of 95 degrees; expected -90 to 90"),
        ({"view": (1, 2, 3)}, "view: got"),
        ({"close_up": "face 5000"}, "close-up: there is no face 5000; the object has faces 0 to 8"),
        ({"close_up": "row 12"}, "close-up: there is no row 12; the object has rows 0 to 8"),
        ({"close_up": "sleeve 3"}, "close-up: got 'sleeve 3'; expected face 120, row 12"),
        ({"close_up": "share 2 0"}, "close-up: got 'share 2 0'; expected shares of the picture from 0 to 1"),
        ({"close_up": "share 0 0"}, "close-up: there is nothing at share 0 0 of the picture"),
        ({"close_up": []}, "close-up: got []; expected"),
        ({"extent": 3.0}, "extent: got the width of a close-up without a close-up"),
        ({"close_up": "row 1", "extent": -1.0}, "extent: got -1 cm; expected a positive number"),
        ({"size": (0, 100)}, "size: got 0 x 100; expected width and height from 1"),
        ({"colour": "bleu"}, "colour: got 'bleu'; expected #rrggbb or a name such as navy or cream; did you mean"),
        ({"colour": "stitch"}, "colour: got 'stitch' for yarns without their stitch mesh; give the stitch mesh too"),
        ({"blend": 2.0}, "blend: got 2; expected 0 to 1"),
        ({"background": "glass"}, "background: colour: got 'glass'"),
        ({"look": "mohar"}, "look: got 'mohar'; expected mohair"),
        ({"colur": "red"}, "render: got 'colur'; expected colour"),
    ],
)
def test_impossible_pictures_are_refused_in_one_line(tmp_path, options, message):
    yarns = replace(rings(), face=np.repeat(np.arange(9), 30))
    with pytest.raises(ParameterError) as error:
        render(yarns, tmp_path / "a.png", **options)
    assert str(error.value).startswith(message) and "\n" not in str(error.value)
    assert not (tmp_path / "a.png").exists()


def test_options_that_a_mesh_does_not_have_are_refused(tmp_path):
    for thing, options, message in (
        (fabric(), {"look": "wool"}, "look: got a look for a mesh"),
        (fabric(), {"tiles": (2, 2)}, "tiles: got tiles of a mesh"),
        ("hat.obj", {}, "render: got a str; expected a mesh, yarns or a swatch"),
    ):
        with pytest.raises(ParameterError, match=message):
            render(thing, tmp_path / "a.png", **options)
