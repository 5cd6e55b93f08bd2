# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches of kernels; a CPU uses all cores."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import for_arguments
from stitchmesh.compute.launch_table import LaunchTable, useful_threads

BLOCK = 64
"""Threads of a block on a GPU. Small blocks spread a swatch over the whole GPU; large scenes are not slower."""


def prepare(
    kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any], device: wp.Device, *, tile: int = 0
) -> wp.Launch:
    """Prepare a launch that will be repeated.

    Args:
        kernel: the kernel.
        count: number of threads, or number of blocks if threads share tiles.
        inputs: the first arguments of the kernel.
        outputs: its last arguments.
        device: where the kernel runs.
        tile: threads of a block that shares tiles; 0 for a kernel without tiles.
    """
    kernel = for_arguments(kernel, [*inputs, *outputs])
    arguments: dict[str, Any] = {"inputs": inputs, "outputs": outputs, "device": device, "record_cmd": True}
    if tile:
        return wp.launch_tiled(kernel, dim=count, block_dim=tile, **arguments)
    return wp.launch(kernel, count, block_dim=BLOCK, **arguments)


def launch(
    kernel: wp.Kernel, count: int, inputs: list[Any], outputs: list[Any], device: wp.Device, *, tile: int = 0
) -> None:
    """Run a kernel once, with the arguments of ``prepare``."""
    if count == 0:
        return
    prepared = prepare(kernel, count, inputs, outputs, device, tile=tile)
    if device.is_cpu and useful_threads(prepared) > 1:
        prepared = LaunchTable([prepared])
    prepared.launch()
