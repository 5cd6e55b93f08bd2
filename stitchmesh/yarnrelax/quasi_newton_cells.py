# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches of the quasistatic solver for cells, which know nothing of one another.

Small scenes spend their time on launches, and a batch of cells needs sums of its own for each: both are served by one
block of threads a cell, which wait for one another between the steps of an iteration. Where a cell is too large for
that, each step is a launch over all cells.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.yarnrelax.block import FEWEST_THREADS, MOST_THREADS, THREADS, sum_rows, wait_for_block
from stitchmesh.yarnrelax.cell import deformed, put_strain_force
from stitchmesh.yarnrelax.method import Scene
from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.quasi_newton_memory import Memory
from stitchmesh.yarnrelax.quasi_newton_steps import (
    PRODUCTS,
    Products,
    Slots,
    note_leaf_test,
    proposed,
    recall_pairs,
    slot_on_trial,
    take_pair,
    with_products,
    with_rise,
)
from stitchmesh.yarnrelax.state import STRAIN_UNIT
from stitchmesh.yarnrelax.term import Run

wp.set_module_options({"enable_backward": False})

MOST_POINTS = 20_000
"""Control points of the largest cell; a larger one is a piece that all of the device works on."""
MOST_IN_BLOCK = 2048
"""Control points of the largest cell for which a block does all steps of an iteration on a GPU: a block reads no more
than one multiprocessor does, and beyond that launches for each step are faster."""
ENTRIES_PER_STRAND, FEWEST_STRANDS, MOST_STRANDS = 8, 256, 1024
"""Entries of the largest cell that a strand takes, and the bounds of the number of strands of a cell."""


@wp.func
def entry_of(e: int, first: int, count: int, strain: int) -> int:
    """The entry that is number ``e`` of a cell: its control points, then its strains."""
    if e < count:
        return first + e
    return strain


@wp.struct
class Cells:
    """Which entries are a cell's."""

    point_count: wp.int32
    strains: wp.int32
    points: wp.array[wp.int32]
    segments: wp.array[wp.int32]


@wp.func
def compared(
    cells: Cells,
    cell: int,
    lane: int,
    threads: int,
    new: int,
    force: wp.array[Any],
    compliance: wp.array[Any],
    moves: wp.array2d[Any],
    points: wp.array[Any],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    last_force: wp.array[Any],
    losses: wp.array2d[Any],
    parts: wp.array2d[wp.float64],
) -> None:
    """Products over a thread's entries."""
    first = cells.points[cell]
    count = cells.points[cell + 1] - first
    total = Products()
    for e in range(lane, count + cells.strains, threads):
        i = entry_of(e, first, count, cells.point_count + cell)
        total = with_products(
            total, i, new, force, compliance, moves, points, listed_points, budget, last_force, losses
        )
        if e < count:
            total[25] += wp.float64(wp.dot(force[i], force[i]))
    for k in range(26):
        parts[k, lane] = total[k]


@wp.func
def preconditioned(
    cells: Cells,
    cell: int,
    lane: int,
    threads: int,
    numbers: wp.array[wp.float64],
    force: wp.array[Any],
    compliance: wp.array[Any],
    stiffness: wp.array[Any],
    fall: wp.array[wp.float64],
    losses: wp.array2d[Any],
    step: wp.array[Any],
    parts: wp.array2d[wp.float64],
) -> None:
    """Z of a thread's entries, and its products."""
    first = cells.points[cell]
    count = cells.points[cell + 1] - first
    plain = numbers[3] != wp.float64(0.0)
    total = Slots()
    for e in range(lane, count + cells.strains, threads):
        i = entry_of(e, first, count, cells.point_count + cell)
        scale = type(stiffness[i])(numbers[5])
        total = with_rise(total, i, plain, scale, force, compliance, stiffness, fall, losses, step)
    for k in range(7):
        parts[k, lane] = total[k]


@wp.func
def moved(
    cells: Cells,
    cell: int,
    lane: int,
    threads: int,
    step_limit: Any,
    numbers: wp.array[wp.float64],
    rise: wp.array[wp.float64],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    points: wp.array[Any],
    moves: wp.array2d[Any],
    step: wp.array[Any],
    limit: wp.array[Any],
) -> None:
    """Move a thread's entries."""
    first = cells.points[cell]
    count = cells.points[cell + 1] - first
    new = slot_on_trial(numbers)
    for e in range(lane, count + cells.strains, threads):
        i = entry_of(e, first, count, cells.point_count + cell)
        move = proposed(i, step_limit, points, listed_points, budget, numbers, rise, moves, step, limit)
        step[i] = move
        moves[new, i] = move
        points[i] = points[i] + move


