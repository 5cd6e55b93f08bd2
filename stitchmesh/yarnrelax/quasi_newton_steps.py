# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The algebra of the quasistatic solver, step by step for one entry or one cell (``quasi_newton``).

An entry is a control point, or the strains of a cell (``cell``). What a cell keeps stands in a row of ``numbers``, of
``curvature`` and so on; its control points are its own. A scene of one piece is one cell.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.yarnrelax.compliance import times_block
from stitchmesh.yarnrelax.motion import room_left
from stitchmesh.yarnrelax.step_limit import shortened

wp.set_module_options({"enable_backward": False})

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

PRODUCTS = 26
"""Products with the memory: three with each slot, and four of the newest pair; the square of the force."""
NUMBERS = 12
"""Numbers of the memory: newest slot, pairs, iterations so far, whether the last move was a plain one, scale of moves,
g, whether all wait for new candidate lists or the next assessment, and the iterations done by then. Then L's test
(``leaf_convergence``): norms of the first and of the last force, iterations in all, and that at which it first held."""

Products = wp.types.vector(length=PRODUCTS, dtype=wp.float64)
Slots = wp.types.vector(length=7, dtype=wp.float64)
Table = wp.types.matrix(shape=(7, 7), dtype=wp.float64)


@wp.func
def slot_before(head: int, age: int) -> int:
    """The slot that was filled ``age`` pairs before the newest."""
    return (head - age + 7) % 7


@wp.func
def slot_on_trial(numbers: wp.array[wp.float64]) -> int:
    """The slot of the newest pair, which may be taken into the memory or not."""
    return (int(numbers[0]) + 1) % 7


@wp.func
def with_products(
    total: Any,
    i: int,
    new: int,
    force: wp.array[Any],
    compliance: wp.array[Any],
    moves: wp.array2d[Any],
    points: wp.array[Any],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    last_force: wp.array[Any],
    losses: wp.array2d[Any],
) -> Any:
    """Note what the force on an entry lost on the last move, and add the entry to all products."""
    now = force[i]
    lost = last_force[i] - now
    last_force[i] = now
    losses[new, i] = lost
    move = moves[new, i]
    for j in range(SLOTS):
        moved = moves[j, i]
        total[j] += wp.float64(wp.dot(moved, now))
        total[j + SLOTS] += wp.float64(wp.dot(moved, lost))
        total[j + 2 * SLOTS] += wp.float64(wp.dot(move, losses[j, i]))
    total[3 * SLOTS] += wp.float64(wp.dot(lost, times_block(compliance[i], lost)))
    total[3 * SLOTS + 1] += wp.float64(wp.dot(move, move))
    total[3 * SLOTS + 2] += wp.float64(wp.dot(lost, lost))
    if room_left(points, listed_points, budget, i) < budget[i] * type(now[0])(1.0 - 0.7):
        total[3 * SLOTS + 3] += wp.float64(1.0)
    return total


@wp.func
def take_pair(
    product: wp.array[wp.float64],
    numbers: wp.array[wp.float64],
    curvature: wp.array2d[wp.float64],
    fall: wp.array[wp.float64],
) -> None:
    """Take a cell's newest pair into the memory if it is sound, and find the numbers a_j."""
    zero = wp.float64(0.0)
    new = slot_on_trial(numbers)
    for j in range(7):
        curvature[j, new] = product[7 + j]
        curvature[new, j] = product[14 + j]
    bend = product[7 + new]
    sound = bend > wp.float64(1.0e-8) * wp.sqrt(product[22] * product[23]) and numbers[3] == zero
    if sound:
        numbers[0] = wp.float64(new)
        numbers[1] = wp.min(numbers[1] + wp.float64(1.0), wp.float64(6.0))
        numbers[5] = wp.clamp(bend / product[21], LEAST_SCALE, LARGEST_SCALE)
    numbers[6] = wp.where(product[24] > zero or numbers[2] >= numbers[7], wp.float64(1.0), zero)
    turn = int(numbers[2]) % 20
    numbers[2] = numbers[2] + wp.float64(1.0) - numbers[6]
    plain = turn >= PERIOD - SMOOTHING
    numbers[3] = wp.where(plain, wp.float64(1.0), zero)
    head, count = int(numbers[0]), int(numbers[1])
    # read everything before anything depends on it: one wait for memory instead of dozens
    table = Table()
    along = Slots()
    for j in range(7):
        along[j] = product[j]
        for k in range(7):
            table[j, k] = curvature[j, k]
    part = Slots()
    for age in range(6):
        if age < count and not plain:
            slot = slot_before(head, age)
            value = along[slot]
            for newer in range(age):
                after = slot_before(head, newer)
                value -= part[after] * table[slot, after]
            part[slot] = value / table[slot, slot]
    for j in range(7):
        fall[j] = part[j]


