# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Factors solve systems and count negative eigenvalues."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array

from stitchmesh.errors import SolverError
from stitchmesh.yarnrelax.energies.term import Coupling
from stitchmesh.yarnrelax.hessian.couplings import CouplingRows, Couplings, joined
from stitchmesh.yarnrelax.hessian.factored_matrix import factored
from tests.yarnrelax.hessian.scenes import SCENES, assembled_hessian, started

pytestmark = pytest.mark.decides
COMPRESSED = assembled_hessian(started(*SCENES["compressed open piece"]))


def test_they_count_the_negative_eigenvalues_and_solve() -> None:
    values = np.linalg.eigvalsh(COMPRESSED.toarray())
    shift = 1e-6 * values[-1]  # The motions of the piece as a whole have eigenvalues of rounding size.
    found = factored(COMPRESSED, shift)
    assert found.negative_count == np.count_nonzero(values < -shift) > 0
    right = np.random.default_rng(0).normal(size=len(values))
    solution = found.solve(right)
    # Rounding of float64 times the condition of the matrix, which is 1e6 by the shift.
    np.testing.assert_allclose(COMPRESSED @ solution + shift * solution, right, atol=1e-8 * np.abs(right).max())


def of_piece(coupling: Coupling) -> Couplings | None:
    return joined([coupling], CouplingRows([coupling]), COMPRESSED.diagonal())


def with_coupling(stiffness: float) -> tuple[np.ndarray, Coupling]:
    """The matrix of the piece with springs on the sums of some of its coordinates, and the springs."""
    size = COMPRESSED.shape[0]
    rows = np.where(np.random.default_rng(4).random((5, size)) < 0.3, 1.0, 0.0)
    compliance = np.eye(5) / stiffness + 0.1 * np.ones((5, 5)) / stiffness
    dense = COMPRESSED.toarray() + rows.T @ np.linalg.solve(compliance, rows)
    return dense, Coupling(csr_array(rows), csr_array(compliance))


def test_couplings_are_parts_of_the_matrix() -> None:
    """Its solutions, and the number of its negative eigenvalues."""
    largest = float(np.linalg.eigvalsh(COMPRESSED.toarray())[-1])
    dense, coupling = with_coupling(0.3 * largest)
    values = np.linalg.eigvalsh(dense)
    shift = 1e-6 * values[-1]
    found = factored(COMPRESSED, shift, of_piece(coupling))
    assert found.negative_count == np.count_nonzero(values < -shift)
    assert found.negative_count != factored(COMPRESSED, shift).negative_count
    right = np.random.default_rng(0).normal(size=(len(values), 2))
    solution = found.solve(right)
    np.testing.assert_allclose(dense @ solution + shift * solution, right, atol=1e-7 * np.abs(right).max())  # see above


def test_constraints_hold_what_their_rows_sum() -> None:
    """As for the matrix of motions that the constraint allows."""
    rows = np.kron(np.eye(4, COMPRESSED.shape[0] // 3), np.eye(3))  # four points that are pinned
    kept = COMPRESSED.toarray()[12:, 12:]
    values = np.linalg.eigvalsh(kept)
    shift = 1e-6 * values[-1]
    found = factored(COMPRESSED, shift, of_piece(Coupling(csr_array(rows))))
    assert found.negative_count == np.count_nonzero(values < -shift) > 0
    right = np.random.default_rng(0).normal(size=COMPRESSED.shape[0])
    solution, expected = found.solve(right), np.linalg.solve(kept + shift * np.eye(len(kept)), right[12:])
    # RIGID is a million times the diagonal; the softest motions of the piece amplify what gives way.
    assert np.abs(solution[:12]).max() < 1e-4 * np.abs(expected).max()
    np.testing.assert_allclose(solution[12:], expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize("matrix", [[[0.0, 1.0], [1.0, 0.0]], [[np.nan, 0.0], [0.0, 1.0]]])
def test_a_matrix_without_such_factors_is_refused(matrix: list[list[float]]) -> None:
    with pytest.raises(SolverError, match="factors of the Hessian"):
        factored(csc_array(np.array(matrix)))
