# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conjugate gradients for the model of a Newton step, many cells at a time (Nocedal and Wright, algorithm 7.2).

For the forces F, the Hessian H (``hessian_product``) and the preconditioner C, from x = 0 and r = F:

    a = r . z / p . H p,    x + a p,    r - a H p,    z = C r,    b = new r . z / old r . z,    p = z + b p

The iteration of a cell ends where the residual r . z has fallen to the square of ``FORCING``, where x is ``REACH``
times as long as the limits of the moves allow, at a direction p of negative curvature, along which x moves by r . z /
|p . H p|, or after a number of products. The length of x over the limits is a mean over the control points of |x_i| /
limit_i with a high power (``POWER``). The product is damped: a multiple of the level of stiffness at each control point
is added to H.

An entry is a control point, or the strains of a cell (``cell_strain``). Each block of threads has a chunk of the
control points of one cell or the strains of one cell; all sums have a fixed order. A GPU waits for launches rather than
for the work of small cells: each block therefore adds up the sums of all blocks of its cell itself and finds a and b,
and the first block of a cell notes them in its record.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block
from stitchmesh.yarnrelax.collision.budget import room_left
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.solvers.lbfgs_steps import CellRanges
from stitchmesh.yarnrelax.solvers.preconditioner import times_block

CHUNK = {"cuda": THREADS, "cpu": 1024}
"""Entries of a block."""
REACH = wp.constant(wp.float64(2.0))
"""Length of an iterate over the limits of the moves at which the iteration ends."""
POWER = wp.constant(wp.float64(32.0))
"""Power of the mean of the ratios of moves to their limits: nearly the largest ratio, as a sum in a fixed order."""
SHORTEST_LIMIT = wp.constant(0.05)
"""Limit in mean radii, times the scale of the limits, below which a control point is shortened by itself and does not
shorten the whole step."""
SMALLEST_CURVATURE = wp.constant(wp.float64(1.0e-3))
"""Smallest negative curvature p . H p over r . z that scales a move along p."""
FORCING = wp.constant(wp.float64(1.0e-2))
"""Part of the residual, in the norm of the preconditioner, at which the iteration ends."""

(STEP_SCALE, ACTIVE, DONE, NEGATIVE, PRODUCTS, RZ, RZ0, ALPHA, NEXT_RZ, RATIO, FACTOR, SQUARE, WORK, STRAIN,
 MOST) = range(15)  # fmt: skip
RECORD = 15
"""Columns of the record of a cell: scale of the limits; whether the cell takes part; whether its iteration has ended
(``ENDED``, ``CUT_SHORT``), and whether at a negative curvature; products so far; r . z, and the first one; a; r . z of
the next direction; length over the limits; factor of the step; square of x; work F . x; largest strain of the step;
largest number of products."""
ENDED, CUT_SHORT = wp.constant(wp.float64(1.0)), wp.constant(wp.float64(2.0))
"""An iteration that has ended, and one that only its number of products has ended."""


@wp.struct
class EntryBlocks:
    """The entries of each block of threads: a chunk of the control points of a cell, or the strains of a cell."""

    cell: wp.array[wp.int32]
    first: wp.array[wp.int32]
    last: wp.array[wp.int32]
    of_cell: wp.array[wp.int32]


@functools.cache
def _solve_struct(scalar: Any) -> Any:
    """The struct of a solve in one precision.

    Vectors of shape (E, 3): the iterate ``x``, the residual ``r``, ``z``, the direction ``p``, its ``product`` with the
    Hessian, and the ``step``. The ``limit`` of each move, the ``level`` of stiffness and the ``damping``, shape (E,).
    The ``record`` of each cell, shape (C, RECORD). The ``sums`` of each block, and its parts of p . H p, the
    ``curvatures``, and of r . z, the ``residuals``, shape (B, 7).
    """
    scalars, threes = wp.array(dtype=scalar), wp.array(dtype=wp.types.vector(length=3, dtype=scalar))
    doubles = wp.array2d(dtype=wp.float64)
    annotations = {
        "x": threes, "r": threes, "z": threes, "p": threes, "product": threes, "step": threes,
        "limit": scalars, "level": scalars, "damping": scalars,
        "record": doubles, "sums": doubles, "curvatures": doubles, "residuals": doubles,
    }  # fmt: skip
    return wp.struct(type(f"NewtonSolve_{scalar.__name__}", (), {"__annotations__": annotations}))


@wp.func
def sum_of_blocks(blocks: EntryBlocks, cell: int, column: int, sums: wp.array2d[wp.float64]) -> wp.float64:
    """The sum over the blocks of a cell."""
    total = wp.float64(0.0)
    for block in range(blocks.of_cell[cell], blocks.of_cell[cell + 1]):
        total += sums[block, column]
    return total


