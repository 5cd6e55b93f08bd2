# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The quasistatic solver: limited-memory quasi-Newton steps (L-BFGS; Nocedal and Wright, algorithm 7.4).

With forces F, the last moves s_j and the changes y_j = F_before - F_after of the gradient over them, the next move is

    q = F - sum a_j y_j,   z = g C q,   x <- x + z + sum (a_j - b_j) s_j
    a_j = s_j . q / s_j . y_j   from the newest to the oldest,      b_j = y_j . z / s_j . y_j   from the oldest on,

where C is the preconditioner of this iteration (``preconditioner``) and g = s . y / y . C y of the newest pair. A move
s_j is the displacement of a control point after its step limit and the constraints, so a pair is also correct if moves
were shortened. A pair whose s . y is not clearly positive is left out.

Quasi-Newton moves leave noise in the stiffest modes, and the residual is then more sensitive to this noise than to the
distance from rest. Each assessment interval therefore ends with ``SMOOTHING`` plain iterations, x <- x + 1.6 F / D with
the row sums D of ``preconditioner``, which do not change the memory.

A control point that has used most of its budget (``step_limit``) would stay behind its neighbours. The whole cell waits
instead until there are new candidate lists.

Each cell has its own memory; one large piece is one cell. This file has one launch for each step (``lbfgs_steps``). The
control points of each cell are divided into chunks, one for each block of threads. A block sums over its threads, and
one block for each cell sums over the blocks; its first thread finds the numbers a_j, b_j.
Nothing is read back to the host, and all sums have a fixed order.

Two files beside this one have the same iteration for cells on a lattice: their periods may be unknowns too
(``lbfgs_cells``), and one launch may do all iterations of an assessment interval (``lbfgs_fused``).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3, Vec6
from stitchmesh.compute.thread_block import THREADS, Products, Slots, sum_over_block
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.solvers.lbfgs_steps import (
    FIRST_GRADIENT,
    GRADIENTS,
    ITERATION,
    LAST_GRADIENT,
    MOST_USED_UP,
    PLAIN,
    PRECONDITIONER_SCALE,
    PRODUCTS,
    STEP_SCALE,
    TENTH,
    USED_UP_COUNT,
    WAITING,
    WANTED,
    Blocks,
    LBFGSArrays,
    PointRange,
    add_direction_products,
    add_force_products,
    apply_move,
    blocks_of,
    make_memory,
    point_range_of,
    propose_move,
    trial_slot,
    update_coefficients,
    update_memory,
)
from stitchmesh.yarnrelax.solvers.preconditioner import (
    bend_row_sums,
    preconditioner_launch,
    put_bounds,
    stretch_row_sums,
)
from stitchmesh.yarnrelax.solvers.solver import Progress, Solver, SolverInputs

FRESH = (0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0)
"""The first eight columns of the record of a cell without pairs."""
PART_USED_UP = 1e-3
"""This part of the control points of a piece may have used up their budgets before the piece waits for new candidate
lists. These points stay where they are, within their balls, and the others continue. Otherwise a garment would wait for
one stitch that slides."""


@wp.func
def force_products(
    point_range: PointRange, points: wp.array[Vec3], listed_points: wp.array[Vec3], budget: wp.array[Scalar],
    force: wp.array[Vec3], preconditioner: wp.array[Vec6], memory: LBFGSArrays
) -> Products:  # fmt: skip
    """Products over the control points of a thread.

    Measured, ``compare_forces`` is an eighth faster with this loop in a function than with the loop in the kernel.
    """
    total, trial = Products(), trial_slot(memory.record[point_range.cell])
    for i in range(point_range.first, point_range.last, point_range.threads):
        total = add_force_products(total, i, trial, points, listed_points, budget, force, preconditioner, memory)
    return total


@kernel(tile=THREADS)
def compare_forces(
    # model
    blocks: Blocks,
    # state in
    points: wp.array[Vec3],
    listed_points: wp.array[Vec3],
    budget: wp.array[Scalar],
    force: wp.array[Vec3],
    preconditioner: wp.array[Vec6],
    # state in and out
    memory: LBFGSArrays,
    # state out
    sums: wp.array2d[wp.float64],
) -> None:
    """The change of the gradient over the last move, and all products that the memory needs."""
    block, lane = wp.tid()
    point_range = point_range_of(blocks, block, lane, wp.block_dim())
    products = force_products(point_range, points, listed_points, budget, force, preconditioner, memory)
    sum_over_block(products, sums[block])


@wp.func
def sum_force_products(
    cell: int, lane: int, threads: int, blocks: Blocks, sums: wp.array2d[wp.float64], memory: LBFGSArrays
) -> None:
    """Leave the sums over the blocks of a cell in the memory's ``products``."""
    total = Products()
    for block in range(blocks.of_cell[cell] + lane, blocks.of_cell[cell + 1], threads):
        for k in range(19):
            total[k] += sums[block, k]
    sum_over_block(total, memory.products[cell])


