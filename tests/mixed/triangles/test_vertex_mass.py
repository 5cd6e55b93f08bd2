# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Masses of vertices, and their weight."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.seam_rod import rest_lengths
from stitchmesh.mixed.triangles.vertex_mass import rod_masses, triangle_masses
from stitchmesh.mixed.triangles.vertex_weight import VertexWeight
from tests.mixed.triangles.derivatives import (
    CPU,
    assert_forces_are_minus_the_gradient,
    energy_of,
    forces_of,
    hessian_of,
)
from tests.mixed.triangles.flat_cloths import rectangle, with_seam

KNIT = ClothMaterial("knit", 1000.0, 3000.0, 400.0, 0.4, 5.0, 2.0, 0.02)


def test_the_masses_are_those_of_the_areas_and_have_their_centre():
    cloth = rectangle("irregular", 6, 5, 3.0, 2.0)
    mass = triangle_masses(cloth, KNIT)
    assert mass.sum() == pytest.approx(0.02 * 6.0) and mass.min() > 0.0
    np.testing.assert_allclose(mass @ cloth.vertices / mass.sum(), [1.5, 1.0, 0.0], atol=1e-12)


def test_blending_weights_scale_the_masses():
    cloth = rectangle("diagonals", 2, 2)
    mass = triangle_masses(cloth, [KNIT], np.arange(8) < 1)
    np.testing.assert_allclose(mass[cloth.triangles[0]], 0.02 * cloth.rest_area[0] / 3.0)
    assert mass.sum() == pytest.approx(0.02 * cloth.rest_area[0])


def test_a_rod_has_half_of_the_mass_of_each_edge_at_its_ends():
    cloth = with_seam(rectangle("diagonals", 2, 2, 1.0, 3.0), [[1, 4], [4, 7]])
    np.testing.assert_allclose(rod_masses(cloth, 0.2, rest_lengths(cloth))[[1, 4, 7, 0]], [0.15, 0.3, 0.15, 0.0])


@pytest.mark.parametrize("scalar", [wp.float32, wp.float64])
def test_weight_is_a_dead_load(scalar):
    cloth = rectangle("diagonals", 3, 3)
    term = VertexWeight(triangle_masses(cloth, KNIT), scalar, CPU, (0.0, 3.0, -981.0))
    force = forces_of(term, cloth.vertices, scalar)
    np.testing.assert_allclose(force.sum(axis=0), 0.02 * np.array([0.0, 3.0, -981.0]), rtol=1e-6)  # single precision
    raised = cloth.vertices + np.array([0.0, 0.0, 2.0])
    work = energy_of(term, raised, scalar) - energy_of(term, cloth.vertices, scalar)
    assert work == pytest.approx(0.02 * 981.0 * 2.0, rel=1e-6)
    assert not hessian_of(VertexWeight(np.ones(4), wp.float64, CPU), np.zeros((4, 3))).any()


def test_the_force_is_minus_the_gradient():
    cloth = rectangle("irregular", 3, 3)
    term = VertexWeight(triangle_masses(cloth, KNIT), wp.float64, CPU)
    assert_forces_are_minus_the_gradient(term, cloth.vertices)


@pytest.mark.parametrize(
    ("mass", "acceleration", "message"),
    [
        ([1.0, -1.0], (0.0, 0.0, 0.0), "vertex 1 has -1 g; expected one mass of at least 0"),
        ([[1.0]], (0.0, 0.0, 0.0), r"got shape \(1, 1\); expected one mass of at least 0"),
        ([1.0], (0.0, np.nan, 0.0), "expected three finite numbers"),
    ],
)
def test_wrong_masses_are_refused(mass, acceleration, message):
    with pytest.raises(ParameterError, match=message):
        VertexWeight(mass, wp.float64, CPU, acceleration)
