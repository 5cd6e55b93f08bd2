# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The light of pictures: shading, shadows and hollows, the ground, and the scale bar."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from stitchmesh.mixed.scene.simple_bodies import ball
from stitchmesh.render import PictureOptions, render, render_mesh, render_yarns
from stitchmesh.render.camera import VIEW_ANGLE, camera_around, camera_at
from stitchmesh.render.ground import Rays, ground_of
from stitchmesh.render.lettering import INK, PLATE, draw_scale_bar, scale_length
from stitchmesh.render.light import FILL, KEY, TO_CAMERA, Relief, ground_light, key_seen, sky_seen, surface_light
from stitchmesh.render.picture import layout_for
from stitchmesh.render.view import view_directions
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.yarn_look import YarnLook
from tests.render.test_camera import cloud, in_picture
from tests.render.test_pictures import pixels, rings

ALL = np.ones((1, 1), dtype=np.float32)
"""A pixel that sees all of a light."""
FLAT = PictureOptions(size=(240, 240), inset=False, scale_bar=False)


def light_on(normal: np.ndarray, sheen: float = 0.0) -> float:
    """The light on a surface with a normal in the picture, which sees all lights."""
    facing = np.round(255 * np.maximum(np.stack([KEY, TO_CAMERA, FILL]) @ normal, 0.0)).astype(np.uint8)
    return float(surface_light(facing.reshape(1, 1, 3), ALL, ALL, sheen)[0, 0])


def ridge(width: int = 9, size: int = 80) -> Relief:
    """A half cylinder from the top to the bottom of the picture, on level ground."""
    across = np.arange(size) - (size - 1) / 2
    profile = np.sqrt(np.maximum((width / 2) ** 2 - across**2, 0.0))
    return Relief(np.tile(profile.astype(np.float32), (size, 1)), 8.0)


def straight_yarn(direction: list[float]) -> YarnSet:
    return YarnSet.from_curves([np.outer(np.linspace(-6.0, 6.0, 30), direction)], closed=[False], radius=0.5)


def test_surfaces_are_lighter_the_more_they_face_the_key_light():
    turned = [light_on(np.cos(angle) * KEY + np.sin(angle) * across) for across in (np.cross(KEY, FILL),)
              for angle in np.radians([0.0, 30.0, 60.0, 90.0])]  # fmt: skip
    assert all(more > less for more, less in pairwise(turned))
    brightest = max(light_on(normal) for normal in (KEY, TO_CAMERA, FILL))
    assert 0.94 * brightest < 1.0  # white yarn reflects 0.94 of the light, and is not clipped


def test_a_surface_shines_midway_between_the_key_light_and_the_camera():
    midway = (KEY + TO_CAMERA) / np.linalg.norm(KEY + TO_CAMERA)
    shine = [light_on(normal, 1.0) - light_on(normal) for normal in (midway, KEY, np.cross(KEY, TO_CAMERA))]
    assert shine[0] > 3.0 * shine[1] > 0.0 and shine[2] == 0.0
    assert light_on(midway, 0.2) < light_on(midway, 1.0)


@pytest.mark.usefixtures("display")
def test_fibres_hide_no_light_from_what_they_stand_over(tmp_path):
    """Of two pictures of one yarn, the one with hair differs only where hair is, and the yarn is nowhere darker."""
    yarn, pictures = straight_yarn([1.0, 0.0, 0.0]), []
    for name, density in (("smooth.png", 0.0), ("hairy.png", 2.0)):
        look = YarnLook("monofilament", sheen=0.1, hair_length=1.0, hair_density=density)
        render_yarns(yarn, tmp_path / name, replace(FLAT, look=look))
        pictures.append(pixels(tmp_path / name)[..., :3].astype(int))
    change = pictures[1] - pictures[0]
    differs = (change != 0).any(axis=2)
    assert 0.0 < differs.mean() < 0.1  # thin lines
    assert change[114:126].max() > 0 and change[114:126].min() >= -1  # rows on the yarn; the rounding of a level


def test_level_ground_sees_all_light():
    relief = Relief(np.full((40, 60), 3.0, dtype=np.float32), 5.0)
    np.testing.assert_array_equal(key_seen(relief), 1.0)
    np.testing.assert_array_equal(sky_seen(relief), 1.0)


def test_the_shadow_lies_on_the_side_away_from_the_key_light():
    """The key light is at the left, so the ground at the right of a ridge is darker than at its left."""
    row = key_seen(ridge())[40]
    left, right = row[30:35], row[45:50]  # the ridge covers columns 35 to 44
    assert right[0] < 0.6 < 0.9 < right[-1]
    assert (left >= right[::-1]).all() and left.min() > 0.9


def test_hollows_see_less_of_the_sky_on_both_sides_alike():
    row = sky_seen(ridge())[40]
    # Directions and distances are whole pixels on both sides, so that only the order of sums differs.
    np.testing.assert_allclose(row, row[::-1], atol=1e-5)
    assert row[34] < row[30] < row[20] <= 1.0
    assert row[39] > 0.99  # the top of the ridge is hidden by nothing
    assert ground_light(0 * ALL, 0 * ALL)[0, 0] > 0.2  # ground below a hole is not black


def test_rays_meet_the_floor_of_the_object_and_a_wall_behind_it():
    points = cloud(30, 60, 20)
    for view, height in (((20.0, 25.0), points[:, 1].min()), ((0.0, 0.0), None)):
        towards, up = view_directions(points, view)
        camera = camera_around(points, towards, up, 1.0)
        assert camera.floor == height
        half = np.tan(np.radians(VIEW_ANGLE / 2)) * np.linspace(-1, 1, 9)
        rays, ground = Rays(camera, half, half[::-1]), ground_of(camera, 250.0)
        met = rays.points(ground.distance(rays))[-1]  # the lowest row of the picture
        # Distances are in float32, and about 200 cm long.
        np.testing.assert_allclose((met - ground.origin) @ ground.normal, 0.0, atol=1e-4)