@kernel(tile=THREADS)
def update_memories(
    # model
    blocks: Blocks,
    # state in
    sums: wp.array2d[wp.float64],
    # state in and out
    memory: LBFGSArrays,
) -> None:
    """Take the newest pair of each cell into its memory, and find a_j; one block for each cell."""
    cell, lane = wp.tid()
    sum_force_products(cell, lane, wp.block_dim(), blocks, sums, memory)
    if lane == 0:
        update_memory(cell, memory)


@wp.func
def direction_products(
    point_range: PointRange, force: wp.array[Vec3], preconditioner: wp.array[Vec6], stiffness: wp.array[Scalar],
    memory: LBFGSArrays
) -> Slots:  # fmt: skip
    """Z of the control points of a thread, and its products; a function like ``force_products``."""
    total, record, alpha = Slots(), memory.record[point_range.cell], memory.alpha[point_range.cell]
    for i in range(point_range.first, point_range.last, point_range.threads):
        total = add_direction_products(total, i, record, alpha, force, preconditioner, stiffness, memory)
    return total


@kernel(tile=THREADS)
def apply_preconditioner(
    # model
    blocks: Blocks,
    # state in
    force: wp.array[Vec3],
    preconditioner: wp.array[Vec6],
    stiffness: wp.array[Scalar],
    # state in and out
    memory: LBFGSArrays,
    # state out
    sums: wp.array2d[wp.float64],
) -> None:
    """z, and its products with the memory."""
    block, lane = wp.tid()
    point_range = point_range_of(blocks, block, lane, wp.block_dim())
    sum_over_block(direction_products(point_range, force, preconditioner, stiffness, memory), sums[block])


@wp.func
def sum_direction_products(
    cell: int, lane: int, threads: int, blocks: Blocks, sums: wp.array2d[wp.float64], memory: LBFGSArrays
) -> None:
    """Leave the sums over the blocks of a cell in the memory's ``products``; a function like ``sum_force_products``."""
    total = Slots()
    for block in range(blocks.of_cell[cell] + lane, blocks.of_cell[cell + 1], threads):
        for k in range(7):
            total[k] += sums[block, k]
    sum_over_block(total, memory.products[cell])


@kernel(tile=THREADS)
def update_directions(
    # model
    blocks: Blocks,
    # state in
    sums: wp.array2d[wp.float64],
    # state in and out
    memory: LBFGSArrays,
) -> None:
    """Find a_j - b_j of each cell; one block for each cell."""
    cell, lane = wp.tid()
    sum_direction_products(cell, lane, wp.block_dim(), blocks, sums, memory)
    if lane == 0:
        update_coefficients(cell, memory)


@kernel(tile=THREADS)
def propose_moves(
    # model
    blocks: Blocks,
    step_limit: Scalar,
    # state in
    points: wp.array[Vec3],
    listed_points: wp.array[Vec3],
    budget: wp.array[Scalar],
    # state in and out
    memory: LBFGSArrays,
) -> None:
    """The next move of each control point, no longer than its limit."""
    block, lane = wp.tid()
    point_range = point_range_of(blocks, block, lane, wp.block_dim())
    record, coefficient = memory.record[point_range.cell], memory.alpha_minus_beta[point_range.cell]
    for i in range(point_range.first, point_range.last, point_range.threads):
        propose_move(i, step_limit, record, coefficient, points, listed_points, budget, memory)


@kernel(tile=THREADS)
def apply_moves(
    # model
    blocks: Blocks,
    # state in and out
    memory: LBFGSArrays,
    points: wp.array[Vec3],
) -> None:
    """Move the control points, and store the moves in the slot of the pair on trial."""
    block, lane = wp.tid()
    point_range = point_range_of(blocks, block, lane, wp.block_dim())
    trial = trial_slot(memory.record[point_range.cell])
    for i in range(point_range.first, point_range.last, point_range.threads):
        apply_move(i, trial, points, memory)


@kernel
def begin_anew(
    # model
    wanted: int,
    done: int,
    step_scale: wp.float64,
    # state in and out
    record: wp.array2d[wp.float64],
) -> None:
    """Forget the pairs and the gradients of each cell, and begin an interval after ``done`` iterations."""
    cell = wp.tid()
    for column in range(8):
        record[cell, column] = wp.float64(0.0)
    record[cell, PLAIN] = wp.float64(1.0)
    record[cell, STEP_SCALE] = step_scale
    record[cell, GRADIENTS] = wp.float64(0.0)
    record[cell, PRECONDITIONER_SCALE] = wp.float64(1.0)
    record[cell, ITERATION] = wp.float64(done)
    record[cell, WANTED] = wp.float64(wanted)


