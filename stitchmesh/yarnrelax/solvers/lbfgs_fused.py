# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Many iterations of small cells in one launch: a block of threads for each cell, with barriers between the steps.

A launch costs more than the work of a small iteration, and in a batch of small cells each cell has its own
multiprocessor. A block iterates until its cell has done all iterations or waits for new candidate lists. Cells do not
wait for each other, and the host reads their progress only at the end.

The kernel takes ``state`` and ``memory`` as in and out, because it runs all steps of an iteration. The signatures of
the kernels in ``evaluation``, ``segment_forces``, ``contact``, ``preconditioner`` and ``lbfgs`` show which step reads
and writes which array. The loops over the control points of one step also stand here, with ``state`` as argument. A
function with such a loop that receives single arrays would need more instructions for their indices, which makes an
iteration of a small cell up to 3 % slower (H200).
"""

from __future__ import annotations

import functools
from itertools import product
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import kernel_factory
from stitchmesh.compute.precision import Scalar, ScalarType, vector
from stitchmesh.compute.thread_block import Products, Slots, VirialSums, sum_over_block, wait_for_block
from stitchmesh.yarnrelax.energies.contact import contact_force_function
from stitchmesh.yarnrelax.energies.evaluation import gather_at
from stitchmesh.yarnrelax.energies.segment_forces import mean_direction_at, segment_force_function
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants, entries_at_once
from stitchmesh.yarnrelax.model.spline import put_samples, segment_corners
from stitchmesh.yarnrelax.model.state import StateArrays
from stitchmesh.yarnrelax.solvers.cell_strain import StrainArrays, add_cell_virial, put_strain_force, strains_of
from stitchmesh.yarnrelax.solvers.lbfgs_cells import CellLBFGS, add_strain_products, move_point
from stitchmesh.yarnrelax.solvers.lbfgs_steps import (
    WAITING,
    CellRanges,
    LBFGSArrays,
    PointRange,
    add_direction_products,
    add_force_products,
    apply_move,
    propose_move,
    trial_slot,
    update_coefficients,
    update_memory,
)
from stitchmesh.yarnrelax.solvers.preconditioner import BoundArrays, preconditioner_at
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL, SolverInputs

MOST_POINTS = 256
"""Control points of the largest cell that one multiprocessor iterates faster than the whole GPU."""
CELL_THREADS = (128, 256, 384, 512)
"""Threads of a block on a GPU. The kernel is compiled for each number, because blocks of fewer threads may have more
registers for each thread: with 512 threads 128, of which a relaxing cell needs 174. The numbers are few."""


@wp.func
def round_to_warps(count: int) -> int:
    """A number of threads rounded up to whole warps."""
    return (count + 31) // 32 * 32


@wp.struct
class ThreadRole:
    """A thread of a block, and the segments of the block's cell.

    Where three loops can run at the same time, the first starts with the first threads (``lane``), the second with the
    last threads (``reversed_lane``), and the third with the threads before those (``offset_lane``). The last thread
    handles the strains.
    """

    cell: wp.int32
    lane: wp.int32
    threads: wp.int32
    reversed_lane: wp.int32
    offset_lane: wp.int32
    first: wp.int32
    last: wp.int32


@wp.func
def thread_role(cells: CellRanges, cell: int, lane: int, threads: int) -> ThreadRole:
    """The role of a thread of a block."""
    role = ThreadRole()
    role.cell = cell
    role.lane = lane
    role.threads = threads
    role.first = cells.segments[cell]
    role.last = cells.segments[cell + 1]
    role.reversed_lane = threads - 1 - lane
    role.offset_lane = (role.reversed_lane + threads - round_to_warps(role.last - role.first) % threads) % threads
    return role


@wp.func
def point_range_in(cells: CellRanges, role: ThreadRole) -> PointRange:
    """The control points that a thread moves."""
    point_range = PointRange()
    point_range.cell = role.cell
    point_range.threads = role.threads
    point_range.first = cells.points[role.cell] + role.lane
    point_range.last = cells.points[role.cell + 1]
    return point_range


@functools.cache
def element_force_function(scalar: ScalarType, quadrature_points: int, entries_at_once: int, cell_relaxes: bool) -> Any:
    """Return the function that finds the forces of segments and samples of a cell, for one precision and accuracy."""
    segment_forces_at = segment_force_function(quadrature_points, cell_relaxes)
    contact_force_at = contact_force_function(scalar, entries_at_once, cell_relaxes)
    ones = vector(3, scalar)

    @wp.func
    def find_element_forces(
        model: YarnConstants, role: ThreadRole, candidate_count: wp.array[wp.int32],
        candidates: wp.array2d[wp.int32], state: StateArrays
    ) -> None:  # fmt: skip
        """Place the samples; then contact forces, leg forces and means at the same time."""
        for s in range(role.first + role.lane, role.last, role.threads):
            q0, q1, q2, q3 = segment_corners(model, state.points, s)
            put_samples(model, s, q0, q1, q2, q3, state.samples)
        wait_for_block()
        for p in range(model.sample_start[role.first] + role.lane, model.sample_start[role.last], role.threads):
            contact_force_at(
                model, p, candidate_count, candidates, state.samples, state.sample_force, state.sample_block,
                state.sample_virial,
            )  # fmt: skip
        for s in range(role.first + role.reversed_lane, role.last, role.threads):
            p0, p1, p2, p3 = segment_corners(model, state.points, s)
            terms = ones(type(p0[0])(1.0))
            segment_forces_at(model, s, terms, p0, p1, p2, p3, state.leg_force, state.segment_virial)
        for s in range(role.first + role.offset_lane, role.last, role.threads):
            r0, r1, r2, r3 = segment_corners(model, state.points, s)
            mean_direction_at(model, s, r0, r1, r2, r3, state.segment_block)
        wait_for_block()

    return find_element_forces


@wp.func
def gather_and_precondition(
    model: YarnConstants, role: ThreadRole, point_range: PointRange, bounds: Any, point_stiffness: wp.array[Scalar],
    state: StateArrays
) -> None:  # fmt: skip
    """Forces on a cell's control points, and at the same time their preconditioners."""
    for i in range(point_range.first, point_range.last, point_range.threads):
        gather_at(
            model, i, point_stiffness, state.leg_force, state.sample_force, state.external_force, state.force,
            state.stiffness,
        )  # fmt: skip
    for i in range(point_range.first - role.lane + role.reversed_lane, point_range.last, point_range.threads):
        preconditioner_at(model, i, bounds, state.segment_block, state.sample_block, state.preconditioner)
    wait_for_block()


