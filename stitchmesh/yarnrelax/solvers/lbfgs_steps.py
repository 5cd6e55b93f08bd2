# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The algebra of the quasistatic solver, step by step for one entry or one cell (``quasi_newton``).

An entry is a control point, or the strains of a cell (``cell``). What a cell keeps stands in its row of the memory's
``numbers``, ``curvature`` and so on; its control points are its own. A scene of one piece is one cell.

An iteration is, with sums over the cell between its steps: ``force_products`` by many threads, ``update_memory`` by
one, ``direction_products`` by many, ``update_coefficients`` by one, ``propose_point_moves`` and ``moved`` by many.
"""

from __future__ import annotations

import functools
from typing import Any

import warp as wp

from stitchmesh.compute.precision import vector
from stitchmesh.compute.thread_block import Products, Slots
from stitchmesh.yarnrelax.collision.step_limit import room_left, shortened
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.solvers.cell_strain import deformed
from stitchmesh.yarnrelax.solvers.preconditioner import times_block

# Loops over these numbers stand as literals below: Warp unrolls a loop only where its bound is one.
MEMORY = 6
"""Pairs that are kept."""
SLOTS = wp.constant(7)
"""Places for pairs: the oldest stays valid while the newest is on trial."""
PERIOD = wp.constant(20)
"""Iterations after which a relaxation is assessed."""
SMOOTHING = wp.constant(4)
"""Plain iterations at the end of each period."""
LEAST_SCALE, LARGEST_SCALE = wp.constant(wp.float64(0.05)), wp.constant(wp.float64(4.0))
"""Bounds of g."""

PRODUCTS = 19
"""Products with the memory: two with each slot, and four of the newest pair; the square of the force."""
NUMBERS = 12
"""Numbers of the memory: newest slot, pairs, iterations so far, whether the last move was a plain one, scale of moves,
g, whether all wait for new candidate lists or the next assessment, and the iterations done by then. Then for L's test
(``leaf_convergence``): norms of the first and of the last force, iterations in all, and that at which the norm had
first fallen to a tenth."""

Ages = wp.types.vector(length=6, dtype=wp.float64)
Table = wp.types.matrix(shape=(6, 6), dtype=wp.float64)


@wp.func
def slot_before(head: int, age: int) -> int:
    """The slot that was filled ``age`` pairs before the newest."""
    return (head - age + 7) % 7


@wp.func
def trial_slot(numbers: wp.array[wp.float64]) -> int:
    """The slot of the newest pair, which may be taken into the memory or not."""
    return (int(numbers[0]) + 1) % 7


@wp.struct
class Cells:
    """Which entries are a cell's."""

    point_count: wp.int32
    points: wp.array[wp.int32]
    segments: wp.array[wp.int32]


@wp.struct
class PointRange:
    """What a thread does of a cell: every so many-th of some control points."""

    cell: wp.int32
    first: wp.int32
    last: wp.int32
    threads: wp.int32


@wp.func
def add_force_products(total: Any, i: int, new: int, state: Any, memory: Any) -> Any:
    """Note what the force on an entry lost on the last move, and add the entry to all products."""
    now = state.force[i]
    lost = memory.last_force[i] - now
    memory.last_force[i] = now
    memory.gradient_change[new, i] = lost
    for j in range(SLOTS):
        moved = memory.moves[j, i]
        total[j] += wp.float64(wp.dot(moved, now))
        total[j + SLOTS] += wp.float64(wp.dot(moved, lost))
    move = memory.moves[new, i]
    total[2 * SLOTS] += wp.float64(wp.dot(lost, times_block(state.preconditioner[i], lost)))
    total[2 * SLOTS + 1] += wp.float64(wp.dot(move, move))
    total[2 * SLOTS + 2] += wp.float64(wp.dot(lost, lost))
    if room_left(state.points, state.listed_points, state.budget, i) < state.budget[i] * type(now[0])(1.0 - 0.7):
        total[2 * SLOTS + 3] += wp.float64(1.0)
    total[2 * SLOTS + 4] += wp.float64(wp.dot(now, now))
    return total