class LBFGS(Solver):
    """Limited-memory quasi-Newton steps."""

    needs_blocks = True
    allowed_rise = 1e-3

    def __init__(self, model: Model, further: NDArray[np.float64], strains: int = 0) -> None:
        """Allocate the memory.

        Args:
            model: the model of the yarns.
            further: row sums of the stiffness of further terms, shape (N,).
            strains: number of relaxing cells: all cells, or 0.
        """
        self.bounds = put_bounds(model, stretch_row_sums(model), bend_row_sums(model), further)
        self.memory = make_memory(model, strains)
        self.blocks = blocks_of(model)
        self.sums = wp.zeros((len(self.blocks.cell), PRODUCTS), dtype=wp.float64, device=model.device)
        if not model.on_lattice:
            record = self.memory.record.numpy()
            record[:, MOST_USED_UP] = model.point_count * PART_USED_UP
            self.memory.record.assign(record)
        self.restart(np.ones(model.cell_count))

    def launches(self, inputs: SolverInputs, launcher: Launcher) -> list[Any]:
        """Find the preconditioner and the products of the forces, update the memory, propose, constrain, move."""
        state, memory = inputs.state, self.memory
        ball = [state.points, state.listed_points, state.budget]
        launches = [
            preconditioner_launch(inputs.model, self.bounds, state, launcher),
            self.of_blocks(compare_forces, *ball, state.force, state.preconditioner, memory, self.sums, by=launcher),
            *self.memory_launches(inputs, launcher),
            self.of_blocks(apply_preconditioner, state.force, state.preconditioner, state.stiffness, memory, self.sums,
                           by=launcher),
            self.direction_launch(inputs, launcher),
            self.of_blocks(propose_moves, inputs.model.number(inputs.step_fraction), *ball, memory, by=launcher),
        ]  # fmt: skip
        for constraint in inputs.constraints:
            launches += constraint.filter_steps(state, memory.step, memory.limit, launcher)
        return [*launches, self.move_launch(inputs, launcher)]

    def of_blocks(self, kernel: wp.Kernel, *arguments: Any, by: Launcher) -> Any:
        """Return the launch of a kernel for the control points of all blocks."""
        return by(kernel, len(self.blocks.cell), [self.blocks, *arguments], [])

    def of_cells(self, kernel: wp.Kernel, *arguments: Any, by: Launcher) -> Any:
        """Return the launch of a kernel with one block for each cell."""
        return by(kernel, len(self.memory.record), [self.blocks, *arguments], [])

    def memory_launches(self, inputs: SolverInputs, launcher: Launcher) -> list[Any]:
        """Return the launches that take the newest pair of each cell into its memory."""
        return [self.of_cells(update_memories, self.sums, self.memory, by=launcher)]

    def direction_launch(self, inputs: SolverInputs, launcher: Launcher) -> Any:
        """Return the launch that finds the parts of the pairs in the next move."""
        return self.of_cells(update_directions, self.sums, self.memory, by=launcher)

    def move_launch(self, inputs: SolverInputs, launcher: Launcher) -> Any:
        """Return the launch that moves the control points."""
        return self.of_blocks(apply_moves, self.memory, inputs.state.points, by=launcher)

    def restart(self, step_scale: NDArray[np.float64], cells: NDArray[np.bool_] | None = None) -> None:
        """Forget all pairs of some cells, or of all."""
        record = self.memory.record.numpy()
        record[slice(None) if cells is None else cells, : len(FRESH)] = FRESH
        record[:, STEP_SCALE] = step_scale
        self.memory.record.assign(record)

    def anew_launch(self, wanted: int, done: int, step_scale: float, launcher: Launcher) -> Any:
        """Return the launch that does on the device what ``restart`` and ``begin`` do; the gradients begin anew too."""
        inputs = [wanted, done, wp.float64(step_scale)]
        return launcher(begin_anew, len(self.memory.record), inputs, [self.memory.record])

    def set_step_scale(self, step_scale: NDArray[np.float64]) -> None:
        """Scale the moves of each cell."""
        record = self.memory.record.numpy()
        record[:, STEP_SCALE] = step_scale
        self.memory.record.assign(record)

    def begin(self, wanted: NDArray[np.int64], done: int = 0) -> None:
        """Start an interval, or continue it after ``done`` iterations; the cells stop moving after ``wanted``."""
        record = self.memory.record.numpy()
        record[:, ITERATION], record[:, WANTED] = done, wanted
        self.memory.record.assign(record)

    def progress(self, inputs: SolverInputs, launched: int) -> Progress:
        """Read the iterations that each cell did, and whether it waits for new candidate lists."""
        record = self.memory.record.numpy()
        behind = record[:, WANTED] > record[:, ITERATION]
        used_up = record[:, USED_UP_COUNT] > 0.0
        return Progress(record[:, ITERATION].copy(), behind & (record[:, WAITING] > 0.0), behind & used_up)

    def gradients(self) -> tuple[list[int | None], list[float]]:
        """For each cell, without strains: iterations to a tenth of the first gradient; last gradient over the first."""
        record = self.memory.record.numpy()
        first, last, tenth = (record[:, column] for column in (FIRST_GRADIENT, LAST_GRADIENT, TENTH))
        part = np.divide(last, first, out=np.zeros_like(last), where=first > 0.0)
        return [count or None for count in tenth.astype(int).tolist()], part.tolist()

    def arrays(self) -> dict[str, wp.array[Any]]:
        """Return the arrays of the memory."""
        names = ("moves", "gradient_change", "last_force", "record", "curvature")
        return {name: getattr(self.memory, name) for name in names}
