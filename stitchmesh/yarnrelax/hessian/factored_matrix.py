# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sparse symmetric matrix in factors, L D L^T, which also tell how many of its eigenvalues are negative.

By Sylvester's law of inertia the matrix has as many negative eigenvalues as the diagonal matrix D has negative entries.
SciPy's SuperLU (Li and Demmel) factors a matrix as L U with unit diagonal L. If rows and columns are permuted alike and
no row is exchanged for its pivot, U is D L^T for a symmetric matrix. Its columns are ordered by minimum degree.

Lanczos' method finds the eigenvectors of the negative eigenvalues from products with the inverse matrix, whose lowest
eigenvalues belong to them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray


@dataclass(frozen=True, eq=False)
class FactoredMatrix:
    """The factors of a symmetric matrix."""

    factors: Any
    """SciPy's factors."""

    @cached_property
    def pivots(self) -> FloatArray:
        """The entries of D, in the order of the elimination, shape (n,)."""
        return np.asarray(self.factors.U.diagonal())

    @property
    def negative_count(self) -> int:
        """Number of negative eigenvalues."""
        return int(np.count_nonzero(self.pivots < 0.0))

    def solve(self, right: FloatArray) -> FloatArray:
        """Return the solution of the linear system for a right-hand side, both of shape (n,) or (n, m)."""
        return np.asarray(self.factors.solve(right))

    def negative_eigenvectors(self) -> FloatArray:
        """Return orthonormal eigenvectors of all negative eigenvalues, shape (n, m)."""
        size, count = len(self.pivots), self.negative_count
        if count == 0:
            return np.zeros((size, 0))
        inverse = LinearOperator((size, size), matvec=self.solve, dtype=np.float64)
        if count >= size - 1:  # Lanczos' method leaves one out.
            values, vectors = np.linalg.eigh(self.solve(np.eye(size)))
            return np.asarray(vectors[:, values < 0.0])
        start = np.random.default_rng(0).normal(size=size)
        return np.asarray(eigsh(inverse, k=count, which="SA", v0=start)[1])


def factored(matrix: csc_array, shift: float = 0.0) -> FactoredMatrix:
    """Factor a symmetric matrix plus a multiple of the identity.

    Args:
        matrix: the matrix, shape (n, n).
        shift: the multiple.

    Raises:
        SolverError: a pivot is zero or not finite, so that the matrix has no such factors.
    """
    shifted = csc_array(matrix + shift * eye_array(matrix.shape[0], format="csc")) if shift else matrix
    try:
        factors = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:  # a pivot is exactly zero
        raise SolverError(f"factors of the Hessian: {error}; shake the yarns") from error
    found = FactoredMatrix(factors)
    if not np.array_equal(factors.perm_r, factors.perm_c) or not np.isfinite(found.pivots).all():
        raise SolverError("factors of the Hessian: a pivot is zero or not finite; shake the yarns")
    return found
