# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The contact force on each segment: the sum over pairs of samples, equal on both sides, none where nothing touches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.mesh import Mesh
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.evaluate import body_distance, contact_load

MATERIAL = YarnMaterial.named()


def crossing(height: float, samples: int = 1) -> YarnSet:
    """Two straight yarns of radius 0.1 at right angles, the second ``height`` above the first."""
    along = np.linspace(-0.5, 0.5, 9)
    zeros = np.zeros(9)
    first, second = np.stack([along, zeros, zeros], 1), np.stack([zeros, along, zeros + height], 1)
    return YarnSet.from_curves([first, second], closed=[False] * 2, radius=0.1)


def test_the_load_is_the_sum_over_pairs_of_samples():
    yarns = crossing(0.16)
    middle = yarns.points[yarns.segment_points[:, 1:3]].mean(axis=1).reshape(2, 6, 3)  # the one sample of a segment
    length = yarns.rest_length[0]
    apart = np.linalg.norm(middle[0][:, None] - middle[1][None], axis=2)
    weight = MATERIAL.k_contact * length * length
    force = np.where(apart < 0.2, 2 * weight * (0.2**4 / apart**4 - 1) / 0.2**2 * apart, 0.0)
    load = contact_load(yarns, MATERIAL, contact_samples=1).reshape(2, 6)
    np.testing.assert_allclose(load[0], force.sum(axis=1) / length, rtol=1e-9)  # rounding of units on the device
    np.testing.assert_allclose(load[1], force.sum(axis=0) / length, rtol=1e-9)


def test_yarns_that_do_not_touch_have_no_load():
    assert (contact_load(crossing(0.21), MATERIAL) == 0.0).all()


def floor(size: float = 5.0) -> Mesh:
    corners = np.array([[-size, 0, -size], [-size, 0, size], [size, 0, size], [size, 0, -size]])
    return Mesh.from_polygons(corners, [[0, 1, 2, 3]])


def test_distance_from_a_floor_is_the_height_less_the_radius():
    yarns = crossing(0.5)
    standing = replace(yarns, points=yarns.points[:, [0, 2, 1]] + [0.0, 1.0, 0.0])
    heights = np.repeat([1.0, 1.5], 6) - 0.1
    # the search works in single precision, the distance from the found face in double precision
    np.testing.assert_allclose(body_distance(standing, floor()), heights, rtol=1e-9)


def test_yarn_below_the_floor_has_a_negative_distance():
    yarns = replace(crossing(0.5), points=crossing(0.5).points[:, [0, 2, 1]] - [0.0, 2.0, 0.0])
    np.testing.assert_allclose(body_distance(yarns, floor()), np.repeat([-2.0, -1.5], 6) - 0.1, rtol=1e-9)
