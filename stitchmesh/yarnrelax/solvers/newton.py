# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Newton's method with conjugate gradients (Nocedal and Wright, algorithm 7.2, in the trust region of the step limits).

At each step the model of the energy with the Hessian H (``hessian_product``) and the forces F is minimised,

    H x = F    by conjugate gradients with the preconditioner C:  the inverse blocks of H at each control point.

The solution is used as far as the model can be trusted: the moves are shortened by one factor for the whole cell, so
that no control point moves more than its limit (``step_limit``), and the solver stops when its iterate is already
``REACH`` times as long as that. Far from rest H is the matrix of Gauss and Newton, which is never negative. Where a
whole step was taken, the next one uses the exact matrix; if a direction of negative curvature appears, the cell is not
at rest but at a saddle, and returns to the first matrix for ``RETURN`` steps.

The length of a whole step of the exact model is an estimate of the distance to rest, of which the next step leaves a
small part: this is what ``convergence`` reads. Each cell has its own model, factor and state.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches, Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import THREADS, Slots, sum_over_block
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT, room_left, shortened
from stitchmesh.yarnrelax.energies.hessian_product import Hessian
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.spline import weight_row
from stitchmesh.yarnrelax.solvers.cell_strain import deformed, strains_of
from stitchmesh.yarnrelax.solvers.lbfgs_steps import CellRanges, cell_ranges
from stitchmesh.yarnrelax.solvers.preconditioner import inverse_block, times_block
from stitchmesh.yarnrelax.solvers.solver import Progress, Solver, SolverInputs

CHUNK = {"cuda": THREADS, "cpu": 1024}
"""Entries of a block."""
REACH = wp.constant(wp.float64(2.0))
"""Length of an iterate over the limit of the moves at which the iteration stops."""
POWERS = {"small": 32.0, "large": 8.0}
"""Power of the mean of the ratios of moves to their limits: of a small cell nearly the largest ratio; in a large piece a
few control points that are faster than all others do not hold up the rest, but are shortened and then damped."""
SMALL_CELL = 4096
"""Control points of the largest small cell."""
SHORTEST_LIMIT = wp.constant(0.05)
"""Limit in mean radii below which a control point is shortened by itself and does not shorten the whole step."""
FORCING = wp.constant(wp.float64(1.0e-2))
"""Part of the residual, in the norm of the preconditioner, at which the iteration ends."""
LEAST_DAMPING, MOST_GROWTH = wp.constant(1.0e-4), wp.constant(8.0)
"""Smallest damping over the stiffness of a control point, and the largest growth of a damping in one step."""
RETURN = 5
"""Steps with the matrix of Gauss and Newton after a negative curvature."""
MOST_PRODUCTS = 1000
"""Products with the Hessian in one step."""

(STEP_SCALE, ACTIVE, DONE, NEGATIVE, PRODUCTS, RZ, RZ0, ALPHA, BETA, RATIO, FACTOR, ITERATION, WANTED, SQUARE,
 WORK, STRAIN) = range(16)  # fmt: skip
RECORD = 16
"""Columns of the record of a cell: scale of the limits; whether it takes part; whether its iteration has ended, and at
a negative curvature; products so far; r . z, and the first; a and b of conjugate gradients; length over limit; factor
of the step; steps done and wanted; square of the step; work of the forces on it; largest strain."""


@wp.struct
class EntryBlocks:
    """The entries of each block of threads: a chunk of control points, or the strains of a cell."""

    cell: wp.array[wp.int32]
    first: wp.array[wp.int32]
    last: wp.array[wp.int32]
    of_cell: wp.array[wp.int32]


@functools.cache
def _solve_struct(scalar: Any) -> Any:
    """The vectors of conjugate gradients, shape (E, 3), the limits, shape (E,), and the record, shape (C, RECORD)."""
    threes = wp.array(dtype=wp.types.vector(length=3, dtype=scalar))
    annotations = {
        "damping": wp.array(dtype=scalar), "x": threes, "r": threes, "z": threes, "p": threes, "product": threes, "step": threes,
        "limit": wp.array(dtype=scalar), "record": wp.array2d(dtype=wp.float64), "sums": wp.array2d(dtype=wp.float64),
    }  # fmt: skip
    return wp.struct(type(f"NewtonSolve_{scalar.__name__}", (), {"__annotations__": annotations}))


