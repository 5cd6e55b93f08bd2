# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Friction with a body: derivatives, rest and slip on an inclined plane, and bodies that carry a cloth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError
from stitchmesh.mesh.vertex_motion import VertexMotion
from stitchmesh.mixed.contact.body import SolidBody
from stitchmesh.mixed.contact.body_distance import BodyContact
from stitchmesh.mixed.contact.body_friction import NO_ANCHOR, BodyFriction
from stitchmesh.mixed.contact.motion import RigidMotion
from tests.mixed.contact.bodies import ball, box
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
)

G, DENSITY, THICKNESS, PRESSURE = 981.0, 0.02, 0.1, 500.0
FLOOR = box((20.0, 20.0, 2.0), (0.0, 0.0, -2.0))


def with_friction(
    cloth: Sheets, body: SolidBody, mu: float, precision: str = "float64"
) -> tuple[BodyContact, BodyFriction]:
    points, _links = cloth.points(THICKNESS, spacing=np.inf)
    contact = BodyContact(points, body, pressure=PRESSURE, scalar=scalar_named(precision), device=cpu())
    return contact, BodyFriction(contact, mu)


def resting_height(press: float = DENSITY * G) -> float:
    """Where a cloth is in equilibrium on a floor."""
    x = brentq(lambda x: PRESSURE * (1 / x**3 - x) - press, 0.5, 1.0)
    return x * THICKNESS / 2


def on_slope(angle: float, mu: float, steps: int, h: float) -> tuple[MovingCloth, np.ndarray]:
    """A patch that starts at rest on an inclined plane; the slope is in gravity. Displacement and steps."""
    gravity = G * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    cloth = sheet(2, 1.0, height=resting_height(-DENSITY * gravity[2]))
    terms = with_friction(cloth, SolidBody(FLOOR), mu)
    motion = MovingCloth(cloth, DENSITY, gravity, 2e3, terms)
    motion.run(steps, h)
    return motion, motion.vertices - cloth.vertices


def test_products_are_derivatives_and_never_negative_on_a_turned_floor():
    motion = RigidMotion(np.zeros(1), np.zeros((1, 3)), Rotation.from_rotvec([0.5, -0.3, 0.8]).as_matrix()[None])
    cloth = sheet(3, 1.0, height=0.03)
    vertices = motion.places_at(cloth.vertices, 0.0)
    _contact, friction = with_friction(cloth, SolidBody(FLOOR, motion), 0.4)
    friction.begin_step(state_of(vertices), 0.0, 1e-3)
    moved = state_of(vertices + 0.004 * np.random.default_rng(0).normal(size=vertices.shape))
    for seed in range(5):
        direction = random_direction(moved, seed)
        assert (direction.numpy()[0] * products_of(friction, moved, direction)).sum() > 0.0
    of_force, of_product = derivative_errors(friction, moved, 1e-7)
    assert of_force < 1e-7 and of_product < 1e-6  # h^2 / e^2, and rounding of the force over h


def test_friction_reaches_mu_times_the_normal_force_and_has_no_normal_part():
    cloth = sheet(3, 1.0, height=0.03)
    contact, friction = with_friction(cloth, SolidBody(FLOOR), 0.4)
    state = state_of(cloth.vertices)
    friction.begin_step(state, 0.0, 1e-3)
    slid = state_of(cloth.vertices + np.array([0.3, -0.4, 0.01]))
    expected = np.outer(0.4 * forces_of(contact, state)[:, 2], [-0.6, 0.8, 0.0])
    assert forces_of(friction, slid) == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_a_patch_rests_below_the_friction_angle():
    """tan 0.3 = 0.31 < mu = 0.35: the patch moves by less than the slip length, and does not creep."""
    motion, displacement = on_slope(0.3, 0.35, 40, 5e-3)
    assert 0.0 < displacement[:, 0].min() and displacement[:, 0].max() < 0.005 + 1e-6
    before = motion.vertices.copy()
    motion.run(20, 5e-3)
    assert np.abs(motion.vertices - before).max() < 1e-6  # the solver's tolerance over a hundred milliseconds


def test_a_patch_slides_above_the_friction_angle():
    """With the acceleration g (sin a - mu cos a)."""
    mu, angle, h, steps = 0.2, 0.5, 2e-3, 30
    motion, displacement = on_slope(angle, mu, steps, h)
    acceleration = G * (np.sin(angle) - mu * np.cos(angle))
    speed = acceleration * steps * h
    # Friction builds up over the slip length of 0.005 cm in the first steps: 2 x 0.005 / (30 h)^2 of 1 / g.
    assert motion.velocity[:, 0].mean() == pytest.approx(speed, rel=0.01)
    # Implicit Euler is n (n + 1) h^2 / 2 for a constant acceleration.
    assert displacement[:, 0].mean() == pytest.approx(acceleration * h * h * steps * (steps + 1) / 2, rel=0.02)
    assert np.abs(motion.velocity[:, 1:]).max() < 0.01 * speed


