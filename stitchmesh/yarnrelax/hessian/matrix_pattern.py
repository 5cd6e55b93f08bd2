# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The places of the entries of the assembled Hessian, which follow from the segments that touch.

A control point has a block with each point of its segments, and with each point of the segments that touch them. Only
blocks on and above the diagonal are computed, and each is written to its two places. The matrix is symmetric, so that
its columns have the places of its rows. The rows of the control points come first. The rows of the strains of relaxing
cells follow; each has an entry for every point and every strain of its cell.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.yarnrelax.hessian.touching_segments import (
    TouchingSegments,
    insert_number,
    place_in_list,
)
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of

CAPACITY = 64
"""First number of points that may share a block with a point; longer lists follow. A fabric at rest needs about 20."""


@kernel
def list_neighbours(
    # model
    model: YarnConstants,
    # state in
    touching_count: wp.array[wp.int32],
    touching: wp.array2d[wp.int32],
    # state out
    count: wp.array[wp.int32],
    below: wp.array[wp.int32],
    neighbours: wp.array2d[wp.int32],
) -> None:
    """The points that share a block with each control point, ascending, and how many have a lower number."""
    i = wp.tid()
    found = int(0)
    slots = model.point_segments[i]
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            corner = model.segment_points[s]
            for b in range(4):
                found = insert_number(neighbours, i, found, corner[b])
            for k in range(touching_count[s]):
                other = model.segment_points[touching[s, k]]
                for b in range(4):
                    found = insert_number(neighbours, i, found, other[b])
    count[i] = found
    if found <= neighbours.shape[1]:
        below[i] = place_in_list(neighbours, i, found, i)


@kernel
def put_places(
    # model
    strain_rows: wp.array[wp.int32],
    # state in
    count: wp.array[wp.int32],
    below: wp.array[wp.int32],
    neighbours: wp.array2d[wp.int32],
    start: wp.array[wp.int32],
    block_start: wp.array[wp.int32],
    # state out
    rows: wp.array[wp.int32],
    blocks: wp.array[wp.vec4i],
) -> None:
    """The rows of the entries in the columns of each point; of each block its points and its places in their lists."""
    i = wp.tid()
    found = count[i]
    height = 3 * found
    if strain_rows.shape[0] > 0:
        height += 3
    for axis in range(3):
        first = start[i] + axis * height
        for k in range(found):
            for row in range(3):
                rows[first + 3 * k + row] = 3 * neighbours[i, k] + row
        for row in range(height - 3 * found):
            rows[first + 3 * found + row] = strain_rows[i] + row
    for k in range(below[i], found):
        j = neighbours[i, k]
        blocks[block_start[i] + k - below[i]] = wp.vec4i(i, j, k, place_in_list(neighbours, j, count[j], i))


@kernel
def put_strain_places(
    # model
    model: YarnConstants,
    first_strain: wp.int32,
    cell_start: wp.array[wp.int32],
    strain_start: wp.array[wp.int32],
    # state out
    rows: wp.array[wp.int32],
) -> None:
    """The rows of the entries in the columns of the strains of a cell: those of its points and of its strains."""
    i = wp.tid()
    cell = cell_of(model.images, wp.max(model.point_segments[i]))
    first, last = cell_start[cell], cell_start[cell + 1]
    height = 3 * (last - first) + 3
    for strain in range(3):
        column = strain_start[cell] + strain * height
        for row in range(3):
            rows[column + 3 * (i - first) + row] = 3 * i + row
            if i == first:
                rows[column + height - 3 + row] = first_strain + 3 * cell + row


@kernel
def count_pairs(
    # state in
    touching_count: wp.array[wp.int32],
    touching: wp.array2d[wp.int32],
    # state out
    lower: wp.array[wp.int32],
    once: wp.array[wp.int32],
) -> None:
    """How many segments that touch a segment have a lower number, and how many have not."""
    s = wp.tid()
    found = int(0)
    while found < touching_count[s] and touching[s, found] < s:
        found += 1
    lower[s] = found
    once[s] = touching_count[s] - found


@kernel
def put_pairs(
    # state in
    touching: wp.array2d[wp.int32],
    lower: wp.array[wp.int32],
    once: wp.array[wp.int32],
    last: wp.array[wp.int32],
    # state out
    pair_base: wp.array[wp.int32],
    pairs: wp.array[wp.vec2i],
) -> None:
    """The pairs of a segment with itself and with those of a higher number."""
    s = wp.tid()
    first = last[s] - once[s]
    pair_base[s] = first - lower[s]
    for k in range(once[s]):
        pairs[first + k] = wp.vec2i(s, touching[s, lower[s] + k])


