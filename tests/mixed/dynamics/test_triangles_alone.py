# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A mixed system without yarns is the cloth alone: backward Euler with whole matrices, without region or embedding."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from stitchmesh.mixed.dynamics.backward_euler import Dynamics
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.mixed.triangles.membrane import Membrane
from stitchmesh.mixed.triangles.shell_bending import ShellBending
from tests.mixed.dynamics.scene import CPU
from tests.mixed.dynamics.test_cloth_system import CLOTH, FALLING, REGIONS, SHEET, SIDE, TIGHT, built
from tests.mixed.triangles.derivatives import FloatArray, forces_of, hessian_of

HELD = [0, 5]
STEPS = 2


def lumped_masses() -> FloatArray:
    """A third of each triangle for each corner [g], shape (V,)."""
    masses = np.zeros(len(CLOTH.vertices))
    np.add.at(masses, CLOTH.triangles, np.repeat(SHEET.density * CLOTH.rest_area[:, None] / 3.0, 3, axis=1))
    return masses


def stepped(terms: Sequence[MixedTerm], vertices: FloatArray, velocities: FloatArray) -> FloatArray:
    """The vertices after a step of backward Euler: M (x - x_n - h u_n) / h^2 = f(x) + M g, by Newton's method."""
    free = np.setdiff1d(np.arange(len(vertices)), HELD)
    index = (3 * free[:, None] + np.arange(3)).ravel()
    inertia = np.repeat(lumped_masses(), 3).reshape(-1, 3) / TIGHT.time_step**2
    goal = vertices + TIGHT.time_step * velocities + TIGHT.time_step**2 * np.array(FALLING)
    found = vertices.copy()
    for _ in range(20):
        left = (sum(forces_of(term, found) for term in terms) - inertia * (found - goal)).ravel()[index]
        matrix = sum(hessian_of(term, found) for term in terms)[np.ix_(index, index)] + np.diag(inertia.ravel()[index])
        move = np.linalg.solve(matrix, left)
        found[free] += move.reshape(-1, 3)
        if np.abs(move).max() < 1e-13:
            return found
    raise AssertionError(f"no step: the last change is {np.abs(move).max():g} cm")


def test_all_triangles_equal_the_cloth_alone():
    scene = built(REGIONS["none"], vertices=HELD)
    x, y = CLOTH.vertices[:, 0], CLOTH.vertices[:, 1]
    vertices = CLOTH.vertices * [1.01, 0.99, 1.0] + np.outer(0.1 * np.sin(2.0 * x) * np.cos(y), [0.0, 0.0, 1.0])
    velocities = np.outer(5.0 * np.cos(x + y), [0.0, 0.2, 1.0])
    velocities[HELD] = 0.0
    mixed = [MixedVector.from_numpy(part, [], [], wp.float64, CPU) for part in (vertices, velocities)]
    run = Dynamics(scene.system, mixed[0], TIGHT, velocities=mixed[1])
    terms = [Membrane(CLOTH, SHEET, wp.float64, CPU), ShellBending(CLOTH, SHEET, wp.float64, CPU)]
    start = vertices
    for step in range(1, STEPS + 1):
        assert run.step().halvings == 0
        after = stepped(terms, vertices, velocities)
        vertices, velocities = after, (after - vertices) / TIGHT.time_step
        np.testing.assert_allclose(run.positions.numpy()[0], vertices, atol=1e-8 * step)  # the tolerance of the solver
    assert np.abs(vertices - start).max() > 1e-3 * SIDE  # it has moved by much more than the tolerance
