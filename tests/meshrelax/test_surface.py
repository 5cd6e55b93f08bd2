# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mesh import Mesh
from stitchmesh.meshrelax.attachment import attach, border_corners
from stitchmesh.meshrelax.surface.closest_point import ClosestPoint
from stitchmesh.meshrelax.surface.limit_surface import BorderCurve, limit_surface
from tests.gallery import tube
from tests.meshrelax.fabrics import cube, grid_fabric, rectangle_points, rotation, tube_chord_points
from tests.shaking import shaken

pytestmark = pytest.mark.decides

RANDOM = np.random.default_rng(11)


def test_closest_points_agree_with_a_dense_sampling() -> None:
    corners = RANDOM.normal(size=(30, 3, 3))
    points = RANDOM.normal(size=(50, 3))
    triangles = np.arange(90).reshape(30, 3)
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    up = np.tile([0.0, 0.0, 1.0], (50, 1))
    found, weights = ClosestPoint(corners.reshape(-1, 3), triangles, 0.1, "cpu").find(points, up)
    assert (facing[found, 2] > 0.0).all()
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-14)
    assert weights.min() >= 0.0
    distance = np.linalg.norm(np.einsum("nc,nci->ni", weights, corners[found]) - points, axis=1)
    share = np.stack(np.meshgrid(np.linspace(0, 1, 41), np.linspace(0, 1, 41)), axis=-1).reshape(-1, 2)
    share = share[share.sum(axis=1) <= 1.0 + 1e-12]
    share = np.concatenate([share, 1.0 - share.sum(axis=1, keepdims=True)], axis=1)
    samples = np.einsum("sc,tci->tsi", share, corners[facing[:, 2] > 0.0]).reshape(-1, 3)
    sampled = np.linalg.norm(points[:, None] - samples[None], axis=2).min(axis=1)
    assert (distance <= sampled + 1e-12).all()
    # A sample lies within 1/40 of the longest edge of a triangle (about 5) of the closest point.
    assert (sampled - distance < 5.0 / 40.0).all()


def test_a_point_stays_on_its_sheet_even_if_another_sheet_is_closer() -> None:
    """Two sheets are back to back, 0.1 apart; a point belongs to the sheet whose normal agrees with its own."""
    square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    vertices = np.concatenate([square, square - [0.0, 0.0, 0.1]])
    triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]])
    search = ClosestPoint(vertices, triangles, 0.02, "cpu")
    point = np.array([[0.3, 0.4, -0.09]])
    assert search.find(point, np.array([[0.0, 0.0, 1.0]]))[0][0] in (0, 1)
    assert search.find(point, np.array([[0.0, 0.0, -1.0]]))[0][0] in (2, 3)


def test_the_normals_of_a_round_surface_are_radial() -> None:
    surface = limit_surface(cube(), 0.05)
    radial = surface.vertices / np.linalg.norm(surface.vertices, axis=1, keepdims=True)
    # The limit of a cube is similar to a sphere; its normals differ from radial directions by up to about 10 degrees.
    assert np.einsum("vi,vi->v", surface.normals, radial).min() > 0.98


def test_the_border_is_parametrized_by_arc_length() -> None:
    angle = 2.0 * np.pi * np.arange(400) / 400
    circle = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    curve = BorderCurve(circle, 2.0 * circle)
    length = curve.arc[-1]
    for turn in (0.0, 1.0, -3.0):
        point, tangent, curvature = curve.at(np.array([0.25 + turn]) * length)
        # The polygon is within 1 - cos(pi / 400) = 3e-5 of the circle.
        np.testing.assert_allclose(point[0], [0.0, 1.0, 0.0], atol=1e-4)
        np.testing.assert_allclose(tangent[0], [-1.0, 0.0, 0.0], atol=1e-4)
        np.testing.assert_allclose(curvature[0], [0.0, -1.0, 0.0], atol=0.02)  # 2 pi / 400 = 0.016 per segment.
    arc, distance = curve.locate(np.array([[0.0, 2.5, 0.0]]))
    np.testing.assert_allclose(arc / length, 0.25, atol=1e-6)
    np.testing.assert_allclose(distance, 0.5, atol=1e-4)


