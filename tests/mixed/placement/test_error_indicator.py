# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Strain and curvature of triangles, and the error that they indicate, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.placement.error_indicator import deformation_of, indicate_errors
from tests.mixed.placement.sheets import WEAVE, sheet

SHEET = sheet(4)
CLOTH = SHEET.cloth


def stretched(gradient: list[list[float]]) -> np.ndarray:
    return np.column_stack([CLOTH.vertices[:, :2] @ np.array(gradient).T, np.zeros(len(CLOTH.vertices))])


def test_the_strain_of_an_affine_motion_is_exact_and_ignores_rotations() -> None:
    gradient = np.array([[1.1, 0.2], [0.0, 0.9]])
    expected = (gradient.T @ gradient - np.eye(2)) / 2.0
    angle = 0.7
    turn = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])
    found = deformation_of(CLOTH, stretched(gradient) @ turn.T)
    assert np.abs(found.strain - expected).max() < 1e-14  # rounding
    assert np.abs(found.curvature).max() < 1e-12  # rounding, over the size of a triangle


def test_a_roll_has_its_curvature_on_inner_triangles() -> None:
    fine, direction = sheet(16), 0.6
    found = deformation_of(fine.cloth, fine.rolled(0.4, direction)).curvature
    along = np.array([np.cos(direction), np.sin(direction)])
    inner = (np.abs(fine.cloth.rest.mean(axis=1) - 0.5) < 0.4).all(axis=1)
    # chords instead of arcs: (kappa h)^2 = 6e-4
    assert np.abs(found[inner] - 0.4 * np.outer(along, along)).max() < 2e-3


def test_tension_is_no_error_of_wrinkles() -> None:
    indicator = indicate_errors(CLOTH, stretched([[1.1, 0.0], [0.0, 1.05]]), WEAVE)
    assert np.array_equal(indicator.wrinkles, np.zeros(32))


def test_compression_beyond_buckling_is_the_energy_that_wrinkles_release() -> None:
    indicator = indicate_errors(CLOTH, stretched([[0.9, 0.0], [0.0, 1.0]]), WEAVE)
    modulus, compression = WEAVE.stretch_course, (1.0 - 0.9**2) / 2.0
    buckling = WEAVE.bending_course * (np.pi / 0.25) ** 2 / modulus
    expected = 0.5 * modulus * (compression - buckling) ** 2 * 0.5 * 0.25**2
    assert np.allclose(indicator.wrinkles, expected, rtol=1e-10)  # rounding


def test_a_curve_costs_what_its_chords_cost() -> None:
    fine, curvature = sheet(16), 0.8
    indicator = indicate_errors(fine.cloth, fine.rolled(curvature), WEAVE)
    turn = (curvature / 16.0) ** 2
    density = 0.5 * WEAVE.stretch_course * (turn / 24.0) ** 2 + 0.5 * WEAVE.bending_course * curvature**2 * turn / 12.0
    inner = (np.abs(fine.cloth.rest.mean(axis=1) - 0.5) < 0.4).all(axis=1)
    # the curvature of the polygon differs from that of the arc by (kappa h)^2 / 24 = 1e-4, which enters up to 4 times
    assert np.allclose(indicator.curves[inner], density * 0.5 / 256.0, rtol=1e-2)


def test_uniform_strain_is_no_error_of_constant_strains() -> None:
    indicator = indicate_errors(CLOTH, stretched([[1.1, 0.05], [0.0, 1.05]]), WEAVE)
    assert indicator.strains.max() < 1e-20  # squares of rounding, times moduli of 1e5


def test_a_strain_that_varies_is_an_error_of_the_order_of_the_square_of_the_triangles() -> None:
    """With x -> x + g x^2 / 2 the strain is about g x, which a triangle of size h misses by up to g h / 2."""
    gradient, errors = 0.01, []
    for squares in (8, 16):
        fine = sheet(squares)
        x, y, _ = fine.cloth.vertices.T
        bent = np.column_stack([x + 0.5 * gradient * x**2, y, np.zeros_like(x)])
        errors.append(indicate_errors(fine.cloth, bent, WEAVE).strains.sum())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)  # borders, where the mean of strains is one-sided
    # a strain that varies linearly by g h on a square differs from its mean by (g h)^2 / 12 in the mean
    # square, and on a triangle by (g h)^2 / 18
    assert errors[1] == pytest.approx(0.5 * WEAVE.stretch_course * (gradient / 16.0) ** 2 / 15.0, rel=0.3)


def test_positions_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ParameterError, match="not finite"):
        indicate_errors(CLOTH, CLOTH.vertices * np.nan, WEAVE)
