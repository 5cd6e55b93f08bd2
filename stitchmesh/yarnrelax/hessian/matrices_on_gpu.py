# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The matrices of cells on a GPU, factored as matrices of blocks (``stitchmesh.compute.cudss``).

One factorization of many small blocks takes hardly longer than the factorization of the largest block alone. The
analysis of a pattern takes longer than the factors, and is therefore kept. Cells are analysed and factored in groups,
so that large cells that take no part cost nothing, and a cell with a new pattern does not spoil the analysis of all
others. An order of elimination is not used again for another pattern, because entries that join the parts which it
separates would fill the factors.

The analysed part of a group (``PartOnGpu``) holds the cells whose factors are asked for, and the cells whose factors
were asked for lately, because cells take turns. While the factors of only some cells are asked for, the rows and
columns of the other cells are replaced by rows and columns of the identity. The signs of the pivots of each cell count
its negative eigenvalues. Couplings of many coordinates of a piece are further rows and columns behind its own
(``couplings``); all of its coordinates are then one part.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.cudss import SymmetricFactors
from stitchmesh.compute.host_copy import HostCopy
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.launch import launch
from stitchmesh.compute.thread_block import total_over_block
from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.hessian.cell_matrices import CellFactors, CellMatrices, Owners
from stitchmesh.yarnrelax.hessian.couplings import CouplingRows, Couplings
from stitchmesh.yarnrelax.hessian.factored_matrix import NO_FACTORS

LANES = 32
"""Threads that share a row of a product; the row of a strain has as many entries as its cell has coordinates."""
LATELY = 24
"""A coordinate still takes part for this number of factorizations of its group after its factors were asked for."""


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
def count_upper_entries(
    # model
    row_start: wp.array[wp.int32],
    columns: wp.array[wp.int32],
    diagonal: wp.array[wp.int32],
    coordinates: wp.array[wp.int32],
    number: wp.array[wp.int32],
    # state out
    counts: wp.array[wp.int32],
) -> None:
    """The number of entries in each row of the upper triangle of a part; that of row i stands at place i + 1."""
    i = wp.tid()
    coordinate = coordinates[i]
    found = int(0)
    for k in range(diagonal[coordinate], row_start[coordinate + 1]):
        if number[columns[k]] >= 0:
            found += 1
    counts[i + 1] = found


@kernel
def put_upper_places(
    # model
    row_start: wp.array[wp.int32],
    columns: wp.array[wp.int32],
    diagonal: wp.array[wp.int32],
    coordinates: wp.array[wp.int32],
    number: wp.array[wp.int32],
    upper_start: wp.array[wp.int32],
    # state out
    upper_columns: wp.array[wp.int32],
    places: wp.array[wp.int32],
) -> None:
    """The columns of the upper triangle of a part, and the places of its entries among all entries."""
    i = wp.tid()
    coordinate = coordinates[i]
    place = upper_start[i]
    for k in range(diagonal[coordinate], row_start[coordinate + 1]):
        if number[columns[k]] >= 0:
            upper_columns[place] = number[columns[k]]
            places[place] = k
            place += 1


@kernel
def put_upper_values(
    # model
    upper_start: wp.array[wp.int32],
    counts: wp.array[wp.int32],
    upper_columns: wp.array[wp.int32],
    places: wp.array[wp.int32],
    coordinates: wp.array[wp.int32],
    owner: wp.array[wp.int32],
    shift: wp.array[wp.float64],
    # state in
    entries: wp.array[wp.float64],
    # state out
    values: wp.array[wp.float64],
) -> None:
    """The upper triangle of the shifted matrices, and of the identity where coordinates are left out."""
    i = wp.tid()
    own, first = owner[coordinates[i]], upper_start[i]
    for k in range(first, first + counts[i + 1]):
        value = wp.float64(0.0)
        if own >= 0 and owner[coordinates[upper_columns[k]]] >= 0:
            value = entries[places[k]]
        values[k] = value
    if own >= 0:
        values[first] += shift[own]
    else:
        values[first] = wp.float64(1.0)


Entry: TypeAlias = Any
"""A column or a value of a matrix."""
named_type("Entry", lambda form: [wp.int32, wp.float64])


@kernel
def put_at(
    # model
    places: wp.array[wp.int32],
    # state in
    given: wp.array[Entry],
    # state out
    values: wp.array[Entry],
) -> None:
    """Write what is given to different places."""
    k = wp.tid()
    values[places[k]] = given[k]


@kernel
def mark_difference(
    # state in
    one: wp.array[wp.int32],
    other: wp.array[wp.int32],
    # state out
    differs: wp.array[wp.int32],
) -> None:
    """Set a mark where two arrays differ anywhere."""
    i = wp.tid()
    if one[i] != other[i]:
        differs[0] = 1


