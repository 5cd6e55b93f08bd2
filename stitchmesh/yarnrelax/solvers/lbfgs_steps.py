# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The algebra of the quasistatic solver (``lbfgs``), step by step, for one entry or one cell.

An entry is a control point, or the strains of a cell (``lbfgs_cells``). The values of a cell are in its row of the
arrays of the memory. A scene of one piece is one cell.

An iteration has these steps, with sums over the cell between them: ``add_force_products`` for each control point,
``update_memory`` by one thread, ``add_direction_products`` for each control point, ``update_coefficients`` by one
thread, ``propose_move`` and ``apply_move`` for each control point.
"""

from __future__ import annotations

import functools
from typing import Any, TypeAlias

import numpy as np
import warp as wp

from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.precision import Scalar, ScalarType, Vec3, Vec6, Vec7, Vec19, vector
from stitchmesh.compute.thread_block import THREADS
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import USED_UP, room_left, shortened
from stitchmesh.yarnrelax.solvers.preconditioner import times_block
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

# Loops over these numbers have literal bounds below: Warp unrolls a loop only where its bound is a literal.
SLOTS = wp.constant(7)
"""Number of slots for pairs: six pairs are kept, and the oldest one stays valid while the newest one is on trial."""
SMOOTHING = wp.constant(4)
"""Number of plain iterations at the end of each assessment interval."""
PLAIN_STEP = wp.constant(1.6)
"""Plain move over force / row sum of stiffness; moves are stable below 2."""
LEAST_SCALE, LARGEST_SCALE = wp.constant(wp.float64(0.05)), wp.constant(wp.float64(4.0))
"""Bounds of the scale g of the preconditioner."""
SOUND = wp.constant(wp.float64(1.0e-8))
"""A pair enters the memory if the cosine between the move and its change of the gradient is at least this."""

NEWEST_SLOT, PAIRS, ITERATION, PLAIN, STEP_SCALE, PRECONDITIONER_SCALE, WAITING, WANTED = range(8)
"""Columns of ``LBFGSMemory.record``: slot of the newest pair; number of pairs; iterations done since the last
assessment; 1 if the last move was a plain one; scale of moves; g; 1 if the cell waits for new candidate lists or for
the assessment; iterations wanted until the assessment."""
USED_UP_COUNT, MOST_USED_UP = 8, 9
"""Columns of ``LBFGSMemory.record``: number of control points that have used up their budget, and the number with which
the cell still continues."""
FIRST_GRADIENT, LAST_GRADIENT, GRADIENTS, TENTH = range(10, 14)
"""Columns of ``LBFGSMemory.record``: norm of the first and of the last force; number of forces so far; iteration at
which the norm had first fallen to a tenth (L eq 5)."""
RECORD = 14
"""Number of columns of ``LBFGSMemory.record``."""

MOVE_FORCE, MOVE_CHANGE = wp.constant(0), wp.constant(7)
"""First of the products of the force, and of the newest change of the gradient, with the move of each slot."""
CHANGE_CHANGE_SCALED, MOVE_MOVE, CHANGE_CHANGE = wp.constant(14), wp.constant(15), wp.constant(16)
"""Products of the newest pair: y . C y, s . s and y . y."""
USED_UP_POINTS, FORCE_FORCE = wp.constant(17), wp.constant(18)
"""Number of control points that have used up their budget; square of the force."""
PRODUCTS = 19
"""Number of columns of ``LBFGSMemory.products``."""

Ages = wp.types.vector(length=6, dtype=wp.float64)
Table = wp.types.matrix(shape=(6, 6), dtype=wp.float64)


LBFGSArrays: TypeAlias = Any
"""The struct of the memory of L-BFGS (``make_memory``), in either precision."""

CHUNK = {"cuda": THREADS, "cpu": 1024}
"""Largest number of control points of a block of threads, which takes a part of the points of one cell."""


@wp.struct
class CellRanges:
    """Which entries and segments belong to each cell."""

    point_count: wp.int32
    points: wp.array[wp.int32]
    segments: wp.array[wp.int32]


@wp.struct
class PointRange:
    """The control points of a cell that one thread handles: every ``threads``-th from ``first`` on."""

    cell: wp.int32
    first: wp.int32
    last: wp.int32
    threads: wp.int32


@wp.func
def slot_before(newest: int, age: int) -> int:
    """The slot that was filled ``age`` pairs before the newest one."""
    return (newest - age + 7) % 7


@wp.func
def trial_slot(record: wp.array[wp.float64]) -> int:
    """The slot of the pair on trial, which may enter the memory or not."""
    return (int(record[NEWEST_SLOT]) + 1) % 7


@wp.func
def add_force_products(
    total: Vec19, i: int, trial: int, points: wp.array[Vec3], listed_points: wp.array[Vec3], budget: wp.array[Scalar],
    force: wp.array[Vec3], preconditioner: wp.array[Vec6], memory: LBFGSArrays
) -> Any:  # fmt: skip
    """Store the change of the gradient of an entry over the last move, and add the entry to all products."""
    now = force[i]
    change = memory.last_force[i] - now
    memory.last_force[i] = now
    memory.gradient_change[trial, i] = change
    for j in range(SLOTS):
        moved = memory.moves[j, i]
        total[j] += wp.float64(wp.dot(moved, now))
        total[j + MOVE_CHANGE] += wp.float64(wp.dot(moved, change))
    move = memory.moves[trial, i]
    total[CHANGE_CHANGE_SCALED] += wp.float64(wp.dot(change, times_block(preconditioner[i], change)))
    total[MOVE_MOVE] += wp.float64(wp.dot(move, move))
    total[CHANGE_CHANGE] += wp.float64(wp.dot(change, change))
    if room_left(points, listed_points, budget, i) < budget[i] * type(now[0])(1.0 - USED_UP):
        total[USED_UP_POINTS] += wp.float64(1.0)
    total[FORCE_FORCE] += wp.float64(wp.dot(now, now))
    return total


@wp.func
def update_memory(cell: int, memory: LBFGSArrays) -> None:
    """With the sums over a cell, take its newest pair into the memory and find the numbers a_j."""
    products, record = memory.products[cell], memory.record[cell]
    accept_pair(products, record, memory.curvature[cell], memory.alpha[cell])
    note_gradient(products[FORCE_FORCE], record)


@wp.func
def curvature_by_age(curvature: wp.array2d[wp.float64], newest: int, count: int) -> Table:  # type: ignore[valid-type]
    """Products s_older . y_newer of the pairs, rows and columns by age.

    The diagonal is 1 / s . y, and 0 where there is no pair. Everything is read before anything depends on it: one wait
    for memory instead of dozens.
    """
    table = Table()
    for older in range(6):
        for newer in range(6):
            if newer <= older:
                table[older, newer] = curvature[slot_before(newest, older), slot_before(newest, newer)]
    for age in range(6):
        table[age, age] = wp.where(age < count, wp.float64(1.0) / table[age, age], wp.float64(0.0))
    return table


@wp.func
def accept_pair(
    product: wp.array[wp.float64], record: wp.array[wp.float64], curvature: wp.array2d[wp.float64],
    alpha: wp.array[wp.float64]
) -> None:  # fmt: skip
    """Take a cell's newest pair into the memory if it is sound, and find the numbers a_j."""
    zero = wp.float64(0.0)
    trial = trial_slot(record)
    for j in range(7):
        curvature[j, trial] = product[7 + j]
    bend = product[MOVE_CHANGE + trial]
    sound = bend > SOUND * wp.sqrt(product[MOVE_MOVE] * product[CHANGE_CHANGE]) and record[PLAIN] == zero
    if sound:
        record[NEWEST_SLOT] = wp.float64(trial)
        record[PAIRS] = wp.min(record[PAIRS] + wp.float64(1.0), wp.float64(6.0))
        record[PRECONDITIONER_SCALE] = wp.clamp(bend / product[CHANGE_CHANGE_SCALED], LEAST_SCALE, LARGEST_SCALE)
    record[USED_UP_COUNT] = product[USED_UP_POINTS]
    waits = product[USED_UP_POINTS] > record[MOST_USED_UP] or record[ITERATION] >= record[WANTED]
    record[WAITING] = wp.where(waits, wp.float64(1.0), zero)
    turn = int(record[ITERATION]) % ASSESSMENT_INTERVAL
    record[ITERATION] = record[ITERATION] + wp.float64(1.0) - record[WAITING]
    plain = turn >= ASSESSMENT_INTERVAL - SMOOTHING
    record[PLAIN] = wp.where(plain, wp.float64(1.0), zero)
    newest, count = int(record[NEWEST_SLOT]), wp.where(plain, 0, int(record[PAIRS]))
    table = curvature_by_age(curvature, newest, count)
    along, part = Ages(), Ages()
    for age in range(6):
        along[age] = product[slot_before(newest, age)]
    for age in range(6):
        value = along[age]
        for newer in range(6):
            if newer < age:
                value -= part[newer] * table[age, newer]
        part[age] = value * table[age, age]
    for age in range(6):
        alpha[slot_before(newest, age)] = part[age]
    # the seventh slot holds no pair of the memory
    alpha[slot_before(newest, 6)] = zero


