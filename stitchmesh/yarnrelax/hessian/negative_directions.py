# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Directions along which symmetric matrices are negative, from solutions of their linear systems.

The lowest eigenvalues of the inverse of a matrix A belong to the small negative eigenvalues of A. Lanczos' method
therefore finds these first. It makes an orthonormal basis Q of the vectors A^-k y, to which each solution
Y_j = A^-1 Q_j adds the next one. A negative Ritz value r with the vector s, (Q^T Y) s = r s, gives the direction
w = Y s. Along it the matrix is negative even if Q has not converged, since

    w^T A w  =  s^T Y^T A Y s  =  s^T Y^T Q s  =  r

and two of these directions are conjugate: w_j^T A w_k = 0. Each new vector is orthogonalised against all vectors of its
basis, because rounding would bring back the converged ones.

Several matrices take their steps together: one solution for a matrix of blocks takes as long as one for a single block.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from stitchmesh.mesh import FloatArray

STEPS, SMALL = 24, 64
"""Most solutions for a matrix; and the size up to which there are as many as rows, so that eigenvectors are exact."""

Solve = Callable[[Mapping[int, FloatArray]], Mapping[int, FloatArray]]
"""Returns the solutions of the linear systems of some matrices, for a right-hand side of each."""


def negative_directions(solve: Solve, sizes: Mapping[int, int], counts: Mapping[int, int]) -> dict[int, FloatArray]:
    """Return an orthonormal basis of directions along which each matrix is negative, shape (n, m).

    The directions are eigenvectors of its negative eigenvalues, as far as these are found. If none is found, there is
    one vector, in soft directions.

    Args:
        solve: returns the solutions for vectors of some of the matrices.
        sizes: number n of rows of each matrix.
        counts: number of negative eigenvalues of each matrix.
    """
    bases = {number: _Basis(size, counts[number]) for number, size in sizes.items()}
    while asked := {number: basis.last for number, basis in bases.items() if not basis.is_complete}:
        for number, solution in solve(asked).items():
            bases[number].add(solution)
    return {number: basis.directions() for number, basis in bases.items()}


class _Basis:
    """The vectors of Lanczos' method for one matrix."""

    def __init__(self, size: int, count: int) -> None:
        start = np.random.default_rng(0).normal(size=size)
        self.size, self.count, self.done = size, count, 0
        """Number of rows, of negative eigenvalues, and of solutions so far."""
        self.most = size if size <= SMALL else min(STEPS, size)
        """Largest number of solutions."""
        self.vectors, self.solutions = (np.zeros((size, self.most), order="F") for _ in range(2))
        self.projected = np.zeros((self.most, self.most))
        """Q^T Y."""
        self.vectors[:, 0] = start / np.linalg.norm(start)
        self.is_complete = count == 0

    @property
    def last(self) -> FloatArray:
        """The vector whose solution comes next."""
        return self.vectors[:, self.done]

    def add(self, solution: FloatArray) -> None:
        """Add the solution for the last vector, and the vector that it leads to."""
        number, self.done = self.done, self.done + 1
        basis = self.vectors[:, : self.done]
        self.solutions[:, number] = solution
        along = basis.T @ solution
        self.projected[: self.done, number] = self.projected[number, : self.done] = along
        new = solution - basis @ along
        new -= basis @ (basis.T @ new)  # what rounding has left
        length = float(np.linalg.norm(new))
        # the basis has all directions if hardly any part of the solution is new
        is_exhausted = length <= 1e-12 * float(np.linalg.norm(solution))
        self.is_complete = self.done == self.most or is_exhausted or self._are_found(length)
        if not self.is_complete:
            self.vectors[:, self.done] = new / length

    def _ritz(self) -> tuple[FloatArray, FloatArray]:
        """Return the Ritz values, ascending, and their vectors."""
        return np.linalg.eigh(self.projected[: self.done, : self.done])

    def _are_found(self, length: float) -> bool:
        """Whether all negative Ritz values are found; ``length`` is the length of the new part of the last solution."""
        if self.size <= SMALL or self.done < self.count:
            return False
        values, vectors = self._ritz()
        found = length * np.abs(vectors[-1]) <= 0.1 * np.abs(values)  # the residual over the magnitude
        return int(np.count_nonzero(found & (values < 0.0))) >= self.count

    def directions(self) -> FloatArray:
        """Return the directions of the negative Ritz values."""
        if self.count == 0:
            return np.zeros((self.size, 0))
        values, vectors = self._ritz()
        solutions, chosen = self.solutions[:, : self.done], values < 0.0
        if not chosen.any():
            return solutions[:, -1:] / np.linalg.norm(solutions[:, -1])
        found = solutions @ vectors[:, chosen]
        return np.asarray(np.linalg.qr(found / np.linalg.norm(found, axis=0))[0])
