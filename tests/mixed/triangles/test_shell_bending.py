# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bending at hinges: cylinders cost the same on all meshes, plates bend as they should, seams keep their angles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.curvature import hinge_stiffness
from stitchmesh.mixed.triangles.shell_bending import ShellBending
from tests.mixed.cloth.panel_shapes import tube
from tests.mixed.triangles.derivatives import (
    CPU,
    assert_forces_are_minus_the_gradient,
    assert_nothing_acts_on_the_whole,
    assert_products_are_differences_of_forces,
    blocks_of,
    diagonal_of,
    energy_of,
    forces_of,
    hessian_of,
    product_of,
    rotation,
)
from tests.mixed.triangles.flat_cloths import KINDS, FloatArray, disc, flat_cloth, rectangle, with_seam

PLATE = ClothMaterial.isotropic("plate", 1000.0, 0.3, 1.0, 0.02)
KNIT = ClothMaterial("knit", 1000.0, 3000.0, 400.0, 0.3, 5.0, 2.0, 0.02, bending_poisson=0.2, twist=0.7)


def bending(cloth: Cloth, material: ClothMaterial = KNIT, scalar: type = wp.float64, weight=None) -> ShellBending:
    return ShellBending(cloth, material, scalar, CPU, weight)


def moved(cloth: Cloth, size: float = 0.02) -> FloatArray:
    return cloth.vertices + size * np.random.default_rng(0).normal(size=cloth.vertices.shape)


def rolled(cloth: Cloth, curvature: float, degrees: float) -> FloatArray:
    """The cloth on a cylinder, with lengths kept; the curvature runs at that angle to the x axis."""
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    across = np.array([-along[1], along[0]])
    x, y = cloth.vertices[:, :2] @ along, cloth.vertices[:, :2] @ across
    plane = np.outer(np.sin(curvature * x) / curvature, along) + np.outer(y, across)
    return np.column_stack([plane, (1.0 - np.cos(curvature * x)) / curvature])


