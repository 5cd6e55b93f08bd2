# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Attachments: what is held, and the motion that is prescribed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.contact.attachments import Attachment, PrescribedMotion, at_simulated_nodes
from stitchmesh.mixed.contact.motion import RigidMotion
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