class MatrixPattern:
    """The places of all entries, for the segments that ``TouchingSegments`` keeps."""

    def __init__(self, model: Model, relaxes: bool, touching: TouchingSegments) -> None:
        """Find the places; ``relaxes`` says whether there are strains."""
        self._number_pairs(model, touching)
        n, cells = model.point_count, model.cell_count if relaxes else 0
        count, self.below, neighbours = _neighbours(model, touching)
        host_count, host_below = count.numpy().astype(np.int64), self.below.numpy().astype(np.int64)

        heights = 3 * host_count + (3 if relaxes else 0)
        cell_heights = 3 * np.diff(model.point_start[: cells + 1]) + 3
        column_start = _starts(np.concatenate([np.repeat(heights, 3), np.repeat(cell_heights, 3)]))
        self.column_start = column_start.astype(np.int32)
        """Place at which the entries of each column start, shape (3 E + 1,)."""
        start = column_start[: 3 * n : 3]
        block_start = _starts(host_count - host_below)
        self.start, self.height = model.integers(start), model.integers(heights)
        """Place at which the first column of each point starts, and number of entries of its columns, shape (N,)."""
        self.block_count = int(block_start[-1])
        self.blocks = wp.zeros(self.block_count, dtype=wp.vec4i, device=model.device)
        """The blocks on and above the diagonal, shape (B, 4): two points i <= j, the place of j in the list of i, and
        the place of i in the list of j."""
        cell = np.repeat(np.arange(model.cell_count), np.diff(model.point_start))
        strain_rows = 3 * (n + cell) if relaxes else np.zeros(0)
        self.rows = wp.zeros(int(column_start[-1]), dtype=wp.int32, device=model.device)
        """The row of each entry, ascending in each column."""
        inputs = [
            model.integers(strain_rows), count, self.below, neighbours, self.start, model.integers(block_start[:-1])
        ]  # fmt: skip
        model.launch(put_places, n, inputs, [self.rows, self.blocks])
        self.strain_start = model.integers(column_start[3 * n : 3 * (n + cells) : 3])
        """Place at which the first strain column of each cell starts, shape (C,), or (0,) without strains."""
        if relaxes:
            inputs = [model.constants, 3 * n, model.cell_points, self.strain_start]
            model.launch(put_strain_places, n, inputs, [self.rows])
        corner = (column_start[3 * n + 1 :].reshape(cells, 3)[:, :, None] - 3) + np.arange(3)
        self.corner = model.integers(corner.ravel())
        """Places of the entries between the strains of each cell, nine for each cell, shape (9 C,), or (0,)."""

    def _number_pairs(self, model: Model, touching: TouchingSegments) -> None:
        """Number the pairs of segments that touch, each once."""
        count, device = model.segment_count, model.device
        lower, once, last, self.pair_base = (wp.zeros(count, dtype=wp.int32, device=device) for _ in range(4))
        model.launch(count_pairs, count, [touching.kept_count, touching.kept], [lower, once])
        wp.utils.array_scan(once, last, inclusive=True)
        self.pair_count = int(last[count - 1 :].numpy()[0])
        self.pairs = wp.zeros(self.pair_count, dtype=wp.vec2i, device=device)
        """The pairs of segments that touch, the lower number first, shape (M, 2)."""
        model.launch(put_pairs, count, [touching.kept, lower, once, last], [self.pair_base, self.pairs])

    @cached_property
    def host_rows(self) -> NDArray[np.int32]:
        """``rows`` in the memory of the host."""
        return np.asarray(self.rows.numpy())


def _neighbours(model: Model, touching: TouchingSegments) -> tuple[wp.array[Any], wp.array[Any], wp.array[Any]]:
    """Return the results of ``list_neighbours``, in lists that are long enough."""
    n, capacity = model.point_count, CAPACITY
    while True:
        count, below = (wp.zeros(n, dtype=wp.int32, device=model.device) for _ in range(2))
        neighbours = wp.zeros((n, capacity), dtype=wp.int32, device=model.device)
        inputs = [model.constants, touching.kept_count, touching.kept]
        model.launch(list_neighbours, n, inputs, [count, below, neighbours])
        if int(count.numpy().max()) <= capacity:
            return count, below, neighbours
        capacity *= 2


def _starts(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(counts)])
