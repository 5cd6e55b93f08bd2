# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Friction between layers of cloth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.contact.layer_friction import LayerFriction
from stitchmesh.mixed.contact.self_collision import SelfCollision
from stitchmesh.mixed.scene.scene import ContactSection
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.mixed.simulation import begin_simulation
from tests.mixed.contact.moving_cloth import MovingCloth
from tests.mixed.contact.sheets import (
    Sheets,
    cpu,
    derivative_errors,
    forces_of,
    products_of,
    random_direction,
    sheet,
    state_of,
    together,
)
from tests.mixed.small_scene import SWINGING

THICKNESS, MU, STEP = 0.1, 0.3, 1e-2


def layers(mu: float = MU, precision: str = "float64") -> tuple[Sheets, SelfCollision, LayerFriction]:
    """Two parallel layers in contact, whose step has begun."""
    cloth = together(sheet(8, 0.6), sheet(8, 0.6, height=0.07, shift=0.02))
    points, links = cloth.points(THICKNESS, spacing=THICKNESS / 2)
    collision = SelfCollision(points, links, scalar=scalar_named(precision), device=cpu())
    friction = LayerFriction(collision, mu)
    state = state_of(cloth.vertices, precision=precision)
    for term in (collision, friction):
        term.begin_step(state, 0.0, STEP)
    return cloth, collision, friction


def test_forces_and_products_are_derivatives_of_the_energy():
    cloth, _collision, friction = layers()
    moved = state_of(cloth.vertices + 0.008 * np.random.default_rng(0).normal(size=cloth.vertices.shape))
    of_force, of_product = derivative_errors(friction, moved, 1e-7)
    assert of_force < 1e-7 and of_product < 1e-5  # (h / e)^2, and rounding of forces over h
    for seed in range(5):
        direction = random_direction(moved, seed)
        assert (direction.numpy()[0] * products_of(friction, moved, direction)).sum() >= 0.0


def test_friction_is_mu_times_the_normal_force_of_the_layers():
    cloth, collision, friction = layers()
    half = len(cloth.vertices) // 2
    slid = cloth.vertices.copy()
    slid[half:] += [0.05, 0.0, 0.0]
    normal = forces_of(collision, state_of(cloth.vertices))[half:, 2].sum()
    force = forces_of(friction, state_of(slid))
    # The normals of single points lean a little, towards the nearest points of the other layer and at its border.
    assert -force[half:, 0].sum() == pytest.approx(MU * normal, rel=0.05)
    assert np.abs(force[half:, 1:].sum(axis=0)).max() < 0.03 * MU * normal
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * np.abs(force).sum()  # equal and opposite, to rounding


def test_motion_together_has_no_friction_and_neither_has_a_static_state():
    cloth, _collision, friction = layers()
    together_moved = state_of(cloth.vertices + np.array([1.0, -2.0, 0.5]))
    # the differences of displacements of 1 cm are rounded, over a slip length of 0.01 cm
    assert np.abs(forces_of(friction, together_moved)).max() < 1e-11
    friction.begin_step(state_of(cloth.vertices), 0.0, 0.0)
    slid = state_of(cloth.vertices * [1.2, 1.0, 1.0])
    assert not forces_of(friction, slid).any() and friction.energy(slid) == 0.0


def test_a_layer_on_a_held_layer_creeps_below_the_friction_angle_and_slides_above():
    """The weight of the upper layer leans by 0.2 or 0.5 to the normal; mu = 0.3 holds 0.2."""
    speeds = {}
    for lean in (0.2, 0.5):
        cloth = together(sheet(4, 1.0), sheet(2, 0.4, height=0.09, shift=0.02))
        lower = 25
        points, links = cloth.points(THICKNESS, spacing=THICKNESS / 2)
        collision = SelfCollision(points, links, pressure=500.0, scalar=wp.float64, device=cpu())
        gravity = 981.0 * np.array([lean, 0.0, -1.0])
        terms = [collision, LayerFriction(collision, 0.3)]
        motion = MovingCloth(cloth, 0.02, gravity, 500.0, terms, held=range(lower))
        motion.run(15, 4e-3)
        speeds[lean] = motion.velocity[lower:, 0].mean()
    assert abs(speeds[0.2]) < 1.0  # the slip speed
    assert speeds[0.5] == pytest.approx(981.0 * (0.5 - 0.3) * 15 * 4e-3, rel=0.25)  # bumps of the points, first contact


def test_a_scene_that_moves_asks_for_it():
    contact = ContactSection(self_collision=True, friction=0.3)
    made = {}
    for friction in (0.0, 0.3):
        prepared = prepare(replace(SWINGING, contact=replace(contact, friction=friction)))
        system, _motion = begin_simulation(prepared, wp.float64, cpu()).system_at(0.0)
        made[friction] = [term for term in system.terms if isinstance(term, LayerFriction)]
    assert not made[0.0] and [term.coefficient for term in made[0.3]] == [0.3]


@pytest.mark.nightly
def test_single_precision_agrees():
    cloth, _collision, friction = layers()
    moved = cloth.vertices + 0.004 * np.random.default_rng(0).normal(size=cloth.vertices.shape)
    expected = forces_of(friction, state_of(moved))
    found = forces_of(layers(precision="float32")[2], state_of(moved, precision="float32"))
    assert np.abs(found - expected).max() < 1e-3 * np.abs(expected).max()  # places of 6e-8 cm, slips of 1e-3 cm


def test_refuses():
    _cloth, collision, _friction = layers()
    with pytest.raises(ParameterError, match=r"^layer friction: got a coefficient of -1\.0; expected at least 0$"):
        LayerFriction(collision, -1.0)
