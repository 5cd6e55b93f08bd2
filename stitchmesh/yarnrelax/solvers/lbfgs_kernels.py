# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches of the quasistatic solver for one large piece, or for cells that know nothing of one another: one a step.

The control points of each cell are parted into chunks, one for a block of threads. A block adds up what its threads
have found, one more block a cell adds up the blocks of the cell, and its first thread finds the numbers a_j, b_j:
nothing is read back to the host, and all sums have their order.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import THREADS, Products, Slots, sum_over_block
from stitchmesh.yarnrelax.energies.term import Launcher
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.solvers.cell_strain import put_strain_force, strains_struct, sum_of_blocks
from stitchmesh.yarnrelax.solvers.lbfgs_steps import (
    PRODUCTS,
    Cells,
    PointRange,
    add_direction_products,
    add_strain_products,
    apply_move,
    direction_products,
    force_products,
    moved,
    propose_move,
    propose_point_moves,
    trial_slot,
    update_coefficients,
    update_memory,
)
from stitchmesh.yarnrelax.solvers.solver import SolverInputs

CHUNK = {"cuda": THREADS, "cpu": 1024}
"""Control points of a block."""


@wp.struct
class Blocks:
    """What each block of threads does."""

    cell: wp.array[wp.int32]
    first: wp.array[wp.int32]
    last: wp.array[wp.int32]
    of_cell: wp.array[wp.int32]


@wp.func
def point_range_of(blocks: Blocks, block: int, lane: int, threads: int) -> PointRange:
    """What a thread of a block does."""
    point_range = PointRange()
    point_range.cell = blocks.cell[block]
    point_range.threads = threads
    point_range.first = blocks.first[block] + lane
    point_range.last = blocks.last[block]
    return point_range


@kernel
def compare(
    # model
    blocks: Blocks,
    # state in and out
    state: Any,
    memory: Any,
    # state out
    sums: wp.array2d[wp.float64],
) -> None:
    """What the forces lost on the last move, and all products that the memory needs."""
    block, lane = wp.tid()
    sum_over_block(force_products(point_range_of(blocks, block, lane, wp.block_dim()), state, memory), sums[block])


@kernel
def remember(
    # model
    cells: Cells,
    blocks: Blocks,
    # state in
    sums: wp.array2d[wp.float64],
    # state in and out
    strains: Any,
    state: Any,
    memory: Any,
) -> None:
    """Take the newest pair of each cell into its memory; a block a cell."""
    cell, lane = wp.tid()
    threads = wp.block_dim()
    if strains.count > 0:
        sum_of_blocks(strains.parts[cell], lane, threads, strains.totals[cell])
    total = Products()
    for block in range(blocks.of_cell[cell] + lane, blocks.of_cell[cell + 1], threads):
        for k in range(19):
            total[k] += sums[block, k]
    sum_over_block(total, memory.products[cell])
    if lane == 0:
        if strains.count > 0:
            entry = cells.point_count + cell
            put_strain_force(cell, entry, strains, state)
            own = add_strain_products(Products(), entry, trial_slot(memory.numbers[cell]), state, memory)
            for k in range(19):
                memory.products[cell, k] += own[k]
        update_memory(cell, memory)


@kernel
def precondition(
    # model
    blocks: Blocks,
    # state in and out
    state: Any,
    memory: Any,
    # state out
    sums: wp.array2d[wp.float64],
) -> None:
    """z, and its products with the memory."""
    block, lane = wp.tid()
    sum_over_block(direction_products(point_range_of(blocks, block, lane, wp.block_dim()), state, memory), sums[block])


@kernel
def recall(
    # model
    cells: Cells,
    blocks: Blocks,
    step_limit: Any,
    # state in
    sums: wp.array2d[wp.float64],
    # state in and out
    strains: Any,
    state: Any,
    memory: Any,
) -> None:
    """The numbers a_j - b_j of each cell, and the move of its strains; a block a cell."""
    cell, lane = wp.tid()
    total = Slots()
    for block in range(blocks.of_cell[cell] + lane, blocks.of_cell[cell + 1], wp.block_dim()):
        for k in range(7):
            total[k] += sums[block, k]
    sum_over_block(total, memory.products[cell])
    if lane == 0:
        entry, numbers = cells.point_count + cell, memory.numbers[cell]
        if strains.count > 0:
            own = add_direction_products(Slots(), entry, numbers, memory.alpha[cell], state, memory)
            for k in range(7):
                memory.products[cell, k] += own[k]
        update_coefficients(cell, memory)
        if strains.count > 0:
            propose_move(entry, step_limit, numbers, memory.alpha_minus_beta[cell], state, memory)
            apply_move(entry, trial_slot(numbers), state, memory)


@kernel
def propose_moves(
    # model
    blocks: Blocks,
    step_limit: Any,
    # state in and out
    state: Any,
    memory: Any,
) -> None:
    """The next move of each control point, within its limit."""
    block, lane = wp.tid()
    propose_point_moves(point_range_of(blocks, block, lane, wp.block_dim()), step_limit, state, memory)


@kernel
def move_and_note(
    # model
    cells: Cells,
    blocks: Blocks,
    # state in and out
    strains: Any,
    state: Any,
    memory: Any,
) -> None:
    """Move, put the move into the slot of the pair on trial, and deform cells."""
    block, lane = wp.tid()
    moved(point_range_of(blocks, block, lane, wp.block_dim()), cells, strains, state, memory)


def cells_of(model: Model) -> Any:
    """The struct of a model's cells."""
    cells = Cells()
    cells.point_count, cells.points, cells.segments = model.point_count, model.cell_points, model.cell_segments
    return cells


def strains_of(scene: SolverInputs) -> Any:
    """The struct of a scene's strains."""
    return strains_struct(scene.model.scalar)() if scene.strain is None else scene.strain.struct(scene.candidates)


def _blocks_of(model: Model) -> Any:
    """Chunks of each cell."""
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


class StepLaunches:
    """Room for the sums of blocks, and the launches of an iteration after the forces."""

    def __init__(self, model: Model, memory: Any) -> None:
        """Part the control points among blocks of threads."""
        self.memory, self.cells, self.blocks = memory, cells_of(model), _blocks_of(model)
        self.threads = THREADS if model.device.is_cuda else 1
        self.count = len(self.blocks.cell)
        self.sums = wp.zeros((self.count, PRODUCTS), dtype=wp.float64, device=model.device)

    def launches(self, scene: SolverInputs, launcher: Launcher) -> list[Any]:
        """Gather the forces on strains, then remember, propose, hold, move."""
        state, memory, cells, blocks, tile = scene.state, self.memory, self.cells, self.blocks, self.threads
        strains, step_limit = strains_of(scene), scene.model.number(scene.step_fraction)
        both = [state.arrays, memory]
        launches = [] if scene.strain is None else [scene.strain.gather_launch(state, launcher)]
        launches += [
            launcher(compare, self.count, [blocks, *both], [self.sums], tile=tile),
            launcher(remember, scene.model.cell_count, [cells, blocks, self.sums, strains, *both], [], tile=tile),
            launcher(precondition, self.count, [blocks, *both], [self.sums], tile=tile),
            launcher(
                recall, scene.model.cell_count, [cells, blocks, step_limit, self.sums, strains, *both], [], tile=tile
            ),
            launcher(propose_moves, self.count, [blocks, step_limit, *both], [], tile=tile),
        ]
        for constraint in scene.constraints:
            launches += constraint.filter_steps(state, memory.step, memory.limit, launcher)
        return [*launches, launcher(move_and_note, self.count, [cells, blocks, strains, *both], [], tile=tile)]
