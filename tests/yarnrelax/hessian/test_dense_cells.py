# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Dense factors of small cells: as the processor's, and with bits that do not depend on the other cells."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import warp as wp
from scipy.sparse import csc_array

from stitchmesh.compute.device import device_named
from stitchmesh.errors import SolverError
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.hessian import dense_cells
from stitchmesh.yarnrelax.hessian.cell_matrices import REFINED, Owners
from stitchmesh.yarnrelax.hessian.dense_cells import DenseCells, MatricesOfSmallCells
from stitchmesh.yarnrelax.hessian.matrices_on_host import MatricesOnHost
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.newton_system import SIGNIFICANT, NewtonSystems
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.yarnrelax.stockinette import periodic_patch, woven_cell

KALDOR, FREE = YarnMaterial.named("kaldor-simulation"), RelaxCell()
POINTS = np.array([12, 27, 21])
"""Coordinates of the points of three cells; with three strains each, the panels of two cells are not full."""
COUNT = int(POINTS.sum()) + 9
CELL = np.concatenate([np.repeat(np.arange(3), POINTS), np.repeat(np.arange(3), 3)]).astype(np.int32)
OWNERS = Owners(np.where(np.arange(COUNT) % 11 == 4, np.int32(-1), CELL), 3)
EVERY = np.ones(3, dtype=bool)
SHIFT = np.array([0.7, 1.2, 2.1])
FORCE = np.random.default_rng(3).normal(size=COUNT)


def matrix(offset: float = 0.0) -> csc_array:
    """A matrix of three cells with eigenvalues of both signs, or with positive ones if the offset is large."""
    given = np.random.default_rng(0).normal(size=(COUNT, COUNT))
    given = np.where((CELL[:, None] == CELL) & (np.abs(given + given.T) > 1.0), given + given.T, 0.0)
    return csc_array(given + np.diag(np.arange(COUNT) % 3 - 0.5 + offset))


def dense(given: csc_array, owners: Owners = OWNERS) -> MatricesOfSmallCells:
    """The matrices as on a GPU."""
    device = device_named("cpu")
    rows = wp.array(given.indices, dtype=wp.int32, device=device)
    pattern: Any = SimpleNamespace(column_start=given.indptr, rows=rows)
    entries = wp.array(given.data, dtype=wp.float64, device=device)
    return MatricesOfSmallCells.of(DenseCells(POINTS, 3, device), pattern, entries, owners)


@pytest.mark.decides
def test_factors_count_and_solve_as_those_of_the_processor() -> None:
    here, there = (each.factored(SHIFT) for each in (dense(matrix()), MatricesOnHost(matrix(), OWNERS)))
    np.testing.assert_array_equal(here.negative_count, there.negative_count)
    assert (here.negative_count > 0).all()
    some = np.array([True, False, True])
    expected = there.solve(FORCE, some)
    # without an exchange of rows a pivot may be small: ten digits are left of float64
    np.testing.assert_allclose(here.solve(FORCE, some), expected, atol=1e-6 * np.abs(expected).max())
    assert (OWNERS.cell[here.negative_pivots] >= 0).all()
    np.testing.assert_array_equal(np.bincount(CELL[here.negative_pivots]), here.negative_count)


def test_products_diagonals_and_medians_are_those_of_the_processor() -> None:
    here, there = dense(matrix()), MatricesOnHost(matrix(), OWNERS)
    np.testing.assert_allclose(here.product(FORCE), there.product(FORCE), atol=1e-13)  # sums in another order
    np.testing.assert_array_equal(here.diagonal(), there.diagonal())
    medians = [np.median(matrix().diagonal()[own]) for own in OWNERS.coordinates]
    np.testing.assert_array_equal(here.medians(), medians)
    np.testing.assert_array_equal(there.medians(), medians)
    assert dense(matrix()).only(np.array([False, True, False])).medians().tolist() == [0.0, medians[1], 0.0]


def test_conjugate_gradients_remove_the_effect_of_the_shift() -> None:
    """As those of the processor do, for the cells with the exact Hessian."""
    given, exact = matrix(14.0), np.array([True, True, False])
    force = np.where(OWNERS.cell >= 0, FORCE, 0.0)
    shift = 0.05 * MatricesOnHost(given, OWNERS).medians()
    found = [each.factored(shift).refined(force, EVERY, exact, shift)
             for each in (dense(given), MatricesOnHost(given, OWNERS))]  # fmt: skip
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)  # rounding of float64
    whole = given.toarray()
    for cell in (0, 1):
        own = OWNERS.coordinates[cell]
        expected = np.linalg.solve(whole[np.ix_(own, own)], force[own])
        np.testing.assert_allclose(found[0][0][own], expected, atol=10.0 * REFINED * np.abs(expected).max())


