# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums of arrays and dot products in a fixed order: each block of threads finds a part, and the parts are added up.

The number of parts depends only on the length of the array, and is small. Each block of the next kernel can therefore
add the parts up for itself, without a launch for the sum.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar
from stitchmesh.compute.thread_block import THREADS, Slots, smallest_over_block, sum_over_block

CHUNK = {"cuda": THREADS, "cpu": 4096}
"""Smallest number of elements that one block sums."""
MOST_PARTS = 1024
"""Largest number of parts of a sum; larger arrays have larger parts."""
WIDTH = 7
"""Width of the sums of a block of threads (``sum_over_block``); only the first one is used."""


def chunk_of(count: int, device: wp.Device) -> int:
    """Number of elements that one block sums, in a sum over ``count`` elements."""
    return max(CHUNK["cuda" if device.is_cuda else "cpu"], -(-count // MOST_PARTS))


def part_count(count: int, device: wp.Device) -> int:
    """Number of parts of a sum over ``count`` elements."""
    return -(-count // chunk_of(count, device))


@kernel(tile=THREADS)
def dot_parts(
    # model
    chunk: int,
    # state in
    first: wp.array[Scalar],
    second: wp.array[Scalar],
    # state out
    parts: wp.array2d[wp.float64],
) -> None:
    """Part of a dot product of each block."""
    block, lane = wp.tid()
    total = Slots()
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, first.shape[0]), wp.block_dim()):
        total[0] += wp.float64(first[i]) * wp.float64(second[i])
    sum_over_block(total, parts[block])


@kernel(tile=THREADS)
def sum_parts(
    # model
    chunk: int,
    # state in
    values: wp.array[Scalar],
    # state out
    parts: wp.array2d[wp.float64],
) -> None:
    """Part of a sum of each block."""
    block, lane = wp.tid()
    total = Slots()
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, values.shape[0]), wp.block_dim()):
        total[0] += wp.float64(values[i])
    sum_over_block(total, parts[block])


@kernel(tile=THREADS)
def least_parts(
    # model
    chunk: int,
    # state in
    values: wp.array[Scalar],
    # state out
    parts: wp.array2d[wp.float64],
) -> None:
    """Smallest value of each block; one that is not a number is passed over."""
    block, lane = wp.tid()
    least = wp.float64(1.0e300)
    for i in range(block * chunk + lane, wp.min((block + 1) * chunk, values.shape[0]), wp.block_dim()):
        least = wp.min(least, wp.float64(values[i]))
    whole = smallest_over_block(least)
    if lane == 0:
        parts[block, 0] = whole


@wp.func
def add_parts(
    parts: wp.array2d[wp.float64], first: int, last: int, lane: int, sums: wp.array[wp.float64]
) -> wp.float64:
    """Add up parts, by one block of threads; ``sums`` is memory of this block."""
    total = Slots()
    for part in range(first + lane, last, wp.block_dim()):
        total[0] += parts[part, 0]
    sum_over_block(total, sums)
    return sums[0]


@kernel(tile=THREADS)
def total_parts(
    # model
    start: wp.array[wp.int32],
    of_minima: wp.array[wp.int32],
    # state in
    parts: wp.array2d[wp.float64],
    # state out
    sums: wp.array2d[wp.float64],
) -> None:
    """The sums of the parts from ``start[k]`` to ``start[k + 1]``, or the smallest of them, one for each block."""
    k, lane = wp.tid()
    if of_minima[k] == 0:
        add_parts(parts, start[k], start[k + 1], lane, sums[k])
    else:
        least = wp.float64(1.0e300)
        for part in range(start[k] + lane, start[k + 1], wp.block_dim()):
            least = wp.min(least, parts[part, 0])
        whole = smallest_over_block(least)
        if lane == 0:
            sums[k, 0] = whole


def parts_for(count: int, device: wp.Device) -> wp.array[Any]:
    """Allocate the parts of a sum over ``count`` elements."""
    return wp.zeros((max(part_count(count, device), 1), WIDTH), dtype=wp.float64, device=device)
