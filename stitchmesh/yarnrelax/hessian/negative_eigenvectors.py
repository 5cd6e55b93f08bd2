# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The eigenvectors of the negative eigenvalues of a symmetric matrix, from solutions of its linear system.

Lanczos' method finds them from products with the inverse matrix, whose lowest eigenvalues belong to them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

from stitchmesh.mesh import FloatArray

SOLUTIONS = 3
"""Solutions after which a random vector lies in soft directions, where Lanczos' method finds none."""


def negative_eigenvectors(solve: Callable[[FloatArray], FloatArray], size: int, count: int) -> FloatArray:
    """Return orthonormal eigenvectors of the negative eigenvalues, of all that are found, shape (n, m).

    Args:
        solve: the solution of the linear system for a right-hand side, both of shape (n,).
        size: number n of the coordinates.
        count: number of the negative eigenvalues.
    """
    if count == 0:
        return np.zeros((size, 0))
    if count >= size - 1:  # Lanczos' method leaves one out.
        values, vectors = np.linalg.eigh(np.stack([solve(unit) for unit in np.eye(size)], axis=1))
        return np.asarray(vectors[:, values < 0.0])
    inverse = LinearOperator((size, size), matvec=solve, dtype=np.float64)
    start = np.random.default_rng(0).normal(size=size)
    try:
        return np.asarray(eigsh(inverse, k=count, which="SA", v0=start)[1])
    except ArpackNoConvergence as error:  # Some are too near to each other; there is a way down without them.
        if error.eigenvectors.shape[1]:
            return np.asarray(error.eigenvectors)
    return _softest(solve, start)


def _softest(solve: Callable[[FloatArray], FloatArray], start: FloatArray) -> FloatArray:
    """Return a unit vector in soft directions, shape (n, 1), where no eigenvector is found: inverse iteration."""
    for _ in range(SOLUTIONS):
        start = solve(start / np.linalg.norm(start))
    return np.asarray(start / np.linalg.norm(start))[:, None]