@kernel(tile=LANES)
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
    """The places of the entries of matrices on a GPU, and the parts of them that are factored."""

    def __init__(
        self, row_start: wp.array[Any], columns: wp.array[Any], group: NDArray[np.int64], coupled: CouplingRows,
        former: PatternOnGpu | None = None,
    ) -> None:  # fmt: skip
        """Find the upper triangle.

        Args:
            row_start: place on the GPU at which the entries of each row start, shape (n + 1,).
            columns: columns of the entries, ascending in each row and with the diagonal; the pattern is symmetric.
            group: the group of each coordinate, shape (n,); no entry joins two groups.
            coupled: the couplings; only a piece of its own has them.
            former: the last pattern of the same coordinates, groups and couplings. Groups that have not changed use its
                analyses. The caller must not use it afterwards.
        """
        self.device, self.size = row_start.device, len(row_start) - 1
        self.row_start, self.columns, self.coupled = row_start, columns, coupled
        self.diagonal = wp.zeros(self.size, dtype=wp.int32, device=self.device)
        """Place of the diagonal in each row, shape (n,)."""
        launch(find_diagonal, self.size, [self.row_start, self.columns], [self.diagonal], self.device)
        self.vector, self.product = (wp.zeros(self.size, dtype=wp.float64, device=self.device) for _ in range(2))
        """A vector, and its product with a matrix, shape (n,)."""
        self.found_product, self.mark = HostCopy(self.product), object()
        if former is None:
            order = np.argsort(group, kind="stable")
            members = np.split(order, np.flatnonzero(np.diff(group[order])) + 1)
            self._groups = [_Group(coordinates) for coordinates in members]
        else:
            self._groups = former._groups

    def parts_for(self, is_in: NDArray[np.bool_]) -> list[PartOnGpu]:
        """Return the parts with the factors of some coordinates, shape (n,)."""
        chosen = [(group, is_in[group.members]) for group in self._groups]
        return [group.part_for(self, own) for group, own in chosen if own.any()]


class _Group:
    """Coordinates that are factored together, and the last part of them that was factored."""

    def __init__(self, members: NDArray[np.int64]) -> None:
        """Make a group without a part, because nobody has asked for factors yet."""
        self.members = members
        """Numbers of the coordinates, ascending, shape (g,)."""
        self._part: PartOnGpu | None = None
        self._mark: object = None  # of the pattern of the part, whose memory is not kept by it
        self._is_in, self._last_asked = np.zeros(len(members), dtype=bool), np.full(len(members), -LATELY)
        self._asked, self._small = 0, 0

    def part_for(self, pattern: PatternOnGpu, is_in: NDArray[np.bool_]) -> PartOnGpu:
        """Return the part with the factors of some coordinates of the group, shape (g,): the last part, if it suits."""
        self._asked += 1
        self._last_asked[is_in] = self._asked
        part, count = self._part, np.count_nonzero(is_in)
        if part is not None:
            # the part is too large if it has more than twice the coordinates whose factors are asked for
            self._small = self._small + 1 if len(part.coordinates) > 2 * count else 0
        if part is None or self._small >= LATELY or not self._is_in[is_in].all():
            self._part, self._small = None, 0  # Its memory is free before more is taken.
            self._is_in = is_in | (self._last_asked > self._asked - LATELY)
            part = PartOnGpu(pattern, self.members[self._is_in])
        elif self._mark is not pattern.mark:
            part = PartOnGpu(pattern, part.coordinates, part)
        self._part, self._mark = part, pattern.mark
        return part


