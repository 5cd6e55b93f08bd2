# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Newton steps of the cells of a batch: solutions, ways down, and shifts that are large enough."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array

from stitchmesh.yarnrelax.energies.term import Coupling
from stitchmesh.yarnrelax.hessian.cell_matrices import REFINED, Owners
from stitchmesh.yarnrelax.hessian.couplings import CouplingRows, joined
from stitchmesh.yarnrelax.hessian.matrices_on_host import MatricesOnHost
from stitchmesh.yarnrelax.solvers.newton_system import SIGNIFICANT, NewtonSystems
from tests.yarnrelax.hessian.places import Place

pytestmark = pytest.mark.decides
POINTS = 3
CELL = np.repeat(np.arange(2), 3 * POINTS).astype(np.int32)
OWNERS = Owners(np.where(np.arange(len(CELL)) == 5, np.int32(-1), CELL), 2)  # a coordinate is held
EVERY = np.ones(2, dtype=bool)
FORCE = np.where(OWNERS.cell >= 0, np.random.default_rng(3).normal(size=len(CELL)), 0.0)


def matrix(*lowest: float) -> np.ndarray:
    """Two cells with a stiffness of about 1, and the lowest eigenvalue of each."""
    found = np.zeros((len(CELL), len(CELL)))
    for cell, value in enumerate(lowest):
        own = OWNERS.coordinates[cell]
        basis = np.linalg.qr(np.random.default_rng(cell).normal(size=(len(own), len(own))))[0]
        found[np.ix_(own, own)] = (basis * np.append(value, np.linspace(1.0, 2.0, len(own) - 1))) @ basis.T
    return found + np.diag(OWNERS.cell < 0)


def systems(place: Place, given: np.ndarray) -> NewtonSystems:
    return NewtonSystems(place(OWNERS, csc_array(given)), FORCE)


def test_the_step_of_the_exact_hessian_has_no_effect_of_the_shift(place: Place) -> None:
    """An eigenvalue as small as the shift would make the step half as long."""
    given = matrix(2.0 * SIGNIFICANT, 1.0)
    expected = np.linalg.solve(given, FORCE)
    found = systems(place, given).steps(EVERY, EVERY)
    # Conjugate gradients end at a thousandth of the residual; the soft direction has most of the step.
    np.testing.assert_allclose(found.motion.ravel(), expected, atol=2e-3 * np.abs(expected).max())
    np.testing.assert_allclose(found.work, OWNERS.sums(FORCE * expected), rtol=2e-3)
    shifted = systems(place, given).steps(EVERY, np.array([False, True])).motion.ravel()
    assert np.abs(shifted[CELL == 0]).max() < 0.8 * np.abs(expected[CELL == 0]).max()


def test_cells_that_are_not_asked_for_do_not_move_and_do_not_matter(place: Place) -> None:
    given, second = matrix(-0.5, 0.5), np.array([False, True])
    together, alone = systems(place, given), NewtonSystems(systems(place, given).matrices.only(second), FORCE)
    assert together.negative_count.tolist() == [1, 0]
    found, expected = (own.steps(second, second).motion for own in (together, alone))
    np.testing.assert_array_equal(found, expected)
    assert not found[:POINTS].any() and found[POINTS:].any()


def test_a_way_down_has_its_length_and_lies_along_the_negative_eigenvectors(place: Place) -> None:
    given = matrix(-0.5, -0.1)
    values, vectors = np.linalg.eigh(given)
    found = systems(place, given).ways_down(EVERY, np.array([0.25, 0.5]))
    for cell in range(2):
        motion = np.where((CELL == cell).reshape(-1, 3), found, 0.0)
        direction = vectors[:, (values < 0.0) & (np.abs(vectors[CELL == cell]).max(axis=0) > 1e-6)]
        along = direction @ (direction.T @ motion.ravel())
        np.testing.assert_allclose(along, motion.ravel(), atol=1e-9)  # Lanczos' method ends at rounding
        assert np.linalg.norm(motion, axis=1).max() == pytest.approx(0.25 * (cell + 1))


def test_each_shift_becomes_as_large_as_its_cell_needs(place: Place) -> None:
    given = matrix(-30.0 * SIGNIFICANT, -3.0 * SIGNIFICANT)
    found = systems(place, given).without_negative_eigenvalues(EVERY)
    assert not found.negative_count.any() and found.shifted == pytest.approx([64.0, 8.0])
    assert systems(place, given).without_negative_eigenvalues(np.array([True, False])).matrices.owners.cells == [0]


def circle(count: int) -> np.ndarray:
    """The Laplace matrix of a closed chain of points, whose motion as a whole has no stiffness."""
    chain = 2.0 * np.eye(count) - np.roll(np.eye(count), 1, axis=0) - np.roll(np.eye(count), -1, axis=0)
    return np.kron(chain, np.eye(3))


def alone(matrix: np.ndarray, force: np.ndarray, couplings: Sequence[Coupling] = ()) -> np.ndarray:
    """The motion of the exact step of one cell on the host, all of whose coordinates are free, shape (n / 3, 3)."""
    owners, every = Owners(np.zeros(len(force), dtype=np.int32), 1), np.ones(1, dtype=bool)
    coupled = joined(couplings, CouplingRows(couplings), matrix.diagonal())
    matrices = MatricesOnHost(csc_array(matrix), owners, coupled)
    return NewtonSystems(matrices, force).steps(every, every).motion


def test_directions_without_stiffness_are_left_alone() -> None:
    """Forces of a closed chain that sum to nothing move it, and its middle stays where it is."""
    force = np.random.default_rng(1).normal(size=(16, 3))
    force -= force.mean(axis=0)
    expected = (np.linalg.pinv(circle(16)) @ force.ravel()).reshape(-1, 3)
    found = alone(circle(16), force.ravel())
    np.testing.assert_allclose(found, expected, atol=REFINED * np.abs(expected).max())


def test_couplings_join_coordinates_and_constraints_hold_their_sums() -> None:
    """A spring on the middle of all points, or a constraint on it; the matrix itself has no stiffness there."""
    count, spring = 5, 7.0
    matrix, force = circle(count), np.random.default_rng(2).normal(size=3 * count)
    rows = csr_array(np.kron(np.ones((1, count)), np.eye(3)))
    joined = Coupling(rows, csr_array(np.eye(3) / spring))
    found = alone(matrix, force, [joined])
    expected = np.linalg.solve(matrix + spring * (rows.T @ rows).toarray(), force)
    np.testing.assert_allclose(found.ravel(), expected, atol=REFINED * np.abs(expected).max())
    held = alone(matrix, force, [Coupling(rows)])
    centred = (force.reshape(-1, 3) - force.reshape(-1, 3).mean(axis=0)).ravel()
    expected = np.linalg.pinv(matrix) @ centred
    # a constraint is a spring a million times as stiff as the diagonal (``RIGID``)
    np.testing.assert_allclose(held.ravel(), expected, atol=1e-4 * np.abs(expected).max())
    assert np.abs(held.sum(axis=0)).max() < 1e-5 * np.abs(expected).max()