@pytest.mark.usefixtures("display")
def test_a_ball_is_lightest_towards_the_key_light(tmp_path):
    render_mesh(ball(3.0, (0.0, 0.0, 0.0)), tmp_path / "ball.png", FLAT)
    grey = pixels(tmp_path / "ball.png").sum(axis=2)
    upper_left, middle, lower_right = (grey[120 + step - 4 : 120 + step + 4, 120 + step - 4 : 120 + step + 4].mean()
                                       for step in (-45, 0, 60))  # fmt: skip
    assert upper_left > middle > lower_right


@pytest.mark.usefixtures("display")
def test_a_yarn_throws_its_shadow_on_the_ground_and_has_no_dots(tmp_path):
    """A yarn from top to bottom is the same in all rows but for its ends; the key light is at the upper left."""
    options = replace(FLAT, background="#c0c0c0", colour="red", look="monofilament")
    render_yarns(straight_yarn([0.0, 1.0, 0.0]), tmp_path / "a.png", options)
    image = pixels(tmp_path / "a.png")
    red = np.flatnonzero(np.ptp(image[120], axis=1) > 5)
    left, right = red[0], red[-1]
    grey = image.sum(axis=2)[90:150]
    assert grey[:, right + 2 : right + 6].mean() < grey[:, left - 6 : left - 2].mean() <= grey[:, :20].mean()
    # A level for the rounding of each pixel, and one for the perspective.
    assert np.ptp(image[110:130, left + 3 : right - 3], axis=0).max() <= 2


@pytest.mark.usefixtures("display")
def test_no_yarn_burns_out_or_drowns(tmp_path):
    drawn = {}
    for colour in ("white", "black"):
        options = PictureOptions(size=(320, 200), inset=False, background="red", scale_bar=False, colour=colour)
        render_yarns(rings(), tmp_path / f"{colour}.png", options)
        image = pixels(tmp_path / f"{colour}.png")
        drawn[colour] = image[(image.max(axis=2) - image.min(axis=2)) < 20]  # grey pixels are yarn
    assert (drawn["white"] == 255).mean() < 0.005
    assert 15 < np.median(drawn["black"]) < np.median(drawn["white"]) / 3
    assert np.ptp(drawn["black"]) > 15  # its folds are seen


def test_a_wide_garment_fills_the_picture_beside_its_close_up():
    """The box around a sweater of 116 by 64 cm is at least 60 % as high as a picture of 8 by 5."""
    points = cloud(116, 64, 26)
    towards, up = view_directions(points)
    layout = layout_for(points, towards, up, 0.2, 1.6)
    place = in_picture(camera_around(points, towards, up, 1.6, part=layout.part), points, 1.6)
    assert np.ptp(place[:, 1]) / 2 > 0.6
    assert np.ptp(place[:, 0]) / 2 < layout.part[0]


def test_the_length_of_a_scale_bar_is_round():
    for width, in_centimetre, length in ((400, 40, 2.0), (400, 79, 1.0), (1000, 2, 100.0), (50, 50, 0.2)):
        assert scale_length(width, in_centimetre) == pytest.approx(length)
        assert 0.08 * width <= length * in_centimetre <= 0.2 * width  # a step of 2.5 leaves two fifths of a fifth


def test_a_scale_bar_is_as_long_as_it_says():
    image = Image.new("RGB", (400, 300), "white")
    draw_scale_bar(image, (0.0, 0.0), 400.0, 40.0)
    ink = (np.asarray(image) == tuple(bytes.fromhex(INK[1:]))).all(axis=2)
    assert abs(ink.sum(axis=1).max() - 80) <= 1  # 2 cm of 40 pixels; both ends are drawn
    assert (np.asarray(image) == tuple(bytes.fromhex(PLATE[1:]))).all(axis=2).any()


@pytest.mark.usefixtures("display")
def test_a_picture_has_a_scale_bar_of_its_camera_unless_it_is_left_out(tmp_path):
    options = PictureOptions(size=(480, 300), inset=False, background="white")
    render_yarns(rings(), tmp_path / "bar.png", options)
    render_yarns(rings(), tmp_path / "none.png", replace(options, scale_bar=False))
    changed = (pixels(tmp_path / "bar.png") != pixels(tmp_path / "none.png")).any(axis=2)
    rows, columns = np.nonzero(changed)
    assert rows.min() > 240 and columns.max() < 160  # it is in the lower left corner
    camera = camera_at(np.zeros(3), TO_CAMERA, np.array([0.0, 1.0, 0.0]), 6.0)
    assert 2 * np.tan(np.radians(VIEW_ANGLE / 2)) * camera.position[2] == pytest.approx(6.0)


@pytest.mark.usefixtures("display")
def test_pictures_of_few_pixels_are_drawn(tmp_path):
    for size in ((1, 1), (1, 90), (200, 3)):
        render_yarns(rings(), tmp_path / "a.png", PictureOptions(size=size))
        assert Image.open(tmp_path / "a.png").size == size


@pytest.mark.usefixtures("display")
def test_the_same_scene_gives_the_same_light(tmp_path):
    drawn = []
    for name in ("a.png", "b.png"):
        render(rings(), tmp_path / name, size=(320, 200))
        drawn.append(Path(tmp_path / name).read_bytes())
    assert drawn[0] == drawn[1]