@wp.func
def force_products(point_range: PointRange, state: Any, memory: Any) -> Products:
    """Products over a thread's control points."""
    total = Products()
    new = trial_slot(memory.numbers[point_range.cell])
    for i in range(point_range.first, point_range.last, point_range.threads):
        total = add_force_products(total, i, new, state, memory)
    return total


@wp.func
def add_strain_products(total: Any, entry: int, new: int, state: Any, memory: Any) -> Any:
    """Add the strains of a cell; L's gradient knows of none."""
    square = total[18]
    whole = add_force_products(total, entry, new, state, memory)
    whole[18] = square
    return whole


@wp.func
def update_memory(cell: int, memory: Any) -> None:
    """With the sums over a cell: take its newest pair."""
    products, numbers = memory.products[cell], memory.numbers[cell]
    accept_pair(products, numbers, memory.curvature[cell], memory.alpha[cell])
    note_gradient(products[18], numbers)


@wp.func
def curvature_by_age(curvature: wp.array2d[wp.float64], head: int, count: int) -> Table:  # type: ignore[valid-type]
    """Products s_older . y_newer of the pairs, rows and columns by age.

    The diagonal is 1 / s . y, and 0 where there is no pair. All is read before anything depends on it: one wait for
    memory instead of dozens.
    """
    table = Table()
    for older in range(6):
        for newer in range(6):
            if newer <= older:
                table[older, newer] = curvature[slot_before(head, older), slot_before(head, newer)]
    for age in range(6):
        table[age, age] = wp.where(age < count, wp.float64(1.0) / table[age, age], wp.float64(0.0))
    return table


@wp.func
def accept_pair(
    product: wp.array[wp.float64],
    numbers: wp.array[wp.float64],
    curvature: wp.array2d[wp.float64],
    alpha: wp.array[wp.float64],
) -> None:
    """Take a cell's newest pair into the memory if it is sound, and find the numbers a_j."""
    zero = wp.float64(0.0)
    new = trial_slot(numbers)
    for j in range(7):
        curvature[j, new] = product[7 + j]
    bend = product[7 + new]
    sound = bend > wp.float64(1.0e-8) * wp.sqrt(product[15] * product[16]) and numbers[3] == zero
    if sound:
        numbers[0] = wp.float64(new)
        numbers[1] = wp.min(numbers[1] + wp.float64(1.0), wp.float64(6.0))
        numbers[5] = wp.clamp(bend / product[14], LEAST_SCALE, LARGEST_SCALE)
    numbers[6] = wp.where(product[17] > zero or numbers[2] >= numbers[7], wp.float64(1.0), zero)
    turn = int(numbers[2]) % 20
    numbers[2] = numbers[2] + wp.float64(1.0) - numbers[6]
    plain = turn >= PERIOD - SMOOTHING
    numbers[3] = wp.where(plain, wp.float64(1.0), zero)
    head, count = int(numbers[0]), wp.where(plain, 0, int(numbers[1]))
    table = curvature_by_age(curvature, head, count)
    along, part = Ages(), Ages()
    for age in range(6):
        along[age] = product[slot_before(head, age)]
    for age in range(6):
        value = along[age]
        for newer in range(6):
            if newer < age:
                value -= part[newer] * table[age, newer]
        part[age] = value * table[age, age]
    for age in range(6):
        alpha[slot_before(head, age)] = part[age]
    # the seventh slot is that of no pair
    alpha[slot_before(head, 6)] = zero


@wp.func
def note_gradient(square: wp.float64, numbers: wp.array[wp.float64]) -> None:
    """Note the gradient of this iteration of a cell, if it moves, and whether the first line of L's eq 5 holds."""
    zero = wp.float64(0.0)
    if numbers[6] != zero:
        return
    norm = wp.sqrt(square)
    if numbers[10] == zero:
        numbers[8] = norm
    elif numbers[11] == zero and norm <= wp.float64(0.1) * numbers[8]:
        numbers[11] = numbers[10]
    numbers[9] = norm
    numbers[10] = numbers[10] + wp.float64(1.0)


