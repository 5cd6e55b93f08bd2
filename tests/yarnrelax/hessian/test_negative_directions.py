# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Directions along which matrices are negative: of small ones they are exact, of others few solutions find them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.hessian.negative_directions import SMALL, STEPS, negative_directions


def symmetric(values: FloatArray) -> FloatArray:
    """A full matrix with these eigenvalues."""
    turned = np.linalg.qr(np.random.default_rng(len(values)).normal(size=(len(values), len(values))))[0]
    return turned @ np.diag(values) @ turned.T


def directions(matrices: Mapping[int, FloatArray]) -> tuple[dict[int, FloatArray], list[list[int]]]:
    """The directions, and which matrices each solution was asked for."""
    asked = list[list[int]]()

    def solve(right: Mapping[int, FloatArray]) -> Mapping[int, FloatArray]:
        asked.append(list(right))
        return {number: np.linalg.solve(matrices[number], vector) for number, vector in right.items()}

    counts = {number: int((np.linalg.eigvalsh(own) < 0.0).sum()) for number, own in matrices.items()}
    return negative_directions(solve, {number: len(own) for number, own in matrices.items()}, counts), asked


def projections_agree(found: FloatArray, matrix: FloatArray, atol: float) -> None:
    """Vectors of near eigenvalues may be turned against each other: the projections are compared."""
    values, vectors = np.linalg.eigh(matrix)
    expected = vectors[:, values < 0.0]
    np.testing.assert_allclose(found @ found.T, expected @ expected.T, atol=atol)


@pytest.mark.parametrize("negative", [7, SMALL])
def test_the_eigenvectors_of_a_small_matrix_are_exact(negative: int) -> None:
    values = np.linspace(1.0, 5.0, SMALL) * np.where(np.arange(SMALL) < negative, -1.0, 1.0)
    matrix = symmetric(values)
    projections_agree(directions({0: matrix})[0][0], matrix, atol=1e-8)  # rounding, magnified by near eigenvalues


@pytest.mark.decides
@pytest.mark.parametrize("negative", [1, 40])
def test_a_matrix_is_negative_along_all_of_them_also_where_they_have_not_converged(negative: int) -> None:
    values = np.geomspace(1e-3, 10.0, 300)
    values[5 : 5 + negative] *= -1.0
    matrix = symmetric(values)
    found, asked = directions({0: matrix})
    assert 0 < found[0].shape[1] <= negative and len(asked) <= STEPS
    assert np.linalg.eigvalsh(found[0].T @ matrix @ found[0]).max() < 0.0
    np.testing.assert_allclose(found[0].T @ found[0], np.eye(found[0].shape[1]), atol=1e-12)


def test_matrices_take_their_steps_together_and_each_finds_what_it_finds_alone() -> None:
    soft, stiff = np.append(-1e-3, np.ones(99)), np.append([-0.3, -0.1], np.linspace(0.01, 2.0, 98))
    matrices = {1: symmetric(soft), 4: symmetric(stiff)}
    together, asked = directions(matrices)
    alone = {number: directions({number: own}) for number, own in matrices.items()}
    assert len(asked) == max(len(own[1]) for own in alone.values()) and asked[0] == [1, 4]
    for number in matrices:
        np.testing.assert_array_equal(together[number], alone[number][0][number])


def test_where_no_negative_ritz_value_is_found_the_way_leads_along_soft_directions() -> None:
    matrix = symmetric(np.append(-1e6, np.geomspace(1e-3, 1.0, 299)))
    found = directions({0: matrix})[0][0]
    assert found.shape == (300, 1)
    assert np.isclose(np.linalg.norm(found), 1.0) and np.linalg.norm(matrix @ found) < 0.01