@wp.func
def note_gradient(square: wp.float64, record: wp.array[wp.float64]) -> None:
    """Note the gradient of a cell that moves, and the iteration at which the first line of L eq 5 first holds."""
    zero = wp.float64(0.0)
    if record[WAITING] != zero:
        return
    norm = wp.sqrt(square)
    if record[GRADIENTS] == zero:
        record[FIRST_GRADIENT] = norm
    elif record[TENTH] == zero and norm <= wp.float64(0.1) * record[FIRST_GRADIENT]:
        record[TENTH] = record[GRADIENTS]
    record[LAST_GRADIENT] = norm
    record[GRADIENTS] = record[GRADIENTS] + wp.float64(1.0)


@wp.func
def add_direction_products(
    total: Vec7, i: int, record: wp.array[wp.float64], alpha: Any, force: wp.array[Vec3],
    preconditioner: wp.array[Vec6], stiffness: wp.array[Scalar], memory: LBFGSArrays
) -> Any:  # fmt: skip
    """Leave z of an entry in the memory's ``step``, and add the entry to the products of z with the memory."""
    rest = force[i]
    plain = record[PLAIN] != wp.float64(0.0)
    scale = type(rest[0])(record[PRECONDITIONER_SCALE])
    for j in range(SLOTS):
        rest -= memory.gradient_change[j, i] * type(scale)(alpha[j])
    ready = times_block(preconditioner[i], rest) * scale
    if plain:
        ready = rest * (type(scale)(PLAIN_STEP) / stiffness[i])
    memory.step[i] = ready
    for j in range(SLOTS):
        total[j] += wp.float64(wp.dot(memory.gradient_change[j, i], ready))
    return total


