# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Matrices of cells are the same wherever they are: products, inertia, solutions and eigenvectors of each cell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from scipy.sparse import csc_array, random_array

from stitchmesh.compute.device import device_named
from stitchmesh.errors import SolverError
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.hessian.cell_matrices import Owners
from stitchmesh.yarnrelax.hessian.couplings import RIGID
from stitchmesh.yarnrelax.hessian.matrices_on_gpu import MatricesOnGpu, PartOnGpu
from stitchmesh.yarnrelax.hessian.matrices_on_host import MatricesOnHost
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.compute.pretended_cudss import pretend_cudss
from tests.compute.test_cudss import GPUS, needs_cudss
from tests.yarnrelax.hessian.places import Place, on_device, pattern_of
from tests.yarnrelax.hessian.scenes import assembled_hessian
from tests.yarnrelax.stockinette import fabric_of, periodic_patch, tube, woven_cell

KALDOR, FREE = YarnMaterial.named("kaldor-simulation"), RelaxCell()
SIZES = (40, 25, 31)
CELL = np.repeat(np.arange(3), SIZES)[np.random.default_rng(1).permutation(sum(SIZES))].astype(np.int32)
"""The cell of each coordinate, in no order."""
OWNERS = Owners(np.where(np.arange(len(CELL)) % 7 == 3, -1, CELL).astype(np.int32), 3)
SHIFT = np.array([0.5, 1.0, 2.0])


def matrix() -> csc_array:
    """A matrix of three cells with eigenvalues of both signs."""
    shape, rng = (len(CELL), len(CELL)), np.random.default_rng(0)
    found = random_array(shape, density=0.15, rng=rng, data_sampler=normal).toarray()
    found = np.where(CELL[:, None] == CELL, found + found.T, 0.0) + np.diag(np.arange(len(CELL)) % 3 - 0.5)
    return csc_array(found)


def normal(size: int) -> np.ndarray:
    return np.random.default_rng(2).normal(size=size)


def part(cell: int) -> np.ndarray:
    """The shifted matrix of a cell without what is left out."""
    own = OWNERS.coordinates[cell]
    return matrix().toarray()[np.ix_(own, own)] + SHIFT[cell] * np.eye(len(own))


def test_products_and_diagonals_leave_out_what_is_left_out(place: Place) -> None:
    vector, is_in = normal(len(CELL)), OWNERS.cell >= 0
    expected = np.where(is_in, matrix().toarray() @ np.where(is_in, vector, 0.0), 0.0)
    matrices = place(OWNERS, matrix())
    np.testing.assert_allclose(matrices.product(vector), expected, atol=1e-14 * len(CELL))  # sums in another order
    np.testing.assert_array_equal(matrices.diagonal(), matrix().diagonal())
    first = np.array([True, False, False])
    expected = np.where(CELL == 0, expected, 0.0)
    np.testing.assert_allclose(matrices.only(first).product(vector), expected, atol=1e-14 * len(CELL))


def test_the_upper_triangle_is_that_of_the_shifted_matrices_and_of_the_identity() -> None:
    matrices, is_in = on_device("cpu", OWNERS, matrix()), OWNERS.cell >= 0
    taken = is_in | (np.arange(len(CELL)) % 2 == 0)
    own = PartOnGpu(matrices.pattern, np.flatnonzero(taken))
    values = wp.zeros(len(own.upper_columns), dtype=wp.float64, device="cpu")
    matrices.put_upper_triangle(own, wp.array(SHIFT, dtype=wp.float64, device="cpu"), values)
    parts, count = (values.numpy(), own.upper_columns.numpy(), own.upper_start.numpy()), len(own.coordinates)
    expected = np.where(is_in[:, None] & is_in, matrix().toarray(), np.diag(~is_in)) + np.diag(OWNERS.each(SHIFT))
    expected = np.triu(expected[np.ix_(taken, taken)])
    np.testing.assert_array_equal(csc_array(parts, shape=(count, count)).toarray().T, expected)


@pytest.mark.decides
def test_factors_count_and_solve_for_each_cell(place: Place) -> None:
    factors, right = place(OWNERS, matrix()).factored(SHIFT), normal(len(CELL))
    some = np.array([True, False, True])
    found = factors.solve(right, some)
    for cell, own in enumerate(OWNERS.coordinates):
        assert factors.negative_count[cell] == np.count_nonzero(np.linalg.eigvalsh(part(cell)) < 0.0) > 0
        expected = np.linalg.solve(part(cell), right[own]) * some[cell]
        # Without an exchange of rows a pivot may be small: ten digits are left of float64.
        np.testing.assert_allclose(found[own], expected, atol=1e-6 * np.abs(expected).max())
    assert (found[OWNERS.cell < 0] == 0.0).all()


