# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Motions by keyframes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.vertex_motion import VertexMotion
from stitchmesh.mixed.contact.motion import RigidMotion

QUARTER = Rotation.from_rotvec([0.0, 0.0, np.pi / 2]).as_matrix()


def test_a_rigid_motion_passes_its_keyframes_and_turns_evenly():
    motion = RigidMotion(
        np.array([1.0, 2.0]), np.array([[0, 0, 0], [0, 0, 2]]), np.stack([np.eye(3), QUARTER]), np.array([1.0, 0, 0])
    )
    points = np.array([[2.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert motion.places_at(points, 0.0) == pytest.approx(points)
    assert motion.places_at(points, 9.0) == pytest.approx(np.array([[1.0, 1.0, 2.0], [1.0, 0.0, 2.0]]))
    half = np.sqrt(0.5)
    assert motion.places_at(points, 1.5) == pytest.approx(np.array([[1.0 + half, half, 1.0], [1.0, 0.0, 1.0]]))


def test_a_rigid_motion_keeps_distances():
    motion = RigidMotion(np.array([0.0, 1.0]), np.zeros((2, 3)), np.stack([np.eye(3), QUARTER]))
    points = np.random.default_rng(0).normal(size=(10, 3))
    moved = motion.places_at(points, 0.3)
    assert np.linalg.norm(np.diff(moved, axis=0), axis=1) == pytest.approx(
        np.linalg.norm(np.diff(points, axis=0), axis=1)
    )


def test_vertices_move_on_straight_lines():
    motion = VertexMotion(np.array([0.0, 1.0, 3.0]), np.array([[[0, 0, 0]], [[1, 0, 0]], [[1, 4, 0]]]))
    expected = {-1.0: [0, 0, 0], 0.5: [0.5, 0, 0], 1.0: [1, 0, 0], 2.0: [1, 2, 0], 9.0: [1, 4, 0]}
    for time, place in expected.items():
        assert motion.vertices_at(time)[0] == pytest.approx(place)
    assert VertexMotion(np.zeros(1), np.ones((1, 2, 3))).vertices_at(5.0) == pytest.approx(np.ones((2, 3)))


@pytest.mark.parametrize(
    ("times", "displacement", "rotation", "message"),
    [
        ([0, 0], np.zeros((2, 3)), None, "motion: keyframe 1: got 0 s after 0 s; expected times that increase"),
        ([0, 1], np.zeros((1, 3)), None, r"motion: displacement: got shape \(1, 3\); expected \(2, 3\)"),
        ([0], np.full((1, 3), np.nan), None, "motion: displacement: got numbers that are not finite"),
        ([0], np.zeros((1, 3)), [np.diag([1, 1, -1])], "motion: keyframe 0: got a matrix that is not a rotation"),
        ([], np.zeros((0, 3)), None, "motion: got no keyframe"),
    ],
)
def test_refuses(times, displacement, rotation, message):
    with pytest.raises(ParameterError, match=message):
        RigidMotion(np.array(times, dtype=float), displacement, None if rotation is None else np.array(rotation))
    with pytest.raises(ParameterError, match="times that increase"):
        VertexMotion(np.array([1.0, 0.0]), np.zeros((2, 4, 3)))
