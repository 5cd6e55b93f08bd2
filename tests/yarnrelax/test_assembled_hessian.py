# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The sparse matrix is the derivative of the forces, and its blocks are those of the products."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.lattice import lattice_frame
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax import assembled_hessian as module
from stitchmesh.yarnrelax.assembled_hessian import assembled_hessian
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT
from stitchmesh.yarnrelax.energies.confinement import Confinement
from tests.yarnrelax.hessian.dense_matrix import Products, forces_at, points_of, started
from tests.yarnrelax.hessian.test_hessian_product import CELLS, FREE, KALDOR, SCENES, assert_close
from tests.yarnrelax.solvers.test_cell_strain import deformed
from tests.yarnrelax.stockinette import periodic_patch

Scene = tuple[YarnSet, YarnMaterial]


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_its_blocks_of_points_and_of_strains_are_those_of_products(scene: Scene) -> None:
    yarns, material = scene
    simulation = started(yarns, material, cell=FREE if yarns.lattice is not None else None)
    found = assembled_hessian(simulation).toarray()
    expected = Products(simulation, exact=1.0).matrix()
    expected[:, 3 * len(yarns.points) :] /= float(STRAIN_UNIT)
    expected[3 * len(yarns.points) :] /= float(STRAIN_UNIT)
    count = 3 * len(yarns.points)
    for part in (slice(None, count), slice(count, None)):
        own = expected[part, part]
        np.testing.assert_allclose(found[part, part], own, atol=1e-12 * np.abs(expected).max())  # rounding of sums
    np.testing.assert_array_equal(found[:count, count:], found[count:, :count].T)


@pytest.mark.parametrize("scene", CELLS.values(), ids=CELLS)
def test_its_border_is_the_derivative_of_the_forces_on_points_that_move_before_the_cell_deforms(scene: Scene) -> None:
    """The energy of points (I + E) (x + u) has the derivative (I + E)^T g by u, with the gradient g there."""
    yarns, material = scene
    assert yarns.lattice is not None
    count = 3 * len(yarns.points)
    border = assembled_hessian(started(yarns, material, cell=FREE)).toarray()[:count, count:] * float(STRAIN_UNIT)
    e1, e2, _normal = lattice_frame(yarns.lattice.periods)
    step = 1e-6
    for column, matrix in enumerate((np.outer(e1, e1), np.outer(e2, e2), np.outer(e1, e2))):
        ends = []
        for side in (1.0, -1.0):
            other = started(deformed(yarns, *(side * step * np.eye(3)[column])), material)
            ends.append(forces_at(other, points_of(other)) @ (np.eye(3) + side * step * matrix))
        assert_close(border[:, column], ((ends[1] - ends[0]) / (2 * step)).ravel())


def test_planes_add_blocks_at_the_points_beyond_them() -> None:
    yarns = periodic_patch(2, 2)
    simulation = started(yarns, KALDOR, [Confinement(0.1)], cell=FREE)
    expected = Products(simulation, exact=1.0).matrix()
    count = 3 * len(yarns.points)
    found = assembled_hessian(simulation).toarray()[:count, :count]
    np.testing.assert_allclose(found, expected[:count, :count], atol=1e-12 * np.abs(expected).max())  # rounding of sums
    without = assembled_hessian(started(yarns, KALDOR, cell=FREE)).toarray()[:count, :count]
    assert np.abs(found - without).max() > 0.0


def test_the_number_of_pairs_that_are_summed_at_once_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = started(*SCENES["sheared cell"], cell=FREE)
    whole = assembled_hessian(simulation).toarray()
    monkeypatch.setattr(module, "PAIRS_AT_ONCE", 7)
    parts = assembled_hessian(simulation).toarray()
    np.testing.assert_allclose(parts, whole, atol=1e-14 * np.abs(whole).max())  # another order of sums
