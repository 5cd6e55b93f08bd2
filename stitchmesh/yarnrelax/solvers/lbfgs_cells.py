# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The quasistatic solver for cells on a lattice, whose periods may be unknowns like the control points.

The strains of a relaxing cell (``cell_strain``) are one more entry of its memory. The iteration is the one of
``lbfgs``. Its three launches that do something for a whole cell are others here: the first thread of a cell's block
adds the strains to the sums over the control points and moves them, and each control point then deforms with its cell.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3, Vec6, Vec19
from stitchmesh.compute.thread_block import THREADS, Products, Slots
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.solvers.cell_strain import (
    StrainArrays,
    deformed,
    put_strain_force,
    strains_of,
    sum_of_blocks,
)
from stitchmesh.yarnrelax.solvers.lbfgs import LBFGS, sum_direction_products, sum_force_products
from stitchmesh.yarnrelax.solvers.lbfgs_steps import (
    FORCE_FORCE,
    Blocks,
    CellRanges,
    LBFGSArrays,
    add_direction_products,
    add_force_products,
    apply_move,
    cell_ranges,
    point_range_of,
    propose_move,
    trial_slot,
    update_coefficients,
    update_memory,
)
from stitchmesh.yarnrelax.solvers.solver import SolverInputs


@wp.func
def add_strain_products(
    total: Vec19, entry: int, trial: int, points: wp.array[Vec3], listed_points: wp.array[Vec3],
    budget: wp.array[Scalar], force: wp.array[Vec3], preconditioner: wp.array[Vec6], memory: LBFGSArrays
) -> Any:  # fmt: skip
    """Add the strains of a cell; the gradient of L eq 5 does not contain them."""
    square = total[FORCE_FORCE]
    whole = add_force_products(total, entry, trial, points, listed_points, budget, force, preconditioner, memory)
    whole[FORCE_FORCE] = square
    return whole


@kernel(tile=THREADS)
def update_memories_of_cells(
    # model
    blocks: Blocks,
    cells: CellRanges,
    # state in
    sums: wp.array2d[wp.float64],
    points: wp.array[Vec3],
    listed_points: wp.array[Vec3],
    budget: wp.array[Scalar],
    # state in and out
    strains: StrainArrays,
    memory: LBFGSArrays,
    # state out, of the strains
    force: wp.array[Vec3],
    stiffness: wp.array[Scalar],
    preconditioner: wp.array[Vec6],
) -> None:
    """Find the forces on strains, take the newest pair into each memory, and find a_j; one block for each cell."""
    cell, lane = wp.tid()
    if strains.count > 0:
        sum_of_blocks(strains.parts[cell], lane, wp.block_dim(), strains.totals[cell])
    sum_force_products(cell, lane, wp.block_dim(), blocks, sums, memory)
    if lane == 0:
        if strains.count > 0:
            entry = cells.point_count + cell
            put_strain_force(cell, entry, strains, force, stiffness, preconditioner)
            trial = trial_slot(memory.record[cell])
            own = add_strain_products(
                Products(), entry, trial, points, listed_points, budget, force, preconditioner, memory
            )
            for k in range(19):
                memory.products[cell, k] += own[k]
        update_memory(cell, memory)


@kernel(tile=THREADS)
def update_directions_of_cells(
    # model
    blocks: Blocks,
    cells: CellRanges,
    step_limit: Scalar,
    # state in
    sums: wp.array2d[wp.float64],
    strains: StrainArrays,
    listed_points: wp.array[Vec3],
    budget: wp.array[Scalar],
    force: wp.array[Vec3],
    preconditioner: wp.array[Vec6],
    stiffness: wp.array[Scalar],
    # state in and out
    memory: LBFGSArrays,
    points: wp.array[Vec3],
) -> None:
    """Find a_j - b_j of each cell, and move its strains; one block for each cell."""
    cell, lane = wp.tid()
    sum_direction_products(cell, lane, wp.block_dim(), blocks, sums, memory)
    if lane == 0:
        entry, record = cells.point_count + cell, memory.record[cell]
        if strains.count > 0:
            own = add_direction_products(
                Slots(), entry, record, memory.alpha[cell], force, preconditioner, stiffness, memory
            )
            for k in range(7):
                memory.products[cell, k] += own[k]
        update_coefficients(cell, memory)
        if strains.count > 0:
            coefficient = memory.alpha_minus_beta[cell]
            propose_move(entry, step_limit, record, coefficient, points, listed_points, budget, memory)
            apply_move(entry, trial_slot(record), points, memory)


