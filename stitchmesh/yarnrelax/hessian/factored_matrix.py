# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sparse symmetric matrix in factors L D L^T, which also tell how many of its eigenvalues are negative.

By Sylvester's law of inertia the matrix has as many negative eigenvalues as the diagonal matrix D has negative entries.
SciPy's SuperLU (Li and Demmel) factors a matrix as L U with unit diagonal L. If rows and columns are permuted alike and
no row is exchanged for a better pivot, U is D L^T for a symmetric matrix. Its columns are ordered by minimum degree.
Couplings of many coordinates become further rows and columns (``couplings``).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import block_array, csc_array, eye_array
from scipy.sparse.linalg import splu

from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.hessian.couplings import Couplings

NO_FACTORS = "factors of the Hessian: a pivot is zero or not finite; shake the yarns"
"""The message for a matrix without such factors."""


@dataclass(frozen=True, eq=False)
class FactoredMatrix:
    """The factors of a symmetric matrix."""

    factors: Any
    """SciPy's factors of the matrix with the rows of its couplings."""
    size: int
    """Number of coordinates of the matrix itself."""

    @cached_property
    def pivots(self) -> FloatArray:
        """The entries of D, in the order of the rows, shape (n + m,)."""
        return np.asarray(self.factors.U.diagonal()[self.factors.perm_c])

    @cached_property
    def negative_count(self) -> int:
        """Number of negative eigenvalues of the matrix with its couplings."""
        return int(np.count_nonzero(self.pivots < 0.0)) - (len(self.pivots) - self.size)

    def solve(self, right: FloatArray) -> FloatArray:
        """Return the solution of the linear system for a right-hand side, both of shape (n,) or (n, m)."""
        further = len(self.pivots) - self.size
        if further:
            right = np.concatenate([right, np.zeros((further, *right.shape[1:]))])
        return np.asarray(self.factors.solve(right))[: self.size]


def factored(matrix: csc_array, shift: float = 0.0, couplings: Couplings | None = None) -> FactoredMatrix:
    """Factor a symmetric matrix plus a multiple of the identity.

    Args:
        matrix: the matrix, shape (n, n).
        shift: the multiple.
        couplings: couplings of many coordinates.

    Raises:
        SolverError: a pivot is zero or not finite, so that the matrix has no such factors.
    """
    whole = csc_array(matrix + shift * eye_array(matrix.shape[0], format="csc")) if shift else matrix
    if couplings is not None:
        whole = csc_array(block_array([[whole, couplings.of.columns], [couplings.of.rows, -couplings.compliance]]))
    try:
        factors = splu(whole, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:  # a pivot is exactly zero
        raise SolverError(f"factors of the Hessian: {error}; shake the yarns") from error
    found = FactoredMatrix(factors, matrix.shape[0])
    if not np.array_equal(factors.perm_r, factors.perm_c) or not np.isfinite(found.pivots).all():
        raise SolverError(NO_FACTORS)
    return found
