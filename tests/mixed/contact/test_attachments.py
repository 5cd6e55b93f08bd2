# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Motions by keyframes, attachments that hold vertices and nodes, and the motion that they prescribe."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.vertex_motion import VertexMotion
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.contact.motion import Attachment, PrescribedMotion, RigidMotion, at_simulated_nodes
from tests.mixed.contact.sheets import sheet

QUARTER = Rotation.from_rotvec([0.0, 0.0, np.pi / 2]).as_matrix()


def square() -> tuple[Cloth, np.ndarray]:
    """A cloth of 4 x 4 squares with sides of 1 cm, and the place of a node at the middle of each triangle."""
    flat = sheet(4, 4.0)
    cloth = Cloth(
        vertices=flat.vertices, triangles=flat.triangles, rest=flat.rest, panel=flat.panel, panel_names=("front",)
    )
    middle = flat.rest.mean(axis=1)
    return cloth, np.column_stack([middle, np.zeros(len(middle))])


def test_prescribed_motion_is_that_of_the_keyframes_and_steps_add_up():
    cloth, place = square()
    turn = RigidMotion(np.array([0.0, 1.0]), np.array([[0.0] * 3, [1.0, 0, 0]]), np.stack([np.eye(3), QUARTER]))
    chosen = [np.flatnonzero(places[:, 0] <= -1.0) for places in (cloth.vertices, place)]
    held = Attachment(*chosen, turn)
    motion = PrescribedMotion([held], cloth.vertices, place)
    assert motion.fixed_vertices.tolist() == chosen[0].tolist() and motion.fixed_nodes.tolist() == chosen[1].tolist()
    v, p, s = motion.positions(1.0)
    assert v[chosen[0]] == pytest.approx(cloth.vertices[chosen[0]] @ QUARTER.T + [1.0, 0.0, 0.0])
    free = np.setdiff1d(np.arange(25), chosen[0])
    assert (v[free] == cloth.vertices[free]).all() and not s.any()
    times = np.sort(np.random.default_rng(0).random(20))
    total = sum(motion.displacements(a, b)[1] for a, b in zip([0.0, *times], [*times, 1.0], strict=True))
    assert place + total == pytest.approx(p)
    velocity = motion.velocities(0.2, 0.3)[0]
    assert velocity * 0.1 == pytest.approx(motion.displacements(0.2, 0.3)[0])


def test_nodes_that_are_not_simulated_are_left_out():
    number = np.array([-1, 0, -1, 1])
    both, only = Attachment(np.array([7]), np.array([0, 1, 3])), Attachment(nodes=np.array([0, 2]))
    (kept,) = at_simulated_nodes([both, only], number)
    assert kept.vertices.tolist() == [7] and kept.nodes.tolist() == [0, 1]


def test_refuses():
    cloth, place = square()
    with pytest.raises(ParameterError, match=r"^attachment: got no vertex and no node; expected some"):
        Attachment()
    with pytest.raises(ParameterError, match="distinct numbers"):
        Attachment(np.array([1, 1]))
    with pytest.raises(ParameterError, match=r"pin: got vertex 3, which hook holds; expected each in one attachment"):
        held = [Attachment(np.array([3]), name="hook"), Attachment(np.array([2, 3]), name="pin")]
        PrescribedMotion(held, cloth.vertices, place)
    with pytest.raises(ParameterError, match="got node 99; expected 0 to 31"):
        PrescribedMotion([Attachment(nodes=np.array([99]))], cloth.vertices, place)


def test_a_rigid_motion_passes_its_keyframes_and_turns_evenly():
    motion = RigidMotion(
        np.array([1.0, 2.0]), np.array([[0, 0, 0], [0, 0, 2]]), np.stack([np.eye(3), QUARTER]), np.array([1.0, 0, 0])
    )
    points = np.array([[2.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert motion.places_at(points, 0.0) == pytest.approx(points)
    assert motion.places_at(points, 9.0) == pytest.approx(np.array([[1.0, 1.0, 2.0], [1.0, 0.0, 2.0]]))
    half = np.sqrt(0.5)
    assert motion.places_at(points, 1.5) == pytest.approx(np.array([[1.0 + half, half, 1.0], [1.0, 0.0, 1.0]]))


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
def test_motions_that_are_refused(times, displacement, rotation, message):
    with pytest.raises(ParameterError, match=message):
        RigidMotion(np.array(times, dtype=float), displacement, None if rotation is None else np.array(rotation))
    with pytest.raises(ParameterError, match="times that increase"):
        VertexMotion(np.array([1.0, 0.0]), np.zeros((2, 4, 3)))
