# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches of the quasistatic solver for one large piece: each step over all of the device.

All products with the memory are found in one pass over the control points and summed in a fixed order; the numbers
a_j, b_j are found by one block of threads, so nothing is read back to the host.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.yarnrelax.method import Scene
from stitchmesh.yarnrelax.quasi_newton_memory import Memory
from stitchmesh.yarnrelax.quasi_newton_steps import (
    PRODUCTS,
    Products,
    Slots,
    proposed,
    recall_pairs,
    slot_on_trial,
    take_pair,
    with_products,
    with_rise,
)
from stitchmesh.yarnrelax.reduction import Walk, walk_over
from stitchmesh.yarnrelax.term import Run

wp.set_module_options({"enable_backward": False})


@wp.kernel(module="unique")
def compare(
    # model
    across: int,
    along: int,
    chunk: int,
    # state in
    force: wp.array[Any],
    compliance: wp.array[Any],
    numbers: wp.array[wp.float64],
    moves: wp.array2d[Any],
    points: wp.array[Any],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    # state out
    last_force: wp.array[Any],
    losses: wp.array2d[Any],
    products: wp.array2d[wp.float64],
) -> None:
    """What the forces lost on the last move, and all products that the memory needs."""
    strand = wp.tid()
    new = slot_on_trial(numbers)
    total = Products()
    for k in range(chunk):
        i = strand * across + k * along
        if i < force.shape[0]:
            total = with_products(
                total, i, new, force, compliance, moves, points, listed_points, budget, last_force, losses
            )
    for k in range(26):
        products[k, strand] = total[k]


@wp.kernel(module="unique")
def remember(
    # state in
    product: wp.array[wp.float64],
    # state out
    numbers: wp.array[wp.float64],
    curvature: wp.array2d[wp.float64],
    fall: wp.array[wp.float64],
) -> None:
    """Take the newest pair into the memory if it is sound, and find the numbers a_j; one thread."""
    take_pair(product, numbers, curvature, fall)


@wp.kernel(module="unique")
def precondition(
    # model
    across: int,
    along: int,
    chunk: int,
    # state in
    force: wp.array[Any],
    compliance: wp.array[Any],
    stiffness: wp.array[Any],
    numbers: wp.array[wp.float64],
    fall: wp.array[wp.float64],
    losses: wp.array2d[Any],
    # state out
    step: wp.array[Any],
    products: wp.array2d[wp.float64],
) -> None:
    """z, and its products with the memory."""
    strand = wp.tid()
    plain = numbers[3] != wp.float64(0.0)
    scale = type(force[0][0])(numbers[5])
    total = Slots()
    for k in range(chunk):
        i = strand * across + k * along
        if i < force.shape[0]:
            total = with_rise(total, i, plain, scale, force, compliance, stiffness, fall, losses, step)
    for k in range(7):
        products[k, strand] = total[k]


@wp.kernel(module="unique")
def recall(
    # state in
    product: wp.array[wp.float64],
    numbers: wp.array[wp.float64],
    curvature: wp.array2d[wp.float64],
    fall: wp.array[wp.float64],
    # state out
    rise: wp.array[wp.float64],
) -> None:
    """The numbers a_j - b_j; one thread."""
    recall_pairs(product, numbers, curvature, fall, rise)


@wp.kernel(module="unique")
def propose_moves(
    # model
    step_limit: Any,
    # state in
    points: wp.array[Any],
    listed_points: wp.array[Any],
    budget: wp.array[Any],
    numbers: wp.array[wp.float64],
    rise: wp.array[wp.float64],
    moves: wp.array2d[Any],
    # state out
    step: wp.array[Any],
    limit: wp.array[Any],
) -> None:
    """The next move of each control point, within its limit."""
    i = wp.tid()
    step[i] = proposed(i, step_limit, points, listed_points, budget, numbers, rise, moves, step, limit)


@wp.kernel(module="unique")
def move_and_note(
    # state in
    numbers: wp.array[wp.float64],
    step: wp.array[Any],
    # state out
    moves: wp.array2d[Any],
    points: wp.array[Any],
) -> None:
    """Move, and put the move into the slot of the pair on trial."""
    i = wp.tid()
    moves[slot_on_trial(numbers), i] = step[i]
    points[i] = points[i] + step[i]


class PieceLaunches:
    """Room for the sums over one piece, and its launches."""

    def __init__(self, memory: Memory) -> None:
        """Strands for all entries."""
        self.memory = memory
        self.walk: Walk = walk_over(memory.entries, memory.device)
        self.products = wp.zeros((PRODUCTS, self.walk.strands), dtype=wp.float64, device=memory.device)
        self.product = wp.zeros(PRODUCTS, dtype=wp.float64, device=memory.device)

    def launches(self, scene: Scene, run: Run) -> list[Any]:
        """Remember, propose, hold, move."""
        state, walk, memory = scene.state, self.walk, self.memory
        numbers, curvature, fall, rise = memory.numbers[0], memory.curvature[0], memory.fall[0], memory.rise[0]
        now = [*walk.numbers, state.point_force, state.compliance]
        places = [scene.model.number(scene.step_fraction), state.points, state.listed_points, state.budget]
        launches = [] if scene.strain is None else scene.strain.force_launches(state, run)
        launches += [
            run(compare, walk.strands, [*now, numbers, memory.moves, *places[1:]],
                [memory.last_force, memory.losses, self.products]),
            walk.total(self.products, self.product, run),
            run(remember, 1, [self.product], [numbers, curvature, fall]),
            run(precondition, walk.strands, [*now, state.stiffness, numbers, fall, memory.losses],
                [memory.step, self.products]),
            walk.total(self.products, self.product, run),
            run(recall, 1, [self.product, numbers, curvature, fall], [rise]),
            run(propose_moves, memory.entries, [*places, numbers, rise, memory.moves], [memory.step, memory.limit]),
        ]  # fmt: skip
        for constraint in scene.constraints:
            launches += constraint.filter_steps(state, memory.step, memory.limit, run)
        launches.append(run(move_and_note, memory.entries, [numbers, memory.step], [memory.moves, state.points]))
        if scene.strain is not None:
            launches.append(scene.strain.deform_launch(state, scene.candidates, memory.step, run))
        return launches
