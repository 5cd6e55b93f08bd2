# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.attachment import positive_part, turning_stiffness
from stitchmesh.meshrelax.placement import SurfacePlacement
from stitchmesh.meshrelax.surface.limit_surface import limit_surface
from tests.meshrelax.fabrics import grid_fabric, tube_chord_points

RADIUS = 2.0


def on_a_cylinder(angle: float) -> SurfacePlacement:
    """A vertex on an upright cylinder of radius 2."""
    normal = np.array([[np.cos(angle), np.sin(angle), 0.0]])
    around = np.array([-np.sin(angle), np.cos(angle), 0.0])
    none = np.zeros((1, 3))
    shape = np.outer(around, around)[None] / RADIUS
    return SurfacePlacement(RADIUS * normal, normal, shape, np.zeros(1), none, none, none)


def part_around(force: FloatArray, angle: float) -> float:
    return float(force[0] @ [-np.sin(angle), np.cos(angle), 0.0])


def test_an_outward_force_on_a_cylinder_gives_a_positive_stiffness() -> None:
    """The tangential part of a constant force decreases by the stiffness when the vertex moves around the cylinder."""
    force, step = np.array([[3.0, 0.5, 1.0]]), 1e-5
    change = (part_around(force, step) - part_around(force, -step)) / (2.0 * step * RADIUS)
    expected = np.diag([0.0, -change, 0.0])
    # The error of central differences is step^2 times third derivatives of order 1.
    np.testing.assert_allclose(turning_stiffness(on_a_cylinder(0.0), force)[0], expected, atol=1e-8)


def test_an_inward_force_on_a_cylinder_gives_no_stiffness() -> None:
    np.testing.assert_array_equal(turning_stiffness(on_a_cylinder(0.3), np.array([[-3.0, 0.0, 0.0]])), 0.0)


def test_a_border_that_is_curved_towards_the_force_gives_no_stiffness() -> None:
    """On a circle of radius 2 the curvature vector has the length 1/2 and points inwards."""
    upward, circle = np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 1.0, 0.0]])
    curvature = np.array([[-1.0 / RADIUS, 0.0, 0.0]])
    position, flat = np.array([[2.0, 0.0, 0.0]]), np.zeros((1, 3, 3))
    placement = SurfacePlacement(position, upward, flat, np.zeros(1), circle, curvature, np.zeros((1, 3)))
    inward = np.array([[-3.0, 0.0, 0.0]])
    np.testing.assert_array_equal(turning_stiffness(placement, inward), 0.0)
    np.testing.assert_allclose(turning_stiffness(placement, -inward)[0], np.diag([0.0, 1.5, 0.0]), atol=1e-15)


def test_the_shape_operator_of_a_tube_is_that_of_a_cylinder() -> None:
    surface = limit_surface(grid_fabric(tube_chord_points(24, 1, np.linspace(0.0, 6.0, 7), RADIUS), wrap=True), 0.1)
    inner = np.flatnonzero(np.abs(surface.vertices[surface.triangles][:, :, 2].mean(axis=1) - 3.0) < 2.0)
    normal = surface.normals[surface.triangles[inner]].mean(axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    shape = surface.shape_operator(inner, normal)
    np.testing.assert_allclose(shape, shape.transpose(0, 2, 1), atol=1e-14)  # Rounding.
    # The B-spline of a regular 24-gon has the curvature of a cylinder within about 2 %, and facets of size 0.1.
    around = np.cross([0.0, 0.0, 1.0], normal)
    np.testing.assert_allclose(np.einsum("ni,nij,nj->n", around, shape, around), 1.0 / RADIUS, rtol=0.05)
    np.testing.assert_allclose(shape[:, :, 2], 0.0, atol=0.02 / RADIUS)


def test_the_positive_part_is_that_of_the_eigenvalues_whatever_their_signs():
    random = np.random.default_rng(2)
    axes = np.linalg.qr(random.normal(size=(6, 3, 3)))[0]
    size = np.array([[2.0, 1.0, 0.0], [2.0, -3.0, 0.0], [-1.0, -2.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0] * 3])
    matrix, expected = ((axes * each[:, None, :]) @ axes.transpose(0, 2, 1) for each in (size, np.maximum(size, 0.0)))
    # rounding of sums of nine products of numbers up to three
    np.testing.assert_allclose(positive_part(matrix), expected, atol=1e-14)
