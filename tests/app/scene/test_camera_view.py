# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The camera of the server agrees with itself and with plain geometry."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from stitchmesh.app.scene.scene import CameraView, ScreenBox

STRAIGHT = CameraView(np.array([0.0, 0.0, -10.0]), np.array([1.0, 0.0, 0.0, 0.0]), np.radians(90.0), 2.0)
"""Looks along z from a distance of 10, with y down; half the height of what it sees there is 10, half the width 20."""


def tilted():
    x, y, z, w = Rotation.from_euler("xyz", [0.3, -1.1, 2.0]).as_quat()
    return CameraView(np.array([3.0, -2.0, 5.0]), np.array([w, x, y, z]), np.radians(35.0), 1.4)


def test_points_of_the_plane_before_the_camera_lie_where_similar_triangles_put_them():
    points = np.array([[0.0, 0.0, 0.0], [20.0, 10.0, 0.0], [-20.0, -10.0, 0.0], [10.0, -5.0, 0.0]])
    expected = np.array([[0.5, 0.5], [1.0, 1.0], [0.0, 0.0], [0.75, 0.25]])
    np.testing.assert_allclose(STRAIGHT.on_screen(points), expected, atol=1e-12)  # rounding of a few operations


def test_every_point_of_a_ray_is_seen_where_the_ray_begins():
    camera = tilted()
    for x, y in [(0.1, 0.2), (0.5, 0.5), (0.93, 0.61)]:
        origin, direction = camera.ray(x, y)
        points = origin + np.array([[0.5], [7.0], [300.0]]) * direction
        np.testing.assert_allclose(camera.on_screen(points), [[x, y]] * 3, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(direction), 1.0, atol=1e-12)


def test_a_box_on_the_screen_holds_what_is_seen_in_it_and_nothing_behind_the_camera():
    box = ScreenBox(STRAIGHT, (0.4, 0.4), (0.8, 0.6))
    points = np.array([[0.0, 0.0, 0.0], [11.0, 0.0, 0.0], [13.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, -20.0]])
    assert box.inside(points).tolist() == [True, True, False, False, False]
