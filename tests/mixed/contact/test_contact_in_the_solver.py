# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact, friction and attachments in the motion of the mixed system, with triangles, yarns and a hybrid region."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warp as wp

from stitchmesh.errors import SolverError
from stitchmesh.mixed.contact.body import SolidBody
from stitchmesh.mixed.contact.body_distance import BodyContact
from stitchmesh.mixed.contact.body_friction import BodyFriction
from stitchmesh.mixed.contact.contact_points import ContactPoints, join_points, points_at_nodes
from stitchmesh.mixed.contact.motion import Attachment, PrescribedMotion, RigidMotion, at_simulated_nodes
from stitchmesh.mixed.contact.self_collision import SelfCollision
from stitchmesh.mixed.dynamics.backward_euler import Dynamics, DynamicsSettings
from stitchmesh.mixed.dynamics.equilibrium import EquilibriumSettings, find_equilibrium
from stitchmesh.mixed.dynamics.mass_matrix import FabricPoints
from stitchmesh.mixed.enrichment.region import Region, region_around
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.simulation.dead_load import Gravity
from tests.mixed.contact.bodies import ball, box
from tests.mixed.contact.sheets import Sheets, cpu, forces_of
from tests.mixed.dynamics.scene import Scene, spring_scene
from tests.mixed.patch import square_patch

PATCH = square_patch(4, 3)
HYBRID = region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.2))
THICKNESS = 0.1
GRAVITY = (0.0, 0.0, -981.0)
FLOOR = box((5.0, 5.0, 1.0), (0.5, 0.5, -1.04))
"""Its upper side is 0.04 cm below the patch, which begins in contact."""


def points_of(region: Region) -> ContactPoints:
    """Points on triangles of weight 1 - alpha and at simulated nodes of weight alpha."""
    rest = PATCH.vertices[PATCH.triangles][:, :, :2]
    flat = Sheets(PATCH.vertices, PATCH.triangles, rest, np.zeros(len(PATCH.triangles), dtype=int))
    on_triangles, _links = flat.points(
        THICKNESS, node_count=len(region.nodes), weight=1.0 - region.triangle_alpha, spacing=np.inf
    )
    nodes = region.nodes
    at_nodes = points_at_nodes(
        len(PATCH.vertices), panel=np.zeros(len(nodes), dtype=int), rest=PATCH.nodes[nodes, :2],
        area=1.0 / len(PATCH.nodes), weight=region.node_alpha[nodes], thickness=THICKNESS,
    )  # fmt: skip
    return join_points([on_triangles, at_nodes])


def on_floor(region: Region, mu: float = 0.4, **options: Any) -> tuple[Scene, BodyContact, BodyFriction]:
    """A patch with weight above a floor."""
    scene = spring_scene(PATCH, region, stiffness=2e3, **options)
    contact = BodyContact(points_of(region), SolidBody(FLOOR), scalar=wp.float64, device=cpu())
    friction = BodyFriction(contact, mu)
    points = FabricPoints(scene.system.mass.lumped, 1.0, wp.float64, cpu())
    for term in (contact, friction, Gravity(GRAVITY).on(points)):
        scene.system.add(term)
    return scene, contact, friction


def total_force(scene: Scene, state: MixedVector, *terms: Any) -> np.ndarray:
    return sum(forces_of(term, state) for term in terms).sum(axis=0)


def test_the_static_equilibrium_on_a_floor_carries_the_weight():
    scene, contact, friction = on_floor(HYBRID)
    positions = scene.at_rest()
    report = find_equilibrium(scene.system, positions, EquilibriumSettings(force_tolerance=1e-4))
    assert report.converged
    total = scene.masses.total * 981.0
    held = total_force(scene, positions, contact, friction)
    # 1e-4 dyn at each of about 100 vertices and nodes
    assert held == pytest.approx([0.0, 0.0, total], abs=0.02)


def test_no_first_guess_jumps_through_a_floor():
    """A patch that falls by many thicknesses of the floor in a step bounces."""
    speed = 3000.0
    scene, contact, _friction = on_floor(HYBRID)
    up = np.array([0.0, 0.0, 1.0])
    positions = scene.vector(PATCH.vertices + up, PATCH.nodes + up)
    velocities = scene.vector(0 * PATCH.vertices - speed * up, 0 * PATCH.nodes - speed * up)
    settings = DynamicsSettings(time_step=5e-3, velocity_tolerance=1.0)
    run = Dynamics(scene.system, positions, settings, velocities=velocities)
    for _ in range(4):
        run.step()
        assert contact.distances(run.positions).min() > -0.8 * contact.depth
    assert run.positions.numpy()[0][:, 2].min() > -0.5


def test_stop_and_resume_give_the_same_bits():
    def started() -> Dynamics:
        scene, _contact, _friction = on_floor(HYBRID)
        sideways = scene.vector(0 * PATCH.vertices + [30.0, 0, 0], 0 * PATCH.nodes + [30.0, 0, 0])
        return Dynamics(scene.system, scene.at_rest(), DynamicsSettings(time_step=2e-3), velocities=sideways)

    whole, second = started(), started()
    for _ in range(3):
        whole.step()
    second.resume(whole.arrays())
    for _ in range(3):
        whole.step()
        second.step()
    assert (whole.positions.values.numpy() == second.positions.values.numpy()).all()
    assert whole.positions.numpy()[0][:, 0].mean() > 0.5


