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
"""Threads of a block on a GPU that sums."""
FEWEST_THREADS, MOST_THREADS = 64, 512
"""Threads of a block that takes all steps of a cell."""

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
    if threads == 1:
        for row in range(rows):
            total = wp.float64(0.0)
            for column in range(parts.shape[1]):
                total += parts[row, column]
            totals[row] = total
        return
    eighth = lane % 8
    # rounds of as many rows as the block has groups of eight; threads without a row wait with the others
    for first in range(0, rows, threads // 8):
        row = first + lane // 8
        share = wp.float64(0.0)
        if row < rows:
            for column in range(eighth, parts.shape[1], 8):
                share += parts[row, column]
        wait_for_block()
        if row < rows:
            parts[row, eighth] = share
    wait_for_block()
    for row in range(lane, rows, threads):
        whole = wp.float64(0.0)
        for column in range(8):
            whole += parts[row, column]
        totals[row] = whole
