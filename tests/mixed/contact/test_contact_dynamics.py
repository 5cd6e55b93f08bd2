# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cloth that falls, rests, is pushed and is carried: contact, friction and guards in motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from stitchmesh.compute.precision import scalar_named
from stitchmesh.mixed.contact.body import SolidBody
from stitchmesh.mixed.contact.body_distance import BodyContact
from stitchmesh.mixed.contact.body_friction import BodyFriction
from stitchmesh.mixed.contact.motion import RigidMotion
from stitchmesh.mixed.contact.self_collision import SelfCollision
from tests.mixed.contact.bodies import ball, box
from tests.mixed.contact.moving_cloth import MovingCloth
from tests.mixed.contact.sheets import Sheets, cpu, forces_of, sheet, state_of, together

DENSITY, THICKNESS = 0.02, 0.1
GRAVITY = np.array([0.0, 0.0, -981.0])
FLOAT64 = scalar_named("float64")


def contact_of(cloth: Sheets, body: SolidBody, spacing: float = THICKNESS) -> BodyContact:
    points, _links = cloth.points(THICKNESS, spacing=spacing)
    return BodyContact(points, body, scalar=FLOAT64, device=cpu())


def motion_of(
    cloth: Sheets, stiffness: float, terms: list, gravity: np.ndarray = GRAVITY, *, held: Sequence[int] = ()
) -> MovingCloth:
    return MovingCloth(cloth, DENSITY, gravity, stiffness, terms, held=held)


def test_a_falling_patch_comes_to_rest_with_its_weight_on_a_ball():
    cloth = sheet(4, 1.0, height=0.3)
    contact = contact_of(cloth, SolidBody(ball(2.0, 3, (0.0, 0.0, -2.0))))
    friction = BodyFriction(contact, 0.6)
    motion = motion_of(cloth, 200.0, [contact, friction])
    motion.run(60, 1e-2)  # implicit Euler damps the rest of the motion
    state = state_of(motion.vertices)
    held = forces_of(contact, state) + forces_of(friction, state)
    weight = motion.mass.sum() * 981.0
    assert held.sum(axis=0) == pytest.approx([0.0, 0.0, weight], abs=1e-3 * weight)  # accelerations below g / 1000
    assert np.abs(motion.velocity).max() < 0.05
    assert contact.distances(state).min() > 0.3 * THICKNESS / 2


def test_a_ball_that_is_pushed_slowly_into_a_cloth_does_not_pass_it():
    """The cloth is held by its border; the ball rises by 0.6 cm and the cloth stays above it."""
    cloth = sheet(6, 2.0)
    rising = RigidMotion(np.array([0.0, 0.3]), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.6]]))
    contact = contact_of(cloth, SolidBody(ball(0.5, 2, (0.03, 0.02, -0.56)), rising), 0.25)
    border = np.flatnonzero(np.abs(cloth.vertices[:, :2]).max(axis=1) > 0.99)
    motion = motion_of(cloth, 2e3, [contact], np.zeros(3), held=border)
    motion.run(10, 3e-2)
    distance = contact.distances(state_of(motion.vertices))
    assert 0.0 < distance.min() < THICKNESS / 2
    assert motion.vertices[:, 2].max() > 0.4


@pytest.mark.parametrize("spacing", [THICKNESS, np.inf], ids=["fine", "coarse"])
def test_a_sheet_that_falls_fast_on_another_one_does_not_pass_it(spacing):
    """Steps of up to twenty thicknesses, whose energy the lower sheet, which is held at its border, can take up."""
    speed, lower = 1000.0, 49
    cloth = together(sheet(6, 0.8), sheet(3, 0.4, height=0.5, shift=0.02))
    points, links = cloth.points(THICKNESS, spacing=spacing)
    contact = SelfCollision(points, links, pressure=2e5, scalar=FLOAT64, device=cpu())
    border = np.flatnonzero(np.abs(cloth.vertices[:lower, :2]).max(axis=1) > 0.39)
    motion = motion_of(cloth, 2e4, [contact], held=border)
    motion.velocity[lower:, 2] = -speed
    pressed = 0.0
    for _ in range(4):
        motion.run(1, 2e-3)
        assert not crossings(cloth, motion.vertices)
        pressed = max(pressed, contact.energy(state_of(motion.vertices)))
    assert pressed > 0.0 and motion.velocity[lower:, 2].mean() > -0.5 * speed


def crossings(cloth: Sheets, vertices: np.ndarray) -> int:
    """Number of sides of triangles that cross a triangle of another panel."""
    total = 0
    for panel in (0, 1):
        own, other = cloth.triangles[cloth.panel == panel], cloth.triangles[cloth.panel != panel]
        start, end = vertices[own].reshape(-1, 1, 3), vertices[np.roll(own, 1, axis=1)].reshape(-1, 1, 3)
        a, b, c = (vertices[other[:, k]][None] for k in range(3))
        normal = np.cross(b - a, c - a)
        height = [np.einsum("std,std->st", normal + 0 * x, x - a) for x in (start, end)]
        part = height[0] / np.where(height[0] == height[1], 1.0, height[0] - height[1])
        at = start + part[:, :, None] * (end - start)
        inside = height[0] * height[1] < 0.0
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= np.einsum("std,std->st", np.cross(q - p, at - p), normal + 0 * at) > 0.0
        total += int(inside.sum())
    return total


def test_layers_rest_on_one_another_and_on_a_floor():
    """The lower layer carries the upper one: the floor carries both."""
    cloth = together(sheet(4, 0.4, height=0.06), sheet(4, 0.4, height=0.18, shift=0.02))
    half = len(cloth.vertices) // 2
    points, links = cloth.points(THICKNESS)
    layers = SelfCollision(points, links, scalar=FLOAT64, device=cpu())
    floor = BodyContact(points, SolidBody(box((5, 5, 1), (0, 0, -1))), scalar=FLOAT64, device=cpu())
    motion = motion_of(cloth, 500.0, [layers, floor, BodyFriction(floor, 0.5)])
    motion.run(30, 2e-2)
    state = state_of(motion.vertices)
    weight = motion.mass.sum() * 981.0
    assert forces_of(floor, state)[:, 2].sum() == pytest.approx(weight, rel=5e-3)
    assert forces_of(layers, state)[half:, 2].sum() == pytest.approx(weight / 2, rel=5e-3)
