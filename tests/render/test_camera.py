# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cameras and layouts show the whole object, from its front and in its part of the picture."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.render.camera import VIEW_ANGLE, Camera, camera_around, camera_at, front_patch
from stitchmesh.render.picture import ALONE, BELOW, beside, layout_for
from stitchmesh.render.view import view_directions


def cloud(*size: float) -> np.ndarray:
    return (np.random.default_rng(1).random((500, 3)) - 0.5) * size + [3, -7, 20]


def in_picture(camera: Camera, points: np.ndarray, aspect: float) -> np.ndarray:
    """Picture coordinates, -1 to 1 inside the picture, shape (n, 2)."""
    depth = (camera.focus - camera.position) / np.linalg.norm(camera.focus - camera.position)
    offset = points - camera.position
    reach = np.tan(np.radians(VIEW_ANGLE / 2)) * (offset @ depth)
    return np.stack([offset @ camera.side / (reach * aspect), offset @ camera.up / reach], axis=1)


@pytest.mark.parametrize(("size", "aspect"), [((30, 60, 20), 0.5), ((100, 1, 1), 1.6), ((5, 5, 0.01), 1.6)])
def test_all_points_are_inside_the_picture_and_fill_it(size, aspect):
    points = cloud(*size)
    towards, up = view_directions(points)
    place = np.abs(in_picture(camera_around(points, towards, up, aspect), points, aspect))
    assert place.max() <= 1.0
    assert place.max() > 0.9  # The margin is 6 %.


def test_points_with_their_clearance_stay_in_their_part_of_the_picture():
    points = cloud(30, 60, 20)
    towards, up = view_directions(points)
    camera = camera_around(points, towards, up, 1.6, part=(0.3, 0.5), clearance=5.0)
    for step in 5.0 * np.concatenate([np.eye(3), -np.eye(3)]) @ np.stack([camera.side, camera.up, [0, 0, 0]]):
        place = np.abs(in_picture(camera, points + step, 1.6))
        assert (place.max(axis=0) <= [0.3, 0.5]).all()


def test_wide_objects_have_their_close_up_below_and_small_objects_have_none():
    towards, up = np.array([0, 0, 1.0]), np.array([0, 1.0, 0])
    assert layout_for(cloud(50, 60, 20), towards, up, 0.1, 1.6) == beside(0.61)
    assert layout_for(cloud(90, 20, 1), towards, up, 0.1, 1.6) is BELOW
    assert layout_for(cloud(3, 4, 1), towards, up, 0.1, 1.6) is ALONE


def test_a_garment_is_shown_upright_and_from_its_wide_side():
    towards, up = view_directions(cloud(50, 60, 20))
    assert towards[2] > 0.9 and towards[1] > 0
    assert up.tolist() == [0, 1, 0]
    assert view_directions(cloud(20, 60, 50))[0][0] > 0.9


def test_a_flat_swatch_is_shown_perpendicular_to_its_plane():
    towards, up = view_directions(cloud(30, 0.5, 20))
    np.testing.assert_array_equal(towards, [0, 1, 0])
    np.testing.assert_array_equal(up, [0, 0, -1])


def test_the_patch_lies_on_the_front_of_a_cylinder():
    turn, height = np.random.default_rng(2).random((2, 20_000)) * [[2 * np.pi], [40.0]]
    points = np.stack([10 * np.sin(turn), height, 10 * np.cos(turn)], axis=1)
    middle, normal = front_patch(points, np.array([0, 0, 1.0]), np.array([0, 1.0, 0]), 4.0)
    # The sagitta of a patch of half width 2 on radius 10 is at most 0.2, and random points shift the centre.
    np.testing.assert_allclose(middle, [0, 20, 10], atol=0.4)
    np.testing.assert_allclose(normal, [0, 0, 1], atol=0.05)


def test_a_camera_at_a_place_shows_the_requested_height():
    camera = camera_at(np.array([1.0, 2, 3]), np.array([1.0, 1, 0]), np.array([0, 1.0, 0]), 6.0)
    edge = camera.focus + 3.0 * camera.up
    np.testing.assert_allclose(in_picture(camera, np.array([edge, camera.focus]), 1.0), [[0, 1], [0, 0]], atol=1e-12)