def test_factors_whose_memory_others_took_are_found_again_to_the_same_bits() -> None:
    matrices, second = dense(matrix()), np.array([False, True, False])
    first = matrices.factored(SHIFT)
    before = first.solve(FORCE, EVERY)
    other = matrices.only(second).factored(3.0 * SHIFT)
    assert not np.array_equal(other.solve(FORCE, second), np.where(CELL == 1, before, 0.0))
    np.testing.assert_array_equal(first.solve(FORCE, EVERY), before)


def test_the_bits_of_a_cell_do_not_depend_on_the_other_cells() -> None:
    given = matrix(14.0)
    changed = given.toarray()
    changed[np.ix_(CELL != 1, CELL != 1)] *= 1.7
    shift = SIGNIFICANT * np.ones(3)
    alone = np.array([False, True, False])
    found = [
        matrices.factored(shift).refined(FORCE, cells, cells, shift)[0][CELL == 1]
        for matrices, cells in ((dense(given), EVERY), (dense(csc_array(changed)), EVERY), (dense(given), alone))
    ]
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_a_matrix_without_such_factors_is_refused(value: float) -> None:
    given = matrix(14.0).tolil()
    given[0, :] = given[:, 0] = 0.0
    given[0, 0] = 1.0
    given = csc_array(given)
    given.data[given.indptr[0]] = value
    with pytest.raises(SolverError, match="factors of the Hessian"):
        dense(given, Owners(CELL, 3)).factored(np.zeros(3))


def test_a_batch_comes_to_the_rest_of_sparse_factors(monkeypatch: pytest.MonkeyPatch) -> None:
    cells = [periodic_patch(1, 1), woven_cell(), periodic_patch(2, 1)]
    given: Any = {"materials": [KALDOR] * 3, "free": [FREE] * 3, "quality": PRESETS["standard"], "device": "cpu"}
    expected = relax_cells(cells, **given, progress=False)
    monkeypatch.setattr(DenseCells, "suit", staticmethod(lambda _sizes, _device: True))
    made = []
    monkeypatch.setattr(dense_cells, "FactorsOfSmallCells", counted(dense_cells.FactorsOfSmallCells, made))
    found = relax_cells(cells, **given, progress=False)
    assert made
    for one, other in zip(found.cells, expected.cells, strict=True):
        assert one.report["converged"] and other.report["converged"]
        sizes = [np.linalg.norm(each.yarns.lattice.periods, axis=1) for each in (one, other)]
        np.testing.assert_allclose(*sizes, rtol=2.0 * PRESETS["standard"].largest_change)


def counted(kind: Any, made: list[Any]) -> Any:
    """A function that makes an object of a class, and notes it."""

    def make(*arguments: Any) -> Any:
        made.append(kind(*arguments))
        return made[-1]

    return make


def test_hessians_of_a_batch_have_the_steps_of_the_processor(monkeypatch: pytest.MonkeyPatch) -> None:
    given = [(yarns, KALDOR) for yarns in (periodic_patch(1, 1), woven_cell(), periodic_patch(2, 2))]
    simulation = YarnSimulation(given, PRESETS["draft"], device_named("cpu"), cells=[FREE] * 3)
    points = np.repeat(np.arange(3), 3 * np.diff(simulation.model.point_start))
    owners = Owners(np.append(points, np.repeat(np.arange(3), 3)).astype(np.int32), 3)
    gauss_newton = np.zeros(simulation.model.segment_count)
    host = MatricesOnHost(HessianAssembly(simulation).matrix(gauss_newton), owners)
    monkeypatch.setattr(DenseCells, "suit", staticmethod(lambda _sizes, _device: True))
    here = HessianAssembly(simulation).cell_matrices(gauss_newton, owners, [], forces_are_found=False)
    assert isinstance(here, MatricesOfSmallCells)
    force = np.random.default_rng(5).normal(size=len(owners.cell))
    found, expected = (NewtonSystems(each, force).steps(EVERY, ~EVERY) for each in (here, host))
    # rounding of float64 times the condition, 2e5 by the shift, times the growth of small pivots
    np.testing.assert_allclose(found.motion, expected.motion, atol=1e-7 * np.abs(expected.motion).max())
    np.testing.assert_allclose(found.work, expected.work, rtol=1e-7)
