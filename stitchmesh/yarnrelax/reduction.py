# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums and maxima in a fixed order, so that the same run gives the same bits."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

wp.set_module_options({"enable_backward": False})

STRANDS = 256
"""Threads of the first stage; each walks through the array with this stride."""


@wp.kernel(module="unique")
def strand_sums(
    # state in
    values: wp.array[Any],
    # state out
    sums: wp.array[wp.float64],
):
    """Sum of every 256th value, in ascending order."""
    strand = wp.tid()
    total = wp.float64(0.0)
    for k in range(strand, values.shape[0], 256):
        total += wp.float64(values[k])
    sums[strand] = total


def ordered_sum(values: wp.array[Any]) -> float:
    """Sum of an array of scalars, read back to the host."""
    sums = wp.empty(STRANDS, dtype=wp.float64, device=values.device)
    wp.launch(strand_sums, dim=STRANDS, inputs=[values], outputs=[sums], device=values.device)
    return float(np.sum(sums.numpy()))
