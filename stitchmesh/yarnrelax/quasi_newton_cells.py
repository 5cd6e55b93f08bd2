# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The launch of the quasistatic solver for cells: one block of threads a cell does all steps of an iteration.

Small scenes spend their time on launches, and a batch of cells needs sums of its own for each: both are served by one
block a cell, whose threads wait for one another between the steps. Cells know nothing of one another.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.yarnrelax.block import FEWEST_THREADS, MOST_THREADS, sum_rows, wait_for_block
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
"""Control points of the largest cell that a block takes; beyond, the steps of one piece are faster."""


@wp.func
def entry_of(e: int, first: int, count: int, strain: int) -> int:
    """The entry that is number ``e`` of a cell: its control points, then its strains."""
    if e < count:
        return first + e
    return strain


@wp.kernel(module="unique")
def step_cells(
    # model
    step_limit: Any,
    strain_unit: wp.float64,
    strains: int,
    point_count: int,
    cell_points: wp.array[wp.int32],
    cell_segments: wp.array[wp.int32],
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
    """One iteration of each cell, once the forces on its control points are known."""
    cell, lane = wp.tid()
    threads = wp.block_dim()
    first = cell_points[cell]
    count = cell_points[cell + 1] - first
    strain = point_count + cell
    numbers, curvature, fall, rise = all_numbers[cell], all_curvature[cell], all_fall[cell], all_rise[cell]
    parts, products = all_parts[cell], all_products[cell]
    if strains > 0:
        sum_rows(strain_parts[cell], 9, lane, threads, products)
        wait_for_block()
        if lane == 0:
            put_strain_force(
                cell, strain, strain_unit, frame, pulls, free, periods, products, point_force, stiffness, compliance
            )
        wait_for_block()
    new = slot_on_trial(numbers)
    total = Products()
    for e in range(lane, count + strains, threads):
        i = entry_of(e, first, count, strain)
        total = with_products(
            total, i, new, point_force, compliance, moves, points, listed_points, budget, last_force, losses
        )
        if e < count:
            total[25] += wp.float64(wp.dot(point_force[i], point_force[i]))
    for k in range(26):
        parts[k, lane] = total[k]
    wait_for_block()
    sum_rows(parts, 26, lane, threads, products)
    wait_for_block()
    if lane == 0:
        take_pair(products, numbers, curvature, fall)
        note_leaf_test(products[25], numbers)
    wait_for_block()
    plain = numbers[3] != wp.float64(0.0)
    scale = type(step_limit)(numbers[5])
    rises = Slots()
    for e in range(lane, count + strains, threads):
        i = entry_of(e, first, count, strain)
        rises = with_rise(rises, i, plain, scale, point_force, compliance, stiffness, fall, losses, step)
    for k in range(7):
        parts[k, lane] = rises[k]
    wait_for_block()
    sum_rows(parts, 7, lane, threads, products)
    wait_for_block()
    if lane == 0:
        recall_pairs(products, numbers, curvature, fall, rise)
    wait_for_block()
    new = slot_on_trial(numbers)
    for e in range(lane, count + strains, threads):
        i = entry_of(e, first, count, strain)
        move = proposed(i, step_limit, points, listed_points, budget, numbers, rise, moves, step, limit)
        step[i] = move
        moves[new, i] = move
        points[i] = points[i] + move
    if strains > 0:
        wait_for_block()
        e1, e2 = frame[2 * cell], frame[2 * cell + 1]
        more = step[strain] * type(step_limit)(wp.float64(1.0) / strain_unit)
        for e in range(lane, count, threads):
            points[first + e] = deformed(points[first + e], e1, e2, more)
            listed_points[first + e] = deformed(listed_points[first + e], e1, e2, more)
        for s in range(cell_segments[cell] + lane, cell_segments[cell + 1], threads):
            listed_centre[s] = deformed(listed_centre[s], e1, e2, more)
        for k in range(lane, 2, threads):
            periods[2 * cell + k] = deformed(periods[2 * cell + k], e1, e2, more)


def fits_blocks(model: Model) -> bool:
    """Whether all of a model's cells are small enough for a block each."""
    return bool(np.diff(model.point_start).max() <= MOST_POINTS)


def _threads(points: int) -> int:
    """Threads of a block on a GPU whose largest cell has so many control points, a power of two."""
    return int(np.clip(1 << (points - 1).bit_length(), FEWEST_THREADS, MOST_THREADS))


class CellLaunches:
    """Room for the sums over each cell, and its launch."""

    def __init__(self, model: Model, memory: Memory) -> None:
        """A column of sums for each thread of a cell's block."""
        self.model, self.memory = model, memory
        self.threads = _threads(int(np.diff(model.point_start).max())) if model.device.is_cuda else 1
        shape = model.cell_count, PRODUCTS
        self.parts = wp.zeros((*shape, self.threads), dtype=wp.float64, device=model.device)
        self.products = wp.zeros(shape, dtype=wp.float64, device=model.device)
        self.none = [model.empty(0, 3), wp.zeros((0, 0), dtype=wp.float64, device=model.device),
                     wp.zeros(0, dtype=wp.vec3d, device=model.device)]  # fmt: skip

    def launches(self, scene: Scene, run: Run) -> list[Any]:
        """Gather the forces on the strains, then remember, propose, move and deform."""
        state, memory, strain = scene.state, self.memory, scene.strain
        launches = [] if strain is None else [strain.gather_launch(state, run)]
        about = self.none if strain is None else [strain.frame, strain.pulls, strain.free]
        gathered = self.parts if strain is None else strain.parts
        inputs = [self.model.number(scene.step_fraction), wp.float64(STRAIN_UNIT), int(strain is not None),
                  self.model.point_count, self.model.cell_points, self.model.cell_segments, *about, gathered,
                  state.budget]  # fmt: skip
        periods = self.model.constants.images.periods
        outputs = [state.point_force, state.stiffness, state.compliance, state.points, state.listed_points,
                   scene.candidates.near.listed_centre, periods, memory.moves, memory.losses, memory.last_force,
                   memory.step, memory.limit, memory.numbers, memory.curvature, memory.fall, memory.rise, self.parts,
                   self.products]  # fmt: skip
        launches.append(run(step_cells, self.model.cell_count, inputs, outputs, tile=self.threads))
        return launches