@wp.func
def strained(
    cells: Cells,
    cell: int,
    lane: int,
    threads: int,
    per_unit: Any,
    frame: wp.array[Any],
    step: wp.array[Any],
    points: wp.array[Any],
    listed_points: wp.array[Any],
    listed_centre: wp.array[Any],
    periods: wp.array[Any],
) -> None:
    """Deform a thread's places by the move of the cell's strains."""
    e1, e2 = frame[2 * cell], frame[2 * cell + 1]
    more = step[cells.point_count + cell] * per_unit
    for i in range(cells.points[cell] + lane, cells.points[cell + 1], threads):
        points[i] = deformed(points[i], e1, e2, more)
        listed_points[i] = deformed(listed_points[i], e1, e2, more)
    for s in range(cells.segments[cell] + lane, cells.segments[cell + 1], threads):
        listed_centre[s] = deformed(listed_centre[s], e1, e2, more)
    for k in range(lane, 2, threads):
        periods[2 * cell + k] = deformed(periods[2 * cell + k], e1, e2, more)


@wp.kernel(module="unique")
def step_cells(
    # model
    cells: Cells,
    step_limit: Any,
    per_unit: Any,
    strain_unit: wp.float64,
    frame: wp.array[Any],
    pulls: wp.array2d[wp.float64],
    free: wp.array[wp.vec3d],
    # state in
    strain_parts: wp.array3d[wp.float64],
    budget: wp.array[Any],
    # state out
    point_force: wp.array[Any],
    stiffness: wp.array[Any],
    compliance: wp.array[Any],
    points: wp.array[Any],
    listed_points: wp.array[Any],
    listed_centre: wp.array[Any],
    periods: wp.array[Any],
    moves: wp.array2d[Any],
    losses: wp.array2d[Any],
    last_force: wp.array[Any],
    step: wp.array[Any],
    limit: wp.array[Any],
    all_numbers: wp.array2d[wp.float64],
    all_curvature: wp.array3d[wp.float64],
    all_fall: wp.array2d[wp.float64],
    all_rise: wp.array2d[wp.float64],
    all_parts: wp.array3d[wp.float64],
    all_products: wp.array2d[wp.float64],
) -> None:
    """One iteration of each cell, once the forces on its control points are known; a block a cell."""
    cell, lane = wp.tid()
    threads = wp.block_dim()
    numbers, curvature, fall, rise = all_numbers[cell], all_curvature[cell], all_fall[cell], all_rise[cell]
    parts, products = all_parts[cell], all_products[cell]
    if cells.strains > 0:
        sum_rows(strain_parts[cell], 9, lane, threads, products)
        wait_for_block()
        if lane == 0:
            put_strain_force(
                cell, cells.point_count + cell, strain_unit, frame, pulls, free, periods, products, point_force,
                stiffness, compliance,
            )  # fmt: skip
        wait_for_block()
    new = slot_on_trial(numbers)
    compared(
        cells, cell, lane, threads, new, point_force, compliance, moves, points, listed_points, budget, last_force,
        losses, parts,
    )  # fmt: skip
    wait_for_block()
    sum_rows(parts, 26, lane, threads, products)
    wait_for_block()
    if lane == 0:
        take_pair(products, numbers, curvature, fall)
        note_leaf_test(products[25], numbers)
    wait_for_block()
    preconditioned(
        cells, cell, lane, threads, numbers, point_force, compliance, stiffness, fall, losses, step, parts
    )
    wait_for_block()
    sum_rows(parts, 7, lane, threads, products)
    wait_for_block()
    if lane == 0:
        recall_pairs(products, numbers, curvature, fall, rise)
    wait_for_block()
    moved(cells, cell, lane, threads, step_limit, numbers, rise, listed_points, budget, points, moves, step, limit)
    if cells.strains > 0:
        wait_for_block()
        strained(
            cells, cell, lane, threads, per_unit, frame, step, points, listed_points, listed_centre, periods
        )