@kernel
def find_point_blocks(
    # model
    model: Any,
    further: wp.array[Any],
    # state in
    damping: wp.array[Any],
    leg_hessian: wp.array2d[Any],
    sample_block: wp.array[Any],
    # state out
    preconditioner: wp.array[Any],
) -> None:
    """The inverse of the block of the matrix of Gauss and Newton at each control point."""
    i = wp.tid()
    slots = model.point_segments[i]
    total = leg_hessian[0, 0] - leg_hessian[0, 0]
    block = type(preconditioner[0])()
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            if slot == 0:
                total += leg_hessian[0, s]
            if slot == 1:
                total += leg_hessian[0, s] + leg_hessian[3, s] - leg_hessian[1, s] - wp.transpose(leg_hessian[1, s])
            if slot == 2:
                total += leg_hessian[3, s] + leg_hessian[5, s] - leg_hessian[4, s] - wp.transpose(leg_hessian[4, s])
            if slot == 3:
                total += leg_hessian[5, s]
            first = model.sample_start[s]
            count = model.sample_start[s + 1] - first
            row = weight_row(model, count, 0)
            for k in range(count):
                weight = model.sample_basis[row + k][slot]
                block += sample_block[first + k] * (weight * weight)
    level = further[i] + damping[i] + (total[0, 0] + total[1, 1] + total[2, 2]) * type(further[i])(1.0e-6)
    block += type(block)(
        total[0, 0] + level, total[1, 1] + level, total[2, 2] + level, total[0, 1], total[0, 2], total[1, 2]
    )
    preconditioner[i] = inverse_block(block)


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
    """Start from x = 0, with r = F; the limits of the moves."""
    block, lane = wp.tid()
    cell = blocks.cell[block]
    scale = type(step_limit)(solve.record[cell, STEP_SCALE])
    total = Slots()
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        solve.limit[i] = wp.min(step_limit * scale, room_left(points, listed_points, budget, i))
        r = force[i]
        z = times_block(preconditioner[i], r)
        solve.x[i] = r - r
        solve.r[i] = r
        solve.z[i] = z
        solve.p[i] = z
        total[0] += wp.float64(wp.dot(r, z))
    sum_over_block(total, solve.sums[block])


@kernel
def begin_cells(
    # model
    blocks: EntryBlocks,
    # state in and out
    solve: Any,
) -> None:
    """The first r . z of each cell, and a record for a new step."""
    cell = wp.tid()
    rz = wp.float64(0.0)
    for block in range(blocks.of_cell[cell], blocks.of_cell[cell + 1]):
        rz += solve.sums[block, 0]
    zero, one = wp.float64(0.0), wp.float64(1.0)
    moves = solve.record[cell, WANTED] > solve.record[cell, ITERATION]
    solve.record[cell, ACTIVE] = wp.where(moves, one, zero)
    solve.record[cell, DONE] = wp.where(moves and rz > zero, zero, one)
    solve.record[cell, NEGATIVE] = zero
    solve.record[cell, PRODUCTS] = zero
    solve.record[cell, RZ] = rz
    solve.record[cell, RZ0] = rz
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
    """Sums of p . H p."""
    block, lane = wp.tid()
    total = Slots()
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        p = solve.p[i]
        product = solve.product[i] + p * solve.damping[i]
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
    """a = r . z / p . H p; a negative curvature ends the iteration."""
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
            if solve.record[cell, PRODUCTS] == zero:
                alpha = wp.float64(1.0)
        solve.record[cell, PRODUCTS] = solve.record[cell, PRODUCTS] + wp.float64(1.0)
    solve.record[cell, ALPHA] = alpha


@kernel
def advance_iterate(
    # model
    point_count: int,
    power: wp.float64,
    blocks: EntryBlocks,
    # state in
    preconditioner: wp.array[Any],
    force: wp.array[Any],
    # state in and out
    solve: Any,
) -> None:
    """x + a p, r - a H p, and z = C r."""
    block, lane = wp.tid()
    alpha = solve.record[blocks.cell[block], ALPHA]
    total = Slots()
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        p = solve.p[i]
        a = type(p[0])(alpha)
        x = solve.x[i] + p * a
        r = solve.r[i] - solve.product[i] * a
        z = times_block(preconditioner[i], r)
        solve.x[i] = x
        solve.r[i] = r
        solve.z[i] = z
        limit = wp.max(solve.limit[i], type(a)(SHORTEST_LIMIT))
        ratio = wp.float64(wp.length(x) / limit)
        total[0] += wp.float64(wp.dot(r, z))
        if i < point_count:
            total[1] += wp.pow(ratio, power)
        else:
            total[4] += ratio
        total[2] += wp.float64(wp.dot(x, x))
        total[3] += wp.float64(wp.dot(x, force[i]))
    sum_over_block(total, solve.sums[block])


