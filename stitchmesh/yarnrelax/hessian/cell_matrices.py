# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The matrices of the cells of a batch as one block-diagonal matrix, and its factors, on any device.

The matrix of all coordinates joins only coordinates of one cell. Coordinates can be left out, because they are held or
because nobody asks for their cell. Vectors have all coordinates of all cells, shape (n,). At coordinates that are left
out, results are zero, and the given values do not matter.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.hessian.negative_directions import negative_directions

REFINEMENTS, REFINED = 8, 1e-3
"""Largest number of conjugate gradients that remove the effect of a shift, and the part of the residual at which they
end."""
SOFTEST = 0.1
"""If the curvature of a direction over the shift is below this, it has no stiffness: the fabric moves as a whole."""


@dataclass(frozen=True, eq=False)
class Owners:
    """The cells to which coordinates belong."""

    cell: NDArray[np.int32]
    """Number of the cell of each coordinate, -1 if the coordinate is left out, shape (n,)."""
    cell_count: int
    """Number C of all cells, also of cells without coordinates."""

    @cached_property
    def owned(self) -> NDArray[np.int64]:
        """Numbers of the coordinates that are not left out, ascending, shape (m,); often they are few."""
        return np.flatnonzero(self.cell >= 0)

    @cached_property
    def cell_of_owned(self) -> NDArray[np.int32]:
        """Number of the cell of each coordinate in ``owned``, shape (m,)."""
        return self.cell[self.owned]

    @cached_property
    def coordinates(self) -> list[NDArray[np.int64]]:
        """The coordinates of each cell that are not left out, ascending."""
        counts = np.bincount(self.cell_of_owned, minlength=self.cell_count)
        return np.split(self.owned[np.argsort(self.cell_of_owned, kind="stable")], np.cumsum(counts)[:-1])

    @cached_property
    def has_coordinates(self) -> NDArray[np.bool_]:
        """Whether each cell has coordinates that are not left out, shape (C,)."""
        return np.bincount(self.cell_of_owned, minlength=self.cell_count) > 0

    @property
    def cells(self) -> list[int]:
        """The cells that have coordinates."""
        return np.flatnonzero(self.has_coordinates).tolist()

    def only(self, cells: NDArray[np.bool_]) -> Owners:
        """Return these owners with the coordinates of the given cells only, shape (C,)."""
        return Owners(np.where(self.are_of(cells), self.cell, np.int32(-1)), self.cell_count)

    def are_of(self, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether each coordinate belongs to one of the given cells, shape (C,), and is not left out."""
        found = np.zeros(len(self.cell), dtype=bool)
        found[self.owned] = cells[self.cell_of_owned]
        return found

    def medians(self, values: FloatArray) -> FloatArray:
        """Return the median of the values of each cell, shape (C,); zero for cells without coordinates."""
        counts = np.bincount(self.cell_of_owned, minlength=self.cell_count)
        own = values[self.owned]
        ordered = own[np.lexsort((own, self.cell_of_owned))]
        first, found = np.cumsum(counts) - counts, np.zeros(self.cell_count)
        there = counts > 0
        low, high = (ordered[(first + (counts - odd) // 2)[there]] for odd in (1, 0))
        found[there] = np.where(low == high, low, (low + high) / 2.0)
        return found

    def sums(self, values: FloatArray) -> FloatArray:
        """Return the sum of the values of each cell, shape (C,)."""
        sums = np.bincount(self.cell_of_owned, values[self.owned], minlength=self.cell_count)
        return np.asarray(sums, dtype=np.float64)

    def each(self, values: FloatArray) -> FloatArray:
        """Return the value of its cell for each coordinate, from values of shape (C,); zero if it is left out."""
        found = np.zeros(len(self.cell))
        found[self.owned] = values[self.cell_of_owned]
        return found


class CellFactors(ABC):
    """The factors of the matrices of some cells."""

    owners: Owners
    matrices: CellMatrices
    """The matrices without their shifts."""
    negative_count: NDArray[np.int64]
    """Number of negative eigenvalues of each cell, shape (C,)."""

    @property
    @abstractmethod
    def negative_pivots(self) -> NDArray[np.int64]:
        """The coordinates whose pivots are negative, ascending."""

    @abstractmethod
    def solve(self, right: FloatArray, cells: NDArray[np.bool_]) -> FloatArray:
        """Return the solution of the linear systems of some cells, shape (C,), for a right-hand side, shape (n,)."""

    def refined(
        self, force: FloatArray, cells: NDArray[np.bool_], exact: NDArray[np.bool_], shift: FloatArray
    ) -> tuple[FloatArray, FloatArray]:  # fmt: skip
        """Return the motions of some cells by their forces, and the work of the forces in them.

        Args:
            force: the forces, shape (n,).
            cells: the cells, shape (C,).
            exact: the cells in whose solutions conjugate gradients remove the effect of the shift, shape (C,).
            shift: the multiple of the identity that was added to each cell's matrix, shape (C,).

        Returns:
            The motions, shape (n,), and the work of each cell, shape (C,).
        """
        found, exact = self.solve(force, cells), cells & exact
        if exact.any():
            found = self._without_shift(found, force, exact, shift)
        return found, self.owners.sums(force * found)

    def _without_shift(
        self, start: FloatArray, force: FloatArray, cells: NDArray[np.bool_], shift: FloatArray
    ) -> FloatArray:  # fmt: skip
        """Return the solution for the matrices of some cells themselves, from the solution for the shifted matrices.

        All cells do each conjugate gradient together, because a GPU takes as long for one cell as for many.
        """
        matrices, owners = self.matrices, self.owners
        enough = REFINED**2 * np.abs(owners.sums(force * start))
        residual = force - matrices.product(start)
        direction = preconditioned = self.solve(residual, cells)
        found, size = start, owners.sums(residual * preconditioned)
        for _ in range(REFINEMENTS):
            product = matrices.product(direction)
            curvature = owners.sums(direction * product)
            cells = cells & (size > enough) & (curvature > SOFTEST * shift * owners.sums(direction * direction))
            if not cells.any():
                break
            ratio = owners.each(np.divide(size, curvature, out=np.zeros_like(size), where=cells))
            found, residual = found + ratio * direction, residual - ratio * product
            preconditioned = self.solve(residual, cells)
            before, size = size, owners.sums(residual * preconditioned)
            growth = np.divide(size, before, out=np.zeros_like(size), where=cells)
            direction = preconditioned + owners.each(growth) * direction
        return found

    def negative_directions(self, cells: Sequence[int]) -> Mapping[int, FloatArray]:
        """Return orthonormal bases of the directions along which the matrices of some cells are negative.

        The basis of a cell has the cell's own coordinates only, shape (m, k) (``negative_directions``).
        """
        own, right = self.owners.coordinates, np.zeros(len(self.owners.cell))

        def solve(asked: Mapping[int, FloatArray]) -> Mapping[int, FloatArray]:
            for cell, vector in asked.items():
                right[own[cell]] = vector
            found = self.solve(right, np.isin(np.arange(self.owners.cell_count), list(asked)))
            return {cell: found[own[cell]] for cell in asked}

        counts = {cell: int(self.negative_count[cell]) for cell in cells}
        return negative_directions(solve, {cell: len(own[cell]) for cell in cells}, counts)


class CellMatrices(ABC):
    """Symmetric matrices of some cells."""

    owners: Owners

    @abstractmethod
    def only(self, cells: NDArray[np.bool_]) -> CellMatrices:
        """Return the matrices of some of these cells, shape (C,)."""

    @abstractmethod
    def diagonal(self) -> FloatArray:
        """Return the entries on the diagonal without couplings, shape (n,), also of coordinates that are left out."""

    def medians(self) -> FloatArray:
        """Return the median of the diagonal of each cell, shape (C,); zero for cells without coordinates."""
        return self.owners.medians(self.diagonal())

    @abstractmethod
    def product(self, vector: FloatArray) -> FloatArray:
        """Return the product with a vector, both of shape (n,)."""

    @abstractmethod
    def factored(self, shift: FloatArray) -> CellFactors:
        """Factor the matrices plus multiples of the identity, one for each cell, shape (C,).

        Raises:
            SolverError: a pivot is zero or not finite, so that a matrix has no such factors.
        """