@wp.kernel(module="unique")
def compare_cells(
    # model
    cells: Cells,
    strands: int,
    # state in
    force: wp.array[Any],
    compliance: wp.array[Any],
    numbers: wp.array2d[wp.float64],
    moves: wp.array2d[Any],
    points: wp.array[Any],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    # state out
    last_force: wp.array[Any],
    losses: wp.array2d[Any],
    parts: wp.array3d[wp.float64],
) -> None:
    """Products of each cell; so many strands a cell."""
    cell = wp.tid() // strands
    lane = wp.tid() - cell * strands
    new = slot_on_trial(numbers[cell])
    compared(
        cells, cell, lane, strands, new, force, compliance, moves, points, listed_points, budget, last_force, losses,
        parts[cell],
    )  # fmt: skip


@wp.kernel(module="unique")
def remember_cells(
    # state in
    parts: wp.array3d[wp.float64],
    # state out
    products: wp.array2d[wp.float64],
    numbers: wp.array2d[wp.float64],
    curvature: wp.array3d[wp.float64],
    fall: wp.array2d[wp.float64],
) -> None:
    """Take the newest pair of each cell into its memory; a block a cell."""
    cell, lane = wp.tid()
    sum_rows(parts[cell], 26, lane, wp.block_dim(), products[cell])
    wait_for_block()
    if lane == 0:
        take_pair(products[cell], numbers[cell], curvature[cell], fall[cell])
        note_leaf_test(products[cell, 25], numbers[cell])


@wp.kernel(module="unique")
def precondition_cells(
    # model
    cells: Cells,
    strands: int,
    # state in
    force: wp.array[Any],
    compliance: wp.array[Any],
    stiffness: wp.array[Any],
    numbers: wp.array2d[wp.float64],
    fall: wp.array2d[wp.float64],
    losses: wp.array2d[Any],
    # state out
    step: wp.array[Any],
    parts: wp.array3d[wp.float64],
) -> None:
    """Z of each cell, and its products with the memory; so many strands a cell."""
    cell = wp.tid() // strands
    lane = wp.tid() - cell * strands
    preconditioned(
        cells, cell, lane, strands, numbers[cell], force, compliance, stiffness, fall[cell], losses, step, parts[cell]
    )


@wp.kernel(module="unique")
def recall_cells(
    # state in
    parts: wp.array3d[wp.float64],
    numbers: wp.array2d[wp.float64],
    curvature: wp.array3d[wp.float64],
    fall: wp.array2d[wp.float64],
    # state out
    products: wp.array2d[wp.float64],
    rise: wp.array2d[wp.float64],
) -> None:
    """The numbers a_j - b_j of each cell; a block a cell."""
    cell, lane = wp.tid()
    sum_rows(parts[cell], 7, lane, wp.block_dim(), products[cell])
    wait_for_block()
    if lane == 0:
        recall_pairs(products[cell], numbers[cell], curvature[cell], fall[cell], rise[cell])


@wp.kernel(module="unique")
def move_cells(
    # model
    cells: Cells,
    strands: int,
    step_limit: Any,
    # state in
    numbers: wp.array2d[wp.float64],
    rise: wp.array2d[wp.float64],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    # state out
    points: wp.array[Any],
    moves: wp.array2d[Any],
    step: wp.array[Any],
    limit: wp.array[Any],
) -> None:
    """Move the entries of each cell; so many strands a cell."""
    cell = wp.tid() // strands
    lane = wp.tid() - cell * strands
    moved(
        cells, cell, lane, strands, step_limit, numbers[cell], rise[cell], listed_points, budget, points, moves, step,
        limit,
    )  # fmt: skip


@wp.kernel(module="unique")
def strain_cells(
    # model
    cells: Cells,
    strands: int,
    per_unit: Any,
    frame: wp.array[Any],
    # state in
    step: wp.array[Any],
    # state out
    points: wp.array[Any],
    listed_points: wp.array[Any],
    listed_centre: wp.array[Any],
    periods: wp.array[Any],
) -> None:
    """Deform each cell by the move of its strains; so many strands a cell."""
    cell = wp.tid() // strands
    lane = wp.tid() - cell * strands
    strained(cells, cell, lane, strands, per_unit, frame, step, points, listed_points, listed_centre, periods)


def fits_cells(model: Model) -> bool:
    """Whether a model's fabrics are cells small enough to be worked on side by side."""
    return bool(np.diff(model.point_start).max() <= MOST_POINTS)


