# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.assembly import assembly
from stitchmesh.meshrelax.forces import force_groups
from stitchmesh.meshrelax.placement import PlacedPoints
from stitchmesh.meshrelax.rest_lengths import RestRectangle, rest_lengths
from stitchmesh.meshrelax.sub_quads import springs, sub_quad_corners, wale_strut_corners
from tests.meshrelax.element_forces import element_forces, shear_force, stretch_force, strut_force
from tests.meshrelax.fabrics import grid_fabric, increase_fabric, rectangle_points, tube_points

RANDOM = np.random.default_rng(7)


def differences(force: Callable[[FloatArray], FloatArray], at: FloatArray, step: float = 1e-5) -> FloatArray:
    """Central differences of the force of an element, shape (S, 3, 3)."""
    columns = [(force(at + step * axis) - force(at - step * axis)) / (2 * step) for axis in np.eye(3)]
    return np.stack(columns, axis=2)


def test_stretch_jacobian_of_extended_springs_is_the_derivative() -> None:
    span = RANDOM.normal(size=(20, 3))
    rest = np.linalg.norm(span, axis=1) * RANDOM.uniform(0.3, 0.95, 20)
    expected = differences(lambda d: stretch_force(d, rest, 2.0)[0], span)
    # The error of central differences is step^2 times third derivatives of order 1 / length^3.
    np.testing.assert_allclose(stretch_force(span, rest, 2.0)[1], expected, rtol=1e-6, atol=1e-7)


def test_stretch_jacobian_of_compressed_springs_is_the_derivative_along_the_springs() -> None:
    span = RANDOM.normal(size=(20, 3))
    rest = np.linalg.norm(span, axis=1) * 1.5
    expected = differences(lambda d: stretch_force(d, rest, 2.0)[0], span)
    jacobian = stretch_force(span, rest, 2.0)[1]
    np.testing.assert_allclose(
        np.einsum("sij,sj->si", jacobian, span), np.einsum("sij,sj->si", expected, span), rtol=1e-6, atol=1e-7
    )


def test_jacobians_are_negative_semidefinite() -> None:
    first, second = RANDOM.normal(size=(2, 200, 3))
    rest = RANDOM.uniform(0.1, 4.0, 200)
    for jacobian in (
        stretch_force(first, rest, 2.0)[1],
        shear_force(first, second, 1.0, 0.2)[1],
        strut_force(first, second, 0.5, 2.0)[1],
    ):
        np.testing.assert_array_equal(jacobian, jacobian.transpose(0, 2, 1))
        assert np.linalg.eigvalsh(jacobian).max() <= 1e-12 * np.abs(jacobian).max()  # Rounding of the eigenvalues.


def test_shear_jacobian_is_the_derivative_where_the_sides_are_equal_and_the_angle_is_acute() -> None:
    """The part that the Jacobian leaves out has no component along m if |a| = |b|; the corner moves along m here."""
    first, second = np.array([[1.0, 0.2, 0.0]]), np.array([[1.0, -0.2, 0.0]])

    def force(shift: FloatArray) -> FloatArray:
        # The corner has the weight 1 in m, so that m also moves by the shift.
        return shear_force(first - shift, second - shift, 1.0, 0.2)[0]

    expected = differences(force, np.zeros((1, 3)))
    np.testing.assert_allclose(shear_force(first, second, 1.0, 0.2)[1], expected, rtol=1e-8, atol=1e-9)


def test_the_shear_force_vanishes_at_a_right_angle_and_opens_an_acute_angle() -> None:
    side = np.array([[1.0, 0.0, 0.0]])
    np.testing.assert_array_equal(shear_force(side, np.array([[0.0, 2.0, 0.0]]), 1.0, 0.2)[0], 0.0)
    force = shear_force(side, np.array([[1.0, 1.0, 0.0]]), 1.0, 0.2)[0]
    assert force[0] @ [2.0, 1.0, 0.0] > 0.0  # The corner moves towards its neighbours, so that the angle grows.


def test_the_strut_force_vanishes_on_a_straight_wale_and_pushes_the_ends_of_a_bent_wale_apart() -> None:
    lower = np.array([[0.0, -1.0, 0.0]])
    force, jacobian = strut_force(lower, -lower, 0.5, 2.0)
    np.testing.assert_array_equal(force, 0.0)
    np.testing.assert_array_equal(jacobian, 0.0)
    upper = np.array([[1.0, 0.0, 0.0]])
    force = strut_force(lower, upper, 0.5, 2.0)[0]
    # With |d| = sqrt(2) and r = 2, the force on the lower end is 2 (1 - sqrt(1/2)), away from the upper end.
    np.testing.assert_allclose(force[0], 2.0 * (1.0 - np.sqrt(0.5)) * np.array([-1.0, -1.0, 0.0]) / np.sqrt(2.0))


