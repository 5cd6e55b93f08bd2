# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The matrices of cells on a GPU, factored all at once as one matrix of blocks (``stitchmesh.compute.cudss``).

One factorization of many small blocks takes less time than many of one block. The matrix of all coordinates is
factored: the rows and columns of those that are left out become those of the identity. The pattern is then the same for
any choice of cells, and its analysis, which takes longer than the factors, is kept for as long as the same segments
touch. The signs of the pivots of each cell count its negative eigenvalues.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.cudss import SymmetricFactors
from stitchmesh.compute.host_copy import HostCopy
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.thread_block import total_over_block
from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.hessian.cell_matrices import CellFactors, CellMatrices, Owners
from stitchmesh.yarnrelax.hessian.factored_matrix import NO_FACTORS

LANES = 32
"""Threads that share a row of a product; rows of strains have as many entries as their cell has coordinates."""


@kernel
def find_diagonal(
    # model
    row_start: wp.array[wp.int32],
    columns: wp.array[wp.int32],
    # state out
    diagonal: wp.array[wp.int32],
) -> None:
    """The place of the diagonal in each row; what follows it in the row is the upper triangle."""
    i = wp.tid()
    low, high = int(row_start[i]), int(row_start[i + 1])
    while low < high:
        middle = (low + high) // 2
        if columns[middle] < i:
            low = middle + 1
        else:
            high = middle
    diagonal[i] = low


@kernel
def copy_upper_columns(
    # model
    columns: wp.array[wp.int32],
    diagonal: wp.array[wp.int32],
    upper_start: wp.array[wp.int32],
    # state out
    upper_columns: wp.array[wp.int32],
) -> None:
    """The columns of the upper triangle."""
    i = wp.tid()
    first = upper_start[i]
    for k in range(first, upper_start[i + 1]):
        upper_columns[k] = columns[diagonal[i] + k - first]


@kernel
def put_upper_values(
    # model
    columns: wp.array[wp.int32],
    diagonal: wp.array[wp.int32],
    upper_start: wp.array[wp.int32],
    owner: wp.array[wp.int32],
    shift: wp.array[wp.float64],
    # state in
    entries: wp.array[wp.float64],
    # state out
    values: wp.array[wp.float64],
) -> None:
    """The upper triangle of the shifted matrices, and of the identity where coordinates are left out."""
    i = wp.tid()
    own, first, place = owner[i], upper_start[i], diagonal[i]
    for k in range(first, upper_start[i + 1]):
        value = wp.float64(0.0)
        if own >= 0 and owner[columns[place + k - first]] >= 0:
            value = entries[place + k - first]
        values[k] = value
    if own >= 0:
        values[first] += shift[own]
    else:
        values[first] = wp.float64(1.0)


@kernel
def multiply(
    # model
    row_start: wp.array[wp.int32],
    columns: wp.array[wp.int32],
    owner: wp.array[wp.int32],
    # state in
    entries: wp.array[wp.float64],
    vector: wp.array[wp.float64],
    # state out
    product: wp.array[wp.float64],
) -> None:
    """The product with a vector; one block for each row."""
    i, lane = wp.tid()
    part = wp.float64(0.0)
    if owner[i] >= 0:
        for k in range(row_start[i] + lane, row_start[i + 1], wp.block_dim()):
            j = columns[k]
            if owner[j] >= 0:
                part += entries[k] * vector[j]
    total = total_over_block(part)
    if lane == 0:
        product[i] = total


@kernel
def copy_diagonal(
    # model
    diagonal: wp.array[wp.int32],
    # state in
    entries: wp.array[wp.float64],
    # state out
    found: wp.array[wp.float64],
) -> None:
    """The entries on the diagonal."""
    i = wp.tid()
    found[i] = entries[diagonal[i]]