@wp.func
def keeps_record(blocks: EntryBlocks, block: int, lane: int) -> bool:
    """Whether a thread writes the record of its cell."""
    return lane == 0 and blocks.of_cell[blocks.cell[block]] == block


@kernel
def start_solve(
    # model
    blocks: EntryBlocks,
    step_limit: Any,
    # state in
    points: wp.array[Any],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    force: wp.array[Any],
    preconditioner: wp.array[Any],
    # state in and out
    solve: Any,
) -> None:
    """Start from x = 0, with r = F and z = C r of the blocks; the limits of the moves."""
    block, lane = wp.tid()
    cell = blocks.cell[block]
    scale = type(step_limit)(solve.record[cell, STEP_SCALE])
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        solve.limit[i] = wp.min(step_limit * scale, room_left(points, listed_points, budget, i))
        solve.x[i] = force[i] - force[i]
        solve.r[i] = force[i]
        solve.z[i] = times_block(preconditioner[i], force[i])


@kernel
def begin_cells(
    # model
    blocks: EntryBlocks,
    # state in and out
    solve: Any,
    # state out
    resting: wp.array[wp.int32],
) -> None:
    """The first r . z of each cell, and a record for a new step."""
    cell = wp.tid()
    rz = sum_of_blocks(blocks, cell, 0, solve.residuals)
    zero, one = wp.float64(0.0), wp.float64(1.0)
    moves = solve.record[cell, ACTIVE] > zero and rz > zero
    solve.record[cell, DONE] = wp.where(moves, zero, one)
    resting[cell] = wp.where(moves, 0, 1)
    solve.record[cell, NEGATIVE] = zero
    solve.record[cell, PRODUCTS] = zero
    solve.record[cell, NEXT_RZ] = rz
    solve.record[cell, RZ0] = rz
    solve.record[cell, RATIO] = zero
    solve.record[cell, FACTOR] = zero
    solve.record[cell, SQUARE] = zero
    solve.record[cell, WORK] = zero


@kernel
def begin_directions(
    # model
    blocks: EntryBlocks,
    # state in and out
    solve: Any,
) -> None:
    """The first direction, p = z."""
    block, lane = wp.tid()
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        solve.p[i] = solve.z[i]


@kernel
def sum_curvature(
    # model
    blocks: EntryBlocks,
    # state in and out
    solve: Any,
) -> None:
    """The damped product, and sums of p . H p."""
    block, lane = wp.tid()
    cell = blocks.cell[block]
    if solve.record[cell, DONE] != wp.float64(0.0):
        return
    if keeps_record(blocks, block, lane):
        solve.record[cell, RZ] = solve.record[cell, NEXT_RZ]
    total = Slots()
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        p = solve.p[i]
        product = solve.product[i] + p * (solve.level[i] * solve.damping[i])
        solve.product[i] = product
        total[0] += wp.float64(wp.dot(p, product))
    sum_over_block(total, solve.curvatures[block])


@wp.func
def advance_entries(
    blocks: EntryBlocks, block: int, lane: int, point_count: int, alpha: wp.float64, force: wp.array[Any],
    preconditioner: wp.array[Any], solve: Any
) -> Slots:  # fmt: skip
    """Find x + a p, r - a H p and z = C r of the entries of a thread; sums of x."""
    total = Slots()
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        p = solve.p[i]
        a = type(p[0])(alpha)
        x, r = solve.x[i] + p * a, solve.r[i] - solve.product[i] * a
        solve.x[i] = x
        solve.r[i] = r
        solve.z[i] = times_block(preconditioner[i], r)
        shortest = type(a)(SHORTEST_LIMIT) * type(a)(solve.record[blocks.cell[block], STEP_SCALE])
        ratio = wp.float64(wp.length(x) / wp.max(solve.limit[i], shortest))
        if i < point_count:
            total[1] += wp.pow(ratio, POWER)
        else:
            total[4] += ratio
        total[2] += wp.float64(wp.dot(x, x))
        total[3] += wp.float64(wp.dot(x, force[i]))
    return total


@kernel
def advance_iterate(
    # model
    point_count: int,
    blocks: EntryBlocks,
    # state in
    force: wp.array[Any],
    preconditioner: wp.array[Any],
    # state in and out
    solve: Any,
) -> None:
    """Find a = r . z / p . H p, and with it x + a p, r - a H p and z = C r of the blocks."""
    block, lane = wp.tid()
    cell, zero = blocks.cell[block], wp.float64(0.0)
    notes = keeps_record(blocks, block, lane)
    if solve.record[cell, DONE] != zero:
        if notes:
            solve.record[cell, ALPHA] = zero
        return
    curvature, rz = sum_of_blocks(blocks, cell, 0, solve.curvatures), solve.record[cell, RZ]
    divisor = wp.where(curvature > zero, curvature, wp.max(-curvature, SMALLEST_CURVATURE * rz))
    alpha = rz / divisor
    if notes:
        solve.record[cell, ALPHA] = alpha
        solve.record[cell, NEGATIVE] = wp.where(curvature > zero, zero, wp.float64(1.0))
        solve.record[cell, PRODUCTS] = solve.record[cell, PRODUCTS] + wp.float64(1.0)
    total = advance_entries(blocks, block, lane, point_count, alpha, force, preconditioner, solve)
    sum_over_block(total, solve.sums[block])