def test_attachments_prescribe_the_motion_of_vertices_and_nodes():
    """A border of triangles and a corner of yarns are lifted by keyframes, without drift."""
    region = region_around(*PATCH.layout, PATCH.near((0.0, 0.5), 0.3))
    lifted = RigidMotion(np.array([0.0, 0.02]), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.3]]))
    border = np.flatnonzero(PATCH.vertices[:, 0] < 1e-9)
    at_border = np.flatnonzero(PATCH.nodes[:, 0] < 0.1)
    held = Attachment(border, at_border, lifted)
    scene, _contact, _friction = on_floor(
        region, fixed_vertices=held.vertices.tolist(), fixed_nodes=held.nodes.tolist()
    )
    own = at_simulated_nodes([held], region.node_number)
    motion = PrescribedMotion(own, PATCH.vertices, PATCH.nodes[region.nodes])
    run = Dynamics(scene.system, scene.at_rest(), DynamicsSettings(time_step=3e-3), prescribed=motion.displacements)
    for _ in range(9):
        run.step()
    v, p, _ = run.positions.numpy()
    aim_v, aim_p, _ = motion.positions(run.time)
    free = region.unknown_vertices[motion.fixed_vertices]
    assert v[motion.fixed_vertices[free]] == pytest.approx(aim_v[motion.fixed_vertices[free]], abs=1e-12)
    assert p[motion.fixed_nodes] == pytest.approx(aim_p[motion.fixed_nodes], abs=1e-12)
    assert p[motion.fixed_nodes, 2] == pytest.approx(0.3)


@pytest.mark.parametrize("time_step", [1e-5, 1e-1])
def test_time_steps_over_four_decades_stay_above_the_floor(time_step):
    """A patch that falls on a floor at 200 cm/s; the longest step would carry it 20 cm."""
    scene, contact, _friction = on_floor(HYBRID)
    up, down = np.array([0.0, 0.0, 0.01]), np.array([0.0, 0.0, -200.0])
    start = scene.vector(PATCH.vertices + up, PATCH.nodes + up)
    velocities = scene.vector(0 * PATCH.vertices + down, 0 * PATCH.nodes + down)
    run = Dynamics(
        scene.system, start, DynamicsSettings(time_step=time_step, velocity_tolerance=1.0), velocities=velocities
    )
    for _ in range(4):
        run.step()
    assert np.isfinite(run.positions.values.numpy()).all()
    assert contact.distances(run.positions).min() > -0.1


def test_a_cloth_that_is_dragged_over_a_body_wraps_it_and_one_that_is_dragged_into_it_is_an_error():
    ball_in_the_way = SolidBody(ball(0.25, 2, (0.5, 0.5, -0.3)))
    border = np.flatnonzero(np.abs(PATCH.vertices[:, :2] - 0.5).max(axis=1) > 0.49)
    for held, works in ((border, True), (np.arange(len(PATCH.vertices)), False)):
        none = region_around(*PATCH.layout, [])
        scene = spring_scene(PATCH, none, stiffness=2e3, fixed_vertices=held.tolist())
        contact = BodyContact(points_of(none), ball_in_the_way, depth=0.2, scalar=wp.float64, device=cpu())
        scene.system.add(contact)
        down = RigidMotion(np.array([0.0, 0.05]), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -0.4]]))
        motion = PrescribedMotion([Attachment(held, motion=down)], PATCH.vertices, np.zeros((0, 3)))
        settings = DynamicsSettings(time_step=5e-3, velocity_tolerance=1e-2)
        run = Dynamics(scene.system, scene.at_rest(), settings, prescribed=motion.displacements)
        if works:
            for _ in range(12):
                run.step()
            assert contact.distances(run.positions).min() > 0.0
            assert run.positions.numpy()[0][12, 2] > -0.1  # the middle lies on the ball
        else:
            with pytest.raises(SolverError, match=r"body: \d+ contact points, the deepest at vertex 12, are up to"):
                for _ in range(12):
                    run.step()


def test_a_body_that_moves_too_far_in_a_step_makes_the_step_shorter():
    """A ball that rises by 2.5 cm in a step of 5 ms, below a patch that it can be found 0.2 cm deep in."""
    scene = spring_scene(PATCH, HYBRID, stiffness=2e3)
    rising = RigidMotion(np.array([0.0, 0.01]), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 5.0]]))
    body = SolidBody(ball(0.6, 2, (0.5, 0.5, -0.9)), rising)
    contact = BodyContact(points_of(HYBRID), body, depth=0.2, scalar=wp.float64, device=cpu())
    scene.system.add(contact)
    run = Dynamics(scene.system, scene.at_rest(), DynamicsSettings(time_step=5e-3, velocity_tolerance=1.0))
    reports = [run.step() for _ in range(3)]
    assert max(report.halvings for report in reports) > 0
    while run.time < 0.004:
        reports.append(run.step())
    assert contact.distances(run.positions).min() > -0.2
    assert run.positions.numpy()[1][:, 2].max() > 1.0  # the yarns in the middle of the patch are carried along


def test_self_collision_of_a_flat_mixed_patch_changes_nothing():
    """Vertices and nodes at the same places are neighbours at rest: they do not push each other."""
    term = SelfCollision(points_of(HYBRID), None, scalar=wp.float64, device=cpu())
    scene = spring_scene(PATCH, HYBRID)
    state = scene.at_rest()
    term.begin_step(state, 0.0, 1e-3)
    assert term.energy(state) == 0.0 and not forces_of(term, state).any()