class PartOnGpu:
    """Some coordinates of matrices on a GPU, and the memory and the analysis of their factors."""

    def __init__(
        self, pattern: PatternOnGpu, coordinates: NDArray[np.int64], former: PartOnGpu | None = None
    ) -> None:  # fmt: skip
        """Find the upper triangle.

        Args:
            pattern: the places of all entries.
            coordinates: numbers of the coordinates, ascending, shape (p,).
            former: the part with the same coordinates in another pattern; its analysis is taken if the entries are the
                same.
        """
        device, count = pattern.device, len(coordinates)
        self.coordinates = coordinates
        number = np.full(pattern.size, -1, dtype=np.int32)
        number[coordinates] = np.arange(count)
        self.own_coordinates, numbers = (
            wp.array(part.astype(np.int32), dtype=wp.int32, device=device) for part in (coordinates, number)
        )
        self.counts, self.upper_start = (wp.zeros(count + 1, dtype=wp.int32, device=device) for _ in range(2))
        """Number of entries of each row of the upper triangle, after a zero, shape (p + 1,); and the place at which
        each row starts, with the rows of the m couplings at the end, shape (p + m + 1,)."""
        inputs = [pattern.row_start, pattern.columns, pattern.diagonal, self.own_coordinates, numbers]
        launch(count_upper_entries, count, inputs, [self.counts], device)
        wp.utils.array_scan(self.counts, self.upper_start, inclusive=True)
        further = further_columns = np.zeros(0, dtype=np.int64)
        if pattern.coupled.first:
            start, further, further_columns = pattern.coupled.after(self.counts.numpy()[1:].astype(np.int64))
            self.upper_start = wp.array(start.astype(np.int32), dtype=wp.int32, device=device)
        entries = int(self.upper_start[len(self.upper_start) - 1 :].numpy()[0])
        self.upper_columns, self.places = (wp.zeros(entries, dtype=wp.int32, device=device) for _ in range(2))
        """Columns of the entries of the upper triangle, and their places among all entries, shape (m,)."""
        launch(put_upper_places, count, [*inputs, self.upper_start], [self.upper_columns, self.places], device)
        self.further, columns = (
            wp.array(part.astype(np.int32), dtype=wp.int32, device=device) for part in (further, further_columns)
        )
        """Places of the entries of couplings in the upper triangle."""
        launch(put_at, len(further), [self.further, columns], [self.upper_columns], device)
        self._former = former if former is not None and self._is_like(former) else None

    def _is_like(self, other: PartOnGpu) -> bool:
        """Return whether another part with as many coordinates has the same entries."""
        if len(self.upper_columns) != len(other.upper_columns):
            return False
        differs = wp.zeros(1, dtype=wp.int32, device=self.upper_start.device)
        for own, others in ((self.upper_start, other.upper_start), (self.upper_columns, other.upper_columns)):
            launch(mark_difference, len(own), [own, others], [differs], own.device)
        return not differs.numpy()[0]

    @cached_property
    def factors(self) -> SymmetricFactors:
        """The memory of the factors, which all matrices use one after another."""
        if self._former is None:
            return SymmetricFactors(self.upper_start, self.upper_columns)
        found, self._former = self._former.factors, None
        return found

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
    couplings: Couplings | None = None
    """Couplings of many coordinates; all coordinates then belong to one cell."""

    def only(self, cells: NDArray[np.bool_]) -> MatricesOnGpu:
        """Return the matrices of some of these cells, shape (C,)."""
        return replace(self, owners=self.owners.only(cells))

    @cached_property
    def owner(self) -> wp.array[Any]:
        """The cell of each coordinate on the GPU, -1 if the coordinate is left out, shape (n,)."""
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
        launch(multiply, pattern.size, inputs, [pattern.product], pattern.device)
        found = pattern.found_product.read()
        return found if self.couplings is None else found + self.couplings.product(vector)

    def factored(self, shift: FloatArray) -> FactorsOnGpu:
        """Factor the matrices plus multiples of the identity."""
        return FactorsOnGpu(self, wp.array(shift, dtype=wp.float64, device=self.pattern.device))

    def put_upper_triangle(self, part: PartOnGpu, shift: wp.array[Any], values: wp.array[Any]) -> None:
        """Write the upper triangle of the shifted matrices of a part; cells that are left out get the identity."""
        places = [part.upper_start, part.counts, part.upper_columns, part.places, part.own_coordinates]
        inputs = [*places, self.owner, shift, self.entries]
        launch(put_upper_values, len(part.coordinates), inputs, [values], self.pattern.device)
        if self.couplings is not None:
            given = wp.array(self.couplings.upper_values, dtype=wp.float64, device=self.pattern.device)
            launch(put_at, len(part.further), [part.further, given], [values], self.pattern.device)


class FactorsOnGpu(CellFactors):
    """The factors of the matrices of cells; if other matrices have taken their memory, they are found again."""

    def __init__(self, matrices: MatricesOnGpu, shift: wp.array[Any]) -> None:
        """Factor the matrices.

        Raises:
            SolverError: a pivot is zero or not finite.
        """
        self.matrices: MatricesOnGpu = matrices
        self._shift, self.owners = shift, matrices.owners
        self._parts = matrices.pattern.parts_for(self.owners.cell >= 0)
        self._mark = object()  # not the object itself: a cycle would keep its memory until garbage is collected
        negative, further = np.zeros(len(self.owners.cell)), 0
        for part in self._parts:
            self._factor(part)
            pivots = part.pivots.read()
            if not np.isfinite(pivots).all() or not pivots.all():
                raise SolverError(NO_FACTORS)
            negative[part.coordinates] = pivots[: len(part.coordinates)] < 0.0
            further += int(np.count_nonzero(pivots[len(part.coordinates) :] > 0.0))
        self.negative_count = self.owners.sums(negative).astype(np.int64) - further
        self._negative_pivots = np.flatnonzero((negative > 0.0) & (self.owners.cell >= 0))

    @property
    def negative_pivots(self) -> NDArray[np.int64]:
        """The coordinates whose pivots are negative."""
        return self._negative_pivots

    def _factor(self, part: PartOnGpu) -> None:
        self.matrices.put_upper_triangle(part, self._shift, part.factors.values)
        part.factors.factor()
        part.factors.holder = self._mark

    def solve(self, right: FloatArray, cells: NDArray[np.bool_]) -> FloatArray:
        """Return the solution of the linear systems of some cells."""
        chosen, found = self.owners.are_of(cells), np.zeros(len(right))
        solved = list[tuple[PartOnGpu, NDArray[np.bool_]]]()
        for part in self._parts:
            own = chosen[part.coordinates]
            if own.any():
                if part.factors.holder is not self._mark:
                    self._factor(part)
                given = np.zeros(len(part.factors.right))
                given[: len(own)] = np.where(own, right[part.coordinates], 0.0)
                part.factors.right.assign(given)
                part.factors.solve()
                solved.append((part, own))
        for part, own in solved:
            found[part.coordinates] = np.where(own, part.solution.read()[: len(own)], 0.0)
        return found
