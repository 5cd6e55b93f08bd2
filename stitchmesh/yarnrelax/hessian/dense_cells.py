# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The matrices of many small cells as dense matrices, each factored and solved by one block of threads.

In a small cell nearly every control point touches a third of the others, and the factors of its matrix are full. A
sparse factorization then gains nothing, but needs an analysis of each pattern on the host. Here a block of threads
copies the sparse matrix A = M + t I of its cell into a square of n x n numbers and factors it in place, without an
exchange of rows, as

    A = L D L^T        L with ones on its diagonal

The square then holds L below the diagonal, D on it, and D L^T above it. Columns are taken in panels of ``PANEL``: each
thread factors the square of the panel on the diagonal, finishes its own rows of the panel with it, and the rest of the
matrix then takes the whole panel at once,

    A_ij <- A_ij - sum over the columns q of the panel of L_iq (D L^T)_qj        j <= i

The signs of D count the negative eigenvalues (Sylvester). A solution goes forward and backward by the same panels. The
conjugate gradients that remove the effect of t (``newton_system``) run in the same launch, with the sparse matrix M.

No cell reads numbers of another one, and every sum has a fixed order, so the bits of a cell's step do not depend on the
other cells. Coordinates that are left out have the rows and columns of the identity.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.free_memory import available_memory
from stitchmesh.compute.host_copy import HostCopy
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.thread_block import total_over_block, wait_for_block
from stitchmesh.errors import SolverError
from stitchmesh.mesh import FloatArray
from stitchmesh.yarnrelax.hessian.cell_matrices import (
    REFINED,
    REFINEMENTS,
    SOFTEST,
    CellFactors,
    CellMatrices,
    Owners,
)
from stitchmesh.yarnrelax.hessian.factored_matrix import NO_FACTORS
from stitchmesh.yarnrelax.hessian.matrices_on_gpu import copy_diagonal, find_diagonal, multiply

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.hessian.matrix_pattern import MatrixPattern

PANEL = wp.constant(8)
"""Columns that are eliminated together."""
WARP = wp.constant(32)
"""Threads of a GPU that run in step; they share a row of the matrix."""
LARGEST_DENSE = 1280
"""Largest number of coordinates of a cell whose matrix is factored as a dense one."""
THREADS = 256
"""Threads of a block that factors the matrix of a cell on a GPU."""
LARGEST_ARRAY = 2**30
"""Largest number of entries of an array with the matrices of a group."""
PART_OF_MEMORY = 0.25
"""Part of the free memory of a GPU that dense matrices may take."""
PanelValues = wp.types.vector(length=8, dtype=wp.float64)
PanelSquare = wp.types.matrix(shape=(8, 8), dtype=wp.float64)


@wp.struct
class DenseMatrices:
    """Where the cells of a group stand among all coordinates, and where their squares stand in an array."""

    first_point: wp.array[wp.int32]
    """First coordinate of the control points of each cell."""
    point_coordinates: wp.array[wp.int32]
    """Number of coordinates of the control points of each cell."""
    first_strain: wp.array[wp.int32]
    """First coordinate of the strain of each cell."""
    size: wp.array[wp.int32]
    """Number n of coordinates of each cell."""
    first_entry: wp.array[wp.int32]
    """First entry of the square of each cell."""
    entries: wp.array[wp.float64]
    """The squares, row by row."""


@wp.struct
class SparseMatrix:
    """The matrix of all coordinates, row by row, and the cell of each coordinate, -1 where it is left out."""

    row_start: wp.array[wp.int32]
    columns: wp.array[wp.int32]
    diagonal: wp.array[wp.int32]
    entries: wp.array[wp.float64]
    owner: wp.array[wp.int32]


@wp.func
def coordinate_of(dense: DenseMatrices, cell: int, i: int) -> int:
    """The coordinate of a row of a cell's square."""
    count = dense.point_coordinates[cell]
    if i < count:
        return dense.first_point[cell] + i
    return dense.first_strain[cell] + i - count


