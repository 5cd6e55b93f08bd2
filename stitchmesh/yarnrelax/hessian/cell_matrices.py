# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The matrices of the cells of a batch as one matrix of blocks, and its factors; where they are found is left open.

The matrix of all coordinates joins only coordinates of one cell. Coordinates can be left out, because they are held or
because nothing is asked of their cell. Vectors have all coordinates of all cells, shape (n,); what is returned is zero
at coordinates that are left out, and what is given there does not matter.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray


@dataclass(frozen=True, eq=False)
class Owners:
    """The cells to which coordinates belong."""

    cell: NDArray[np.int32]
    """Number of the cell of each coordinate, -1 where it is left out, shape (n,)."""
    cell_count: int
    """Number C of all cells."""

    @cached_property
    def coordinates(self) -> list[NDArray[np.int64]]:
        """Numbers of the coordinates of each cell that are not left out, ascending."""
        counts = np.bincount(self.cell + 1, minlength=self.cell_count + 1)
        return np.split(np.argsort(self.cell, kind="stable"), np.cumsum(counts)[:-1])[1:]

    @property
    def cells(self) -> list[int]:
        """The cells that have coordinates."""
        return [cell for cell, own in enumerate(self.coordinates) if len(own)]

    def only(self, cells: NDArray[np.bool_]) -> Owners:
        """These without the coordinates of other cells than some, shape (C,)."""
        return Owners(np.where(self.are_of(cells), self.cell, np.int32(-1)), self.cell_count)

    def are_of(self, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether each coordinate belongs to one of some cells, shape (C,), and is not left out."""
        return np.append(cells, False)[self.cell]

    def sums(self, values: FloatArray) -> FloatArray:
        """The sum of the values of each cell, shape (C,)."""
        return np.asarray(np.bincount(self.cell + 1, values, minlength=self.cell_count + 1)[1:], dtype=np.float64)

    def each(self, values: FloatArray) -> FloatArray:
        """The value of its cell for each coordinate, from values of shape (C,); zero where it is left out."""
        return np.append(values, 0.0)[self.cell]


class CellFactors(ABC):
    """The factors of the matrices of some cells."""

    negative_count: NDArray[np.int64]
    """Number of negative eigenvalues of each cell, shape (C,)."""

    @abstractmethod
    def solve(self, right: FloatArray, cells: NDArray[np.bool_]) -> FloatArray:
        """Return the solution of the linear systems of some cells, shape (C,), for a right-hand side, shape (n,)."""

    @abstractmethod
    def negative_eigenvectors(self, cells: Sequence[int]) -> Mapping[int, FloatArray]:
        """Return orthonormal eigenvectors of the negative eigenvalues of some cells, of all that are found.

        Those of a cell have its own coordinates only, shape (m, k).
        """


class CellMatrices(ABC):
    """Symmetric matrices of some cells."""

    owners: Owners

    @abstractmethod
    def only(self, cells: NDArray[np.bool_]) -> CellMatrices:
        """The matrices of some of these cells, shape (C,)."""

    @abstractmethod
    def diagonal(self) -> FloatArray:
        """Return the entries on the diagonal, shape (n,), also where coordinates are left out."""

    @abstractmethod
    def product(self, vector: FloatArray) -> FloatArray:
        """Return the product with a vector, both of shape (n,)."""

    @abstractmethod
    def factored(self, shift: FloatArray) -> CellFactors:
        """Factor the matrices plus multiples of the identity, one for each cell, shape (C,).

        Raises:
            SolverError: a pivot is zero or not finite, so that a matrix has no such factors.
        """