def test_a_deforming_body_carries_a_patch():
    """A floor that starts slowly takes the patch along; what is within mu g does not slip."""
    away = np.array([[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.08, 0.0, 0.0], [0.18, 0.0, 0.0]])
    times = np.array([0.0, 0.02, 0.04, 0.06])  # 50 to 150 cm / s^2 in jumps of 1 to 3 cm / s
    moving = VertexMotion(times, FLOOR.vertices + away[:, None])
    cloth = sheet(2, 1.0, height=resting_height())
    terms = with_friction(cloth, SolidBody(FLOOR, moving), 0.5)
    gravity = np.array([0.0, 0.0, -G])
    motion = MovingCloth(cloth, DENSITY, gravity, 2e3, terms)
    motion.run(50, 2e-3)
    assert motion.vertices[:, 0] - cloth.vertices[:, 0] == pytest.approx(np.full(9, 0.18), abs=0.015)
    assert np.abs(motion.velocity).max() < 0.5  # at rest with the floor, except the swing about the anchors


def test_a_turntable_carries_what_rests_on_it():
    """Points on a turntable keep their places on it."""
    table = box((3.0, 3.0, 1.0), (0.0, 0.0, -1.0))
    turns = Rotation.from_rotvec(np.outer(np.linspace(0.0, 0.2, 5), [0.0, 0.0, 1.0])).as_matrix()
    turning = RigidMotion(np.linspace(0.0, 0.4, 5), np.zeros((5, 3)), turns)
    cloth = sheet(2, 1.0, height=resting_height())
    terms = with_friction(cloth, SolidBody(table, turning), 0.5)
    motion = MovingCloth(cloth, DENSITY, np.array([0.0, 0.0, -G]), 2e3, terms)
    motion.run(90, 5e-3)
    assert motion.vertices == pytest.approx(turning.places_at(cloth.vertices, 1.0), abs=0.006)


def test_anchors_on_edges_and_curves_start_without_force():
    mesh = ball(1.0, 1)
    rng = np.random.default_rng(0)
    places = rng.normal(size=(50, 3))
    places *= 1.02 / np.linalg.norm(places, axis=1)[:, None]
    cloth = sheet(1, 1.0)
    contact, friction = with_friction(cloth, SolidBody(mesh), 0.5)
    for four in places[:48].reshape(-1, 4, 3):
        friction._begun = False
        friction.face.fill_(int(NO_ANCHOR))
        friction.begin_step(state_of(four), 0.0, 1e-3)
        force = forces_of(friction, state_of(four))
        assert np.abs(force).max() <= 1e-9 * np.abs(forces_of(contact, state_of(four))).max()


def test_stop_and_resume_give_the_same_bits():
    cloth = sheet(2, 1.0, height=0.03)
    state, later = state_of(cloth.vertices), state_of(cloth.vertices + np.array([0.02, 0.0, 0.0]))
    _contact, friction = with_friction(cloth, SolidBody(FLOOR), 0.4)
    friction.begin_step(state, 0.0, 1e-3)
    friction.end_step(later, 1e-3, 1e-3)
    kept = {name: array.numpy() for name, array in friction.arrays().items()}
    _other, resumed = with_friction(cloth, SolidBody(FLOOR), 0.4)
    resumed.resume(kept)
    for term in (friction, resumed):
        term.begin_step(later, 1e-3, 1e-3)
    end = state_of(cloth.vertices + np.array([0.023, 0.001, 0.0]))
    assert (forces_of(friction, end) == forces_of(resumed, end)).all()
    friction.end_step(state_of(cloth.vertices + np.array([0.0, 0.0, 5.0])), 2e-3, 1e-3)
    assert (friction.face.numpy() == int(NO_ANCHOR)).all() and not friction.load.numpy().any()


@pytest.mark.nightly
def test_single_precision_agrees():
    cloth = sheet(3, 1.0, height=0.03)
    forces = []
    for precision in ("float64", "float32"):
        _contact, friction = with_friction(cloth, SolidBody(FLOOR), 0.4, precision)
        friction.begin_step(state_of(cloth.vertices, precision=precision), 0.0, 1e-3)
        forces.append(
            forces_of(friction, state_of(cloth.vertices + np.array([0.003, 0.001, 0.0]), precision=precision))
        )
    # the place of an anchor on a triangle of 40 cm is rounded by 2e-6 cm, 1e-3 of the slip of 0.003 cm
    assert np.abs(forces[1] - forces[0]).max() < 1e-3 * np.abs(forces[0]).max()


def test_refuses():
    cloth = sheet(1, 1.0)
    points, _links = cloth.points(THICKNESS, spacing=np.inf)
    contact = BodyContact(points, SolidBody(FLOOR, name="floor"), scalar=scalar_named("float64"), device=cpu())
    with pytest.raises(ParameterError, match=r"^floor friction: got a coefficient of -0\.1; expected at least 0$"):
        BodyFriction(contact, -0.1)
    with pytest.raises(ParameterError, match=r"slip length of 0\.0 cm; expected a positive number$"):
        BodyFriction(contact, 0.1, slip_length=0.0)
