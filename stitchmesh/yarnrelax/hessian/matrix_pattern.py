# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The places of the entries of the assembled Hessian, which follow from the segments that touch.

A control point has a block with each point of its segments and of the segments that touch them. Only blocks on and
above the diagonal are computed; each is written to its two places. The matrix is symmetric, so that its columns have
the places of its rows: those of the control points come first, and then those of the strains of cells that relax, of
which each has an entry for every point of its cell and for every strain of it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.yarnrelax.hessian.touching_segments import (
    TouchingLists,
    TouchingSegments,
    insert_number,
    place_in_list,
)
from stitchmesh.yarnrelax.model.constants import Model

CAPACITY = 64
"""Points that may share a block with a point before the lists are made longer; about 20 do in a fabric at rest."""


@kernel
def list_neighbours(
    # model
    model: Any,
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


class MatrixPattern:
    """The places of all entries, for one set of segments that touch."""

    def __init__(self, model: Model, relaxes: bool, touching: TouchingSegments, lists: TouchingLists) -> None:
        """Find the places; ``lists`` are those of ``touching``, and ``relaxes`` says whether there are strains."""
        self.lists = lists
        self._number_pairs(model, lists)
        n, cells = model.point_count, model.cell_count if relaxes else 0
        count, below, neighbours = _neighbours(model, touching)
        host_count, host_below = count.numpy().astype(np.int64), below.numpy().astype(np.int64)

        heights = 3 * host_count + (3 if relaxes else 0)
        cell_heights = 3 * np.diff(model.point_start[: cells + 1]) + 3
        column_start = _starts(np.concatenate([np.repeat(heights, 3), np.repeat(cell_heights, 3)]))
        self.column_start = column_start.astype(np.int32)
        """Where the entries of each column start, shape (3 E + 1,)."""
        start = column_start[: 3 * n : 3]
        block_start = _starts(host_count - host_below)
        self.start, self.height = model.integers(start), model.integers(heights)
        """Where the first column of each point starts, and the number of entries of its columns, shape (N,)."""
        self.block_count = int(block_start[-1])
        self.blocks = wp.zeros(self.block_count, dtype=wp.vec4i, device=model.device)
        """The blocks on and above the diagonal: two points i <= j, the place of j in the list of i, and that of i in
        the list of j, shape (B, 4)."""
        cell = np.repeat(np.arange(model.cell_count), np.diff(model.point_start))
        strain_rows = 3 * (n + cell) if relaxes else np.zeros(0)
        of_points = int(column_start[3 * n])
        rows = wp.zeros(of_points, dtype=wp.int32, device=model.device)
        inputs = [model.integers(strain_rows), count, below, neighbours, self.start, model.integers(block_start[:-1])]
        model.launch(put_places, n, inputs, [rows, self.blocks])

        own_points = [np.arange(*(3 * model.point_start[c : c + 2])) for c in range(cells)]
        of_strains = [np.tile(np.append(own, 3 * (n + c) + np.arange(3)), 3) for c, own in enumerate(own_points)]
        self.rows = np.concatenate([rows.numpy(), *(own.astype(np.int32) for own in of_strains)])
        """The row of each entry, ascending in each column."""
        self.diagonal = (start[:, None, None] + np.arange(3)[:, None] * heights[:, None, None]
                         + 3 * host_below[:, None, None] + np.arange(3))  # fmt: skip
        """The entries of the block of each point with itself, shape (N, 3, 3)."""
        self.strain_start = model.integers(column_start[3 * n : 3 * (n + cells) : 3])
        """Where the first strain column of each cell starts, shape (C,), or (0,) without strains."""
        self.corner = (column_start[3 * n + 1 :].reshape(cells, 3)[:, :, None] - 3) + np.arange(3)
        """The entries of the strains of each cell with themselves, shape (C, 3, 3), or (0, 3, 3)."""

    def _number_pairs(self, model: Model, lists: TouchingLists) -> None:
        """Number the pairs of segments that touch, each once."""
        segment = np.repeat(np.arange(model.segment_count), lists.count)
        once = lists.segments >= segment
        lower = np.bincount(segment[~once], minlength=model.segment_count)
        self.pair_count = int(np.count_nonzero(once))
        self.pairs = wp.array(np.stack([segment[once], lists.segments[once]], axis=1).astype(np.int32), dtype=wp.vec2i,
                              device=model.device)  # fmt: skip
        """The pairs of segments that touch, the lower number first, shape (M, 2)."""
        first = _starts(lists.count - lower)[:-1]
        self.pair_base = model.integers(first - lower)
        """What is added to a place in the list of a segment for the number of the pair, shape (S,)."""

    @property
    def entry_count(self) -> int:
        """Number of entries."""
        return len(self.rows)


def _neighbours(model: Model, touching: TouchingSegments) -> tuple[wp.array[Any], wp.array[Any], wp.array[Any]]:
    """What ``list_neighbours`` finds, in lists that are long enough."""
    n, capacity = model.point_count, CAPACITY
    while True:
        count, below = (wp.zeros(n, dtype=wp.int32, device=model.device) for _ in range(2))
        neighbours = wp.zeros((n, capacity), dtype=wp.int32, device=model.device)
        inputs = [model.constants, touching.count, touching.segments]
        model.launch(list_neighbours, n, inputs, [count, below, neighbours])
        if int(count.numpy().max()) <= capacity:
            return count, below, neighbours
        capacity *= 2


def _starts(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(counts)])
