# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The matrices of cells in the memory of the host, each with factors of its own (``factored_matrix``).

They are factored one after another, because SciPy uses one core, and several threads would take as long.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.hessian.cell_matrices import CellFactors, CellMatrices, Owners
from stitchmesh.yarnrelax.hessian.couplings import Couplings
from stitchmesh.yarnrelax.hessian.factored_matrix import FactoredMatrix, factored


@dataclass(frozen=True, eq=False)
class MatricesOnHost(CellMatrices):
    """The matrices of cells."""

    matrix: csc_array
    """The matrix of all coordinates, shape (n, n)."""
    owners: Owners
    couplings: Couplings | None = None
    """Couplings of many coordinates; all coordinates then belong to one cell."""

    def only(self, cells: NDArray[np.bool_]) -> MatricesOnHost:
        """Return the matrices of some of these cells, shape (C,)."""
        return replace(self, owners=self.owners.only(cells))

    def diagonal(self) -> FloatArray:
        """Return the entries on the diagonal, shape (n,)."""
        return np.asarray(self.matrix.diagonal())

    def product(self, vector: FloatArray) -> FloatArray:
        """Return the product with a vector, both of shape (n,)."""
        is_in = self.owners.cell >= 0
        found = self.matrix @ np.where(is_in, vector, 0.0)
        if self.couplings is not None:
            found += self.couplings.product(vector)
        return np.asarray(np.where(is_in, found, 0.0))

    def factored(self, shift: FloatArray) -> CellFactors:
        """Factor the matrices plus multiples of the identity."""
        cells = self.owners.cells
        found = {cell: factored(self._of(cell), float(shift[cell]), self.couplings) for cell in cells}
        return FactorsOnHost(found, self)

    def _of(self, cell: int) -> csc_array:
        own = self.owners.coordinates[cell]
        return self.matrix if len(own) == self.matrix.shape[0] else csc_array(self.matrix[:, own][own])


@dataclass(frozen=True, eq=False)
class FactorsOnHost(CellFactors):
    """The factors of the matrices of cells."""

    factors: Mapping[int, FactoredMatrix]
    matrices: MatricesOnHost

    @property
    def owners(self) -> Owners:  # type: ignore[override]
        """The cells to which coordinates belong."""
        return self.matrices.owners

    @cached_property
    def negative_count(self) -> NDArray[np.int64]:  # type: ignore[override]
        """Number of negative eigenvalues of each cell, shape (C,)."""
        count = np.zeros(self.owners.cell_count, dtype=np.int64)
        for cell, own in self.factors.items():
            count[cell] = own.negative_count
        return count

    @property
    def negative_pivots(self) -> NDArray[np.int64]:
        """The coordinates whose pivots are negative."""
        found = [
            self.owners.coordinates[cell][own.pivots[: own.size] < 0.0] for cell, own in self.factors.items()
        ]  # fmt: skip
        return np.sort(np.concatenate(found))

    def solve(self, right: FloatArray, cells: NDArray[np.bool_]) -> FloatArray:
        """Return the solution of the linear systems of some cells."""
        solution = np.zeros(len(right))
        for cell in np.flatnonzero(cells).tolist():
            own = self.owners.coordinates[cell]
            solution[own] = self.factors[cell].solve(right[own])
        return solution