@wp.func
def update_coefficients(cell: int, memory: LBFGSArrays) -> None:
    """With the sums over a cell, find the numbers a_j - b_j."""
    products, record = memory.products[cell], memory.record[cell]
    find_coefficients(products, record, memory.curvature[cell], memory.alpha[cell], memory.alpha_minus_beta[cell])


@wp.func
def find_coefficients(
    product: wp.array[wp.float64], record: wp.array[wp.float64], curvature: wp.array2d[wp.float64],
    alpha: wp.array[wp.float64], alpha_minus_beta: wp.array[wp.float64]
) -> None:  # fmt: skip
    """Find a cell's numbers a_j - b_j."""
    zero = wp.float64(0.0)
    newest, count = int(record[NEWEST_SLOT]), wp.where(record[PLAIN] != zero, 0, int(record[PAIRS]))
    table = curvature_by_age(curvature, newest, count)
    along, first, part = Ages(), Ages(), Ages()
    for age in range(6):
        along[age] = product[slot_before(newest, age)]
        first[age] = alpha[slot_before(newest, age)]
    for later in range(6):
        value = along[5 - later]
        for older in range(6):
            if older > 5 - later:
                value += part[older] * table[older, 5 - later]
        part[5 - later] = wp.where(5 - later < count, first[5 - later] - value * table[5 - later, 5 - later], zero)
    for age in range(6):
        alpha_minus_beta[slot_before(newest, age)] = part[age]
    alpha_minus_beta[slot_before(newest, 6)] = zero


@wp.func
def propose_move(
    i: int, step_limit: Scalar, record: wp.array[wp.float64], coefficient: wp.array[wp.float64], points: wp.array[Vec3],
    listed_points: wp.array[Vec3], budget: wp.array[Scalar], memory: LBFGSArrays
) -> None:  # fmt: skip
    """Leave the next move of an entry in the memory's ``step``, no longer than its limit, which is stored too."""
    allowed = wp.min(step_limit, room_left(points, listed_points, budget, i))
    wish = memory.step[i]
    for j in range(SLOTS):
        wish += memory.moves[j, i] * type(allowed)(coefficient[j])
    allowed *= type(allowed)(1.0) - type(allowed)(record[WAITING])
    memory.limit[i] = allowed
    memory.step[i] = shortened(wish * type(allowed)(record[STEP_SCALE]), allowed)


