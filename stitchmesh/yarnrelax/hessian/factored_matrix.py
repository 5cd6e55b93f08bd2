# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sparse symmetric matrix in factors, L D L^T, which also tell how many of its eigenvalues are negative.

By Sylvester's law of inertia the matrix has as many negative eigenvalues as the diagonal matrix D has negative entries.
SciPy's SuperLU (Li and Demmel) factors a matrix as L U with unit diagonal L. If rows and columns are permuted alike and
no row is exchanged for its pivot, U is D L^T for a symmetric matrix. Its columns are ordered by minimum degree.

Some stiffnesses join many coordinates x, such as that of a patch of stitches: V^T C^-1 V with rows V that sum them and
a compliance C. As a matrix it would be dense. With one more unknown y = C^-1 V x for each row, the matrix

    | H + t I   V^T |
    |    V       -C |

is sparse. It has one negative eigenvalue more for each row than H + t I + V^T C^-1 V, whose solutions it gives. A
constraint V x = 0 is a row whose compliance is that of a spring ``RIGID`` times as stiff as the diagonal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import block_array, block_diag, csc_array, eye_array, vstack
from scipy.sparse.linalg import splu

from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.energies.term import Coupling

RIGID = 1e6
"""Stiffness of a constraint over the median of the diagonal of the matrix: the constraint holds to six digits, and the
rounding of float64 leaves ten digits of the solution."""

NO_FACTORS = "factors of the Hessian: a pivot is zero or not finite; shake the yarns"
"""What is said of a matrix without such factors."""


@dataclass(frozen=True, eq=False)
class FactoredMatrix:
    """The factors of a symmetric matrix."""

    factors: Any
    """SciPy's factors, also of the rows of couplings."""
    size: int
    """Number of coordinates of the matrix itself."""

    @cached_property
    def pivots(self) -> FloatArray:
        """The entries of D, in the order of the elimination, shape (n + m,)."""
        return np.asarray(self.factors.U.diagonal())

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


def factored(matrix: csc_array, shift: float = 0.0, couplings: Sequence[Coupling] = ()) -> FactoredMatrix:
    """Factor a symmetric matrix plus a multiple of the identity.

    Args:
        matrix: the matrix, shape (n, n).
        shift: the multiple.
        couplings: stiffnesses that join many coordinates.

    Raises:
        SolverError: a pivot is zero or not finite, so that the matrix has no such factors.
    """
    whole = csc_array(matrix + shift * eye_array(matrix.shape[0], format="csc")) if shift else matrix
    if couplings:
        rows = vstack([each.rows for each in couplings])
        rigid = 1.0 / (RIGID * float(np.median(whole.diagonal())))
        compliance = block_diag([
            rigid * eye_array(each.rows.shape[0]) if each.compliance is None else each.compliance for each in couplings
        ])  # fmt: skip
        whole = csc_array(block_array([[whole, rows.T], [rows, -compliance]]))
    try:
        factors = splu(whole, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError as error:  # a pivot is exactly zero
        raise SolverError(f"factors of the Hessian: {error}; shake the yarns") from error
    found = FactoredMatrix(factors, matrix.shape[0])
    if not np.array_equal(factors.perm_r, factors.perm_c) or not np.isfinite(found.pivots).all():
        raise SolverError(NO_FACTORS)
    return found