def test_the_negative_directions_of_each_cell_are_found(place: Place) -> None:
    for cell, found in place(OWNERS, matrix()).factored(SHIFT).negative_directions([0, 2]).items():
        values, vectors = np.linalg.eigh(part(cell))
        expected = vectors[:, values < 0.0]
        # Vectors of near eigenvalues may be turned against each other: the projections are compared.
        np.testing.assert_allclose(found @ found.T, expected @ expected.T, atol=1e-6)


@pytest.mark.parametrize("given", [[[0.0, 1.0], [1.0, 0.0]], [[np.nan, 0.0], [0.0, 1.0]]])
def test_a_matrix_without_such_factors_is_refused(place: Place, given: list[list[float]]) -> None:
    full = csc_array((np.ravel(given), [0, 1, 0, 1], [0, 2, 4]), shape=(2, 2))
    with pytest.raises(SolverError, match="factors of the Hessian"):
        place(Owners(np.zeros(2, dtype=np.int32), 1), full).factored(np.zeros(1))


def test_factors_whose_memory_others_took_are_found_again_to_the_same_bits(place: Place) -> None:
    matrices, right, every = place(OWNERS, matrix()), normal(len(CELL)), np.ones(3, dtype=bool)
    first = matrices.factored(SHIFT)
    before = first.solve(right, every)
    second = matrices.only(np.array([False, True, False])).factored(3.0 * SHIFT)
    assert not np.array_equal(second.solve(right, np.array([False, True, False])), before)
    np.testing.assert_array_equal(first.solve(right, every), before)
    np.testing.assert_array_equal(place(OWNERS, matrix()).factored(SHIFT).solve(right, every), before)


def test_factors_whose_analysis_a_new_pattern_has_taken_are_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    pretend_cudss(monkeypatch)
    device, every, right = device_named("cpu"), np.ones(3, dtype=bool), normal(len(CELL))
    group, given = np.where(CELL == 1, 1, 0), matrix()
    pattern = pattern_of(given, device, group)
    first = MatricesOnGpu(pattern, wp.array(given.data, dtype=wp.float64, device="cpu"), OWNERS).factored(SHIFT)
    before = first.solve(right, every)
    taken = pattern_of(given, device, group, pattern)
    second = MatricesOnGpu(taken, wp.array(3.0 * given.data, dtype=wp.float64, device="cpu"), OWNERS).factored(SHIFT)
    after = second.solve(right, every)
    np.testing.assert_array_equal(first.solve(right, every), before)
    np.testing.assert_array_equal(second.solve(right, every), after)
    assert not np.array_equal(before, after)


def batch_on(device: str) -> YarnSimulation:
    given = [(yarns, KALDOR) for yarns in (periodic_patch(1, 1), woven_cell(), periodic_patch(2, 2))]
    return YarnSimulation(given, PRESETS["draft"], device_named(device), cells=[FREE] * 3)


def owners_in(simulation: YarnSimulation) -> Owners:
    """All coordinates of the control points and of the strains."""
    cell = np.append(np.repeat(np.arange(3), 3 * np.diff(simulation.model.point_start)), np.repeat(np.arange(3), 3))
    return Owners(cell.astype(np.int32), 3)


def exactly(simulation: YarnSimulation) -> np.ndarray:
    """The share of the exact Hessian of each segment where nothing is mixed."""
    return np.ones(simulation.model.segment_count)


