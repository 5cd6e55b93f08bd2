# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sums and maxima in a fixed order, so that the same run gives the same bits."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

wp.set_module_options({"enable_backward": False})

STRANDS = 256
"""Threads of the first stage; each walks through the array with this stride."""


@wp.kernel(module="unique")
def strand_sums(
    # state in
    values: wp.array[Any],
    # state out
    sums: wp.array[wp.float64],
) -> None:
    """Sum of every 256th value, in ascending order."""
    strand = wp.tid()
    total = wp.float64(0.0)
    for k in range(strand, values.shape[0], 256):
        total += wp.float64(values[k])
    sums[strand] = total


@wp.kernel(module="unique")
def strand_minima(
    # state in
    values: wp.array[Any],
    # state out
    minima: wp.array[wp.float64],
) -> None:
    """Smallest of every 256th value; not a number where one of them is not."""
    strand = wp.tid()
    least = wp.float64(1.0e300)
    for k in range(strand, values.shape[0], 256):
        value = wp.float64(values[k])
        if least == least and not (value >= least):  # once it is not a number it stays so
            least = value
    minima[strand] = least


def ordered_sum(values: wp.array[Any]) -> float:
    """Sum of an array of scalars, read back to the host."""
    return float(np.sum(_reduced(strand_sums, values)))


def minimum(values: wp.array[Any]) -> float:
    """Smallest of an array of scalars, read back to the host; not a number where one of them is not."""
    return float(np.min(_reduced(strand_minima, values)))


def _reduced(kernel: wp.Kernel, values: wp.array[Any]) -> NDArray[np.float64]:
    partial = wp.empty(STRANDS, dtype=wp.float64, device=values.device)
    wp.launch(kernel, dim=STRANDS, inputs=[values], outputs=[partial], device=values.device)
    return partial.numpy()