@wp.func
def note_leaf_test(square: wp.float64, numbers: wp.array[wp.float64]) -> None:
    """Look whether L's eq 5 holds in this iteration of a cell, if it moves."""
    zero = wp.float64(0.0)
    if numbers[6] != zero:
        return
    norm, last = wp.sqrt(square), numbers[9]
    if numbers[10] == zero:
        numbers[8] = norm
    elif numbers[11] == zero and norm <= wp.float64(0.1) * numbers[8]:
        if wp.abs(norm - last) <= wp.float64(1.0e-5) * last:
            numbers[11] = numbers[10]
    numbers[9] = norm
    numbers[10] = numbers[10] + wp.float64(1.0)


@wp.func
def with_rise(
    total: Any,
    i: int,
    plain: bool,
    scale: Any,
    force: wp.array[Any],
    compliance: wp.array[Any],
    stiffness: wp.array[Any],
    fall: wp.array[wp.float64],
    losses: wp.array2d[Any],
    step: wp.array[Any],
) -> Any:
    """Leave z of an entry in ``step``, and add the entry to z's products with the memory."""
    rest = force[i]
    for j in range(SLOTS):
        rest -= losses[j, i] * type(scale)(fall[j])
    ready = times_block(compliance[i], rest) * scale
    if plain:
        ready = rest * (type(scale)(1.6) / stiffness[i])
    step[i] = ready
    for j in range(SLOTS):
        total[j] += wp.float64(wp.dot(losses[j, i], ready))
    return total


@wp.func
def recall_pairs(
    product: wp.array[wp.float64],
    numbers: wp.array[wp.float64],
    curvature: wp.array2d[wp.float64],
    fall: wp.array[wp.float64],
    rise: wp.array[wp.float64],
) -> None:
    """Find a cell's numbers a_j - b_j."""
    head, count = int(numbers[0]), int(numbers[1])
    plain = numbers[3] != wp.float64(0.0)
    table = Table()
    along, down = Slots(), Slots()
    for j in range(7):
        along[j] = product[j]
        down[j] = fall[j]
        for k in range(7):
            table[j, k] = curvature[j, k]
    part = Slots()
    for later in range(6):
        age = 5 - later
        if age < count and not plain:
            slot = slot_before(head, age)
            value = along[slot]
            for older in range(age + 1, 6):
                if older < count:
                    before = slot_before(head, older)
                    value += part[before] * table[before, slot]
            part[slot] = down[slot] - value / table[slot, slot]
    for j in range(7):
        rise[j] = part[j]


@wp.func
def proposed(
    i: int,
    step_limit: Any,
    points: wp.array[Any],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    numbers: wp.array[wp.float64],
    rise: wp.array[wp.float64],
    moves: wp.array2d[Any],
    step: wp.array[Any],
    limit: wp.array[Any],
) -> Any:
    """The next move of an entry, within its limit, which is noted."""
    allowed = wp.min(step_limit, room_left(points, listed_points, budget, i))
    wish = step[i]
    for j in range(SLOTS):
        wish += moves[j, i] * type(allowed)(rise[j])
    allowed *= type(allowed)(1.0) - type(allowed)(numbers[6])
    limit[i] = allowed
    return shortened(wish * type(allowed)(numbers[4]), allowed)
