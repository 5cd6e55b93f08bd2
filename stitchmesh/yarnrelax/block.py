# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Work that one block of threads does together for one cell: barriers, and sums in a fixed order.

On a CPU a block is one thread.
"""

# no postponed annotations: Warp reads the types of native functions as they stand
# mypy: disable-error-code="no-untyped-def,empty-body,valid-type"

import warp as wp

wp.set_module_options({"enable_backward": False})

THREADS = 256
"""Threads of a block on a GPU."""

_BARRIER = """
#if defined(__CUDA_ARCH__)
    __syncthreads();
#endif
"""


@wp.func_native(_BARRIER)
def wait_for_block():
    """Go on when all threads of the block have come here and what they wrote can be read."""
    ...


@wp.func
def sum_rows(
    parts: wp.array2d(dtype=wp.float64), rows: int, lane: int, threads: int, totals: wp.array1d(dtype=wp.float64)
):
    """Sum each of some rows, eight threads a row; overwrites the first eight columns. All threads take part."""
    count = parts.shape[1]
    row, eighth = lane // 8, lane % 8
    if threads == 1:
        for k in range(rows):
            total = wp.float64(0.0)
            for column in range(count):
                total += parts[k, column]
            totals[k] = total
    total8 = wp.float64(0.0)
    if threads > 1 and row < rows:
        for column in range(eighth, count, 8):
            total8 += parts[row, column]
    wait_for_block()
    if threads > 1 and row < rows:
        parts[row, eighth] = total8
    wait_for_block()
    if threads > 1 and lane < rows:
        whole = wp.float64(0.0)
        for column in range(8):
            whole += parts[lane, column]
        totals[lane] = whole