@wp.func
def sum_cell_virial(
    model: YarnConstants, role: ThreadRole, entry: int, strains: StrainArrays, state: StateArrays
) -> None:
    """Force on a cell's strains."""
    part = add_cell_virial(
        VirialSums(), model, role.first, role.last, role.lane, role.threads, state.segment_virial, state.sample_virial
    )  # fmt: skip
    sum_over_block(part, strains.totals[role.cell])
    if role.reversed_lane == 0:
        put_strain_force(role.cell, entry, strains, state.force, state.stiffness, state.preconditioner)


@wp.func
def force_products(point_range: PointRange, state: StateArrays, memory: LBFGSArrays) -> Products:
    """Products over the control points of a thread."""
    total, trial = Products(), trial_slot(memory.record[point_range.cell])
    for i in range(point_range.first, point_range.last, point_range.threads):
        total = add_force_products(
            total, i, trial, state.points, state.listed_points, state.budget, state.force, state.preconditioner, memory
        )
    return total


@wp.func
def direction_products(point_range: PointRange, state: StateArrays, memory: LBFGSArrays) -> Slots:
    """Z of the control points of a thread, and its products."""
    total, record, alpha = Slots(), memory.record[point_range.cell], memory.alpha[point_range.cell]
    for i in range(point_range.first, point_range.last, point_range.threads):
        total = add_direction_products(
            total, i, record, alpha, state.force, state.preconditioner, state.stiffness, memory
        )  # fmt: skip
    return total


@wp.func
def propose_point_moves(point_range: PointRange, step_limit: Scalar, state: StateArrays, memory: LBFGSArrays) -> None:
    """Propose moves of the control points of a thread."""
    record, coefficient = memory.record[point_range.cell], memory.alpha_minus_beta[point_range.cell]
    for i in range(point_range.first, point_range.last, point_range.threads):
        propose_move(i, step_limit, record, coefficient, state.points, state.listed_points, state.budget, memory)


@wp.func
def move_points(
    point_range: PointRange, cells: CellRanges, strains: StrainArrays, state: StateArrays, memory: LBFGSArrays
) -> None:
    """Move the control points of a thread."""
    trial = trial_slot(memory.record[point_range.cell])
    for i in range(point_range.first, point_range.last, point_range.threads):
        move_point(i, trial, point_range.cell, cells, strains, state.points, state.listed_points, memory)


