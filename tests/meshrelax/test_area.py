# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.forces import SMALLEST_AREA
from tests.meshrelax.element_forces import area_forces

RANDOM = np.random.default_rng(3)
REST, STIFFNESS = 0.8, 1.5


def diagonals(part: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Diagonals p and q and random unit normals n, such that the areas are the given fractions of the rest area."""
    normal = RANDOM.normal(size=(len(part), 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    first, second = RANDOM.normal(size=(2, len(part), 3))
    area = 0.5 * np.einsum("qi,qi->q", normal, np.cross(first, second))
    return first, second * (part * REST / area)[:, None], normal


def energy(first: FloatArray, second: FloatArray, normal: FloatArray) -> FloatArray:
    """Energy of each sub-quad: kappa u (a - 1 - ln a), its tangent line below ``SMALLEST_AREA``, zero above a = 1."""
    part = 0.5 * np.einsum("qi,qi->q", normal, np.cross(first, second)) / REST
    limited = np.clip(part, SMALLEST_AREA, 1.0)
    tangent = (1.0 - 1.0 / limited) * np.minimum(part - limited, 0.0)
    return STIFFNESS * np.sqrt(REST) * (limited - 1.0 - np.log(limited) + tangent)


def test_the_forces_are_minus_the_gradient_of_the_energy() -> None:
    first, second, normal = diagonals(np.array([-0.7, -0.1, 0.02, 0.1, 0.3, 0.6, 0.9, 1.3]))
    force, _ = area_forces(first, second, normal, REST, STIFFNESS)
    step = 1e-6
    for axis in range(3):
        shift = step * np.eye(3)[axis]
        on_first = energy(first - shift, second, normal) - energy(first + shift, second, normal)
        on_second = energy(first, second - shift, normal) - energy(first, second + shift, normal)
        # The errors are step^2 times third derivatives of about 1 / 0.1^3, and rounding divided by the step.
        expected = np.concatenate([on_first, on_second]) / (2.0 * step)
        np.testing.assert_allclose(force[:, axis], expected, rtol=1e-6, atol=1e-7)


def test_a_stitch_of_its_rest_area_or_more_has_no_force() -> None:
    force, jacobian = area_forces(*diagonals(np.array([1.001, 1.5, 4.0])), REST, STIFFNESS)
    np.testing.assert_array_equal(force, 0.0)
    np.testing.assert_array_equal(jacobian, 0.0)


def test_the_jacobians_bound_the_second_derivative_of_the_energy() -> None:
    """The matrix -J of both diagonals, and also -J minus E''(A) g g^T, have no negative eigenvalues."""
    part = RANDOM.uniform(0.1, 0.95, 20)
    first, second, normal = diagonals(part)
    _, jacobian = area_forces(first, second, normal, REST, STIFFNESS)
    gradient = 0.5 * np.concatenate([np.cross(second, normal), np.cross(normal, first)], axis=1)
    curvature = STIFFNESS * np.sqrt(REST) / (part * REST) ** 2
    for quad in range(len(part)):
        bound = np.zeros((6, 6))
        bound[:3, :3], bound[3:, 3:] = -jacobian[quad], -jacobian[quad + len(part)]
        scale = 1e-12 * np.abs(bound).max()  # Rounding of eigenvalues.
        assert np.linalg.eigvalsh(bound).min() >= -scale
        exact = curvature[quad] * np.outer(gradient[quad], gradient[quad])
        assert np.linalg.eigvalsh(bound - exact).min() >= -scale


def test_the_moment_about_the_normal_vanishes() -> None:
    """A rotation in the surface does not change the area of a stitch."""
    first, second, normal = diagonals(np.array([-0.5, 0.03, 0.4, 0.8]))
    force, _ = area_forces(first, second, normal, REST, STIFFNESS)
    moment = np.cross(first, force[:4]) + np.cross(second, force[4:])
    scale = np.abs(force).max() * max(np.abs(first).max(), np.abs(second).max())
    np.testing.assert_allclose(np.einsum("qi,qi->q", normal, moment), 0.0, atol=1e-14 * scale)  # Rounding.