@wp.func
def apply_move(i: int, trial: int, points: wp.array[Vec3], memory: LBFGSArrays) -> None:
    """Move an entry, and store the move in the slot of the pair on trial."""
    move = memory.step[i]
    memory.moves[trial, i] = move
    points[i] = points[i] + move


def cell_ranges(model: Model) -> Any:
    """Return the struct that assigns entries and segments to the cells of a model."""
    cells = CellRanges()
    cells.point_count, cells.points, cells.segments = model.point_count, model.cell_points, model.cell_segments
    return cells


@functools.cache
def _memory_struct(scalar: ScalarType) -> Any:
    """Return the struct of a memory in one precision.

    For each entry: ``moves``, the move in each slot, and ``gradient_change``, the force before the move less the force
    after it, shape (7, E, 3); ``last_force``, the force of the last iteration, and ``step``, the next move, shape
    (E, 3); ``limit``, the largest length of the next move, shape (E,). For each cell: ``record`` (the columns above),
    shape (C, 14); ``curvature``, products of moves with changes of the gradient, shape (C, 7, 7); ``alpha``, the
    numbers a_j, and ``alpha_minus_beta``, a_j - b_j, shape (C, 7); ``products``, sums over the entries of the cell (the
    columns above), shape (C, 19).
    """
    threes, doubles = vector(3, scalar), wp.float64
    annotations = {
        "moves": wp.array2d(dtype=threes),
        "gradient_change": wp.array2d(dtype=threes),
        "last_force": wp.array(dtype=threes),
        "step": wp.array(dtype=threes),
        "limit": wp.array(dtype=scalar),
        "record": wp.array2d(dtype=doubles),
        "curvature": wp.array3d(dtype=doubles),
        "alpha": wp.array2d(dtype=doubles),
        "alpha_minus_beta": wp.array2d(dtype=doubles),
        "products": wp.array2d(dtype=doubles),
    }
    return wp.struct(type(f"LBFGSMemory_{scalar.__name__}", (), {"__annotations__": annotations}))


named_type("LBFGSArrays", lambda form: [_memory_struct(form.scalar)])


def make_memory(model: Model, strains: int) -> Any:
    """Return a memory for a model's control points and the strains of ``strains`` cells, as a struct for kernels."""
    n, cells = model.point_count + strains, model.cell_count
    memory = _memory_struct(model.scalar)()
    memory.moves, memory.gradient_change = model.empty((7, n), 3), model.empty((7, n), 3)
    memory.last_force, memory.step, memory.limit = model.empty(n, 3), model.empty(n, 3), model.empty(n)
    shapes = {"record": (cells, RECORD), "curvature": (cells, 7, 7), "alpha": (cells, 7),
              "alpha_minus_beta": (cells, 7), "products": (cells, PRODUCTS)}  # fmt: skip
    for name, shape in shapes.items():
        setattr(memory, name, wp.zeros(shape, dtype=wp.float64, device=model.device))
    return memory


@wp.struct
class Blocks:
    """The chunk of control points of each block of threads."""

    cell: wp.array[wp.int32]
    first: wp.array[wp.int32]
    last: wp.array[wp.int32]
    of_cell: wp.array[wp.int32]


@wp.func
def point_range_of(blocks: Blocks, block: int, lane: int, threads: int) -> PointRange:
    """The control points of a thread of a block."""
    point_range = PointRange()
    point_range.cell = blocks.cell[block]
    point_range.threads = threads
    point_range.first = blocks.first[block] + lane
    point_range.last = blocks.last[block]
    return point_range


def blocks_of(model: Model) -> Any:
    """Return the chunks of each cell of a model."""
    chunk = CHUNK["cuda" if model.device.is_cuda else "cpu"]
    counts = -(-np.diff(model.point_start) // chunk)
    of_cell = np.concatenate([[0], np.cumsum(counts)])
    cell = np.repeat(np.arange(model.cell_count), counts)
    first = model.point_start[cell] + (np.arange(of_cell[-1]) - of_cell[cell]) * chunk
    blocks = Blocks()
    blocks.cell, blocks.of_cell = model.integers(cell), model.integers(of_cell)
    blocks.first = model.integers(first)
    blocks.last = model.integers(np.minimum(first + chunk, model.point_start[cell + 1]))
    return blocks