def test_strut_jacobian_is_the_derivative_along_a_symmetrically_bent_strut() -> None:
    def force(separation: float) -> float:
        reach = 1.0 + 0.5 * separation
        return strut_force(np.array([[-reach, 0.3, 0.0]]), np.array([[reach, 0.3, 0.0]]), 0.5, 2.0)[0][0, 0]

    step = 1e-5
    # The span points from the upper end to the lower end, in the direction -x.
    expected = (force(step) - force(-step)) / (-2 * step)
    jacobian = strut_force(np.array([[-1.0, 0.3, 0.0]]), np.array([[1.0, 0.3, 0.0]]), 0.5, 2.0)[1]
    np.testing.assert_allclose(jacobian[0, 0, 0], expected, rtol=1e-7)


def test_forces_of_vanished_edges_are_finite() -> None:
    spans = np.array([[0.0, 0.0, 0.0], [1e-200, 1e-200, 1e-200]])
    for force, jacobian in (
        stretch_force(spans, np.ones(2), 2.0),
        shear_force(spans, spans, 1.0, 0.2),
        strut_force(spans, spans, 1.0, 2.0),
    ):
        assert np.isfinite(force).all() and np.isfinite(jacobian).all()


def test_forces_and_their_moments_sum_to_zero() -> None:
    fabric = grid_fabric(tube_points(12, 6, 3.0, 4.0), wrap=True)
    model = springs(fabric, RestRectangle(1.0, 0.77))
    position = fabric.vertices + 0.2 * RANDOM.normal(size=fabric.vertices.shape)
    element = element_forces(model, PlacedPoints(position, fabric.vertex_normal))[0]
    gather = assembly(len(position), force_groups(model))
    force = gather.scatter @ (element)
    scale = 1e-12 * np.abs(force).sum()  # Rounding of a sum of some hundred forces.
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=scale)
    # The area forces use projected areas, so that their moments vanish only about the normal of the surface.
    without_areas = replace(model, area_force=False)
    force = gather.scatter @ (element_forces(without_areas, PlacedPoints(position, fabric.vertex_normal))[0])
    np.testing.assert_allclose(np.cross(position, force).sum(axis=0), 0.0, atol=10 * scale)
    assert np.abs(force).max() > 0.1


def test_the_assembled_jacobian_is_the_derivative_of_extended_springs() -> None:
    """All edges are stretched, and springs are the only forces, so that no part of the Jacobian is dropped."""
    fabric = grid_fabric(rectangle_points(3, 3, 6.0, 6.0))
    model = springs(fabric, RestRectangle(1.0, 0.8), area_force=False)
    gather = assembly(len(fabric.vertices), force_groups(model))
    count = len(model.stretch_ends)

    def force(position: FloatArray) -> FloatArray:
        element = element_forces(model, PlacedPoints(position, fabric.vertex_normal))[0]
        element[count:] = 0.0
        return gather.scatter @ (element)

    position = fabric.vertices + 0.05 * RANDOM.normal(size=fabric.vertices.shape)
    jacobian = element_forces(model, PlacedPoints(position, fabric.vertex_normal))[1]
    jacobian[count:] = 0.0
    step = 1e-5
    for vertex in range(len(position)):
        shift = np.zeros_like(position)
        shift[vertex, vertex % 3] = step
        change = np.einsum("em,emi->ei", gather.weights, shift[gather.vertices])
        derivative = gather.scatter @ (np.einsum("eij,ej->ei", jacobian, change)) / step
        expected = (force(position + shift) - force(position - shift)) / (2 * step)
        np.testing.assert_allclose(derivative, expected, atol=1e-8)  # step^2 times third derivatives.


def test_a_1_to_3_increase_has_three_sub_quads_on_its_single_bottom_edge() -> None:
    fabric = increase_fabric()
    quads = fabric.face_vertex[sub_quad_corners(fabric)]
    assert quads[:3].tolist() == [[0, 1, 3, 2], [0, 1, 4, 3], [0, 1, 5, 4]]
    assert len(quads) == 6


def test_struts_follow_wales_and_stop_where_wales_begin() -> None:
    fabric = increase_fabric()
    struts = fabric.face_vertex[wale_strut_corners(fabric)[:, [0, 1, 3]]]
    assert sorted([*sorted([a, c]), b] for a, b, c in struts.tolist()) == [[0, 6, 2], [1, 9, 5]]


def test_unstressed_stitches_cover_the_requested_part_of_the_area() -> None:
    """N counts (b + t) / 2 per face: 2 for the 1-to-3 increase and 3 for the knit stitches, 5 in total."""
    rest = rest_lengths(increase_fabric(), 20.0, aspect=0.8, alpha=0.9)
    assert rest.course * rest.wale * 5.0 == pytest.approx(0.9 * 20.0)
    assert rest.wale / rest.course == pytest.approx(0.8)