def _power(count: int, fewest: int, most: int) -> int:
    """A power of two of at least so many, within bounds that are powers of two."""
    return int(np.clip(1 << max(count - 1, 0).bit_length(), fewest, most))


class CellLaunches:
    """Room for the sums over each cell, and its launches: one block for all steps, or one launch a step."""

    def __init__(self, model: Model, memory: Memory) -> None:
        """A column of sums for each thread of a cell's block, or for each of its strands."""
        self.model, self.memory = model, memory
        largest = int(np.diff(model.point_start).max())
        self.in_blocks = not model.device.is_cuda or largest <= MOST_IN_BLOCK
        self.threads = 1
        if model.device.is_cuda:
            self.threads = _power(largest, FEWEST_THREADS, MOST_THREADS)
        if not self.in_blocks:
            self.threads = _power(largest // ENTRIES_PER_STRAND, FEWEST_STRANDS, MOST_STRANDS)
        shape = model.cell_count, PRODUCTS
        self.parts = wp.zeros((*shape, self.threads), dtype=wp.float64, device=model.device)
        self.products = wp.zeros(shape, dtype=wp.float64, device=model.device)
        self.none = [model.empty(0, 3), wp.zeros((0, 0), dtype=wp.float64, device=model.device),
                     wp.zeros(0, dtype=wp.vec3d, device=model.device)]  # fmt: skip

    def launches(self, scene: Scene, run: Run) -> list[Any]:
        """Gather the forces on the strains, then remember, propose, move and deform."""
        return self._block_launches(scene, run) if self.in_blocks else self._step_launches(scene, run)

    def _cells(self, scene: Scene) -> Any:
        cells = Cells()
        cells.point_count, cells.strains = self.model.point_count, int(scene.strain is not None)
        cells.points, cells.segments = self.model.cell_points, self.model.cell_segments
        return cells

    def _block_launches(self, scene: Scene, run: Run) -> list[Any]:
        state, memory, strain, model = scene.state, self.memory, scene.strain, self.model
        launches = [] if strain is None else [strain.gather_launch(state, run)]
        about = self.none if strain is None else [strain.frame, strain.pulls, strain.free]
        gathered = self.parts if strain is None else strain.parts
        inputs = [self._cells(scene), model.number(scene.step_fraction), model.number(1.0 / STRAIN_UNIT),
                  wp.float64(STRAIN_UNIT), *about, gathered, state.budget]  # fmt: skip
        outputs = [state.point_force, state.stiffness, state.compliance, state.points, state.listed_points,
                   scene.candidates.near.listed_centre, model.constants.images.periods, memory.moves, memory.losses,
                   memory.last_force, memory.step, memory.limit, memory.numbers, memory.curvature, memory.fall,
                   memory.rise, self.parts, self.products]  # fmt: skip
        return [*launches, run(step_cells, model.cell_count, inputs, outputs, tile=self.threads)]

    def _step_launches(self, scene: Scene, run: Run) -> list[Any]:
        state, memory, strain, model = scene.state, self.memory, scene.strain, self.model
        count, strands = model.cell_count, model.cell_count * self.threads
        own = [self._cells(scene), self.threads]
        now = [state.point_force, state.compliance]
        launches = [] if strain is None else strain.force_launches(state, run)
        launches += [
            run(compare_cells, strands, [*own, *now, memory.numbers, memory.moves, state.points, state.listed_points,
                state.budget], [memory.last_force, memory.losses, self.parts]),
            run(remember_cells, count, [self.parts], [self.products, memory.numbers, memory.curvature, memory.fall],
                tile=THREADS),
            run(precondition_cells, strands, [*own, *now, state.stiffness, memory.numbers, memory.fall, memory.losses],
                [memory.step, self.parts]),
            run(recall_cells, count, [self.parts, memory.numbers, memory.curvature, memory.fall],
                [self.products, memory.rise], tile=THREADS),
            run(move_cells, strands, [*own, model.number(scene.step_fraction), memory.numbers, memory.rise,
                state.listed_points, state.budget], [state.points, memory.moves, memory.step, memory.limit]),
        ]  # fmt: skip
        if strain is not None:
            inputs = [*own, model.number(1.0 / STRAIN_UNIT), strain.frame, memory.step]
            outputs = [state.points, state.listed_points, scene.candidates.near.listed_centre, strain.periods]
            launches.append(run(strain_cells, strands, inputs, outputs))
        return launches
