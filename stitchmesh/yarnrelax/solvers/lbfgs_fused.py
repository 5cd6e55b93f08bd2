# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Many iterations of small cells in one launch: a block of threads a cell, which wait for one another between steps.

A launch costs more than the work of a small iteration, and a batch of small cells has a multiprocessor for each. A
block goes on until its cell has done what it should, or waits for new candidate lists: cells do not wait for one
another, and nobody has to look at how far they have come before the end.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import vector
from stitchmesh.compute.thread_block import Parts, sum_over_block, wait_for_block
from stitchmesh.yarnrelax.energies.contact import contact_force_function
from stitchmesh.yarnrelax.energies.gather import gather_at
from stitchmesh.yarnrelax.energies.segment_forces import mean_direction_at, segment_force_function
from stitchmesh.yarnrelax.energies.term import Launcher
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.contact_samples import put_samples
from stitchmesh.yarnrelax.model.spline import segment_corners
from stitchmesh.yarnrelax.solvers.cell_strain import add_cell_virial, put_strain_force
from stitchmesh.yarnrelax.solvers.lbfgs_kernels import cells_of, strains_of
from stitchmesh.yarnrelax.solvers.lbfgs_steps import (
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
from stitchmesh.yarnrelax.solvers.preconditioner import preconditioner_at
from stitchmesh.yarnrelax.solvers.solver import SolverInputs

MOST_POINTS = 256
"""Control points of the largest cell that one multiprocessor works on faster than all of them do."""
FEWEST_THREADS, MOST_THREADS = 128, 512
"""Threads of a block on a GPU."""


@wp.func
def round_to_warps(count: int) -> int:
    """So many threads rounded up to warps."""
    return (count + 31) // 32 * 32


@wp.struct
class ThreadRole:
    """A thread among those of a block, and the segments of their cell.

    Where things can be done at once, the first threads begin with one, the last ones with another (``from_end``), and
    those before them with a third (``beside``). The last thread looks after the strains.
    """

    cell: wp.int32
    lane: wp.int32
    threads: wp.int32
    from_end: wp.int32
    beside: wp.int32
    first: wp.int32
    last: wp.int32


@wp.func
def thread_role(cells: Cells, cell: int, lane: int, threads: int) -> ThreadRole:
    """What a thread has to know of its block."""
    role = ThreadRole()
    role.cell = cell
    role.lane = lane
    role.threads = threads
    role.first = cells.segments[cell]
    role.last = cells.segments[cell + 1]
    role.from_end = threads - 1 - lane
    role.beside = (role.from_end + threads - round_to_warps(role.last - role.first) % threads) % threads
    return role


@wp.func
def point_range_in(cells: Cells, role: ThreadRole) -> PointRange:
    """The control points that a thread moves."""
    point_range = PointRange()
    point_range.cell = role.cell
    point_range.threads = role.threads
    point_range.first = cells.points[role.cell] + role.lane
    point_range.last = cells.points[role.cell + 1]
    return point_range


@functools.cache
def element_force_function(scalar: Any, quadrature_points: int, entries_at_once: int, cell_relaxes: bool) -> Any:
    """The function that finds what segments and samples of a cell exert, for one precision and one accuracy."""
    segment_forces_at = segment_force_function(quadrature_points, cell_relaxes)
    contact_force_at = contact_force_function(scalar, entries_at_once, cell_relaxes)
    ones = vector(3, scalar)

    @wp.func
    def find_element_forces(
        model: Any, role: ThreadRole, candidate_count: wp.array[wp.int32], candidates: wp.array2d[wp.int32], state: Any
    ) -> None:
        """Place the samples; then pushes, pulls and means side by side."""
        for s in range(role.first + role.lane, role.last, role.threads):
            q0, q1, q2, q3 = segment_corners(model, state.points, s)
            put_samples(model, s, q0, q1, q2, q3, state.samples)
        wait_for_block()
        for p in range(model.sample_start[role.first] + role.lane, model.sample_start[role.last], role.threads):
            contact_force_at(model, p, candidate_count, candidates, state)
        for s in range(role.first + role.from_end, role.last, role.threads):
            p0, p1, p2, p3 = segment_corners(model, state.points, s)
            terms = ones(type(p0[0])(1.0))
            segment_forces_at(model, s, terms, p0, p1, p2, p3, state)
        for s in range(role.first + role.beside, role.last, role.threads):
            r0, r1, r2, r3 = segment_corners(model, state.points, s)
            mean_direction_at(model, s, r0, r1, r2, r3, state)
        wait_for_block()

    return find_element_forces


@wp.func
def gather_and_precondition(
    model: Any, role: ThreadRole, point_range: PointRange, bounds: Any, point_stiffness: wp.array[Any], state: Any
) -> None:
    """Forces on a cell's control points, and side by side how they give way."""
    for i in range(point_range.first, point_range.last, point_range.threads):
        gather_at(model, i, point_stiffness, state)
    for i in range(point_range.first - role.lane + role.from_end, point_range.last, point_range.threads):
        preconditioner_at(model, i, bounds, state)
    wait_for_block()


@wp.func
def sum_cell_virial(model: Any, role: ThreadRole, entry: int, strains: Any, state: Any) -> None:
    """Force on a cell's strains."""
    part = add_cell_virial(
        Parts(), model, role.first, role.last, role.lane, role.threads, state.segment_virial, state.sample_virial
    )  # fmt: skip
    sum_over_block(part, strains.totals[role.cell])
    if role.from_end == 0:
        put_strain_force(role.cell, entry, strains, state)


@functools.cache
def burst(scalar: Any, quadrature_points: int, entries_at_once: int, cell_relaxes: bool) -> wp.Kernel:
    """The kernel for one precision and one accuracy, and for cells that relax or do not."""
    find_element_forces = element_force_function(scalar, quadrature_points, entries_at_once, cell_relaxes)

    @kernel(launch_bounds=MOST_THREADS)
    def burst(
        # model
        model: Any,
        cells: Cells,
        bounds: Any,
        point_stiffness: wp.array[Any],
        step_limit: Any,
        iterations: int,
        # state in
        candidate_count: wp.array[wp.int32],
        candidates: wp.array2d[wp.int32],
        # state in and out
        strains: Any,
        state: Any,
        memory: Any,
    ) -> None:
        """Iterate each cell until it waits; a block a cell."""
        cell, lane = wp.tid()
        role = thread_role(cells, cell, lane, wp.block_dim())
        point_range = point_range_in(cells, role)
        entry, numbers = cells.point_count + cell, memory.numbers[cell]
        for _iteration in range(iterations):
            find_element_forces(model, role, candidate_count, candidates, state)
            if wp.static(cell_relaxes):
                sum_cell_virial(model, role, entry, strains, state)
            gather_and_precondition(model, role, point_range, bounds, point_stiffness, state)
            products = force_products(point_range, state, memory)
            if wp.static(cell_relaxes):
                if role.from_end == 0:
                    products = add_strain_products(products, entry, trial_slot(numbers), state, memory)
            sum_over_block(products, memory.products[cell])
            if lane == 0:
                update_memory(cell, memory)
            wait_for_block()
            slots = direction_products(point_range, state, memory)
            if wp.static(cell_relaxes):
                if role.from_end == 0:
                    slots = add_direction_products(slots, entry, numbers, memory.alpha[cell], state, memory)
            sum_over_block(slots, memory.products[cell])
            if lane == 0:
                update_coefficients(cell, memory)
            wait_for_block()
            propose_point_moves(point_range, step_limit, state, memory)
            if wp.static(cell_relaxes):
                if role.from_end == 0:
                    propose_move(entry, step_limit, numbers, memory.alpha_minus_beta[cell], state, memory)
                    apply_move(entry, trial_slot(numbers), state, memory)
                wait_for_block()
            moved(point_range, cells, strains, state, memory)
            wait_for_block()
            if numbers[6] != wp.float64(0.0):
                break

    return burst


class FusedLaunch:
    """The launch of a burst."""

    def __init__(self, model: Model, memory: Any) -> None:
        """Threads for each contact sample and twice for each segment of the largest cell, within bounds."""
        self.memory, self.cells = memory, cells_of(model)
        self.threads = 1
        if model.device.is_cuda:
            largest = int(np.diff(model.segment_start).max())
            wanted = 32 * (-(-model.largest_cell // 32) + 2 * -(-largest // 32))
            self.threads = int(np.clip(wanted, FEWEST_THREADS, MOST_THREADS))

    def launch(
        self, scene: SolverInputs, bounds: Any, point_stiffness: wp.array[Any], iterations: int, launcher: Launcher
    ) -> Any:
        """All of so many iterations, forces included."""
        model = scene.model
        kernel = burst(
            model.scalar, model.quadrature_points, 4 if model.device.is_cuda else 1, scene.strain is not None
        )
        lists = [scene.candidates.count, scene.candidates.lists]
        inputs = [model.constants, self.cells, bounds, point_stiffness, model.number(scene.step_fraction), iterations,
                  *lists, strains_of(scene), scene.state.arrays, self.memory]  # fmt: skip
        return launcher(kernel, model.cell_count, inputs, [], tile=self.threads)


def suits_fusing(model: Model) -> bool:
    """Whether all cells are small."""
    return bool(np.diff(model.point_start).max() <= MOST_POINTS)