@kernel
def sum_residuals(
    # model
    blocks: EntryBlocks,
    # state in
    resting: wp.array[wp.int32],
    # state in and out
    solve: Any,
) -> None:
    """Sums of r . z."""
    block, lane = wp.tid()
    if resting[blocks.cell[block]] != 0:
        return
    total = Slots()
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        total[0] += wp.float64(wp.dot(solve.r[i], solve.z[i]))
    sum_over_block(total, solve.residuals[block])


@wp.func
def end_at(
    cells: CellRanges, blocks: EntryBlocks, cell: int, rz: wp.float64, solve: Any
) -> wp.float64:  # fmt: skip
    """Whether and how the iteration of a cell ends, 0 if it goes on; note the length and the factor of its step."""
    one = wp.float64(1.0)
    count = wp.float64(cells.points[cell + 1] - cells.points[cell])
    powers, strain = sum_of_blocks(blocks, cell, 1, solve.sums), sum_of_blocks(blocks, cell, 4, solve.sums)
    ratio = wp.max(wp.pow(powers / count, one / POWER), strain)
    solve.record[cell, RATIO] = ratio
    solve.record[cell, FACTOR] = one / wp.max(one, ratio)
    solve.record[cell, SQUARE] = sum_of_blocks(blocks, cell, 2, solve.sums)
    solve.record[cell, WORK] = sum_of_blocks(blocks, cell, 3, solve.sums)
    small = rz <= FORCING * FORCING * solve.record[cell, RZ0] or solve.record[cell, NEGATIVE] != wp.float64(0.0)
    if small or ratio > REACH:
        return ENDED
    return wp.where(solve.record[cell, PRODUCTS] >= solve.record[cell, MOST], CUT_SHORT, wp.float64(0.0))


@kernel
def find_direction(
    # model
    cells: CellRanges,
    blocks: EntryBlocks,
    # state in and out
    solve: Any,
    # state out
    resting: wp.array[wp.int32],
) -> None:
    """Find b = new r . z / old r . z and the next direction, p = z + b p; whether the iteration of each cell ends."""
    block, lane = wp.tid()
    cell = blocks.cell[block]
    if solve.record[cell, ALPHA] == wp.float64(0.0):
        return
    rz = sum_of_blocks(blocks, cell, 0, solve.residuals)
    beta = rz / solve.record[cell, RZ]
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        z = solve.z[i]
        solve.p[i] = z + solve.p[i] * type(z[0])(beta)
    if keeps_record(blocks, block, lane):
        solve.record[cell, NEXT_RZ] = rz
        end = end_at(cells, blocks, cell, rz, solve)
        if end != wp.float64(0.0):
            solve.record[cell, DONE] = end
            resting[cell] = 1


def make_solve(model: Model, strains: int, blocks: Any) -> Any:
    """The vectors and records of a model's control points and of the strains of ``strains`` cells, in a struct."""
    solve = _solve_struct(model.scalar)()
    entries = model.point_count + strains
    for name in ("x", "r", "z", "p", "product", "step"):
        setattr(solve, name, model.empty(entries, 3))
    solve.limit, solve.level, solve.damping = (model.empty(entries) for _ in range(3))
    solve.record = wp.zeros((model.cell_count, RECORD), dtype=wp.float64, device=model.device)
    solve.sums = wp.zeros((len(blocks.cell), 7), dtype=wp.float64, device=model.device)
    solve.curvatures, solve.residuals = wp.zeros_like(solve.sums), wp.zeros_like(solve.sums)
    return solve


def entry_blocks(model: Model, strains: int) -> Any:
    """The blocks of the control points of each cell, and one for its strains where cells relax."""
    chunk = CHUNK["cuda" if model.device.is_cuda else "cpu"]
    ranges = []
    for cell, (start, end) in enumerate(zip(model.point_start[:-1], model.point_start[1:], strict=True)):
        firsts = np.arange(start, end, chunk)
        ranges += [(cell, first, min(first + chunk, end)) for first in firsts]
        if strains:
            ranges.append((cell, model.point_count + cell, model.point_count + cell + 1))
    cell, first, last = np.array(ranges).T
    blocks = EntryBlocks()
    blocks.cell, blocks.first, blocks.last = model.integers(cell), model.integers(first), model.integers(last)
    blocks.of_cell = model.integers(np.searchsorted(cell, np.arange(model.cell_count + 1)))
    return blocks
