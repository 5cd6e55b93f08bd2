# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Work that one block of threads does together for one cell: barriers, and sums in a fixed order.

On a CPU a block is one thread. A block of a GPU has a multiple of 32 threads, up to 1,024.
"""

# no postponed annotations: Warp reads the types of native functions as they stand
# ruff: noqa: F811
# mypy: disable-error-code="no-redef,no-untyped-def,empty-body,valid-type"

import functools
from typing import Any

import warp as wp

from stitchmesh.yarnrelax.precision import vector

THREADS = 256
"""Threads of a block on a GPU that sums."""
MOST_THREADS = 1024
"""Threads of the largest block."""

Parts = wp.types.vector(length=9, dtype=wp.float64)
Slots = wp.types.vector(length=7, dtype=wp.float64)
Products = wp.types.vector(length=19, dtype=wp.float64)

_BARRIER = """
#if defined(__CUDA_ARCH__)
    __syncthreads();
#endif
"""


# Lanes of a warp exchange halves of their numbers until each has the sum of one; then each number's warps are added.
_SUM = """
    constexpr int count = sizeof(values) / sizeof(double);
#if defined(__CUDA_ARCH__)
    constexpr int room = count > 16 ? 32 : count > 8 ? 16 : 8;
    __shared__ double parts[32][room];
    const int lane = threadIdx.x & 31, warp = threadIdx.x >> 5, warps = blockDim.x >> 5;
    double mine[room];
    #pragma unroll
    for (int k = 0; k < room; ++k) mine[k] = k < count ? values[k < count ? k : 0] : 0.0;
    #pragma unroll
    for (int half = room / 2; half > 0; half /= 2) {
        #pragma unroll
        for (int k = 0; k < half; ++k) {
            const bool upper = lane & half;
            const double given = upper ? mine[k] : mine[k + half];
            mine[k] = (upper ? mine[k + half] : mine[k]) + __shfl_xor_sync(0xffffffffu, given, half);
        }
    }
    #pragma unroll
    for (int half = room; half < 32; half *= 2) mine[0] += __shfl_xor_sync(0xffffffffu, mine[0], half);
    if (lane < room) parts[warp][lane] = mine[0];
    __syncthreads();
    if (threadIdx.x < count) {
        double total = 0.0;
        for (int k = 0; k < warps; ++k) total += parts[k][threadIdx.x];
        totals.data[threadIdx.x] = total;
    }
    __syncthreads();
#else
    for (int k = 0; k < count; ++k) totals.data[k] = values[k];
#endif
"""


_SUM_OF_FOUR = """
#if defined(__CUDA_ARCH__)
    constexpr int count = sizeof(values) / sizeof(values[0]);
    const unsigned four = 0xfu << (threadIdx.x & 28);
    for (int k = 0; k < count; ++k) values[k] += __shfl_xor_sync(four, values[k], 1);
    for (int k = 0; k < count; ++k) values[k] += __shfl_xor_sync(four, values[k], 2);
#endif
    return values;
"""


@wp.func_native(_BARRIER)
def wait_for_block():
    """Go on when all threads of the block have come here and what they wrote can be read."""
    ...


@wp.func_native(_SUM)
def sum_over_block(values: Parts, totals: wp.array1d(dtype=wp.float64)):
    """Sum each of a thread's numbers over all threads of the block, always in the same order."""
    ...


@wp.func_native(_SUM)
def sum_over_block(values: Slots, totals: wp.array1d(dtype=wp.float64)):
    """Sum each of a thread's numbers over all threads of the block, always in the same order."""
    ...


@wp.func_native(_SUM)
def sum_over_block(values: Products, totals: wp.array1d(dtype=wp.float64)):
    """Sum each of a thread's numbers over all threads of the block, always in the same order."""
    ...


@functools.cache
def summing_four(size: int, scalar: Any) -> Any:
    """The function that sums vectors of so many numbers over four threads side by side, in which it leaves the sum."""
    numbers = vector(size, scalar)

    @wp.func_native(_SUM_OF_FOUR)
    def sum_of_four(values: numbers) -> numbers:
        """Sum of the vectors of four threads; on a CPU the vector of the only one."""
        ...

    return sum_of_four