def inner_triangles(cloth: Cloth, rings: int = 1, outside: float = 1e-12) -> FloatArray:
    """1 for triangles at least that many triangles away from the border, and nearly 0 for the others."""
    outer = np.unique(cloth.triangles[(cloth.twin < 0).reshape(-1, 3).any(axis=1)])
    for _ring in range(rings):
        touched = np.isin(cloth.triangles, outer).any(axis=1)
        outer = np.unique(cloth.triangles[touched])
    return np.where(touched, outside, 1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_a_cylinder_costs_the_same_on_every_mesh_in_every_direction(kind):
    """Half the rigidity times the square of the curvature, per area of the triangles away from the border."""
    cloth = rectangle(kind, 10, 10)
    weight = inner_triangles(cloth)
    term = bending(cloth, PLATE, weight=weight)
    for degrees in (0, 30, 45, 105):
        energy = energy_of(term, rolled(cloth, 0.01, degrees))
        # angles of 0.01 times edges of 0.1: their sines differ by 1e-7, softened shares by 1e-4 (``LEAST_SINGULAR``)
        assert energy == pytest.approx(0.5 * 0.01**2 * (cloth.rest_area @ weight), rel=1e-4), degrees


def test_a_tube_costs_the_same_across_its_seam():
    """A panel rolled up and sewn to itself: half the rigidity times 1 / R^2 per area, but for its two open ends."""
    material = ClothMaterial.isotropic("plate", 1000.0, 0.0, 1.0, 0.02)
    cloth = tube(20.0, 10.0, 0.7)
    energy = energy_of(bending(cloth, material), cloth.vertices)
    # triangles at the ends do not bend along their free sides: a part of their size, 0.7 of 10, times a small number
    assert energy == pytest.approx(0.5 * (2.0 * np.pi / 20.0) ** 2 * 200.0, rel=0.005)


@pytest.mark.parametrize(("degrees", "rigidity"), [(0.0, 5.0), (90.0, 2.0), (45.0, None)])
def test_rolls_along_course_wale_and_between_have_the_rigidities_of_the_material(degrees, rigidity):
    cloth = rectangle("irregular", 10, 10)
    weight = inner_triangles(cloth)
    moduli = KNIT.rigidities()
    expected = 0.25 * (moduli[0, 0] + moduli[1, 1] + 2.0 * moduli[0, 1]) + moduli[2, 2]
    if rigidity is not None:
        expected = rigidity / (1.0 - 0.2**2)  # the strip keeps its width
    energy = energy_of(bending(cloth, weight=weight), rolled(cloth, 0.01, degrees))
    assert energy == pytest.approx(0.5 * expected * 0.01**2 * (cloth.rest_area @ weight), rel=1e-4)


def test_moments_curl_a_cloth_to_the_curvature_that_uses_them_up():
    """Flat, the moments are those of the material; rolled up by the moments over the rigidities there is no energy."""
    cloth, curvature = rectangle("irregular", 10, 10), 0.01
    course, wale, _twist = KNIT.rigidities() @ [curvature, 0.0, 0.0]
    curled = replace(KNIT, moment_course=course, moment_wale=wale)
    weight = inner_triangles(cloth)
    flat, other = (energy_of(bending(cloth, curled, weight=weight), rolled(cloth, k, 0.0)) for k in (1e-9, -curvature))
    rest = energy_of(bending(cloth, curled, weight=weight), rolled(cloth, curvature, 0.0))
    # half the moment times the curvature; angles of 0.01 times edges of 0.1, and softened shares, as above
    assert flat == pytest.approx(0.5 * course * curvature * (cloth.rest_area @ weight), rel=1e-4)
    assert other == pytest.approx(4.0 * flat, rel=1e-4)
    assert rest < 1e-6 * flat


def test_panels_bend_as_one_cloth_across_their_seam():
    """Each panel has its own coordinates; the rest shapes meet at the edges of the seam."""
    cloth = rectangle("irregular", 8, 8)
    right = cloth.vertices[cloth.triangles].mean(axis=1)[:, 0] > 0.5
    angle = 0.7
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    rest = np.where(right[:, None, None], cloth.rest @ turn + [7.0, -3.0], cloth.rest)
    panels = replace(cloth, rest=rest, panel=right.astype(int), panel_names=("left", "right"))
    vertices = moved(cloth)
    one, two = bending(cloth, PLATE), bending(panels, PLATE)
    assert energy_of(two, vertices) == pytest.approx(energy_of(one, vertices), rel=1e-10)  # rounding of turned shapes


@pytest.mark.parametrize(("lift", "sign"), [(-0.4, 1.0), (0.4, -1.0)])
def test_the_energy_is_smallest_at_the_rest_angle(lift, sign):
    """A ridge seen from outside has a positive angle."""
    cloth = flat_cloth([[0, 0], [1, 0], [0.5, 1], [0.5, -1]], [[0, 1, 2], [1, 0, 3]])
    vertices = cloth.vertices.copy()
    vertices[2:, 2] = lift
    term = bending(with_seam(cloth, [[0, 1]], sign * 2.0 * np.arctan(0.4)))
    assert energy_of(term, vertices) < 1e-28 and np.abs(forces_of(term, vertices)).max() < 1e-13  # rounding
    flat, mirrored = energy_of(term, cloth.vertices), energy_of(term, vertices * [1.0, 1.0, -1.0])
    assert flat > 0.1 and mirrored == pytest.approx(4.0 * flat, rel=1e-12)  # twice the deflection


def test_derivatives():
    cloth = rectangle("irregular", 4, 3)
    term, vertices = bending(cloth), moved(cloth)
    assert_forces_are_minus_the_gradient(term, vertices)
    assert_products_are_differences_of_forces(term, vertices)
    assert_nothing_acts_on_the_whole(term, vertices)
    exact, least = hessian_of(term, vertices), hessian_of(term, vertices, 0.0)
    scale = np.abs(exact).max()
    for matrix in (exact, least):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * scale)  # rounding
    np.testing.assert_allclose(blocks_of(term, vertices, 0.0), diagonal_of(least), atol=1e-12 * scale)
    assert np.linalg.eigvalsh(exact)[0] < -1e-3 * scale
    assert np.linalg.eigvalsh(least)[0] > -1e-12 * scale
    np.testing.assert_allclose(hessian_of(term, cloth.vertices), hessian_of(term, cloth.vertices, 0.0))  # no moments