@wp.func
def row_of(dense: DenseMatrices, cell: int, coordinate: int) -> int:
    """The row of a coordinate in its cell's square."""
    count = dense.point_coordinates[cell]
    own = coordinate - dense.first_point[cell]
    if own >= 0 and own < count:
        return own
    return count + coordinate - dense.first_strain[cell]


@kernel(tile=THREADS)
def find_medians(
    # model
    chosen: wp.array[wp.int32],
    dense: DenseMatrices,
    sparse: SparseMatrix,
    # state out
    middle: wp.array2d[wp.float64],
) -> None:
    """The two middle values of the diagonal of each cell, equal if their number is odd: an entry's rank decides."""
    block, lane = wp.tid()
    cell = chosen[block]
    size = dense.size[cell]
    part = wp.float64(0.0)
    for i in range(lane, size, wp.block_dim()):
        if sparse.owner[coordinate_of(dense, cell, i)] >= 0:
            part += wp.float64(1.0)
    count = int(total_over_block(part))
    for i in range(lane, size, wp.block_dim()):
        own = coordinate_of(dense, cell, i)
        if sparse.owner[own] >= 0:
            value = sparse.entries[sparse.diagonal[own]]
            rank = int(0)
            for j in range(size):
                other = coordinate_of(dense, cell, j)
                if sparse.owner[other] >= 0:
                    against = sparse.entries[sparse.diagonal[other]]
                    if against < value or (against == value and j < i):
                        rank += 1
            if rank == (count - 1) // 2:
                middle[cell, 0] = value
            if rank == count // 2:
                middle[cell, 1] = value