def test_vertices_are_associated_through_the_input_polygons() -> None:
    """The limit of a 4-sided tube is far inside the tube; the middle of a flat side maps to the middle of the arc."""
    coarse = tube(4, 4, radius=4.0, height=2.0)
    fabric = grid_fabric(_chord_points_of(coarse))
    surface = limit_surface(coarse, 0.2)
    _, placement = attach(fabric, surface, 0.2, "cpu")
    middle = placement.position[fabric.vertices.shape[0] // 2]
    before = fabric.vertices[fabric.vertices.shape[0] // 2]
    assert np.linalg.norm(middle - before) > 0.2
    np.testing.assert_allclose(middle[0] * before[2], middle[2] * before[0], atol=1e-6)


def _chord_points_of(coarse: Mesh) -> np.ndarray:
    """Grid points of a small flat swatch around the middle of one flat side of the 4-sided tube."""
    first, second = coarse.vertices[0], coarse.vertices[1]
    share = np.linspace(0.4, 0.6, 3)[None, :, None]
    line = (1.0 - share) * first + share * second
    return line + np.linspace(3.5, 4.5, 3)[:, None, None] * np.array([0.0, 1.0, 0.0])


def test_a_step_keeps_vertices_on_the_surface_and_border_vertices_on_their_border() -> None:
    slide = 1.7
    points = tube_chord_points(8, 2, np.linspace(0.0, 6.0, 7), 3.0)
    fabric = grid_fabric(points, wrap=True)
    coarse = grid_fabric(tube_chord_points(8, 1, np.linspace(0.0, 6.0, 4), 3.0), wrap=True)
    surface = limit_surface(coarse, 0.15)
    attachment, placement = attach(fabric, surface, 0.2, "cpu")
    around = np.cross([0.0, 0.0, 1.0], placement.normal)
    border = attachment.border >= 0
    around[border] = placement.tangent[border]
    moved = attachment.move(placement, slide * around, 0.5)
    radius = np.linalg.norm(moved.position[:, :2], axis=1)
    # The limit of an octagon of radius 3 is a B-spline within 0.2 % of a circle; its fine edges add their sagitta.
    np.testing.assert_allclose(radius, np.median(radius), rtol=0.01)
    np.testing.assert_allclose(np.sort(moved.position[border, 2]), np.repeat([0.0, 6.0], 16), atol=1e-12)
    length = np.linalg.norm(moved.position - placement.position, axis=1)
    chord = 2.0 * np.median(radius) * np.sin(0.5 * slide / np.median(radius))
    np.testing.assert_allclose(length, chord, rtol=0.05)  # Each part of the step is straight and then projected.


def test_the_corners_of_a_swatch_do_not_move() -> None:
    fabric = grid_fabric(rectangle_points(6, 6, 3.0, 3.0))
    surface = limit_surface(grid_fabric(rectangle_points(2, 2, 3.0, 3.0)), 0.3)
    attachment, placement = attach(fabric, surface, 0.2, "cpu")
    assert np.flatnonzero(attachment.fixed).tolist() == [0, 6, 42, 48]
    projector = attachment.projector(placement, np.zeros_like(placement.position))
    np.testing.assert_array_equal(projector[attachment.fixed], 0.0)
    np.testing.assert_allclose(np.trace(projector, axis1=1, axis2=2)[3], 1.0)  # A border vertex has one direction.
    np.testing.assert_allclose(np.trace(projector, axis1=1, axis2=2)[24], 2.0)  # An inner vertex has a plane.


@pytest.mark.parametrize("push", [1.0, -1.0])
def test_an_inner_vertex_at_the_end_of_the_surface_may_leave_it_only_inwards(push: float) -> None:
    fabric = grid_fabric(rectangle_points(6, 6, 3.0, 3.0))
    surface = limit_surface(grid_fabric(rectangle_points(2, 2, 3.0, 3.0)), 0.3)
    attachment, placement = attach(fabric, surface, 0.2, "cpu")
    inner = 26  # in the middle of the height, a stitch from the border at x = 3
    step = np.zeros_like(placement.position)
    step[inner] = [2.0, 0.1, 0.0]
    pressed = attachment.within().move(placement, step, 0.5)
    np.testing.assert_allclose(pressed.position[inner, 0], 3.0, atol=1e-12)  # the surface ends there
    np.testing.assert_allclose(pressed.outward[inner], [1.0, 0.0, 0.0], atol=1e-12)
    assert not np.delete(pressed.outward, inner, axis=0).any()
    force = np.zeros_like(step)
    force[inner] = [push, 0.0, 0.0]
    allowed = attachment.within().projector(pressed, force)[inner]
    np.testing.assert_allclose(allowed, np.diag([0.0 if push > 0.0 else 1.0, 1.0, 0.0]), atol=1e-12)
    # Without a stop there is a force that moves nothing, and the relaxation cannot converge.
    assert attachment.projector(pressed, force)[inner, 0, 0] == 1.0


def test_closest_points_do_not_depend_on_rounding() -> None:
    """On edges and at vertices, rounding may determine which triangle is found, but not the closest point."""
    fabric = grid_fabric(rectangle_points(4, 4, 2.0, 3.0))
    surface = limit_surface(fabric, 0.3)
    ends = surface.vertices[surface.triangles]
    targets = np.concatenate([ends[:, 0], 0.5 * ends[:, 0] + 0.5 * ends[:, 1], 0.25 * ends[:, 1] + 0.75 * ends[:, 2]])
    facing = np.tile(surface.evaluate(np.zeros(1, int), np.full((1, 3), 1 / 3))[1], (len(targets), 1))
    size = np.abs(ends).max()
    for seed in range(6):
        closest = ClosestPoint(shaken(surface.vertices, seed), surface.triangles, 0.1, "cpu")
        triangle, weights = closest.find(shaken(targets, seed + 50), facing)
        found = np.einsum("nc,nci->ni", weights, ends[triangle])
        # The tolerance is some units in the last place of the centred coordinates.
        np.testing.assert_allclose(found, targets, atol=1e-14 * size)


def test_a_right_angle_of_a_border_is_not_a_corner_for_any_rounding_and_rotation() -> None:
    fabric = grid_fabric(rectangle_points(4, 2, 2.0, 1.0))
    loop = fabric.face_vertex[fabric.boundary_loops[0]]
    inner = np.flatnonzero(np.bincount(fabric.face_vertex)[loop] == 2)[0]
    before, here, after = (fabric.vertices[loop[(inner + k) % len(loop)]] for k in (-1, 0, 1))
    bent = fabric.vertices.copy()
    bent[loop[(inner + 1) % len(loop)]] = here + np.cross([0.0, 0.0, 1.0], here - before) * np.linalg.norm(after - here)
    for seed in range(20):
        assert not border_corners(fabric, shaken(bent @ rotation(seed), seed))[loop[inner]]
