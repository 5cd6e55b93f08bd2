# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Mixtures of the exact Hessian with the matrix of Gauss and Newton, of which the latter is never negative."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.lattice import Lattice
from tests.yarnrelax.hessian.scenes import FREE, SCENES, Scene, mixture


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_the_matrix_of_gauss_and_newton_is_symmetric_and_never_negative(scene: Scene) -> None:
    matrix = mixture(*scene, 0.0, FREE if scene[0].lattice is not None else None)
    np.testing.assert_array_equal(matrix, matrix.T)
    largest = np.abs(matrix).max()
    assert np.abs(matrix - np.diag(np.diag(matrix))).max() > 0.01 * largest
    assert np.linalg.eigvalsh(matrix).min() > -1e-12 * largest


def test_a_share_mixes_both_matrices() -> None:
    none, some, whole = (mixture(*SCENES["sheared cell"], exact, FREE) for exact in (0.0, 0.7, 1.0))
    np.testing.assert_allclose(some, 0.3 * none + 0.7 * whole, atol=1e-13 * np.abs(whole).max())  # rounding of sums


def test_the_exact_matrix_is_negative_somewhere_where_yarns_are_compressed() -> None:
    """Otherwise the first test would say nothing about the matrix of Gauss and Newton."""
    matrix = mixture(*SCENES["compressed open piece"], 1.0)
    assert np.linalg.eigvalsh(matrix).min() < -1e-3 * np.abs(matrix).max()


@pytest.mark.parametrize("exact", [0.0, 1.0])
def test_a_motion_of_the_piece_as_a_whole_changes_no_force(exact: float) -> None:
    yarns, material = SCENES["closed piece"]
    matrix = mixture(yarns, material, exact)
    shift = np.tile([0.3, -0.2, 0.5], len(yarns.points))
    np.testing.assert_allclose(matrix @ shift, 0.0, atol=1e-12 * np.abs(matrix).max())  # rounding of sums


def test_the_choice_of_periods_does_not_change_the_matrix() -> None:
    yarns, material = SCENES["sheared cell"]
    assert yarns.lattice is not None
    periods = Lattice(np.array([[1, 0], [-2, 1]]) @ yarns.lattice.periods)
    one = mixture(yarns, material, 0.5, FREE)
    other = mixture(replace(yarns, lattice=periods), material, 0.5, FREE)
    np.testing.assert_allclose(other, one, atol=1e-12 * np.abs(one).max())  # rounding
