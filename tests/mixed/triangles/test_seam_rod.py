# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rods along seams: stretch, bending and their rest shape."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.triangles.seam_rod import SeamMaterial, SeamRod, rest_lengths
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
)
from tests.mixed.triangles.flat_cloths import FloatArray, disc, rectangle, with_seam

COUNT = 12
STRETCHY, BENDY = SeamMaterial(500.0, 0.0), SeamMaterial(0.0, 3.0)
BOTH = SeamMaterial(500.0, 3.0, density=0.002)


def rod(cloth: Cloth, material: SeamMaterial = BOTH, weight=None) -> SeamRod:
    return SeamRod(cloth, material, wp.float64, CPU, weight)


def straight_seam() -> Cloth:
    """A square with a seam along its middle line x = 1/2."""
    cloth = rectangle("diagonals", 2, COUNT)
    middle = np.arange(COUNT + 1) * 3 + 1
    return with_seam(cloth, np.column_stack([middle[:-1], middle[1:]]))


def round_seam(rings: int = 3, ring: int = 2) -> Cloth:
    """A disc of radius 1 with a closed seam along one of its rings."""
    cloth = disc(rings, 1.0)
    radius = np.linalg.norm(cloth.vertices, axis=1)
    loop = np.flatnonzero(np.abs(radius - ring / rings) < 1e-9)
    loop = loop[np.argsort(np.arctan2(*cloth.vertices[loop, 1::-1].T))]
    return with_seam(cloth, np.column_stack([loop, np.roll(loop, -1)]))


def moved(cloth: Cloth, size: float = 0.03) -> FloatArray:
    return cloth.vertices + size * np.random.default_rng(0).normal(size=cloth.vertices.shape)


def test_uniform_stretch_costs_half_the_stiffness_times_the_square_of_the_strain():
    cloth = straight_seam()
    energy = energy_of(rod(cloth, STRETCHY), cloth.vertices * [1.0, 1.2, 1.0])
    assert energy == pytest.approx(0.5 * 500.0 * 0.2**2, rel=1e-12)  # per length, of a seam of length 1


def test_an_arc_costs_half_the_stiffness_times_the_square_of_the_curvature():
    cloth = straight_seam()
    angle = cloth.vertices[:, 1] * 2.0
    bent = np.column_stack([cloth.vertices[:, 0], np.sin(angle) / 2.0, np.cos(angle) / 2.0])
    # eleven of twelve edges' lengths lie around a vertex between two edges
    assert energy_of(rod(cloth, BENDY), bent) == pytest.approx(0.5 * 3.0 * 4.0 * (COUNT - 1) / COUNT, rel=1e-12)


def test_the_seam_of_a_flat_cloth_is_at_rest_even_where_it_is_curved():
    for cloth in (straight_seam(), round_seam()):
        term = rod(cloth)
        assert energy_of(term, cloth.vertices) < 1e-25  # rounding
        assert np.abs(forces_of(term, cloth.vertices)).max() < 1e-11


def test_a_closed_seam_has_an_angle_at_each_vertex():
    """A ring of radius 2/3 that is bent to the double radius has the energy B (1/R - 1/R_0)^2 / 2 per length."""
    cloth = round_seam(12, 8)
    stretched = rod(cloth, BENDY)
    opened = cloth.vertices.copy()
    loop = cloth.seam_edges[:, 0]
    angle = np.arange(len(loop)) * 2.0 * np.pi / len(loop) / 2.0
    opened[loop] = (4.0 / 3.0) * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    length = rest_lengths(cloth).sum()
    open_part = energy_of(stretched, opened) - corner_energy(cloth, opened)
    # the part of the two corners where the half ring is closed by a chord is left out; smoothing adds 1 percent
    assert open_part == pytest.approx(0.5 * 3.0 * 0.75**2 * length * (1.0 - 2.0 / len(loop)), rel=0.02)


