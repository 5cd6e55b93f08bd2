# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The coarse matrices are those of rigid motions of pieces of yarn, and their inverses are found in a fixed order."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.solvers.coarse_space import CoarseSpace, inverse_in_order
from tests.yarnrelax.hessian.dense_matrix import Products, points_of, started
from tests.yarnrelax.stockinette import periodic_patch

KALDOR = YarnMaterial.named("kaldor-simulation")
YARNS = periodic_patch(2, 2)


def rigid_motions(space: CoarseSpace, points: np.ndarray) -> np.ndarray:
    """The motions of all groups as columns, without the strains, shape (3 N, 6 G)."""
    group, middle = space.groups.of_point.numpy(), space.groups.middle.numpy()
    size = space.groups.size.numpy()
    motions = np.zeros((len(points), 3, len(middle), 6))
    for i, g in enumerate(group.tolist()):
        motions[i, :, g, :3] = np.eye(3)
        motions[i, :, g, 3:] = np.cross(np.eye(3), (points[i] - middle[g]) / size[g]).T
    return motions.reshape(3 * len(points), -1)


@pytest.fixture(scope="module")
def assembled() -> tuple[CoarseSpace, np.ndarray, np.ndarray]:
    """A coarse space, its control points, and the matrix of Gauss and Newton of the control points."""
    simulation = started(YARNS, KALDOR, cell=RelaxCell())
    products = Products(simulation, 0.0)
    level, damping = simulation.model.empty(products.entries), simulation.model.empty(products.entries)
    space = CoarseSpace(simulation.model, 1)
    space.prepare(products.hessian, simulation.state.points, level, damping)
    space.invert(np.ones(1, dtype=bool))
    points = points_of(simulation)
    return space, points, products.matrix()[: points.size, : points.size]


def test_the_coarse_matrix_is_that_of_rigid_motions(assembled: tuple[CoarseSpace, np.ndarray, np.ndarray]) -> None:
    space, points, matrix = assembled
    motions = rigid_motions(space, points)
    count = motions.shape[1]
    assert count == 6 * space.count > 6
    expected = motions.T @ matrix @ motions
    # both are sums of the same products in double precision
    assert np.abs(space.matrices.numpy()[0, :count, :count] - expected).max() < 1e-12 * np.abs(expected).max()


def test_the_inverse_undoes_the_matrix_for_stiff_motions(
    assembled: tuple[CoarseSpace, np.ndarray, np.ndarray],
) -> None:
    """A motion of the fabric as a whole has no stiffness."""
    space, points, matrix = assembled
    motions = rigid_motions(space, points)
    count = motions.shape[1]
    own = motions.T @ matrix @ motions
    values, vectors = np.linalg.eigh(own)
    stiff = vectors[:, values > 1e-3 * values.max()]
    inverse = np.linalg.inv(np.linalg.inv(space.inverse.numpy()[0])[:count, :count])
    # the diagonal is raised by a ten millionth of its mean, and stiff motions are a thousandth of the largest at least
    assert np.abs(inverse @ own @ stiff - stiff).max() < 1e-3


@pytest.mark.parametrize("count", [1, 7, 60])
def test_the_inverse_of_a_matrix_is_its_inverse(count: int) -> None:
    random = np.random.default_rng(count)
    factor = random.normal(size=(count, count))
    matrix = factor @ factor.T + np.eye(count)
    # rounding times the condition, which is below 1e3
    assert np.abs(inverse_in_order(matrix) @ matrix - np.eye(count)).max() < 1e-11