@kernel
def find_beta(
    # model
    cells: CellRanges,
    blocks: EntryBlocks,
    power: wp.float64,
    most_products: wp.float64,
    # state in and out
    solve: Any,
) -> None:
    """b = new r . z / old r . z; whether the iteration of each cell ends; the factor of its step."""
    cell = wp.tid()
    zero, one = wp.float64(0.0), wp.float64(1.0)
    # each sum is a number of its own: Warp lets names that are assigned from one name share it
    rz, powers, square, work, strain = (
        wp.float64(0.0), wp.float64(0.0), wp.float64(0.0), wp.float64(0.0), wp.float64(0.0)
    )  # fmt: skip
    for block in range(blocks.of_cell[cell], blocks.of_cell[cell + 1]):
        rz += solve.sums[block, 0]
        powers += solve.sums[block, 1]
        square += solve.sums[block, 2]
        work += solve.sums[block, 3]
        strain += solve.sums[block, 4]
    beta = zero
    if solve.record[cell, ALPHA] != zero:
        count = wp.float64(cells.points[cell + 1] - cells.points[cell])
        ratio = wp.max(wp.pow(powers / count, one / power), strain)
        solve.record[cell, RATIO] = ratio
        solve.record[cell, FACTOR] = one / wp.max(one, ratio)
        solve.record[cell, SQUARE] = square
        solve.record[cell, WORK] = work
        beta = rz / solve.record[cell, RZ]
        solve.record[cell, RZ] = rz
        small = rz <= FORCING * FORCING * solve.record[cell, RZ0]
        if small or ratio > REACH or solve.record[cell, PRODUCTS] >= most_products:
            solve.record[cell, DONE] = one
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
    beta = solve.record[blocks.cell[block], BETA]
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        z = solve.z[i]
        solve.p[i] = z + solve.p[i] * type(z[0])(beta)


@kernel
def propose_steps(
    # model
    point_count: int,
    blocks: EntryBlocks,
    # state in
    stiffness: wp.array[Any],
    # state in and out
    solve: Any,
) -> None:
    """The step of each entry, no longer than its limit, and its damping in the next step."""
    block, lane = wp.tid()
    moves = solve.record[blocks.cell[block], ACTIVE]
    factor = solve.record[blocks.cell[block], FACTOR] * solve.record[blocks.cell[block], ACTIVE]
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        step = solve.x[i] * type(solve.damping[i])(factor)
        limit = solve.limit[i]
        solve.step[i] = shortened(step, limit)
        if i < point_count and moves != wp.float64(0.0):
            least = stiffness[i] * type(limit)(LEAST_DAMPING)
            damping = solve.damping[i] + least * type(limit)(0.0)
            length = wp.length(step)
            if length > limit * type(limit)(1.5):
                over = length / wp.max(limit, type(limit)(1.0e-6))
                damping = wp.max(damping, least) * wp.min(over * over, type(limit)(MOST_GROWTH))
            elif length < limit * type(limit)(0.5):
                damping = damping * type(limit)(0.25)
            solve.damping[i] = wp.where(damping < least, type(limit)(0.0), wp.min(damping, stiffness[i]))


@kernel
def apply_steps(
    # model
    cells: CellRanges,
    blocks: EntryBlocks,
    # state in and out
    strains: Any,
    solve: Any,
    points: wp.array[Any],
    listed_points: wp.array[Any],
) -> None:
    """Move all entries, and deform the control points and their listed places as the strains of their cells changed.

    The first control points of a cell also deform what stands once for each segment and for each period of the cell.
    """
    block, lane = wp.tid()
    cell = blocks.cell[block]
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        points[i] = points[i] + solve.step[i]
        if strains.count > 0 and i < cells.point_count:
            e1, e2 = strains.frame[2 * cell], strains.frame[2 * cell + 1]
            more = solve.step[cells.point_count + cell] * strains.per_unit
            points[i] = deformed(points[i], e1, e2, more)
            listed_points[i] = deformed(listed_points[i], e1, e2, more)
            number = i - cells.points[cell]
            s = cells.segments[cell] + number
            if s < cells.segments[cell + 1]:
                strains.listed_centre[s] = deformed(strains.listed_centre[s], e1, e2, more)
            if number < 2:
                strains.periods[2 * cell + number] = deformed(strains.periods[2 * cell + number], e1, e2, more)


