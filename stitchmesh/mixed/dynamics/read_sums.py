# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums and dot products that launches find in a fixed order, and that the host reads back together.

Blocks of threads add up parts of an array, and one block for each sum then adds up its parts. On a GPU a reading costs
as much time as some launches, so that what is needed together is read together.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block

CHUNK = {"cuda": 4 * THREADS, "cpu": 4096}
"""Smallest number of elements whose part of a sum one block finds."""
MOST_PARTS = 512
"""Largest number of parts of a sum; larger arrays have larger parts."""
WIDTH = 7
"""Sums of a block of threads, of which one is used."""


def chunk_of(count: int, device: wp.Device) -> int:
    """Number of elements whose part of a sum one block finds, for ``count`` elements."""
    return max(CHUNK["cuda" if device.is_cuda else "cpu"], -(-count // MOST_PARTS))


def part_count(count: int, device: wp.Device) -> int:
    """Number of parts of a sum over ``count`` elements."""
    return -(-count // chunk_of(count, device))


@kernel
def dot_parts(
    # model
    chunk: int,
    # state in
    first: wp.array[Any],
    second: wp.array[Any],
    # state out
    parts: wp.array2d[wp.float64],
) -> None:
    """Part of a dot product of each block."""
    block, lane = wp.tid()
    total = Slots()
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, first.shape[0]), wp.block_dim()):
        total[0] += wp.float64(first[i]) * wp.float64(second[i])
    sum_over_block(total, parts[block])


@kernel
def sum_parts(
    # model
    chunk: int,
    # state in
    values: wp.array[Any],
    # state out
    parts: wp.array2d[wp.float64],
) -> None:
    """Part of a sum of each block."""
    block, lane = wp.tid()
    total = Slots()
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, values.shape[0]), wp.block_dim()):
        total[0] += wp.float64(values[i])
    sum_over_block(total, parts[block])


@wp.func
def add_parts(parts: wp.array2d[wp.float64], first: int, last: int, lane: int, sums: wp.array[wp.float64]) -> wp.float64:
    """Add up parts, by one block of threads; ``sums`` is memory of this block."""
    total = Slots()
    for part in range(first + lane, last, wp.block_dim()):
        total[0] += parts[part, 0]
    sum_over_block(total, sums)
    return sums[0]


@kernel
def total_parts(
    # model
    start: wp.array[wp.int32],
    # state in
    parts: wp.array2d[wp.float64],
    # state out
    sums: wp.array2d[wp.float64],
) -> None:
    """The sums of the parts from ``start[k]`` to ``start[k + 1]``, one for each block."""
    k, lane = wp.tid()
    add_parts(parts, start[k], start[k + 1], lane, sums[k])


class ReadSums:
    """Sums that are found by launches and read back together."""

    def __init__(self, device: wp.Device) -> None:
        """Begin without sums."""
        self._device = device
        self._counts: list[int] = []
        self._todo: list[tuple[wp.Kernel, list[Any], int]] = []
        self._sums: wp.array[Any] = wp.zeros((0, WIDTH), dtype=wp.float64, device=device)

    def add_sum(self, values: wp.array[Any]) -> None:
        """Add the sum of an array of scalars."""
        self._add(sum_parts, [values], len(values))

    def add_dot(self, first: wp.array[Any], second: wp.array[Any]) -> None:
        """Add the dot product of two arrays of scalars."""
        self._add(dot_parts, [first, second], len(first))

    def launches(self, run: Launcher) -> list[Any]:
        """The launches that find all sums that have been added."""
        if not self._counts:
            return []
        start = np.concatenate([[0], np.cumsum(self._counts)]).astype(np.int32)
        parts = wp.zeros((max(int(start[-1]), 1), WIDTH), dtype=wp.float64, device=self._device)
        self._sums = wp.zeros((len(self._counts), WIDTH), dtype=wp.float64, device=self._device)
        result = []
        for (kernel_of_parts, inputs, chunk), first, last in zip(self._todo, start[:-1], start[1:], strict=True):
            if last > first:
                own = parts[int(first) : int(last)]
                result.append(run(kernel_of_parts, int(last - first), [chunk, *inputs], [own], tile=THREADS))
        starts = wp.array(start, dtype=wp.int32, device=self._device)
        self._kept = parts, starts
        return [*result, run(total_parts, len(self._counts), [starts, parts], [self._sums], tile=THREADS)]

    def read(self) -> NDArray[np.float64]:
        """The sums in the order in which they were added; their launches must have run."""
        sums: NDArray[np.float64] = self._sums.numpy()[:, 0]
        return sums

    def _add(self, kernel_of_parts: wp.Kernel, inputs: list[Any], count: int) -> None:
        self._todo.append((kernel_of_parts, inputs, chunk_of(count, self._device)))
        self._counts.append(part_count(count, self._device))