@wp.func
def put_square(
    cell: int, lane: int, threads: int, dense: DenseMatrices, sparse: SparseMatrix, shift: wp.float64
) -> None:
    """Copy the lower triangle of the shifted matrix of a cell into its square."""
    size, first = dense.size[cell], dense.first_entry[cell]
    for k in range(lane, size * size, threads):
        dense.entries[first + k] = wp.float64(0.0)
    wait_for_block()
    width = wp.min(threads, WARP)  # the threads of a warp share a row
    for i in range(lane // width, size, threads // width):
        own = coordinate_of(dense, cell, i)
        row = first + i * size
        if sparse.owner[own] >= 0:
            for k in range(sparse.row_start[own] + lane % width, sparse.row_start[own + 1], width):
                other = sparse.columns[k]
                if sparse.owner[other] >= 0:
                    j = row_of(dense, cell, other)
                    if j < i:
                        dense.entries[row + j] = sparse.entries[k]
                    elif j == i:
                        dense.entries[row + j] = sparse.entries[k] + shift
        elif lane % width == 0:
            dense.entries[row + i] = wp.float64(1.0)
    wait_for_block()


@wp.func
def factor_square(
    first: int, size: int, start: int, entries: wp.array[wp.float64]
) -> PanelSquare:  # type: ignore[valid-type]
    """The factors of the square of a panel on the diagonal: L below the diagonal, D on it, and D L^T above it.

    Each thread finds them for itself, because an exchange between threads takes longer. Rows behind the last row are
    rows of the identity.
    """
    square = PanelSquare()
    for p in range(PANEL):
        square[p, p] = wp.float64(1.0)
        if start + p < size:
            for q in range(PANEL):
                if q <= p:
                    square[p, q] = entries[first + (start + p) * size + start + q]
    for c in range(PANEL):
        for p in range(PANEL):
            if p >= c:
                value = square[p, c]
                for q in range(PANEL):
                    if q < c:
                        value -= square[p, q] * square[q, c]
                square[p, c] = value
        for p in range(PANEL):
            if p > c:
                square[c, p] = square[p, c]
                square[p, c] = square[p, c] / square[c, c]
    return square


@wp.func
def eliminate_panel(
    first: int, size: int, start: int, lane: int, threads: int, entries: wp.array[wp.float64]
) -> None:
    """Finish the columns of a panel: L below the diagonal, D on it, and D L^T above it."""
    square = factor_square(first, size, start, entries)
    wait_for_block()
    if lane == 0:
        for p in range(PANEL):
            for q in range(PANEL):
                if start + p < size and start + q < size:
                    entries[first + (start + p) * size + start + q] = square[p, q]
    for i in range(start + PANEL + lane, size, threads):
        row = first + i * size + start
        own = PanelValues()
        for c in range(PANEL):
            value = entries[row + c]
            for q in range(PANEL):
                if q < c:
                    value -= own[q] * square[q, c]
            entries[first + (start + c) * size + i] = value
            own[c] = value / square[c, c]
        for c in range(PANEL):
            entries[row + c] = own[c]
    wait_for_block()


@wp.func
def take_panel(first: int, size: int, start: int, lane: int, threads: int, entries: wp.array[wp.float64]) -> None:
    """Subtract the products of a whole panel from the triangle behind it; the threads of a warp share a row.

    A thread takes four columns at once, because it waits for memory most of the time.
    """
    width = wp.min(threads, WARP)
    begin = start + PANEL
    for i in range(begin + lane // width, size, threads // width):
        row = first + i * size
        own = PanelValues()
        for q in range(PANEL):
            own[q] = entries[row + start + q]
        for j in range(begin + lane % width, i + 1, 4 * width):
            second, third, fourth = wp.min(j + width, i), wp.min(j + 2 * width, i), wp.min(j + 3 * width, i)
            values = wp.vec4d(entries[row + j], entries[row + second], entries[row + third], entries[row + fourth])
            for q in range(PANEL):
                upper = first + (start + q) * size
                values[0] -= own[q] * entries[upper + j]
                values[1] -= own[q] * entries[upper + second]
                values[2] -= own[q] * entries[upper + third]
                values[3] -= own[q] * entries[upper + fourth]
            entries[row + j] = values[0]
            if j + width <= i:
                entries[row + second] = values[1]
            if j + 2 * width <= i:
                entries[row + third] = values[2]
            if j + 3 * width <= i:
                entries[row + fourth] = values[3]
    wait_for_block()


@kernel(tile=THREADS)
def factor_cells(
    # model
    chosen: wp.array[wp.int32],
    shift: wp.array[wp.float64],
    # state in
    sparse: SparseMatrix,
    # state in and out
    dense: DenseMatrices,
    # state out
    pivots: wp.array[wp.float64],
) -> None:
    """Factor the shifted matrix of a cell; one block for each chosen cell."""
    block, lane = wp.tid()
    threads = wp.block_dim()
    cell = chosen[block]
    size, first = dense.size[cell], dense.first_entry[cell]
    put_square(cell, lane, threads, dense, sparse, shift[cell])
    for panel in range((size + PANEL - 1) // PANEL):
        start = panel * PANEL
        eliminate_panel(first, size, start, lane, threads, dense.entries)
        if start + PANEL < size:
            take_panel(first, size, start, lane, threads, dense.entries)
    for i in range(lane, size, threads):
        pivots[coordinate_of(dense, cell, i)] = dense.entries[first + i * size + i]


@kernel(tile=THREADS)
def count_signs(
    # model
    chosen: wp.array[wp.int32],
    dense: DenseMatrices,
    owner: wp.array[wp.int32],
    # state in
    pivots: wp.array[wp.float64],
    # state out
    signs: wp.array2d[wp.float64],
) -> None:
    """The number of negative pivots of a cell, and of pivots that are zero or not finite; one block for each cell."""
    block, lane = wp.tid()
    cell = chosen[block]
    negative, broken = wp.float64(0.0), wp.float64(0.0)
    for i in range(lane, dense.size[cell], wp.block_dim()):
        own = coordinate_of(dense, cell, i)
        if owner[own] >= 0:
            if not wp.isfinite(pivots[own]) or pivots[own] == wp.float64(0.0):
                broken += wp.float64(1.0)
            elif pivots[own] < wp.float64(0.0):
                negative += wp.float64(1.0)
    signs[cell, 0] = total_over_block(negative)
    signs[cell, 1] = total_over_block(broken)


@wp.func
def solve_in_block(
    cell: int, lane: int, threads: int, dense: DenseMatrices, vector: wp.array[wp.float64]
) -> None:
    """Replace a vector, which has the coordinates of all cells, by its solution in one cell."""
    size, first = dense.size[cell], dense.first_entry[cell]
    panels = (size + PANEL - 1) // PANEL
    for panel in range(panels):
        start = panel * PANEL
        found = PanelValues()
        for p in range(PANEL):
            if start + p < size:
                value = vector[coordinate_of(dense, cell, start + p)]
                for q in range(p):
                    value -= dense.entries[first + (start + p) * size + start + q] * found[q]
                found[p] = value
        wait_for_block()
        for i in range(start + PANEL + lane, size, threads):
            own = coordinate_of(dense, cell, i)
            value = vector[own]
            for p in range(PANEL):
                value -= dense.entries[first + i * size + start + p] * found[p]
            vector[own] = value
        if lane == 0:
            for p in range(PANEL):
                if start + p < size:
                    vector[coordinate_of(dense, cell, start + p)] = found[p]
        wait_for_block()
    for i in range(lane, size, threads):
        own = coordinate_of(dense, cell, i)
        vector[own] = vector[own] / dense.entries[first + i * size + i]
    wait_for_block()
    for panel in range(panels):
        start = (panels - 1 - panel) * PANEL
        found = PanelValues()
        for back in range(PANEL):
            p = PANEL - 1 - back
            if start + p < size:
                value = vector[coordinate_of(dense, cell, start + p)]
                for q in range(PANEL):
                    if q > p and start + q < size:
                        value -= dense.entries[first + (start + q) * size + start + p] * found[q]
                found[p] = value
        wait_for_block()
        for j in range(lane, start, threads):
            own = coordinate_of(dense, cell, j)
            value = vector[own]
            for p in range(PANEL):
                if start + p < size:
                    value -= dense.entries[first + (start + p) * size + j] * found[p]
            vector[own] = value
        if lane == 0:
            for p in range(PANEL):
                if start + p < size:
                    vector[coordinate_of(dense, cell, start + p)] = found[p]
        wait_for_block()


@wp.func
def product_at(own: int, sparse: SparseMatrix, vector: wp.array[wp.float64]) -> wp.float64:
    """A coordinate of the product of the matrix with a vector; zero where the coordinate is left out."""
    total = wp.float64(0.0)
    if sparse.owner[own] >= 0:
        for k in range(sparse.row_start[own], sparse.row_start[own + 1]):
            other = sparse.columns[k]
            if sparse.owner[other] >= 0:
                total += sparse.entries[k] * vector[other]
    return total


@wp.struct
class SolverVectors:
    """Vectors with the coordinates of all cells."""

    right: wp.array[wp.float64]
    solution: wp.array[wp.float64]
    residual: wp.array[wp.float64]
    preconditioned: wp.array[wp.float64]
    direction: wp.array[wp.float64]
    product: wp.array[wp.float64]


@kernel(tile=THREADS)
def solve_cells(
    # model
    chosen: wp.array[wp.int32],
    shift: wp.array[wp.float64],
    is_refined: wp.array[wp.int32],
    # state in
    sparse: SparseMatrix,
    dense: DenseMatrices,
    # state in and out
    vectors: SolverVectors,
    # state out
    work: wp.array[wp.float64],
) -> None:
    """Solve the linear system of a cell, and refine the solution by conjugate gradients; one block for each cell.

    The loop is ``CellFactors.refined`` for one cell.
    """
    block, lane = wp.tid()
    threads = wp.block_dim()
    cell = chosen[block]
    size = dense.size[cell]
    for i in range(lane, size, threads):
        own = coordinate_of(dense, cell, i)
        vectors.solution[own] = wp.where(sparse.owner[own] >= 0, vectors.right[own], wp.float64(0.0))
    wait_for_block()
    solve_in_block(cell, lane, threads, dense, vectors.solution)
    part = wp.float64(0.0)
    if is_refined[cell] != 0:
        first, along = wp.float64(0.0), wp.float64(0.0)
        for i in range(lane, size, threads):
            own = coordinate_of(dense, cell, i)
            if sparse.owner[own] >= 0:
                first += vectors.right[own] * vectors.solution[own]
                vectors.residual[own] = vectors.right[own] - product_at(own, sparse, vectors.solution)
            else:
                vectors.residual[own] = wp.float64(0.0)
            vectors.preconditioned[own] = vectors.residual[own]
        enough = wp.float64(REFINED) * wp.float64(REFINED) * wp.abs(total_over_block(first))
        wait_for_block()
        solve_in_block(cell, lane, threads, dense, vectors.preconditioned)
        for i in range(lane, size, threads):
            own = coordinate_of(dense, cell, i)
            vectors.direction[own] = vectors.preconditioned[own]
            along += vectors.residual[own] * vectors.preconditioned[own]
        left = total_over_block(along)
        step, goes_on = int(0), int(1)
        while goes_on != 0 and step < REFINEMENTS:
            bent, square = wp.float64(0.0), wp.float64(0.0)
            for i in range(lane, size, threads):
                own = coordinate_of(dense, cell, i)
                value = vectors.direction[own]
                vectors.product[own] = product_at(own, sparse, vectors.direction)
                bent += value * vectors.product[own]
                square += value * value
            curvature, length = total_over_block(bent), total_over_block(square)
            if left > enough and curvature > wp.float64(SOFTEST) * shift[cell] * length:
                ratio = left / curvature
                for i in range(lane, size, threads):
                    own = coordinate_of(dense, cell, i)
                    vectors.solution[own] += ratio * vectors.direction[own]
                    vectors.residual[own] -= ratio * vectors.product[own]
                    vectors.preconditioned[own] = vectors.residual[own]
                wait_for_block()
                solve_in_block(cell, lane, threads, dense, vectors.preconditioned)
                along = wp.float64(0.0)
                for i in range(lane, size, threads):
                    own = coordinate_of(dense, cell, i)
                    along += vectors.residual[own] * vectors.preconditioned[own]
                before = left
                left = total_over_block(along)
                for i in range(lane, size, threads):
                    own = coordinate_of(dense, cell, i)
                    vectors.direction[own] = vectors.preconditioned[own] + left / before * vectors.direction[own]
                wait_for_block()
            else:
                goes_on = 0
            step += 1
    for i in range(lane, size, threads):
        own = coordinate_of(dense, cell, i)
        if sparse.owner[own] >= 0:
            part += vectors.right[own] * vectors.solution[own]
    work[cell] = total_over_block(part)


class DenseCells:
    """The memory of the dense matrices of all cells of a batch, on any device; matrices take it one after another."""

    def __init__(self, point_coordinates: NDArray[np.int64], strains: int, device: wp.Device) -> None:
        """Divide the cells into groups.

        Args:
            point_coordinates: number of coordinates of the control points of each cell, shape (C,).
            strains: number of coordinates of the strain of each cell, behind the coordinates of all control points.
            device: where the kernels run.
        """
        count, total = len(point_coordinates), int(point_coordinates.sum())
        self.device, self.size = device, total + strains * count
        first_point = np.concatenate([[0], np.cumsum(point_coordinates)[:-1]])
        sizes = point_coordinates + strains
        places = {"first_point": first_point, "point_coordinates": point_coordinates,
                  "first_strain": total + strains * np.arange(count), "size": sizes}  # fmt: skip
        self._places = {name: self._integers(place) for name, place in places.items()}
        self._sizes = sizes
        self.groups = [_Group(self, members) for members in _groups(sizes)]
        self.vectors = SolverVectors()
        for name in ("right", "solution", "residual", "preconditioned", "direction", "product"):
            setattr(self.vectors, name, self._numbers(self.size))
        self.pivots, self.work = self._numbers(self.size), self._numbers(count)
        self.pairs = wp.zeros((count, 2), dtype=wp.float64, device=device)
        """Two values of each cell, which a launch returns, shape (C, 2)."""
        self.found_solution, self.found_work = HostCopy(self.vectors.solution), HostCopy(self.work)
        self.found_pairs, self.found_pivots = HostCopy(self.pairs), HostCopy(self.pivots)
        self.holder = np.zeros(count, dtype=np.int64)
        """The number of the factors that each cell has at present, shape (C,); 0 for none."""
        self.factored = 0
        """How many factors have taken the memory."""

    @staticmethod
    def suit(sizes: NDArray[np.int64], device: wp.Device) -> bool:
        """Whether cells of these numbers of coordinates are factored as dense matrices on a device."""
        if not device.is_cuda or sizes.max() > LARGEST_DENSE:
            return False
        return bool(8.0 * (sizes.astype(np.float64) ** 2).sum() < PART_OF_MEMORY * available_memory(device))

    def _integers(self, values: NDArray[Any]) -> wp.array[Any]:
        return wp.array(values.astype(np.int32), dtype=wp.int32, device=self.device)

    def _numbers(self, count: int) -> wp.array[Any]:
        return wp.zeros(count, dtype=wp.float64, device=self.device)

    def launch(self, kernel: wp.Kernel, cells: NDArray[np.bool_], inputs: list[Any], outputs: list[Any]) -> None:
        """Run a kernel with one block for each of some cells, group by group; ``inputs`` may name ``DenseMatrices``."""
        for group in self.groups:
            numbers = group.members[cells[group.members]]
            if len(numbers):
                given = [group.dense if each is DenseMatrices else each for each in inputs]
                arguments = [self._integers(numbers), *given]
                launch(kernel, len(numbers), arguments, outputs, self.device)


class _Group:
    """Cells whose matrices stand in one array."""

    def __init__(self, cells: DenseCells, members: NDArray[np.int64]) -> None:
        self.members = members
        squares = cells._sizes[members] ** 2
        first = np.zeros(len(cells._sizes), dtype=np.int64)
        first[members] = np.concatenate([[0], np.cumsum(squares)[:-1]])
        self.dense = DenseMatrices()
        for name, place in cells._places.items():
            setattr(self.dense, name, place)
        self.dense.first_entry = cells._integers(first)
        self.dense.entries = cells._numbers(int(squares.sum()))


def _groups(sizes: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The cells of each group, of which only the last ones are smaller than others; their squares fit in an array."""
    order = np.argsort(-sizes, kind="stable")
    part = np.cumsum(sizes[order] ** 2) // LARGEST_ARRAY
    return [order[part == number] for number in np.unique(part)]


@dataclass(frozen=True, eq=False)
class MatricesOfSmallCells(CellMatrices):
    """The matrices of small cells: the entries of a sparse matrix, and the memory of its dense factors."""

    room: DenseCells
    """The memory of the factors."""
    sparse: Any
    """The matrix of all coordinates, a ``SparseMatrix``."""
    owners: Owners

    @classmethod
    def of(
        cls, room: DenseCells, pattern: MatrixPattern, entries: wp.array[Any], owners: Owners
    ) -> MatricesOfSmallCells:  # fmt: skip
        """Return the matrices with these entries, which nobody may overwrite."""
        sparse = SparseMatrix()
        sparse.row_start, sparse.columns = room._integers(pattern.column_start), pattern.rows
        sparse.diagonal = wp.zeros(room.size, dtype=wp.int32, device=room.device)
        launch(find_diagonal, room.size, [sparse.row_start, sparse.columns], [sparse.diagonal], room.device)
        sparse.entries, sparse.owner = entries, room._integers(owners.cell)
        return cls(room, sparse, owners)

    def only(self, cells: NDArray[np.bool_]) -> MatricesOfSmallCells:
        """Return the matrices of some of these cells, shape (C,)."""
        owners, sparse = self.owners.only(cells), SparseMatrix()
        for name in ("row_start", "columns", "diagonal", "entries"):
            setattr(sparse, name, getattr(self.sparse, name))
        sparse.owner = self.room._integers(owners.cell)
        return replace(self, sparse=sparse, owners=owners)

    def diagonal(self) -> FloatArray:
        """Return the entries on the diagonal, shape (n,)."""
        room, sparse = self.room, self.sparse
        launch(copy_diagonal, room.size, [sparse.diagonal, sparse.entries], [room.vectors.product], room.device)
        return np.asarray(room.vectors.product.numpy().copy())

    def medians(self) -> FloatArray:
        """Return the median of the diagonal of each cell, shape (C,); zero for cells without coordinates."""
        chosen = self.owners.has_coordinates
        self.room.launch(find_medians, chosen, [DenseMatrices, self.sparse], [self.room.pairs])
        return np.where(chosen, self.room.found_pairs.read().mean(axis=1), 0.0)

    def product(self, vector: FloatArray) -> FloatArray:
        """Return the product with a vector, both of shape (n,)."""
        room, sparse = self.room, self.sparse
        room.vectors.direction.assign(vector)
        inputs = [sparse.row_start, sparse.columns, sparse.owner, sparse.entries, room.vectors.direction]
        launch(multiply, room.size, inputs, [room.vectors.product], room.device)
        return np.asarray(room.vectors.product.numpy().copy())

    def factored(self, shift: FloatArray) -> FactorsOfSmallCells:
        """Factor the matrices plus multiples of the identity."""
        return FactorsOfSmallCells(self, shift)


class FactorsOfSmallCells(CellFactors):
    """The factors of the matrices of small cells; if other matrices have taken their memory, they are found again."""

    def __init__(self, matrices: MatricesOfSmallCells, shift: FloatArray) -> None:
        """Factor the matrices.

        Raises:
            SolverError: a pivot is zero or not finite.
        """
        self.matrices: MatricesOfSmallCells = matrices
        self.owners, self._room = matrices.owners, matrices.room
        self._shift = wp.array(shift, dtype=wp.float64, device=self._room.device)
        self._room.factored += 1
        self._number = self._room.factored
        cells = self.owners.has_coordinates
        self._factor(cells)
        room = self._room
        room.launch(count_signs, cells, [DenseMatrices, matrices.sparse.owner, room.pivots], [room.pairs])
        negative, broken = np.where(cells[:, None], room.found_pairs.read(), 0.0).T
        if broken.any():
            raise SolverError(NO_FACTORS)
        self.negative_count = negative.astype(np.int64)

    @cached_property
    def negative_pivots(self) -> NDArray[np.int64]:
        """The coordinates whose pivots are negative."""
        self._find_again(self.owners.has_coordinates)
        return np.flatnonzero((self._room.found_pivots.read() < 0.0) & (self.owners.cell >= 0))

    def _factor(self, cells: NDArray[np.bool_]) -> None:
        inputs = [self._shift, self.matrices.sparse, DenseMatrices]
        self._room.launch(factor_cells, cells, inputs, [self._room.pivots])
        self._room.holder[cells] = self._number

    def _find_again(self, cells: NDArray[np.bool_]) -> None:
        """Factor the matrices of those cells again whose memory others have taken."""
        taken = cells & (self._room.holder != self._number)
        if taken.any():
            self._factor(taken)

    def solve(self, right: FloatArray, cells: NDArray[np.bool_]) -> FloatArray:
        """Return the solution of the linear systems of some cells."""
        return self.refined(right, cells, np.zeros_like(cells), np.zeros(len(cells)))[0]

    def refined(
        self, force: FloatArray, cells: NDArray[np.bool_], exact: NDArray[np.bool_], shift: FloatArray
    ) -> tuple[FloatArray, FloatArray]:  # fmt: skip
        """Return the solutions of some cells, without the effect of the shift where the matrix is ``exact``."""
        room, cells = self._room, cells & self.owners.has_coordinates
        self._find_again(cells)
        room.vectors.right.assign(force)
        inputs = [wp.array(shift, dtype=wp.float64, device=room.device), room._integers(exact & cells),
                  self.matrices.sparse, DenseMatrices, room.vectors]  # fmt: skip
        room.launch(solve_cells, cells, inputs, [room.work])
        solution = np.where(self.owners.are_of(cells), room.found_solution.read(), 0.0)
        return solution, np.where(cells, room.found_work.read(), 0.0)