@kernel_factory(
    lambda form: product(
        [form.scalar], form.quadratures, [entries_at_once(on_gpu=form.on_gpu)], form.relaxing,
        CELL_THREADS if form.on_gpu else CELL_THREADS[:1],
    )
)  # fmt: skip
def fused_iterations(
    scalar: ScalarType, quadrature_points: int, entries_at_once: int, cell_relaxes: bool, threads: int
) -> wp.Kernel:
    """Return the kernel for one precision, one accuracy and one size of a block, for cells that relax or do not."""
    find_element_forces = element_force_function(scalar, quadrature_points, entries_at_once, cell_relaxes)

    @kernel(tile=threads, launch_bounds=threads)
    def fused_iterations(
        # model
        model: YarnConstants,
        cells: CellRanges,
        bounds: BoundArrays,
        point_stiffness: wp.array[Scalar],
        step_limit: Scalar,
        iterations: int,
        # state in
        candidate_count: wp.array[wp.int32],
        candidates: wp.array2d[wp.int32],
        # state in and out
        strains: StrainArrays,
        state: StateArrays,
        memory: LBFGSArrays,
    ) -> None:
        """Iterate each cell until it waits; one block for each cell."""
        cell, lane = wp.tid()
        role = thread_role(cells, cell, lane, wp.block_dim())
        point_range = point_range_in(cells, role)
        entry, record = cells.point_count + cell, memory.record[cell]
        for _iteration in range(iterations):
            find_element_forces(model, role, candidate_count, candidates, state)
            if wp.static(cell_relaxes):
                sum_cell_virial(model, role, entry, strains, state)
            gather_and_precondition(model, role, point_range, bounds, point_stiffness, state)
            products = force_products(point_range, state, memory)
            if wp.static(cell_relaxes):
                if role.reversed_lane == 0:
                    products = add_strain_products(
                        products, entry, trial_slot(record), state.points, state.listed_points, state.budget,
                        state.force, state.preconditioner, memory,
                    )  # fmt: skip
            sum_over_block(products, memory.products[cell])
            if lane == 0:
                update_memory(cell, memory)
            wait_for_block()
            slots = direction_products(point_range, state, memory)
            if wp.static(cell_relaxes):
                if role.reversed_lane == 0:
                    slots = add_direction_products(
                        slots, entry, record, memory.alpha[cell], state.force, state.preconditioner, state.stiffness,
                        memory,
                    )  # fmt: skip
            sum_over_block(slots, memory.products[cell])
            if lane == 0:
                update_coefficients(cell, memory)
            wait_for_block()
            propose_point_moves(point_range, step_limit, state, memory)
            if wp.static(cell_relaxes):
                if role.reversed_lane == 0:
                    propose_move(
                        entry, step_limit, record, memory.alpha_minus_beta[cell], state.points, state.listed_points,
                        state.budget, memory,
                    )  # fmt: skip
                    apply_move(entry, trial_slot(record), state.points, memory)
                wait_for_block()
            move_points(point_range, cells, strains, state, memory)
            wait_for_block()
            if record[WAITING] != wp.float64(0.0):
                break

    return fused_iterations


class FusedLBFGS(CellLBFGS):
    """Limited-memory quasi-Newton steps of small cells: one launch for all iterations of an assessment interval."""

    def __init__(self, model: Model, further: NDArray[np.float64], strains: int = 0) -> None:
        """Choose the threads that suit the cell that needs most of them."""
        super().__init__(model, further, strains)
        samples, segments = np.diff(model.sample_start[model.segment_start]), np.diff(model.segment_start)
        each = zip(samples.tolist(), segments.tolist(), strict=True)
        suitable = (threads_of_cell(*counts) for counts in each)
        self.threads_of_cell = max(suitable) if model.device.is_cuda else CELL_THREADS[0]

    def fused_launch(self, inputs: SolverInputs, point_stiffness: wp.array[Any], launcher: Launcher) -> Any:
        """Return one launch of all iterations of an assessment interval, with their forces."""
        model, candidates = inputs.model, inputs.candidates
        kernel = fused_iterations(
            model.scalar, model.quadrature_points, model.entries_at_once, inputs.strain is not None,
            self.threads_of_cell,
        )  # fmt: skip
        arguments = [model.constants, self.cells, self.bounds, point_stiffness, model.number(inputs.step_fraction),
                     int(ASSESSMENT_INTERVAL), candidates.count, candidates.lists,
                     strains_of(model, inputs.strain, candidates), inputs.state.arrays, self.memory]  # fmt: skip
        return launcher(kernel, model.cell_count, arguments, [])


def threads_of_cell(samples: int, segments: int) -> int:
    """Return the number of threads for a cell: one for each sample and two for each segment, within bounds."""
    wanted = 32 * (-(-samples // 32) + 2 * -(-segments // 32))
    return next((block for block in CELL_THREADS if block >= wanted), CELL_THREADS[-1])


def suits_fusing(model: Model) -> bool:
    """Whether all cells are small enough for a fused launch."""
    return bool(np.diff(model.point_start).max() <= MOST_POINTS)
