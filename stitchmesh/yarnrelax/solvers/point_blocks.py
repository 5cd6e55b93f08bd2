# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Chunks of control points for blocks of threads: each block takes a part of the points of one cell."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.thread_block import THREADS
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.solvers.lbfgs_steps import PointRange

CHUNK = {"cuda": THREADS, "cpu": 1024}
"""Control points of a block."""


@wp.struct
class Blocks:
    """The chunk of control points of each block of threads."""

    cell: wp.array[wp.int32]
    first: wp.array[wp.int32]
    last: wp.array[wp.int32]
    of_cell: wp.array[wp.int32]


@wp.func
def point_range_of(blocks: Blocks, block: int, lane: int, threads: int) -> PointRange:
    """The control points of a thread of a block."""
    point_range = PointRange()
    point_range.cell = blocks.cell[block]
    point_range.threads = threads
    point_range.first = blocks.first[block] + lane
    point_range.last = blocks.last[block]
    return point_range


def blocks_of(model: Model) -> Any:
    """Return the chunks of each cell of a model."""
    chunk = CHUNK["cuda" if model.device.is_cuda else "cpu"]
    counts = -(-np.diff(model.point_start) // chunk)
    of_cell = np.concatenate([[0], np.cumsum(counts)])
    cell = np.repeat(np.arange(model.cell_count), counts)
    first = model.point_start[cell] + (np.arange(of_cell[-1]) - of_cell[cell]) * chunk
    blocks = Blocks()
    blocks.cell, blocks.of_cell = model.integers(cell), model.integers(of_cell)
    blocks.first = model.integers(first)
    blocks.last = model.integers(np.minimum(first + chunk, model.point_start[cell + 1]))
    return blocks