def corner_energy(cloth: Cloth, vertices: FloatArray) -> float:
    """The energy of the two angles at the ends of the closing edge."""
    weight = np.zeros(len(cloth.seam_edges))
    weight[[-2, -1, 0]] = 1.0  # an angle has the smaller weight of its two edges
    return energy_of(rod(cloth, BENDY, weight=weight), vertices)


@pytest.mark.parametrize("make", [straight_seam, round_seam])
def test_derivatives(make):
    cloth = make()
    term, vertices = rod(cloth), moved(cloth)
    assert_forces_are_minus_the_gradient(term, vertices)
    assert_products_are_differences_of_forces(term, vertices)
    assert_nothing_acts_on_the_whole(term, vertices)
    exact, least = hessian_of(term, vertices), hessian_of(term, vertices, 0.0)
    scale = np.abs(exact).max()
    for matrix, part in ((exact, 1.0), (least, 0.0)):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * scale)  # rounding
        np.testing.assert_allclose(blocks_of(term, vertices, part), diagonal_of(matrix), atol=1e-12 * scale)
    assert np.linalg.eigvalsh(exact)[0] < -1e-3 * scale
    assert np.linalg.eigvalsh(least)[0] > -1e-12 * scale


@pytest.mark.parametrize("turning", [1e-9, 0.0999, 0.1001, 2.0])
def test_small_and_large_angles_join_smoothly(turning):
    """Forces of one angle are B angle over the mean length and over each length, for all angles."""
    cloth = rectangle("diagonals", 2, 2)
    cloth = with_seam(cloth, [[1, 4], [4, 7]])
    vertices = cloth.vertices.copy()
    vertices[7] = vertices[4] + 0.5 * np.array([0.0, np.cos(turning), np.sin(turning)])
    force = forces_of(rod(cloth, BENDY), vertices)
    # a series up to the second power of 0.1, whose next term is 0.1^4 / 50
    assert np.linalg.norm(force[7]) == pytest.approx(3.0 * turning / 0.5 / 0.5, rel=3e-6)


def test_edges_without_weight_are_not_read():
    cloth = straight_seam()
    weight = np.ones(COUNT)
    weight[4:7] = 0.0
    vertices = moved(cloth)
    unread = cloth.seam_edges[5]
    before = energy_of(rod(cloth, weight=weight), vertices)
    vertices[unread] += 10.0
    assert energy_of(rod(cloth, weight=weight), vertices) == before
    assert not forces_of(rod(cloth, weight=weight), vertices)[unread].any()


def test_the_rest_length_is_the_mean_of_both_panels():
    cloth = straight_seam()
    left = cloth.rest.copy()
    left[cloth.seam_sides[:, 0] // 3] *= 1.2
    puckered = Cloth(
        vertices=cloth.vertices, triangles=cloth.triangles, rest=left, panel=cloth.panel, panel_names=cloth.panel_names,
        seam_edges=cloth.seam_edges, seam_start=cloth.seam_start, seam_angle=cloth.seam_angle,
    )  # fmt: skip
    np.testing.assert_allclose(rest_lengths(puckered), 1.1 / COUNT)


@pytest.mark.parametrize("last", [[0.5, 0.0, 0.0], [0.5, 0.5, 0.0]])
def test_folded_back_and_collapsed_rods_stay_finite(last):
    cloth = with_seam(rectangle("diagonals", 2, 2), [[1, 4], [4, 7]])
    vertices = cloth.vertices.copy()
    vertices[7] = last
    term = rod(cloth)
    assert np.isfinite(energy_of(term, vertices))
    assert np.isfinite(forces_of(term, vertices)).all()
    direction = np.random.default_rng(0).normal(size=vertices.shape)
    for part in (0.0, 1.0):
        assert np.isfinite(product_of(term, vertices, direction, part)).all()


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ((-1.0, 0.0), "stretch is -1.0; expected a number that is not negative"),
        ((1.0, np.nan), "bending is nan; expected a number that is not negative"),
        ((0.0, 0.0), "stretch and bending are 0; expected one of them"),
    ],
)
def test_wrong_materials_are_refused(numbers, message):
    with pytest.raises(ParameterError, match=message):
        SeamMaterial(*numbers)