def test_a_rigid_motion_costs_nothing():
    cloth = rectangle("irregular", 5, 4)
    term = bending(cloth)
    vertices = cloth.vertices @ rotation() + [3.0, -7.0, 20.0]
    # angles of rounding: coordinates of 20 over heights of 0.05
    assert energy_of(term, vertices) < 1e3 * (400.0 * 2e-16) ** 2 * 100.0
    assert np.abs(forces_of(term, vertices)).max() < 1e3 * 400.0 * 2e-16 * 20.0


def test_the_matrix_between_hinges_is_never_negative_and_only_flat_cloth_is_free():
    for cloth in (rectangle("irregular", 6, 5), disc(3, 1.0)):
        rigidities = np.broadcast_to(KNIT.rigidities(), (len(cloth.triangles), 3, 3))
        matrix = hinge_stiffness(cloth, rigidities, np.ones(len(cloth.triangles))).toarray()
        eigenvalues = np.linalg.eigvalsh(matrix)
        assert np.abs(matrix - matrix.T).max() < 1e-12 * eigenvalues[-1]  # rounding
        assert eigenvalues[0] > 1e-3 * eigenvalues[-1]  # rows of a corner triangle with one hinge are the softest


def heights_matrix(kind: str, count: int) -> tuple[Cloth, FloatArray]:
    """Second derivatives of the energy by the heights of the vertices of a flat square, or of a disc."""
    cloth = disc(count, count / (count - 0.5)) if kind == "disc" else rectangle(kind, count, count)
    term, directions = bending(cloth, PLATE), np.zeros((len(cloth.vertices), len(cloth.vertices), 3))
    directions[np.arange(len(directions)), np.arange(len(directions)), 2] = 1.0
    return cloth, np.array([product_of(term, cloth.vertices, each)[:, 2] for each in directions])


def deflection(cloth: Cloth, matrix: FloatArray, free: np.ndarray) -> float:
    """Largest height under a load of one per area."""
    load = np.bincount(cloth.triangles.ravel(), np.repeat(cloth.rest_area / 3.0, 3))
    return float(np.abs(np.linalg.solve(matrix[np.ix_(free, free)], load[free])).max())


def test_a_simply_supported_square_plate():
    """0.00406235 q a^4 / D in the middle. Between supported sides the Poisson ratio has no effect."""
    errors = []
    for count in (8, 16):
        cloth, matrix = heights_matrix("irregular", count)
        free = ((cloth.vertices[:, :2] > 1e-9) & (cloth.vertices[:, :2] < 1.0 - 1e-9)).all(axis=1)
        errors.append(abs(deflection(cloth, matrix, free) / 0.00406235 - 1.0))
    # the Morley element has errors of h^2 in the heights, so that a refinement divides them by 4
    assert errors[0] < 0.03 and errors[1] < errors[0] / 3.3


def test_a_clamped_disc():
    """q a^4 / 64 D in the middle; the edge lies half-way between two rings of vertices that are held."""
    errors = []
    for count in (5, 10):
        cloth, matrix = heights_matrix("disc", count)
        free = np.linalg.norm(cloth.vertices, axis=1) < (count - 1.25) / (count - 0.5)
        errors.append(abs(deflection(cloth, matrix, free) * 64.0 - 1.0))
    # the height at the edge is zero to the second order, as the height where a parabola is cut by its chord
    assert errors[0] < 0.05 and errors[1] < errors[0] / 2.5