@wp.func
def add_direction_products(
    total: Any, i: int, numbers: wp.array[wp.float64], alpha: Any, state: Any, memory: Any
) -> Any:
    """Leave z of an entry in the memory's ``step``, and add the entry to z's products with the memory."""
    rest = state.force[i]
    plain = numbers[3] != wp.float64(0.0)
    scale = type(rest[0])(numbers[5])
    for j in range(SLOTS):
        rest -= memory.gradient_change[j, i] * type(scale)(alpha[j])
    ready = times_block(state.preconditioner[i], rest) * scale
    if plain:
        ready = rest * (type(scale)(1.6) / state.stiffness[i])
    memory.step[i] = ready
    for j in range(SLOTS):
        total[j] += wp.float64(wp.dot(memory.gradient_change[j, i], ready))
    return total


@wp.func
def direction_products(point_range: PointRange, state: Any, memory: Any) -> Slots:
    """Z of a thread's control points, and its products."""
    total = Slots()
    numbers, alpha = memory.numbers[point_range.cell], memory.alpha[point_range.cell]
    for i in range(point_range.first, point_range.last, point_range.threads):
        total = add_direction_products(total, i, numbers, alpha, state, memory)
    return total


@wp.func
def update_coefficients(cell: int, memory: Any) -> None:
    """With the sums over a cell: find the numbers a_j - b_j."""
    products, numbers = memory.products[cell], memory.numbers[cell]
    find_coefficients(products, numbers, memory.curvature[cell], memory.alpha[cell], memory.alpha_minus_beta[cell])


@wp.func
def find_coefficients(
    product: wp.array[wp.float64],
    numbers: wp.array[wp.float64],
    curvature: wp.array2d[wp.float64],
    alpha: wp.array[wp.float64],
    alpha_minus_beta: wp.array[wp.float64],
) -> None:
    """Find a cell's numbers a_j - b_j."""
    zero = wp.float64(0.0)
    head, count = int(numbers[0]), wp.where(numbers[3] != zero, 0, int(numbers[1]))
    table = curvature_by_age(curvature, head, count)
    along, down, part = Ages(), Ages(), Ages()
    for age in range(6):
        along[age] = product[slot_before(head, age)]
        down[age] = alpha[slot_before(head, age)]
    for later in range(6):
        value = along[5 - later]
        for older in range(6):
            if older > 5 - later:
                value += part[older] * table[older, 5 - later]
        part[5 - later] = wp.where(5 - later < count, down[5 - later] - value * table[5 - later, 5 - later], zero)
    for age in range(6):
        alpha_minus_beta[slot_before(head, age)] = part[age]
    alpha_minus_beta[slot_before(head, 6)] = zero


@wp.func
def propose_move(
    i: int,
    step_limit: Any,
    numbers: wp.array[wp.float64],
    alpha_minus_beta: wp.array[wp.float64],
    state: Any,
    memory: Any,
) -> None:
    """Leave the next move of an entry in the memory's ``step``, within its limit, which is noted."""
    allowed = wp.min(step_limit, room_left(state.points, state.listed_points, state.budget, i))
    wish = memory.step[i]
    for j in range(SLOTS):
        wish += memory.moves[j, i] * type(allowed)(alpha_minus_beta[j])
    allowed *= type(allowed)(1.0) - type(allowed)(numbers[6])
    memory.limit[i] = allowed
    memory.step[i] = shortened(wish * type(allowed)(numbers[4]), allowed)


@wp.func
def apply_move(i: int, new: int, state: Any, memory: Any) -> None:
    """Move an entry, and put the move into the slot of the pair on trial."""
    move = memory.step[i]
    memory.moves[new, i] = move
    state.points[i] = state.points[i] + move


