# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Attachments: what is chosen, the motion that is prescribed, and springs."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from scipy.spatial.transform import Rotation

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.contact.attachment_springs import AttachmentSprings
from stitchmesh.mixed.contact.attachments import (
    Attachment,
    AttachmentNodes,
    at_simulated_nodes,
    chosen_in_box,
    chosen_on_border,
    chosen_with_vertices,
)
from stitchmesh.mixed.contact.motion import RigidMotion
from stitchmesh.mixed.contact.prescribed_motion import PrescribedMotion
from tests.mixed.contact.sheets import blocks_of, cpu, derivative_errors, forces_of, products_of, sheet, state_of

QUARTER = Rotation.from_rotvec([0.0, 0.0, np.pi / 2]).as_matrix()


def square() -> tuple[Cloth, AttachmentNodes]:
    """A cloth of 4 x 4 squares with sides of 1 cm, and a node at the middle of each triangle."""
    flat = sheet(4, 4.0)
    cloth = Cloth(
        vertices=flat.vertices, triangles=flat.triangles, rest=flat.rest, panel=flat.panel, panel_names=("front",)
    )
    middle = flat.rest.mean(axis=1)
    place = np.column_stack([middle, np.zeros(len(middle))])
    return cloth, AttachmentNodes(np.zeros(32, dtype=int), middle, np.arange(32), place)


def test_a_box_holds_vertices_and_nodes():
    vertices, nodes = chosen_in_box([-2.0, -2.0, -1.0], [-1.0, 0.0, 1.0], *square())
    cloth, own = square()
    assert cloth.vertices[vertices, :2].max(axis=0) == pytest.approx([-1.0, 0.0]) and len(vertices) == 6
    assert len(nodes) == 4 and own.place[nodes].max(axis=0)[0] < -1.0


def test_vertices_hold_the_nodes_of_their_triangles():
    cloth, own = square()
    corner = cloth.triangles[7]
    vertices, nodes = chosen_with_vertices([*corner, 24], cloth, own)
    assert vertices.tolist() == sorted({*corner.tolist(), 24})
    assert nodes.tolist() == [7]


@pytest.mark.parametrize(
    ("side", "count", "axis", "value"), [("left", 5, 0, -2), ("right", 5, 0, 2), ("bottom", 5, 1, -2), ("top", 5, 1, 2)]
)
def test_sides_of_a_panel(side, count, axis, value):
    cloth, own = square()
    vertices, nodes = chosen_on_border("front", side, cloth, own, width=0.4)
    assert len(vertices) == count and cloth.vertices[vertices, axis] == pytest.approx(value)
    # one of the two triangles beside each edge has its middle a third of a side away from it
    assert len(nodes) == 4 and own.position[nodes, axis] == pytest.approx(value * (1 - 1 / 6))
    assert not len(chosen_on_border("front", side, cloth, own)[1])


def test_the_whole_border_of_a_panel():
    cloth, own = square()
    vertices, nodes = chosen_on_border("front", "all", cloth, own, width=0.4)
    assert len(vertices) == 16 and len(nodes) == 14  # two of the sixteen places beside edges are in corner triangles


def test_prescribed_motion_is_that_of_the_keyframes_and_steps_add_up():
    cloth, own = square()
    turn = RigidMotion(np.array([0.0, 1.0]), np.array([[0.0] * 3, [1.0, 0, 0]]), np.stack([np.eye(3), QUARTER]))
    chosen = chosen_in_box([-2, -2, -1], [-1, 2, 1], cloth, own)
    held = Attachment(*chosen, turn)
    motion = PrescribedMotion([held, Attachment(np.array([24]), stiffness=5.0)], cloth.vertices, own.place)
    assert motion.fixed_vertices.tolist() == chosen[0].tolist() and motion.fixed_nodes.tolist() == chosen[1].tolist()
    v, p, s = motion.positions(1.0)
    assert v[chosen[0]] == pytest.approx(cloth.vertices[chosen[0]] @ QUARTER.T + [1.0, 0.0, 0.0])
    free = np.setdiff1d(np.arange(25), chosen[0])
    assert (v[free] == cloth.vertices[free]).all() and not s.any()
    times = np.sort(np.random.default_rng(0).random(20))
    total = sum(motion.displacements(a, b)[1] for a, b in zip([0.0, *times], [*times, 1.0], strict=True))
    assert own.place + total == pytest.approx(p)
    velocity = motion.velocities(0.2, 0.3)[0]
    assert velocity * 0.1 == pytest.approx(motion.displacements(0.2, 0.3)[0])