def on_pretended_gpu(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the assembly factor on the device ``cpu``."""
    pretend_cudss(monkeypatch)
    monkeypatch.setattr("stitchmesh.yarnrelax.assembled_hessian.factors_on", lambda _device: True)


def test_without_cudss_the_processor_factors(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = batch_on("cpu")
    owners, assembly = owners_in(simulation), HessianAssembly(simulation)
    assert isinstance(assembly.cell_matrices(exactly(simulation), owners, [], forces_are_found=False), MatricesOnHost)
    on_pretended_gpu(monkeypatch)
    first = assembly.cell_matrices(exactly(simulation), owners, [], forces_are_found=True)
    second = assembly.cell_matrices(0.0 * exactly(simulation), owners, [], forces_are_found=True)
    assert isinstance(first, MatricesOnGpu) and isinstance(second, MatricesOnGpu)
    assert first.pattern is second.pattern  # whose analysis is kept


@pytest.mark.decides
@pytest.mark.parametrize("device", ["cpu", pytest.param("GPU", marks=needs_cudss)])
def test_couplings_have_the_inertia_and_the_solutions_of_the_dense_matrix(
    device: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A garment that keeps its shape and its borders: patches join hundreds of coordinates, borders hold their sums."""
    if device == "cpu":
        on_pretended_gpu(monkeypatch)
    fabric, yarns = fabric_of(4, 6, closed=True), tube(4, 6)
    kept, held = [KeepShape(fabric)], [KeepBorders(fabric)]
    where = device_named(device if device == "cpu" else GPUS[0])
    simulation = YarnSimulation.start(yarns, KALDOR, replace(PRESETS["draft"], precision="float64"), where, kept, held)
    assembly, count = HessianAssembly(simulation), 3 * len(yarns.points)
    owners, every = Owners(np.zeros(count, dtype=np.int32), 1), np.ones(1, dtype=bool)
    exact = exactly(simulation)
    for _ in range(2):
        couplings = [simulation.terms[0].coupling(simulation.state), simulation.constraints[0].coupling()]
        found = assembly.cell_matrices(exact, owners, couplings, forces_are_found=False)
        assert isinstance(found, MatricesOnGpu)
        dense = assembly.matrix().toarray()
        rigid = RIGID * float(np.median(dense.diagonal()))
        for each in couplings:
            rows, spring = each.rows.toarray(), rigid * np.eye(each.rows.shape[0])
            dense += rows.T @ (spring if each.compliance is None else np.linalg.inv(each.compliance.toarray())) @ rows
        values = np.linalg.eigvalsh(dense)
        shift = 1e-4 * float(np.median(found.diagonal()))
        factors, right = found.factored(np.array([shift])), normal(count)
        assert factors.negative_count.tolist() == [np.count_nonzero(values < -shift)]
        assert (len(factors.negative_pivots) > 0) == (values[0] < -shift)
        expected = np.linalg.solve(dense + shift * np.eye(count), right)
        # Rounding of float64 times the stiffness of constraints over the shift, which is 1e10.
        np.testing.assert_allclose(factors.solve(right, every), expected, atol=1e-5 * np.abs(expected).max())
        product = dense @ right
        np.testing.assert_allclose(found.product(right), product, atol=1e-12 * np.abs(product).max())
        # A move by more than a radius changes the stiffness of some patches across it, and nothing of their rows.
        points = simulation.state.points.numpy()
        points[: count // 3, 0] += 2.0
        simulation.state.points.assign(points)
        simulation.search_contacts()


@pytest.mark.decides
@pytest.mark.parametrize("device", ["cpu", pytest.param("GPU", marks=needs_cudss)])
def test_hessians_of_a_batch_have_the_inertia_and_the_solutions_of_the_processor(
    device: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if device == "cpu":
        on_pretended_gpu(monkeypatch)
    simulation = batch_on(device if device == "cpu" else GPUS[0])
    owners, assembly = owners_in(simulation), HessianAssembly(simulation)
    for exact in (exactly(simulation), 0.0 * exactly(simulation)):
        found = assembly.cell_matrices(exact, owners, [], forces_are_found=False)
        assert isinstance(found, MatricesOnGpu)
        host = MatricesOnHost(assembly.matrix(exact), owners)
        # a shift that counts: motions of a cell as a whole have eigenvalues of the size of rounding
        shift = np.array([1e-5 * np.median(found.diagonal()[own]) for own in owners.coordinates])
        here, there = found.factored(shift), host.factored(shift)
        np.testing.assert_array_equal(here.negative_count, there.negative_count)
        right, every = normal(len(owners.cell)), np.ones(3, dtype=bool)
        solution = there.solve(right, every)
        # Rounding of float64 times the condition, 1e7 by the shift, times the growth of small pivots.
        np.testing.assert_allclose(here.solve(right, every), solution, atol=1e-5 * np.abs(solution).max())


def test_on_a_gpu_places_last_while_segments_part_and_touch_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of candidates that do not touch hold zeros."""
    on_pretended_gpu(monkeypatch)
    simulation, patterns = batch_on("cpu"), set()
    owners, assembly = owners_in(simulation), HessianAssembly(simulation)
    points, vector, touching = simulation.state.points.numpy(), normal(len(owners.cell)), set()
    for seed in range(4):
        motion = np.random.default_rng(seed).normal(scale=0.02, size=points.shape)
        motion[simulation.model.point_count :] = 0.0
        simulation.state.points.assign(points + motion)
        found = assembly.cell_matrices(exactly(simulation), owners, [], forces_are_found=False)
        assert isinstance(found, MatricesOnGpu)
        patterns.add(found.pattern)
        with monkeypatch.context() as beside:
            beside.setattr("stitchmesh.yarnrelax.assembled_hessian.factors_on", lambda _device: False)
            exact = MatricesOnHost(assembled_hessian(simulation), owners)
        touching.add(exact.matrix.nnz)
        assert exact.matrix.nnz < len(found.entries)
        # sums of the same numbers in another order
        expected = exact.product(vector)
        np.testing.assert_allclose(found.product(vector), expected, atol=1e-12 * np.abs(expected).max())
    assert len(patterns) == 1 and len(touching) > 1
