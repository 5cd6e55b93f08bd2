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
control points of one cell or the strains of one cell; all sums have a fixed order.
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

(STEP_SCALE, ACTIVE, DONE, NEGATIVE, PRODUCTS, RZ, RZ0, ALPHA, BETA, RATIO, FACTOR, SQUARE, WORK,
 STRAIN) = range(14)  # fmt: skip
RECORD = 14
"""Columns of the record of a cell: scale of the limits; whether the cell takes part; whether its iteration has ended,
and whether at a negative curvature; products so far; r . z, and the first one; a and b; length over the limits; factor
of the step; square of x; work F . x; largest strain of the step."""


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
    The ``record`` of each cell, shape (C, RECORD). The ``sums`` of each block, and its part of r . z, the
    ``residuals``, shape (B, 7).
    """
    scalars, threes = wp.array(dtype=scalar), wp.array(dtype=wp.types.vector(length=3, dtype=scalar))
    doubles = wp.array2d(dtype=wp.float64)
    annotations = {
        "x": threes, "r": threes, "z": threes, "p": threes, "product": threes, "step": threes,
        "limit": scalars, "level": scalars, "damping": scalars,
        "record": doubles, "sums": doubles, "residuals": doubles,
    }  # fmt: skip
    return wp.struct(type(f"NewtonSolve_{scalar.__name__}", (), {"__annotations__": annotations}))


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
    # state in and out
    solve: Any,
) -> None:
    """Start from x = 0, with r = F; the limits of the moves."""
    block, lane = wp.tid()
    cell = blocks.cell[block]
    scale = type(step_limit)(solve.record[cell, STEP_SCALE])
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        solve.limit[i] = wp.min(step_limit * scale, room_left(points, listed_points, budget, i))
        solve.x[i] = force[i] - force[i]
        solve.r[i] = force[i]
        solve.p[i] = force[i] - force[i]


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
    rz = wp.float64(0.0)
    for block in range(blocks.of_cell[cell], blocks.of_cell[cell + 1]):
        rz += solve.residuals[block, 0]
    zero, one = wp.float64(0.0), wp.float64(1.0)
    moves = solve.record[cell, ACTIVE] > zero and rz > zero
    solve.record[cell, DONE] = wp.where(moves, zero, one)
    resting[cell] = wp.where(moves, 0, 1)
    solve.record[cell, NEGATIVE] = zero
    solve.record[cell, PRODUCTS] = zero
    solve.record[cell, RZ] = rz
    solve.record[cell, RZ0] = rz
    solve.record[cell, BETA] = zero
    solve.record[cell, RATIO] = zero
    solve.record[cell, FACTOR] = zero
    solve.record[cell, SQUARE] = zero
    solve.record[cell, WORK] = zero


@kernel
def sum_curvature(
    # model
    blocks: EntryBlocks,
    # state in and out
    solve: Any,
) -> None:
    """The damped product, and sums of p . H p."""
    block, lane = wp.tid()
    if solve.record[blocks.cell[block], DONE] != wp.float64(0.0):
        return
    total = Slots()
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        p = solve.p[i]
        product = solve.product[i] + p * (solve.level[i] * solve.damping[i])
        solve.product[i] = product
        total[0] += wp.float64(wp.dot(p, product))
    sum_over_block(total, solve.sums[block])


@kernel
def find_alpha(
    # model
    blocks: EntryBlocks,
    # state in and out
    solve: Any,
) -> None:
    """Find a = r . z / p . H p; a negative curvature ends the iteration."""
    cell = wp.tid()
    zero = wp.float64(0.0)
    curvature = wp.float64(0.0)
    for block in range(blocks.of_cell[cell], blocks.of_cell[cell + 1]):
        curvature += solve.sums[block, 0]
    alpha = zero
    if solve.record[cell, DONE] == zero:
        if curvature > zero:
            alpha = solve.record[cell, RZ] / curvature
        else:
            solve.record[cell, NEGATIVE] = wp.float64(1.0)
            solve.record[cell, DONE] = wp.float64(1.0)
            alpha = solve.record[cell, RZ] / wp.max(-curvature, SMALLEST_CURVATURE * solve.record[cell, RZ])
        solve.record[cell, PRODUCTS] = solve.record[cell, PRODUCTS] + wp.float64(1.0)
    solve.record[cell, ALPHA] = alpha


@kernel
def advance_iterate(
    # model
    point_count: int,
    blocks: EntryBlocks,
    # state in
    force: wp.array[Any],
    # state in and out
    solve: Any,
) -> None:
    """Find x + a p and r - a H p."""
    block, lane = wp.tid()
    cell = blocks.cell[block]
    alpha, scale = solve.record[cell, ALPHA], solve.record[cell, STEP_SCALE]
    if alpha == wp.float64(0.0):
        return
    total = Slots()
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        p = solve.p[i]
        a = type(p[0])(alpha)
        x = solve.x[i] + p * a
        solve.x[i] = x
        solve.r[i] = solve.r[i] - solve.product[i] * a
        limit = wp.max(solve.limit[i], type(a)(SHORTEST_LIMIT) * type(a)(scale))
        ratio = wp.float64(wp.length(x) / limit)
        if i < point_count:
            total[1] += wp.pow(ratio, POWER)
        else:
            total[4] += ratio
        total[2] += wp.float64(wp.dot(x, x))
        total[3] += wp.float64(wp.dot(x, force[i]))
    sum_over_block(total, solve.sums[block])


@kernel
def apply_point_blocks(
    # model
    blocks: EntryBlocks,
    # state in
    resting: wp.array[wp.int32],
    preconditioner: wp.array[Any],
    # state in and out
    solve: Any,
) -> None:
    """Find z = C r with the blocks at the control points."""
    block, lane = wp.tid()
    if resting[blocks.cell[block]] != 0:
        return
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        solve.z[i] = times_block(preconditioner[i], solve.r[i])


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


@kernel
def find_beta(
    # model
    cells: CellRanges,
    blocks: EntryBlocks,
    most_products: wp.float64,
    # state in and out
    solve: Any,
    # state out
    resting: wp.array[wp.int32],
) -> None:
    """Find b = new r . z / old r . z; whether the iteration of each cell ends; the factor of its step."""
    cell = wp.tid()
    zero, one = wp.float64(0.0), wp.float64(1.0)
    # each sum is a number of its own: Warp lets names that are assigned from one name share it
    rz, powers, square, work, strain = (
        wp.float64(0.0), wp.float64(0.0), wp.float64(0.0), wp.float64(0.0), wp.float64(0.0)
    )  # fmt: skip
    for block in range(blocks.of_cell[cell], blocks.of_cell[cell + 1]):
        rz += solve.residuals[block, 0]
        powers += solve.sums[block, 1]
        square += solve.sums[block, 2]
        work += solve.sums[block, 3]
        strain += solve.sums[block, 4]
    beta = zero
    if solve.record[cell, ALPHA] != zero:
        count = wp.float64(cells.points[cell + 1] - cells.points[cell])
        ratio = wp.max(wp.pow(powers / count, one / POWER), strain)
        solve.record[cell, RATIO] = ratio
        solve.record[cell, FACTOR] = one / wp.max(one, ratio)
        solve.record[cell, SQUARE] = square
        solve.record[cell, WORK] = work
        beta = rz / solve.record[cell, RZ]
        solve.record[cell, RZ] = rz
        small = rz <= FORCING * FORCING * solve.record[cell, RZ0]
        if small or ratio > REACH or solve.record[cell, PRODUCTS] >= most_products:
            solve.record[cell, DONE] = one
        if solve.record[cell, DONE] != zero:
            resting[cell] = 1
    solve.record[cell, BETA] = beta


@kernel
def find_direction(
    # model
    blocks: EntryBlocks,
    # state in and out
    solve: Any,
) -> None:
    """The next direction, p = z + b p."""
    block, lane = wp.tid()
    if solve.record[blocks.cell[block], DONE] != wp.float64(0.0):
        return
    beta = solve.record[blocks.cell[block], BETA]
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        z = solve.z[i]
        solve.p[i] = z + solve.p[i] * type(z[0])(beta)


def make_solve(model: Model, strains: int, blocks: Any) -> Any:
    """The vectors and records of a model's control points and of the strains of ``strains`` cells, in a struct."""
    solve = _solve_struct(model.scalar)()
    entries = model.point_count + strains
    for name in ("x", "r", "z", "p", "product", "step"):
        setattr(solve, name, model.empty(entries, 3))
    solve.limit, solve.level, solve.damping = (model.empty(entries) for _ in range(3))
    solve.record = wp.zeros((model.cell_count, RECORD), dtype=wp.float64, device=model.device)
    solve.sums = wp.zeros((len(blocks.cell), 7), dtype=wp.float64, device=model.device)
    solve.residuals = wp.zeros_like(solve.sums)
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