def test_nodes_that_are_not_simulated_are_left_out():
    number = np.array([-1, 0, -1, 1])
    both, only = Attachment(np.array([7]), np.array([0, 1, 3])), Attachment(nodes=np.array([0, 2]))
    (kept,) = at_simulated_nodes([both, only], number)
    assert kept.vertices.tolist() == [7] and kept.nodes.tolist() == [0, 1]


def springs() -> tuple[AttachmentSprings, Cloth, AttachmentNodes]:
    cloth, own = square()
    moving = RigidMotion(np.array([0.0, 1.0]), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]))
    soft = [Attachment(np.array([0, 3]), np.array([5]), moving, 40.0), Attachment(np.array([7]), stiffness=10.0)]
    return AttachmentSprings(soft, cloth.vertices, own.place, scalar=wp.float64, device=cpu()), cloth, own


def test_springs_pull_to_where_the_attachment_will_be():
    term, cloth, own = springs()
    state = state_of(cloth.vertices, own.place)
    assert term.energy(state) == 0.0
    term.begin_step(state, 0.4, 0.1)
    force = forces_of(term, state)
    assert force[[0, 3, 25 + 5]] == pytest.approx(np.tile([0.0, 0.0, 40.0], (3, 1)))
    assert np.abs(force).sum() == pytest.approx(120.0)
    assert term.energy(state) == pytest.approx(3 * 0.5 * 40.0)


def test_forces_of_springs_are_derivatives():
    term, cloth, own = springs()
    state = state_of(cloth.vertices + 0.1, own.place)
    of_force, of_product = derivative_errors(term, state, 1e-3)
    assert of_force < 1e-9 and of_product < 1e-9  # quadratic: rounding alone
    direction = state_of(np.ones((25, 3)), np.ones((32, 3)))
    assert products_of(term, state, direction)[7] == pytest.approx([10.0] * 3)
    assert blocks_of(term, state)[7] == pytest.approx(10.0 * np.eye(3))


def test_refuses():
    cloth, own = square()
    with pytest.raises(ParameterError, match=r"^attachment: got no vertex and no node; expected some"):
        Attachment()
    with pytest.raises(ParameterError, match="distinct numbers"):
        Attachment(np.array([1, 1]))
    with pytest.raises(ParameterError, match=r"hook: got a stiffness of 0\.0 dyn / cm"):
        Attachment(np.array([1]), stiffness=0.0, name="hook")
    with pytest.raises(ParameterError, match=r"pin: got vertex 3, which hook holds; expected each in one attachment"):
        held = [Attachment(np.array([3]), name="hook"), Attachment(np.array([2, 3]), name="pin")]
        PrescribedMotion(held, cloth.vertices, own.place)
    with pytest.raises(ParameterError, match="got node 99; expected 0 to 31"):
        PrescribedMotion([Attachment(nodes=np.array([99]))], cloth.vertices, own.place)
    with pytest.raises(ParameterError, match="got the panel 'back'; expected one of front"):
        chosen_on_border("back", "all", cloth, own)
    with pytest.raises(ParameterError, match="got the side 'up'; expected one of all, left"):
        chosen_on_border("front", "up", cloth, own)
    with pytest.raises(ParameterError, match="width of nan cm"):
        chosen_on_border("front", "all", cloth, own, width=np.nan)
    with pytest.raises(ParameterError, match="got vertex 25; expected 0 to 24"):
        chosen_with_vertices([3, 25], cloth, own)
    with pytest.raises(ParameterError, match="three increasing coordinates"):
        chosen_in_box([0, 0, 0], [1, -1, 1], cloth, own)
    assert AttachmentNodes.none().place.shape == (0, 3)
