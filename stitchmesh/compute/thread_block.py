# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Work that the threads of one block do together: barriers, extremes, and sums in a fixed order.

On a CPU a block is one thread. A block of a GPU has a multiple of 32 threads, up to 1,024.
"""

# no postponed annotations: Warp evaluates the types of native functions directly
# ruff: noqa: F811
# mypy: disable-error-code="no-redef,no-untyped-def,empty-body,valid-type"

import warp as wp

THREADS = 256
"""Threads of a block that sums on a GPU."""
MOST_THREADS = 1024
"""Threads of the largest block."""

VirialSums = wp.types.vector(length=9, dtype=wp.float64)
Slots = wp.types.vector(length=7, dtype=wp.float64)
Products = wp.types.vector(length=19, dtype=wp.float64)

_BARRIER = """
#if defined(__CUDA_ARCH__)
    __syncthreads();
#endif
"""


def _exchanges(room: int) -> str:
    """Code in which the lanes of a warp exchange halves of their values until each lane has the sum of one value.

    Loops have literal bounds, because an array does not stay in registers if an index is unknown at compile time.
    """
    steps = [1 << k for k in reversed(range(room.bit_length() - 1))]
    halving = "".join(
        f"""
    #pragma unroll
    for (int k = 0; k < {half}; ++k) {{
        const bool upper = lane & {half};
        const double given = upper ? mine[k] : mine[k + {half}];
        mine[k] = (upper ? mine[k + {half}] : mine[k]) + __shfl_xor_sync(0xffffffffu, given, {half});
    }}"""
        for half in steps
    )
    rest = "".join(
        f"\n    mine[0] += __shfl_xor_sync(0xffffffffu, mine[0], {room << k});" for k in range(6 - room.bit_length())
    )
    return halving + rest


def _sum(count: int) -> str:
    """Code that sums ``count`` values: first within warps, then over the warps of a block."""
    room = 1 << (count - 1).bit_length()
    return f"""
#if defined(__CUDA_ARCH__)
    __shared__ double parts[32][{room}];
    const int lane = threadIdx.x & 31, warp = threadIdx.x >> 5, warps = blockDim.x >> 5;
    double mine[{room}];
    #pragma unroll
    for (int k = 0; k < {count}; ++k) mine[k] = values[k];
    #pragma unroll
    for (int k = {count}; k < {room}; ++k) mine[k] = 0.0;{_exchanges(room)}
    if (lane < {room}) parts[warp][lane] = mine[0];
    __syncthreads();
    if (threadIdx.x < {count}) {{
        double total = 0.0;
        for (int k = 0; k < warps; ++k) total += parts[k][threadIdx.x];
        totals.data[threadIdx.x] = total;
    }}
    __syncthreads();
#else
    for (int k = 0; k < {count}; ++k) totals.data[k] = values[k];
#endif
"""


def _extreme(sign: str) -> str:
    """Code that finds the extreme of one value of each thread: first within warps, then over the warps of a block."""
    return f"""
#if defined(__CUDA_ARCH__)
    __shared__ double parts[32];
    for (int step = 16; step > 0; step >>= 1) {{
        const double other = __shfl_xor_sync(0xffffffffu, value, step);
        if (other {sign} value) value = other;
    }}
    if ((threadIdx.x & 31) == 0) parts[threadIdx.x >> 5] = value;
    __syncthreads();
    const int warps = blockDim.x >> 5;
    for (int k = 0; k < warps; ++k)
        if (parts[k] {sign} value) value = parts[k];
    __syncthreads();
#endif
    return value;
"""


_TOTAL = """
#if defined(__CUDA_ARCH__)
    __shared__ double parts[32];
    for (int step = 16; step > 0; step >>= 1) value += __shfl_xor_sync(0xffffffffu, value, step);
    if ((threadIdx.x & 31) == 0) parts[threadIdx.x >> 5] = value;
    __syncthreads();
    const int warps = blockDim.x >> 5;
    value = 0.0;
    for (int k = 0; k < warps; ++k) value += parts[k];
    __syncthreads();
#endif
    return value;
"""


@wp.func_native(_BARRIER)
def wait_for_block():
    """Continue when all threads of the block have reached this point and their writes are visible."""
    ...


@wp.func_native(_extreme(">"))
def largest_over_block(value: wp.float64) -> wp.float64:
    """Largest value over all threads of the block."""
    ...


@wp.func_native(_extreme("<"))
def smallest_over_block(value: wp.float64) -> wp.float64:
    """Smallest value over all threads of the block."""
    ...


@wp.func_native(_TOTAL)
def total_over_block(value: wp.float64) -> wp.float64:
    """Sum of one value over all threads of the block, always in the same order; each thread gets it."""
    ...


@wp.func_native(_sum(9))
def sum_over_block(values: VirialSums, totals: wp.array1d(dtype=wp.float64)):
    """Sum each component over all threads of the block, always in the same order."""
    ...


@wp.func_native(_sum(7))
def sum_over_block(values: Slots, totals: wp.array1d(dtype=wp.float64)):
    """Sum each component over all threads of the block, always in the same order."""
    ...


@wp.func_native(_sum(19))
def sum_over_block(values: Products, totals: wp.array1d(dtype=wp.float64)):
    """Sum each component over all threads of the block, always in the same order."""
    ...
