# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stretch and shear of triangles: Saint Venant-Kirchhoff elasticity in plane stress, orthotropic or by tables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scipy.optimize import brentq

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.membrane import Membrane
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
    rotation,
)
from tests.mixed.triangles.flat_cloths import FloatArray, flat_cloth, rectangle

ISOTROPIC = ClothMaterial.isotropic("isotropic", 1000.0, 0.3, 1.0, 0.02)
KNIT = ClothMaterial("knit", 1000.0, 3000.0, 400.0, 0.4, 5.0, 2.0, 0.02)
TABLE = ((-0.2, -100.0), (0.0, 0.0), (0.1, 90.0), (0.2, 250.0), (0.3, 700.0))
JAMMING = ((0.0, 0.0), (0.2, 50.0), (0.4, 300.0))
STIFFENING = ClothMaterial(
    "stiffening", 1000.0, 3000.0, 400.0, 0.2, 5.0, 2.0, 0.02, tension_course=TABLE, shear_table=JAMMING
)
COUPLING = ((-0.3, -40.0), (0.0, 0.0), (0.1, 20.0), (0.5, 300.0))
COUPLED = replace(STIFFENING, name="coupled", coupling_table=COUPLING)


def membrane(cloth, material: ClothMaterial, scalar: type = wp.float64, weight=None) -> Membrane:
    return Membrane(cloth, material, scalar, CPU, weight)


def moved(cloth, size: float = 0.03) -> FloatArray:
    """Vertices away from rest in all directions."""
    return cloth.vertices + size * np.random.default_rng(0).normal(size=cloth.vertices.shape)


def tension_of_free_strip(material: ClothMaterial, stretch: float, angle: float) -> tuple[float, float]:
    """Tension per rest width of a square that is pulled along x and free along y, and its lateral stretch."""
    cloth = flat_cloth([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]], angle)
    term = membrane(cloth, material)

    def forces(lateral: float) -> FloatArray:
        return forces_of(term, cloth.vertices * [stretch, lateral, 1.0])

    lateral = brentq(lambda y: forces(y)[2:, 1].sum(), 0.5, 1.5, xtol=1e-14)
    return -forces(lateral)[1:3, 0].sum(), lateral


def test_plane_stress_of_an_isotropic_strip():
    """P = Y lambda (lambda^2 - 1) / 2, and the sides contract to (1 - nu (lambda^2 - 1))^(1/2)."""
    found = tension_of_free_strip(ISOTROPIC, 1.2, 0.7)  # whatever the axes of the panel
    assert found[0] / 1000.0 == pytest.approx(0.264, rel=1e-12)
    assert found[1] == pytest.approx((1.0 - 0.3 * 0.44) ** 0.5, rel=1e-12)


@pytest.mark.parametrize(
    ("angle", "modulus", "ratio"), [(0.0, 1000.0, 0.4 * 3.0**-0.5), (-np.pi / 2, 3000.0, 0.4 * 3.0**0.5)]
)
def test_orthotropic_strips_along_course_and_wale(angle, modulus, ratio):
    tension, lateral = tension_of_free_strip(KNIT, 1.15, angle)
    strain = (1.15**2 - 1.0) / 2.0
    assert tension == pytest.approx(1.15 * modulus * strain, rel=1e-12)
    assert lateral == pytest.approx((1.0 - 2.0 * ratio * strain) ** 0.5, rel=1e-12)


def test_pure_shear_strain_costs_half_the_shear_modulus_times_its_square():
    cloth = rectangle("irregular", 4, 3)
    shear = np.array([[1.0, 0.0, 0.0], [0.3, (1.0 - 0.09) ** 0.5, 0.0], [0.0, 0.0, 1.0]])  # columns stay unit vectors
    assert energy_of(membrane(cloth, KNIT), cloth.vertices @ shear) == pytest.approx(0.5 * 400.0 * 0.09, rel=1e-12)