@kernel
def count_steps(
    # model
    first_entry: int,
    per_unit: wp.float64,
    # state in
    step: wp.array[Any],
    # state in and out
    record: wp.array2d[wp.float64],
) -> None:
    """Count the step of each cell that moves, and note the largest change of its strains."""
    cell = wp.tid()
    record[cell, ITERATION] = record[cell, ITERATION] + record[cell, ACTIVE]
    if first_entry < step.shape[0]:
        strain = step[first_entry + cell]
        largest = wp.max(wp.abs(strain[0]), wp.max(wp.abs(strain[1]), wp.abs(strain[2])))
        record[cell, STRAIN] = wp.float64(largest) * per_unit


class Newton(Solver):
    """Newton's method with conjugate gradients."""

    needs_blocks = True
    allowed_rise = 0.0
    interval = 1

    def __init__(self, model: Model, further: NDArray[np.float64], strains: int = 0, *, alone: bool = True) -> None:
        """Allocate the vectors; arguments as for ``LBFGS``."""
        self.model, self.strains = model, strains
        self.further = model.upload(np.maximum(further, np.finfo(np.float32).tiny))
        self.cells, self.blocks = cell_ranges(model), entry_blocks(model, strains)
        self.threads = THREADS if model.device.is_cuda else 1
        self.solve = _solve_struct(model.scalar)()
        entries = model.point_count + strains
        for name in ("x", "r", "z", "p", "product", "step"):
            setattr(self.solve, name, model.empty(entries, 3))
        self.solve.limit, self.solve.damping = model.empty(entries), model.empty(entries)
        self.solve.record = wp.zeros((model.cell_count, RECORD), dtype=wp.float64, device=model.device)
        self.solve.sums = wp.zeros((len(self.blocks.cell), 7), dtype=wp.float64, device=model.device)
        self.exact = np.zeros(model.cell_count, dtype=np.int32)
        self.wait = np.zeros(model.cell_count, dtype=np.int32)
        """Steps for which each cell keeps the matrix of Gauss and Newton."""
        self.products = 0
        self.was_exact = np.zeros(model.cell_count, dtype=bool)
        self.restart(np.ones(model.cell_count))

    def launches(self, inputs: SolverInputs, launcher: Launcher) -> list[Any]:
        """Not used: a step has a number of launches that depends on the state."""
        raise NotImplementedError

    def prepare(self, inputs: SolverInputs, forces: list[Any]) -> None:
        """Capture the launches of a step for the current arrays; ``forces`` are those that find the forces."""
        model, state = inputs.model, inputs.state
        launcher, solve, blocks = model.prepare, self.solve, self.blocks
        self.hessian = Hessian(model, state, inputs.candidates, inputs.strain, inputs.terms)
        strains = strains_of(model, inputs.strain, inputs.candidates)
        count, device = len(blocks.cell), model.device
        small = np.diff(model.point_start).max() <= SMALL_CELL
        power = wp.float64(POWERS["small" if small else "large"])

        def tiled(kernel: wp.Kernel, *arguments: Any) -> Any:
            return launcher(kernel, count, list(arguments), [], tile=self.threads)

        def filtered(array: wp.array[Any]) -> list[Any]:
            return [launch for constraint in inputs.constraints for launch in constraint.filter_forces(array, launcher)]

        begin = list(forces)
        if inputs.strain is not None:
            begin += inputs.strain.force_launches(state, inputs.candidates, launcher)
        self.hessian.exact.zero_()
        begin += self.hessian.find_launches(launcher)
        begin.append(launcher(find_point_blocks, model.point_count,
                              [model.constants, self.further, solve.damping, self.hessian.leg_hessian, state.sample_block],
                              [state.preconditioner]))  # fmt: skip
        ball = [state.points, state.listed_points, state.budget]
        start = [
            tiled(start_solve, blocks, model.number(inputs.step_fraction), *ball, state.force, state.preconditioner,
                  solve),
            launcher(begin_cells, model.cell_count, [blocks, solve], []),
            *filtered(solve.p),
        ]  # fmt: skip
        iterate = [
            *self.hessian.product_launches(solve.p, solve.product, launcher),
            *filtered(solve.product),
            tiled(sum_curvature, blocks, solve),
            launcher(find_alpha, model.cell_count, [blocks, solve], []),
            tiled(advance_iterate, model.point_count, power, blocks, state.preconditioner, state.force, solve),
            launcher(find_beta, model.cell_count, [self.cells, blocks, power, wp.float64(MOST_PRODUCTS), solve], []),
            *filtered(solve.z),
            tiled(find_direction, blocks, solve),
        ]
        finish = [tiled(propose_steps, model.point_count, blocks, state.stiffness, solve)]
        for constraint in inputs.constraints:
            finish += constraint.filter_steps(state, solve.step, solve.limit, launcher)
        finish += [
            tiled(apply_steps, self.cells, blocks, strains, solve, *ball[:2]),
            launcher(count_steps, model.cell_count,
                     [model.point_count, wp.float64(1.0 / STRAIN_UNIT), solve.step, solve.record], []),
        ]
        self._begin = CapturedLaunches(begin, device)
        self._find = CapturedLaunches(self.hessian.find_launches(launcher), device)
        self._start = CapturedLaunches(start, device)
        self._iterate = CapturedLaunches(iterate, device, times=8 if device.is_cuda else 1)
        self._finish = CapturedLaunches(finish, device)

    def step(self) -> None:
        """Do one step of all cells that move."""
        self.hessian.exact.zero_()
        self._begin.launch()
        if self.exact.any():
            self.hessian.exact.assign(self.exact)
            self._find.launch()
        self._start.launch()
        while True:
            self._iterate.launch()
            record = self.solve.record.numpy()
            if (record[:, DONE] > 0.0).all():
                break
        self._finish.launch()
        self._choose_matrices(record)

    def _choose_matrices(self, record: NDArray[np.float64]) -> None:
        """Decide which cells use the exact matrix in their next step."""
        moved = record[:, ACTIVE] > 0.0
        self.products += int(record[:, PRODUCTS].max())
        negative = moved & (record[:, NEGATIVE] > 0.0)
        self.wait[moved] = np.maximum(self.wait[moved] - 1, 0)
        self.wait[negative] = RETURN
        self.was_exact = (self.exact > 0) & moved & ~negative
        whole = (record[:, RATIO] < 0.1) & (self.wait == 0)
        self.exact[moved] = whole[moved].astype(np.int32)

    def at_rest(self, tolerance: float) -> NDArray[np.bool_]:
        """Whether the last step of each cell was a whole one of the exact model, and small enough."""
        record = self.solve.record.numpy()
        rms = np.sqrt(record[:, SQUARE] / np.diff(self.model.point_start))
        return self.was_exact & (record[:, RATIO] < 0.5) & (record[:, STRAIN] < tolerance) & (rms < tolerance * 10)

    def restart(self, step_scale: NDArray[np.float64], cells: NDArray[np.bool_] | None = None) -> None:
        """Take the matrix of Gauss and Newton for some cells, or for all; scale the limits of moves."""
        chosen = slice(None) if cells is None else cells
        self.exact[chosen] = 0
        self.wait[chosen] = RETURN if cells is not None else 0
        self.set_step_scale(step_scale)

    def set_step_scale(self, step_scale: NDArray[np.float64]) -> None:
        """Scale the limits of the moves of each cell."""
        record = self.solve.record.numpy()
        record[:, STEP_SCALE] = step_scale
        self.solve.record.assign(record)

    def begin(self, wanted: NDArray[np.int64], done: int = 0) -> None:
        """Start an interval."""
        record = self.solve.record.numpy()
        record[:, ITERATION], record[:, WANTED] = done, wanted
        self.solve.record.assign(record)

    def progress(self, inputs: SolverInputs, launched: int) -> Progress:
        """Read the steps that each cell did; new candidate lists are made before each step."""
        record = self.solve.record.numpy()
        return Progress(record[:, ITERATION].copy(), record[:, ACTIVE] > 0.0)

    def arrays(self) -> dict[str, wp.array[Any]]:
        """The record."""
        return {"record": self.solve.record, "damping": self.solve.damping}


def entry_blocks(model: Model, strains: int) -> Any:
    """Chunks of control points of each cell, and its strains as a block of their own."""
    chunk = CHUNK["cuda" if model.device.is_cuda else "cpu"]
    counts = -(-np.diff(model.point_start) // chunk)
    cell, first, last = [], [], []
    for c in range(model.cell_count):
        starts = model.point_start[c] + np.arange(counts[c]) * chunk
        first.append(starts)
        last.append(np.minimum(starts + chunk, model.point_start[c + 1]))
        if strains:
            first.append(np.array([model.point_count + c]))
            last.append(first[-1] + 1)
        cell.append(np.full(counts[c] + (1 if strains else 0), c))
    blocks = EntryBlocks()
    blocks.cell, blocks.first = model.integers(np.concatenate(cell)), model.integers(np.concatenate(first))
    blocks.last = model.integers(np.concatenate(last))
    blocks.of_cell = model.integers(np.concatenate([[0], np.cumsum([len(c) for c in cell])]))
    return blocks