@wp.func
def propose_point_moves(point_range: PointRange, step_limit: Any, state: Any, memory: Any) -> None:
    """Propose moves of a thread's control points."""
    numbers, alpha_minus_beta = memory.numbers[point_range.cell], memory.alpha_minus_beta[point_range.cell]
    for i in range(point_range.first, point_range.last, point_range.threads):
        propose_move(i, step_limit, numbers, alpha_minus_beta, state, memory)


@wp.func
def moved(point_range: PointRange, cells: Cells, strains: Any, state: Any, memory: Any) -> None:
    """Move a thread's control points, and deform them and as many segments' places as the cell's strains moved."""
    cell = point_range.cell
    new = trial_slot(memory.numbers[cell])
    for i in range(point_range.first, point_range.last, point_range.threads):
        apply_move(i, new, state, memory)
    if strains.count > 0:
        e1, e2 = strains.frame[2 * cell], strains.frame[2 * cell + 1]
        more = memory.step[cells.point_count + cell] * strains.per_unit
        for i in range(point_range.first, point_range.last, point_range.threads):
            state.points[i] = deformed(state.points[i], e1, e2, more)
            state.listed_points[i] = deformed(state.listed_points[i], e1, e2, more)
            # a cell has no more segments than control points
            number = i - cells.points[cell]
            s = cells.segments[cell] + number
            if s < cells.segments[cell + 1]:
                strains.listed_centre[s] = deformed(strains.listed_centre[s], e1, e2, more)
            if number < 2:
                strains.periods[2 * cell + number] = deformed(strains.periods[2 * cell + number], e1, e2, more)


@functools.cache
def _struct(scalar: Any) -> Any:
    """The struct of a memory in one precision.

    Of each entry: ``moves``, what it did in the iteration of each slot, and ``gradient_change``, the force before less
    the force after, shape (7, E, 3); ``last_force``, that of the last iteration, and ``step``, its next move, shape
    (E, 3); ``limit``, how far it may go, shape (E,). Of each cell: ``numbers``, (C, 12); ``curvature``, products of
    moves with changes of the gradient, (C, 7, 7); ``alpha``, the numbers a_j, and ``alpha_minus_beta``, a_j - b_j,
    (C, 7); ``products``, sums over its entries, (C, 19).
    """
    threes, doubles = vector(3, scalar), wp.float64
    annotations = {
        "moves": wp.array2d(dtype=threes),
        "gradient_change": wp.array2d(dtype=threes),
        "last_force": wp.array(dtype=threes),
        "step": wp.array(dtype=threes),
        "limit": wp.array(dtype=scalar),
        "numbers": wp.array2d(dtype=doubles),
        "curvature": wp.array3d(dtype=doubles),
        "alpha": wp.array2d(dtype=doubles),
        "alpha_minus_beta": wp.array2d(dtype=doubles),
        "products": wp.array2d(dtype=doubles),
    }
    return wp.struct(type(f"Memory_{scalar.__name__}", (), {"__annotations__": annotations}))


def make_memory(model: Model, strains: int) -> Any:
    """Room for a model's control points and so many cells' strains, in a struct for kernels."""
    n, cells = model.point_count + strains, model.cell_count
    memory = _struct(model.scalar)()
    memory.moves, memory.gradient_change = model.empty((7, n), 3), model.empty((7, n), 3)
    memory.last_force, memory.step, memory.limit = model.empty(n, 3), model.empty(n, 3), model.empty(n)
    shapes = {"numbers": (cells, NUMBERS), "curvature": (cells, 7, 7), "alpha": (cells, 7),
              "alpha_minus_beta": (cells, 7), "products": (cells, PRODUCTS)}  # fmt: skip
    for name, shape in shapes.items():
        setattr(memory, name, wp.zeros(shape, dtype=wp.float64, device=model.device))
    return memory