@wp.func
def move_point(
    i: int, trial: int, cell: int, cells: CellRanges, strains: StrainArrays, points: wp.array[Vec3],
    listed_points: wp.array[Vec3], memory: LBFGSArrays
) -> None:  # fmt: skip
    """Move a control point, and deform it and its listed place as the strains of its cell changed.

    The first control points of a cell also deform what stands once for each segment and for each period of the cell.
    """
    apply_move(i, trial, points, memory)
    if strains.count > 0:
        e1, e2 = strains.frame[2 * cell], strains.frame[2 * cell + 1]
        more = memory.step[cells.point_count + cell] * strains.per_unit
        points[i] = deformed(points[i], e1, e2, more)
        listed_points[i] = deformed(listed_points[i], e1, e2, more)
        # a cell has no more segments than control points
        number = i - cells.points[cell]
        s = cells.segments[cell] + number
        if s < cells.segments[cell + 1]:
            strains.listed_centre[s] = deformed(strains.listed_centre[s], e1, e2, more)
        if number < 2:
            strains.periods[2 * cell + number] = deformed(strains.periods[2 * cell + number], e1, e2, more)


@kernel(tile=THREADS)
def move_points_of_cells(
    # model
    blocks: Blocks,
    cells: CellRanges,
    # state in and out
    strains: StrainArrays,
    memory: LBFGSArrays,
    points: wp.array[Vec3],
    listed_points: wp.array[Vec3],
) -> None:
    """Move the control points, store the moves in the slot of the pair on trial, and deform cells."""
    block, lane = wp.tid()
    point_range = point_range_of(blocks, block, lane, wp.block_dim())
    trial = trial_slot(memory.record[point_range.cell])
    for i in range(point_range.first, point_range.last, point_range.threads):
        move_point(i, trial, point_range.cell, cells, strains, points, listed_points, memory)


class CellLBFGS(LBFGS):
    """Limited-memory quasi-Newton steps of cells on a lattice, which may relax."""

    def __init__(self, model: Model, further: NDArray[np.float64], strains: int = 0) -> None:
        """Allocate the memory, with the arguments of ``LBFGS``."""
        super().__init__(model, further, strains)
        self.cells = cell_ranges(model)

    def memory_launches(self, inputs: SolverInputs, launcher: Launcher) -> list[Any]:
        """Return the launches that find the forces on strains, and take the newest pair of each cell."""
        state = inputs.state
        update = self.of_cells(
            update_memories_of_cells, self.cells, self.sums, state.points, state.listed_points, state.budget,
            strains_of(inputs.model, inputs.strain, inputs.candidates), self.memory, state.force, state.stiffness,
            state.preconditioner, by=launcher,
        )  # fmt: skip
        return [update] if inputs.strain is None else [inputs.strain.gather_launch(state, launcher), update]

    def direction_launch(self, inputs: SolverInputs, launcher: Launcher) -> Any:
        """Return the launch that finds the parts of the pairs in the next move, and moves the strains."""
        state = inputs.state
        return self.of_cells(
            update_directions_of_cells, self.cells, inputs.model.number(inputs.step_fraction), self.sums,
            strains_of(inputs.model, inputs.strain, inputs.candidates), state.listed_points, state.budget, state.force,
            state.preconditioner, state.stiffness, self.memory, state.points, by=launcher,
        )  # fmt: skip

    def move_launch(self, inputs: SolverInputs, launcher: Launcher) -> Any:
        """Return the launch that moves the control points and deforms the cells."""
        state, strains = inputs.state, strains_of(inputs.model, inputs.strain, inputs.candidates)
        return self.of_blocks(
            move_points_of_cells, self.cells, strains, self.memory, state.points, state.listed_points, by=launcher
        )