def test_the_energy_is_linear_in_the_blending_weights():
    cloth = rectangle("irregular", 4, 4)
    vertices, count = moved(cloth), len(cloth.triangles)
    one, other = np.random.default_rng(4).uniform(0.1, 0.5, size=(2, count))
    energies = [energy_of(bending(cloth, weight=weight), vertices) for weight in (one, other, one + other)]
    assert energies[2] == pytest.approx(energies[0] + energies[1], rel=1e-12)
    assert energy_of(bending(cloth, weight=np.zeros(count)), vertices) == 0.0


def test_triangles_without_weight_are_not_read_and_the_cloth_goes_on_behind_them():
    """Where yarns alone carry the cloth, the vertices of the triangles are not unknowns and have no definite place."""
    cloth = rectangle("irregular", 10, 10)
    weight = inner_triangles(cloth, outside=0.0)
    vertices = rolled(cloth, 0.01, 30.0)
    unread = ~np.isin(np.arange(len(vertices)), cloth.triangles[weight > 0.0])
    vertices[unread] += np.random.default_rng(5).normal(size=(int(unread.sum()), 3))
    term = bending(cloth, PLATE, weight=weight)
    # slopes at the end follow from six angles, of which some corners have fewer
    assert energy_of(term, vertices) == pytest.approx(0.5 * 0.01**2 * (cloth.rest_area @ weight), rel=0.01)
    assert not forces_of(term, vertices)[unread].any()
    assert not product_of(term, vertices, vertices)[unread].any()


def test_single_precision_agrees_with_double_precision():
    cloth = rectangle("irregular", 6, 6)
    vertices = moved(cloth) @ rotation() + [5.0, 2.0, 1.0]
    expected = forces_of(bending(cloth), vertices)
    found = forces_of(bending(cloth, scalar=wp.float32), vertices, wp.float32)
    # coordinates of 5 with 6e-8 over heights of 0.05
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, 1, 0]],  # folded flat: theta = pi
        [[0, 0, 0], [1, 0, 0], [0.5, 0, 0], [0.5, -1, 0]],  # a triangle without area
        [[0, 0, 0], [0, 0, 0], [0.5, 1, 0], [0.5, -1, 0]],  # an edge without length
        [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0.5, -1, 1e-6], [0.5, 1, 0]],  # turned over
    ],
)
def test_folded_and_collapsed_hinges_stay_finite(corners):
    """In single precision, which overflows first."""
    cloth = flat_cloth([[0, 0], [1, 0], [0.5, 1], [0.5, -1]], [[0, 1, 2], [1, 0, 3]])
    term, vertices = bending(cloth, scalar=wp.float32), np.array(corners, dtype=float)
    assert np.isfinite(energy_of(term, vertices, wp.float32))
    assert np.isfinite(forces_of(term, vertices, wp.float32)).all()
    direction = np.random.default_rng(0).normal(size=(4, 3))
    assert np.isfinite(product_of(term, vertices, direction, 1.0, wp.float32)).all()


def test_slivers_and_conics_have_finite_stiffness():
    """Narrow triangles, and eight vertices on one circle, where five angles do not show one curvature."""
    sliver = flat_cloth([[0, 0], [1, 0], [0.5, 1e-4], [0.5, -1e-4], [0.2, 1]], [[0, 1, 2], [1, 0, 3], [0, 2, 4]])
    angle = np.arange(8) * np.pi / 4.0
    fan = flat_cloth(np.column_stack([np.cos(angle), np.sin(angle)]), [[0, k, k + 1] for k in range(1, 7)])
    for cloth in (sliver, fan):
        rigidities = np.broadcast_to(KNIT.rigidities(), (len(cloth.triangles), 3, 3))
        matrix = hinge_stiffness(cloth, rigidities, np.ones(len(cloth.triangles))).toarray()
        assert np.isfinite(matrix).all() and np.linalg.eigvalsh(matrix)[0] > -1e-12 * np.abs(matrix).max()


def test_a_single_triangle_does_not_bend():
    cloth = flat_cloth([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]])
    term = bending(cloth)
    assert energy_of(term, cloth.vertices) == 0.0 and not forces_of(term, cloth.vertices).any()