class PatternOnGpu:
    """The places of the entries of matrices on a GPU, and the memory and the analysis of their factors."""

    def __init__(self, row_start: NDArray[np.int32], columns: NDArray[np.int32], device: wp.Device) -> None:
        """Find the upper triangle.

        Args:
            row_start: where the entries of each row start, shape (n + 1,).
            columns: their columns, ascending in each row and with the diagonal; the pattern is symmetric.
            device: the GPU.
        """
        self.device, self.size = device, len(row_start) - 1
        self.row_start, self.columns = (wp.array(part, dtype=wp.int32, device=device) for part in (row_start, columns))
        self.diagonal = wp.zeros(self.size, dtype=wp.int32, device=device)
        """Place of the diagonal in each row, shape (n,)."""
        launch(find_diagonal, self.size, [self.row_start, self.columns], [self.diagonal], device)
        upper_start = np.concatenate([[0], np.cumsum(row_start[1:] - self.diagonal.numpy())]).astype(np.int32)
        self.upper_start = wp.array(upper_start, dtype=wp.int32, device=device)
        """Where each row of the upper triangle starts, shape (n + 1,)."""
        self.upper_columns = wp.zeros(int(upper_start[-1]), dtype=wp.int32, device=device)
        inputs = [self.columns, self.diagonal, self.upper_start]
        launch(copy_upper_columns, self.size, inputs, [self.upper_columns], device)
        self.vector, self.product = (wp.zeros(self.size, dtype=wp.float64, device=device) for _ in range(2))
        """A vector, and its product with a matrix, shape (n,)."""
        self.found_product = HostCopy(self.product)
        self.factored: object = None
        """The mark of those whose factors are in memory."""

    @cached_property
    def factors(self) -> SymmetricFactors:
        """The memory of the factors, which all matrices of this pattern use one after the other."""
        return SymmetricFactors(self.upper_start, self.upper_columns)

    @cached_property
    def solution(self) -> HostCopy:
        """The solution of a linear system."""
        return HostCopy(self.factors.solution)

    @cached_property
    def pivots(self) -> HostCopy:
        """The pivots, in the order of the rows."""
        return HostCopy(self.factors.pivots)


@dataclass(frozen=True, eq=False)
class MatricesOnGpu(CellMatrices):
    """The matrices of cells."""

    pattern: PatternOnGpu
    entries: wp.array[Any]
    """The entries of the matrix of all coordinates, shape (m,)."""
    owners: Owners

    def only(self, cells: NDArray[np.bool_]) -> MatricesOnGpu:
        """The matrices of some of these cells, shape (C,)."""
        return MatricesOnGpu(self.pattern, self.entries, self.owners.only(cells))

    @cached_property
    def owner(self) -> wp.array[Any]:
        """The cell of each coordinate on the GPU, -1 where it is left out, shape (n,)."""
        return wp.array(self.owners.cell, dtype=wp.int32, device=self.pattern.device)

    def diagonal(self) -> FloatArray:
        """Return the entries on the diagonal, shape (n,)."""
        pattern = self.pattern
        launch(copy_diagonal, pattern.size, [pattern.diagonal, self.entries], [pattern.product], pattern.device)
        return pattern.found_product.read()

    def product(self, vector: FloatArray) -> FloatArray:
        """Return the product with a vector, both of shape (n,)."""
        pattern = self.pattern
        pattern.vector.assign(vector)
        inputs = [pattern.row_start, pattern.columns, self.owner, self.entries, pattern.vector]
        launch(multiply, pattern.size, inputs, [pattern.product], pattern.device, tile=LANES)
        return pattern.found_product.read()

    def factored(self, shift: FloatArray) -> FactorsOnGpu:
        """Factor the matrices plus multiples of the identity."""
        return FactorsOnGpu(self, wp.array(shift, dtype=wp.float64, device=self.pattern.device))

    def put_upper_triangle(self, shift: wp.array[Any], values: wp.array[Any]) -> None:
        """Write the upper triangle of the shifted matrices, with the identity where coordinates are left out."""
        pattern = self.pattern
        inputs = [pattern.columns, pattern.diagonal, pattern.upper_start, self.owner, shift, self.entries]
        launch(put_upper_values, pattern.size, inputs, [values], pattern.device)


class FactorsOnGpu(CellFactors):
    """The factors of the matrices of cells; where others have taken their memory, they are found again."""

    def __init__(self, matrices: MatricesOnGpu, shift: wp.array[Any]) -> None:
        """Factor.

        Raises:
            SolverError: a pivot is zero or not finite.
        """
        self._matrices, self._shift, self.owners = matrices, shift, matrices.owners
        self._mark = object()  # not itself: as a cycle it would keep its memory until garbage is collected
        self._factor()
        pivots = matrices.pattern.pivots.read()
        if not np.isfinite(pivots).all() or not pivots.all():
            raise SolverError(NO_FACTORS)
        self.negative_count = matrices.owners.sums((pivots < 0.0).astype(np.float64)).astype(np.int64)

    def _factor(self) -> None:
        pattern = self._matrices.pattern
        self._matrices.put_upper_triangle(self._shift, pattern.factors.values)
        pattern.factors.factor()
        pattern.factored = self._mark

    def solve(self, right: FloatArray, cells: NDArray[np.bool_]) -> FloatArray:
        """Return the solution of the linear systems of some cells."""
        pattern = self._matrices.pattern
        if pattern.factored is not self._mark:
            self._factor()
        chosen = self._matrices.owners.are_of(cells)
        pattern.factors.right.assign(np.where(chosen, right, 0.0))
        pattern.factors.solve()
        return np.asarray(np.where(chosen, pattern.solution.read(), 0.0))
