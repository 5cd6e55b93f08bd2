# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Layers of stitches that lie on each other are moved apart."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh import Mesh
from stitchmesh.shaping.panels.shape_panels import THICKNESS, opened_folds

WIDTH = 1.0


def layers(height: float, *, facing: bool) -> Mesh:
    """Two flat grids of 6 x 6 cm, back to back or face to face, at some distance."""
    x, y = np.meshgrid(np.arange(7.0), np.arange(7.0))
    grid = np.stack([x.ravel(), y.ravel(), np.zeros(49)], axis=1)
    quads = [[7 * j + i, 7 * j + i + 1, 7 * j + i + 8, 7 * j + i + 7] for j in range(6) for i in range(6)]
    lower, upper = (quads, [quad[::-1] for quad in quads])[:: 1 if facing else -1]
    points = np.concatenate([grid, grid + np.array([0.0, 0.0, height])])
    return Mesh.from_polygons(points, [*lower, *([v + 49 for v in quad] for quad in upper)])


@pytest.mark.parametrize("facing", [True, False])
def test_layers_are_as_far_apart_as_a_fabric_is_thick(facing):
    mesh = layers(0.2, facing=facing)
    points = opened_folds(mesh, WIDTH)
    # Each layer moves by half of what is missing, straight along its normal.
    assert np.allclose(points[49:, 2] - points[:49, 2], THICKNESS * WIDTH, rtol=0.0, atol=1e-9)
    assert np.allclose(points[:, :2], mesh.vertices[:, :2])


def test_layers_in_one_place_are_opened_outside_out():
    mesh = layers(0.0, facing=False)
    points = opened_folds(mesh, WIDTH)
    normal = mesh.face_vector_area[[0, 36], 2]
    motion = points[[24, 73], 2]  # the middle of each layer
    assert (motion * normal > 0.0).all() and np.isclose(abs(motion[1] - motion[0]), THICKNESS * WIDTH)


def test_layers_with_room_stay_where_they_are():
    mesh = layers(THICKNESS * WIDTH, facing=False)
    assert np.allclose(opened_folds(mesh, WIDTH), mesh.vertices, rtol=0.0, atol=1e-12)