@pytest.mark.parametrize("material", [STIFFENING, COUPLED], ids=lambda material: material.name)
def test_a_strip_of_constant_width_has_the_tensions_of_its_table(material):
    cloth = rectangle("diagonals", 2, 2)
    for strain, tension in TABLE:
        force = forces_of(membrane(cloth, material), cloth.vertices * [1.0 + strain, 1.0, 1.0])
        found = -force[cloth.vertices[:, 0] == 1.0, 0].sum()
        assert found == pytest.approx(tension, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("axis", [0, 1])
def test_the_coupling_adds_the_stress_of_its_table_across_the_axis_that_is_stretched(axis):
    cloth = rectangle("diagonals", 2, 2)
    side = cloth.vertices[:, 1 - axis] == 1.0
    uncoupled = replace(COUPLED, coupling_table=(), poisson=0.0)
    for strain, stress in COUPLING:
        stretched = cloth.vertices.copy()
        stretched[:, axis] *= np.sqrt(1.0 + 2.0 * strain)
        force, alone = (forces_of(membrane(cloth, one), stretched) for one in (COUPLED, uncoupled))
        assert -(force - alone)[side, 1 - axis].sum() == pytest.approx(stress, rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_yarns_that_turn_towards_each_other_have_the_stress_of_their_table(sign):
    """Along the sides y = 0 and y = 1 of a square whose sides keep their lengths, the stress pulls along x."""
    cloth = rectangle("diagonals", 2, 2)
    for strain, stress in JAMMING:
        sheared = cloth.vertices @ [[1.0, 0.0, 0.0], [sign * strain, (1.0 - strain**2) ** 0.5, 0.0], [0.0, 0.0, 1.0]]
        force = forces_of(membrane(cloth, STIFFENING), sheared)[cloth.vertices[:, 1] == 1.0].sum(axis=0)
        np.testing.assert_allclose(force, [-sign * stress, 0.0, 0.0], atol=1e-10)  # rounding of 3000


@pytest.mark.parametrize("material", [KNIT, COUPLED], ids=lambda material: material.name)
def test_derivatives(material):
    cloth = rectangle("irregular", 5, 4)
    term, vertices = membrane(cloth, material), moved(cloth)
    assert_forces_are_minus_the_gradient(term, vertices)
    assert_products_are_differences_of_forces(term, vertices)
    assert_nothing_acts_on_the_whole(term, vertices)
    exact, least = hessian_of(term, vertices), hessian_of(term, vertices, 0.0)
    for matrix, part in ((exact, 1.0), (least, 0.0)):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())  # rounding
        np.testing.assert_allclose(blocks_of(term, vertices, part), diagonal_of(matrix), atol=1e-9)


def test_shares_along_course_and_wale():
    """They scale the energies along their axes, the smaller one that of both axes; derivatives follow."""
    cloth = rectangle("irregular", 4, 3)
    count, vertices = len(cloth.triangles), moved(cloth)
    shares = np.random.default_rng(6).uniform(0.2, 2.0, (count, 2))
    term = Membrane(cloth, COUPLED, wp.float64, CPU, shares=shares)
    assert_forces_are_minus_the_gradient(term, vertices)
    assert_products_are_differences_of_forces(term, vertices)
    assert np.linalg.eigvalsh(hessian_of(term, cloth.vertices))[0] > -1e-9  # rounding of stiffnesses of 3,000 dyn/cm
    stretched = cloth.vertices * [1.1, 1.0, 1.0]
    alone = [energy_of(membrane(cloth, COUPLED, weight=np.arange(count) == t), stretched) for t in range(count)]
    wider = np.column_stack([shares[:, 0], shares[:, 0]])
    found = energy_of(Membrane(cloth, COUPLED, wp.float64, CPU, shares=wider), stretched)
    assert found == pytest.approx(shares[:, 0] @ alone, rel=1e-12)  # rounding of sums


def test_the_hessian_that_is_never_negative():
    """It has no negative eigenvalue in any state; without compression it is the exact one."""
    cloth = rectangle("irregular", 4, 3)
    term = membrane(cloth, KNIT)
    for vertices in (moved(cloth, 0.1), 0.5 * moved(cloth), cloth.vertices * [1.0, -1.0, 1.0]):
        eigenvalues = np.linalg.eigvalsh(hessian_of(term, vertices, 0.0))
        assert eigenvalues[0] > -1e-12 * eigenvalues[-1]  # rounding of a symmetric matrix
    assert np.linalg.eigvalsh(hessian_of(term, 0.5 * cloth.vertices))[0] < -100.0
    stretched = 1.1 * cloth.vertices
    difference = hessian_of(term, stretched) - hessian_of(term, stretched, 0.0)
    assert np.abs(difference).max() == 0.0


def test_a_rigid_motion_costs_nothing():
    cloth = rectangle("equilateral", 5, 4)
    vertices = cloth.vertices @ rotation() + [3.0, -7.0, 20.0]
    term = membrane(cloth, KNIT)
    # strains of rounding: coordinates of 20 over edges of 0.2, squared in the energy
    assert energy_of(term, vertices) < 3000.0 * (1e-16 * 100.0) ** 2 * 1e3
    assert np.abs(forces_of(term, vertices)).max() < 3000.0 * 1e-13


def test_single_precision_agrees_with_double_precision():
    cloth = rectangle("irregular", 6, 6)
    vertices = moved(cloth) @ rotation() + [5.0, 2.0, 1.0]
    single, double = membrane(cloth, STIFFENING, wp.float32), membrane(cloth, STIFFENING)
    expected = forces_of(double, vertices)
    # coordinates of 5 with 6e-8 over edges of about 0.1, times moduli of 3000 over strains of 0.3
    np.testing.assert_allclose(forces_of(single, vertices, wp.float32), expected, atol=2e-4 * np.abs(expected).max())
    assert energy_of(single, vertices, wp.float32) == pytest.approx(energy_of(double, vertices), rel=1e-4)


def test_collapsed_inverted_and_huge_triangles_stay_finite():
    """In single precision, which overflows first."""
    cloth = flat_cloth([[0, 0], [1, 0], [0.5, 1e-4], [0.2, 1.0]], [[0, 1, 2], [0, 2, 3]])  # a sliver and a triangle
    term = membrane(cloth, KNIT, wp.float32)
    for scale in ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, -1.0, 1.0), (1e4, 1e4, 1.0)):
        assert np.isfinite(energy_of(term, cloth.vertices * scale, wp.float32)), scale
        assert np.isfinite(forces_of(term, cloth.vertices * scale, wp.float32)).all(), scale


@pytest.mark.parametrize(
    ("weight", "message"),
    [([1.0], r"got shape \(1,\); expected \(2,\)"), ([1.0, 1.5], "element 1 has 1.5; expected 0 to 1")],
)
def test_wrong_weights_are_refused(weight, message):
    with pytest.raises(ParameterError, match=message):
        membrane(rectangle("diagonals", 1, 1), KNIT, weight=weight)
