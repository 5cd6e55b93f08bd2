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
from stitchmesh.yarnrelax.energies.contact import pushing
from stitchmesh.yarnrelax.energies.gather import gather_at
from stitchmesh.yarnrelax.energies.segment_forces import mean_at, pulling
from stitchmesh.yarnrelax.energies.term import Run
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.contact_samples import put_samples
from stitchmesh.yarnrelax.model.spline import segment_corners
from stitchmesh.yarnrelax.solvers.cell_strain import put_strain_force, with_strain_shares
from stitchmesh.yarnrelax.solvers.lbfgs_kernels import cells_of, strains_of
from stitchmesh.yarnrelax.solvers.lbfgs_steps import (
    Cells,
    Share,
    compared,
    judge,
    moved,
    preconditioned,
    propose,
    proposed,
    recollect,
    slot_on_trial,
    take,
    with_rise,
    with_strain_products,
)
from stitchmesh.yarnrelax.solvers.preconditioner import compliance_at
from stitchmesh.yarnrelax.solvers.solver import Scene

MOST_POINTS = 256
"""Control points of the largest cell that one multiprocessor works on faster than all of them do."""
FEWEST_THREADS, MOST_THREADS = 128, 512
"""Threads of a block on a GPU."""


@wp.func
def in_warps(count: int) -> int:
    """So many threads rounded up to warps."""
    return (count + 31) // 32 * 32


@wp.struct
class Crew:
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
def crew_of(cells: Cells, cell: int, lane: int, threads: int) -> Crew:
    """What a thread has to know of its block."""
    crew = Crew()
    crew.cell = cell
    crew.lane = lane
    crew.threads = threads
    crew.first = cells.segments[cell]
    crew.last = cells.segments[cell + 1]
    crew.from_end = threads - 1 - lane
    crew.beside = (crew.from_end + threads - in_warps(crew.last - crew.first) % threads) % threads
    return crew


@wp.func
def share_in(cells: Cells, crew: Crew) -> Share:
    """The control points that a thread moves."""
    share = Share()
    share.cell = crew.cell
    share.threads = crew.threads
    share.first = cells.points[crew.cell] + crew.lane
    share.last = cells.points[crew.cell + 1]
    return share


@functools.cache
def exerting(scalar: Any, quadrature_points: int, together: int, strained: bool) -> Any:
    """The function that finds what segments and samples of a cell exert, for one precision and one accuracy."""
    pull_at = pulling(quadrature_points, strained)
    push_at = pushing(scalar, together, strained)
    ones = vector(3, scalar)

    @wp.func
    def exert(
        model: Any, crew: Crew, candidate_count: wp.array[wp.int32], candidates: wp.array2d[wp.int32], state: Any
    ) -> None:
        """Place the samples; then pushes, pulls and means side by side."""
        for s in range(crew.first + crew.lane, crew.last, crew.threads):
            q0, q1, q2, q3 = segment_corners(model, state.points, s)
            put_samples(model, s, q0, q1, q2, q3, state.samples)
        wait_for_block()
        for p in range(model.sample_start[crew.first] + crew.lane, model.sample_start[crew.last], crew.threads):
            push_at(model, p, candidate_count, candidates, state)
        for s in range(crew.first + crew.from_end, crew.last, crew.threads):
            p0, p1, p2, p3 = segment_corners(model, state.points, s)
            terms = ones(type(p0[0])(1.0))
            pull_at(model, s, terms, p0, p1, p2, p3, state)
        for s in range(crew.first + crew.beside, crew.last, crew.threads):
            r0, r1, r2, r3 = segment_corners(model, state.points, s)
            mean_at(model, s, r0, r1, r2, r3, state)
        wait_for_block()

    return exert


@wp.func
def gather_and_give(
    model: Any, crew: Crew, share: Share, bounds: Any, point_stiffness: wp.array[Any], state: Any
) -> None:
    """Forces on a cell's control points, and side by side how they give way."""
    for i in range(share.first, share.last, share.threads):
        gather_at(model, i, point_stiffness, state)
    for i in range(share.first - crew.lane + crew.from_end, share.last, share.threads):
        compliance_at(model, i, bounds, state)
    wait_for_block()


@wp.func
def sum_strains(model: Any, crew: Crew, entry: int, strains: Any, state: Any) -> None:
    """Force on a cell's strains."""
    part = with_strain_shares(
        Parts(), model, crew.first, crew.last, crew.lane, crew.threads, state.segment_strain, state.sample_strain
    )  # fmt: skip
    sum_over_block(part, strains.totals[crew.cell])
    if crew.from_end == 0:
        put_strain_force(crew.cell, entry, strains, state)


@functools.cache
def burst(scalar: Any, quadrature_points: int, together: int, strained: bool) -> wp.Kernel:
    """The kernel for one precision and one accuracy, and for cells that relax or do not."""
    exert = exerting(scalar, quadrature_points, together, strained)

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
        crew = crew_of(cells, cell, lane, wp.block_dim())
        share = share_in(cells, crew)
        entry, numbers = cells.point_count + cell, memory.numbers[cell]
        for _iteration in range(iterations):
            exert(model, crew, candidate_count, candidates, state)
            if wp.static(strained):
                sum_strains(model, crew, entry, strains, state)
            gather_and_give(model, crew, share, bounds, point_stiffness, state)
            products = compared(share, state, memory)
            if wp.static(strained):
                if crew.from_end == 0:
                    products = with_strain_products(products, entry, slot_on_trial(numbers), state, memory)
            sum_over_block(products, memory.products[cell])
            if lane == 0:
                judge(cell, memory)
            wait_for_block()
            slots = preconditioned(share, state, memory)
            if wp.static(strained):
                if crew.from_end == 0:
                    slots = with_rise(slots, entry, numbers, memory.fall[cell], state, memory)
            sum_over_block(slots, memory.products[cell])
            if lane == 0:
                recollect(cell, memory)
            wait_for_block()
            proposed(share, step_limit, state, memory)
            if wp.static(strained):
                if crew.from_end == 0:
                    propose(entry, step_limit, numbers, memory.rise[cell], state, memory)
                    take(entry, slot_on_trial(numbers), state, memory)
                wait_for_block()
            moved(share, cells, strains, state, memory)
            wait_for_block()
            if numbers[6] != wp.float64(0.0):
                break

    return burst


class BurstLaunches:
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
        self, scene: Scene, bounds: Any, point_stiffness: wp.array[Any], iterations: int, run: Run
    ) -> Any:
        """All of so many iterations, forces included."""
        model = scene.model
        kernel = burst(
            model.scalar, model.quadrature_points, 4 if model.device.is_cuda else 1, scene.strain is not None
        )
        lists = [scene.candidates.count, scene.candidates.lists]
        inputs = [model.constants, self.cells, bounds, point_stiffness, model.number(scene.step_fraction), iterations,
                  *lists, strains_of(scene), scene.state.arrays, self.memory]  # fmt: skip
        return run(kernel, model.cell_count, inputs, [], tile=self.threads)


def suits_burst(model: Model) -> bool:
    """Whether all cells are small."""
    return bool(np.diff(model.point_start).max() <= MOST_POINTS)
