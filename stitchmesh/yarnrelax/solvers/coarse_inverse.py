# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The inverses of many symmetric positive definite matrices on the device, each computed in a fixed order.

The symmetric elimination of Gauss and Jordan needs no pivots (the sweep operator; Goodnight 1979). With the six columns
K of one group after the other, D = (A_KK)^-1 and all other rows and columns I,

    A_II <- A_II - A_IK D A_KI,     A_IK <- A_IK D,     A_KK <- -D

and after all groups A is minus the inverse of the matrix. Each matrix stays symmetric, so that only the part on and
below the diagonal is computed. All cells take a step in the same two launches: the first finds A_IK and A_IK D, the
second changes the matrix, one block of threads for each six rows. No entry is a sum of which the order could vary.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.kernel import kernel
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.lattice_images import rests
from stitchmesh.yarnrelax.solvers.coarse_motions import Groups, Motion, width_of

THREADS = 64
"""Threads of a block on a GPU."""
FEWEST_STEPS = 8
"""Steps that are always captured together."""

Square = wp.types.matrix(shape=(6, 6), dtype=wp.float64)


@wp.func
def inverse_of_block(block: Any) -> Any:
    """The inverse of a symmetric positive definite block, by elimination."""
    result = block
    for k in range(6):
        pivot = wp.float64(1.0) / result[k, k]
        for column in range(6):
            if column != k:
                result[k, column] = result[k, column] * pivot
        for row in range(6):
            if row != k:
                factor = result[row, k] + wp.float64(0.0)
                for column in range(6):
                    if column != k:
                        result[row, column] = result[row, column] - factor * result[k, column]
                result[row, k] = -factor * pivot
        result[k, k] = pivot
    return result


@kernel
def find_panels(
    # model
    model: Any,
    groups: Groups,
    step: int,
    # state in
    matrix: wp.array[wp.float64],
    # state out
    panel: wp.array[Motion],
    scaled: wp.array[Motion],
) -> None:
    """A_IK and A_IK D of the group ``step`` of each cell; one thread for each row."""
    thread = wp.tid()
    g, k = thread // 6, thread % 6
    cell = groups.cell[g]
    first = groups.of_cell[cell]
    if rests(model.images, cell) or first + step >= groups.of_cell[cell + 1]:
        return
    width = width_of(groups, cell)
    pivot = groups.row[first + step]
    block = Square()
    for row in range(6):
        for column in range(6):
            at = wp.max(row, column) * width + 6 * step + wp.min(row, column)
            block[row, column] = matrix[pivot + at]
    inverse = inverse_of_block(block)
    own = Motion()
    for column in range(6):
        if groups.number[g] > step:
            own[column] = matrix[groups.row[g] + k * width + 6 * step + column]
        elif groups.number[g] < step:
            own[column] = matrix[pivot + column * width + 6 * groups.number[g] + k]
        elif column == k:
            own[column] = wp.float64(-1.0)
    panel[thread] = own
    scaled[thread] = inverse * own


@kernel
def eliminate(
    # model
    model: Any,
    groups: Groups,
    step: int,
    # state in
    panel: wp.array[Motion],
    scaled: wp.array[Motion],
    # state in and out
    matrix: wp.array[wp.float64],
) -> None:
    """Take the step of the elimination in the rows of a group, up to the diagonal; one block for each group."""
    g, lane = wp.tid()
    cell = groups.cell[g]
    first, number = groups.of_cell[cell], groups.number[g]
    if rests(model.images, cell) or first + step >= groups.of_cell[cell + 1]:
        return
    width = width_of(groups, cell)
    six = int(6)  # a loop over a name is not unrolled
    for column in range(lane, 6 * number + 6, wp.block_dim()):
        of_column, other = column // 6, panel[6 * first + column]
        for k in range(six):
            at = groups.row[g] + k * width + column
            value = matrix[at]
            if number == step:
                value = scaled[6 * first + column][k]
            elif of_column == step:
                value = scaled[6 * g + k][column % 6]
            else:
                value = value - wp.dot(scaled[6 * g + k], other)
            matrix[at] = value


@kernel
def fill_both_sides(
    # model
    model: Any,
    groups: Groups,
    # state in and out
    matrix: wp.array[wp.float64],
) -> None:
    """Change the sign of the rows of a group and copy them to the columns; one block for each group."""
    g, lane = wp.tid()
    cell = groups.cell[g]
    if rests(model.images, cell):
        return
    width, own = width_of(groups, cell), 6 * groups.number[g]
    start = groups.row[g] - own * width
    for column in range(lane, own + 6, wp.block_dim()):
        for k in range(6):
            if column <= own + k:
                value = -matrix[groups.row[g] + k * width + column]
                matrix[groups.row[g] + k * width + column] = value
                matrix[start + column * width + own + k] = value


class Inverses:
    """The matrices of all cells, which are replaced by their inverses; cells at rest keep theirs."""

    def __init__(self, model: Model, groups: Groups, matrix: wp.array[Any]) -> None:
        """Capture the launches for the ``groups`` of a model; ``matrix`` holds the rows on and below the diagonals.

        Cells take as many steps as they have groups. The launches of the steps between two numbers of groups are
        captured together, so that large cells that are at rest cost nothing.
        """
        self.model, self.groups, self.matrix = model, groups, matrix
        self.counts = np.diff(groups.of_cell.numpy())
        """Groups of each cell, shape (C,)."""
        self._threads = THREADS if model.device.is_cuda else 1
        self._panels = [wp.zeros(6 * len(groups.cell), dtype=Motion, device=model.device) for _ in range(2)]
        ends = _chosen_ends(self.counts)
        self._parts = [(first, self._captured(first, end)) for first, end in pairwise([0, *ends])]
        fill = model.prepare(fill_both_sides, len(groups.cell), [model.constants, groups, matrix], [],
                             tile=self._threads)  # fmt: skip
        self._fill = CapturedLaunches([fill], model.device)

    def invert(self, cells: NDArray[np.bool_]) -> None:
        """Invert the matrices of some cells, shape (C,); the others are marked as resting (``Model.resting``)."""
        most = int(self.counts[cells].max(initial=0))
        for first, part in self._parts:
            if first < most:
                part.launch()
        self._fill.launch()

    def _captured(self, first: int, end: int) -> CapturedLaunches:
        """The launches of some steps."""
        launcher, count, launches = self.model.prepare, len(self.groups.cell), []
        for step in range(first, end):
            given = [self.model.constants, self.groups, step]
            launches.append(launcher(find_panels, 6 * count, [*given, self.matrix], self._panels))
            launches.append(launcher(eliminate, count, [*given, *self._panels, self.matrix], [], tile=self._threads))
        return CapturedLaunches(launches, self.model.device)


def _chosen_ends(counts: NDArray[np.int64]) -> list[int]:
    """Numbers of groups after which a part of the steps ends: the largest one below each doubling."""
    most, ends = int(counts.max()), [FEWEST_STEPS]
    while ends[-1] < most:
        ends.append(2 * ends[-1])
    return sorted({int(counts[counts <= end].max(initial=1)) for end in ends if (counts <= end).any()})
