# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The quasistatic solver: limited-memory quasi-Newton steps (L-BFGS; Nocedal and Wright, algorithm 7.4).

With forces F, the last moves s_j and what the forces lost on them y_j = F_before - F_after, the next move is

    q = F - sum a_j y_j,   z = g C q,   x <- x + z + sum (a_j - b_j) s_j
    a_j = s_j . q / s_j . y_j   from the newest to the oldest,      b_j = y_j . z / s_j . y_j   from the oldest on,

where C is the compliance of this iteration (``compliance``) and g = s . y / y . C y of the newest pair.
A move is what a control point really did after its step limit and the constraints, so a pair tells the truth even where
moves were cut short. A pair with s . y not clearly positive is left out.

All products with the memory are found in one pass over the control points and summed in a fixed order; the numbers
a_j, b_j are found by one block of threads, so nothing is read back to the host.

Quasi-Newton moves leave noise in the stiffest modes, of which the residual then tells more than of the distance to
rest. So each ``PERIOD`` iterations end with ``SMOOTHING`` plain ones, x <- x + 1.6 F / D with the row sums D of
``stiffness``, which leave the memory alone.

A control point that has used up most of its budget (``step_limit``) would be left behind by its neighbours. All wait
instead until there are new candidate lists.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.yarnrelax.compliance import find_compliance, times_block
from stitchmesh.yarnrelax.method import Method, Scene
from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.motion import room_left
from stitchmesh.yarnrelax.reduction import Walk, walk_over
from stitchmesh.yarnrelax.step_limit import shortened
from stitchmesh.yarnrelax.stiffness import along_stiffness, bend_stiffness
from stitchmesh.yarnrelax.term import Run

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

PRODUCTS = 25
"""Products with the memory: three with each slot, and four of the newest pair."""
NUMBERS = 8
"""Numbers of the memory: newest slot, pairs, iterations so far, whether the last move was a plain one, scale of moves,
g, whether all wait for new candidate lists or the next assessment, and the iterations done by then."""

Products = wp.types.vector(length=PRODUCTS, dtype=wp.float64)
Slots = wp.types.vector(length=7, dtype=wp.float64)
Table = wp.types.matrix(shape=(7, 7), dtype=wp.float64)


@wp.func
def slot_before(head: int, age: int) -> int:
    """The slot that was filled ``age`` pairs before the newest."""
    return (head - age + 7) % 7


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
    new = (int(numbers[0]) + 1) % 7
    total = Products()
    for k in range(chunk):
        i = strand * across + k * along
        if i < force.shape[0]:
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
    for k in range(25):
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
    zero = wp.float64(0.0)
    new = (int(numbers[0]) + 1) % 7
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
            rest = force[i]
            for j in range(SLOTS):
                rest -= losses[j, i] * type(scale)(fall[j])
            ready = times_block(compliance[i], rest) * scale
            if plain:
                ready = rest * (type(scale)(1.6) / stiffness[i])
            step[i] = ready
            for j in range(SLOTS):
                total[j] += wp.float64(wp.dot(losses[j, i], ready))
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
    allowed = wp.min(step_limit, room_left(points, listed_points, budget, i))
    wish = step[i]
    for j in range(SLOTS):
        wish += moves[j, i] * type(allowed)(rise[j])
    allowed *= type(allowed)(1.0) - type(allowed)(numbers[6])
    limit[i] = allowed
    step[i] = shortened(wish * type(allowed)(numbers[4]), allowed)


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
    moves[(int(numbers[0]) + 1) % 7, i] = step[i]
    points[i] = points[i] + step[i]


class QuasiNewton(Method):
    """Limited-memory quasi-Newton steps."""

    needs_blocks = True
    allowed_rise = 1e-3

    def __init__(self, model: Model, further: NDArray[np.float64], strains: int = 0) -> None:
        """Room for the memory; ``further`` are row sums of the stiffness of further terms, shape (N,)."""
        n = model.point_count + strains
        self.along = model.upload(along_stiffness(model), 4)
        self.across = model.upload(bend_stiffness(model), 4)
        self.further = model.upload(np.maximum(further, np.finfo(np.float32).tiny))
        self.walk: Walk = walk_over(n, model.device)
        self.moves, self.losses = model.empty((7, n), 3), model.empty((7, n), 3)
        self.last_force, self.step, self.limit = model.empty(n, 3), model.empty(n, 3), model.empty(n)
        self.numbers = _doubles(model, NUMBERS)
        self.curvature = _doubles(model, (7, 7))
        self.fall, self.rise = _doubles(model, 7), _doubles(model, 7)
        self.products, self.product = _doubles(model, (PRODUCTS, self.walk.strands)), _doubles(model, PRODUCTS)
        self.restart(1.0)

    def launches(self, scene: Scene, run: Run) -> list[Any]:
        """Remember, propose, hold, move."""
        state, walk, count, points = scene.state, self.walk, len(self.step), scene.model.point_count
        now = [*walk.numbers, state.point_force, state.compliance, self.numbers]
        blocks = [self.along, self.across, self.further, state.segment_block, state.sample_block, state.sample_force]
        remembered = [self.numbers, self.curvature, self.fall]
        places = [scene.model.number(scene.step_fraction), state.points, state.listed_points, state.budget]
        launches = [
            run(find_compliance, points, [scene.model.constants, *blocks], [state.compliance]),
            run(compare, walk.strands, [*now, self.moves, *places[1:]], [self.last_force, self.losses, self.products]),
            walk.total(self.products, self.product, run),
            run(remember, 1, [self.product], remembered),
            run(precondition, walk.strands, [*now[:-1], state.stiffness, self.numbers, self.fall, self.losses],
                [self.step, self.products]),
            walk.total(self.products, self.product, run),
            run(recall, 1, [self.product, *remembered], [self.rise]),
            run(propose_moves, count, [*places, self.numbers, self.rise, self.moves], [self.step, self.limit]),
        ]  # fmt: skip
        for constraint in scene.constraints:
            launches += constraint.filter_steps(state, self.step, self.limit, run)
        launches.append(run(move_and_note, count, [self.numbers, self.step], [self.moves, state.points]))
        if scene.strain is not None:
            launches.append(scene.strain.deform_launch(state, scene.candidates, self.step, run))
        return launches

    def restart(self, caution: float) -> None:
        """Forget all pairs; the next force has none before it."""
        self.numbers.assign([0.0, 0.0, 0.0, 1.0, caution, 1.0, 0.0, 0.0])

    def dare(self, caution: float) -> None:
        """Scale moves."""
        self.numbers[4:5].fill_(caution)

    def begin(self, count: int) -> None:
        """Start a new period, and stand still at its end."""
        self.left = count
        self.numbers[2:3].zero_()
        self.numbers[7:8].fill_(float(count))

    def worn(self, scene: Scene, launched: int) -> bool:
        """Read how many iterations were done, and whether all wait for new candidate lists."""
        numbers = self.numbers.numpy()
        self.left = int(numbers[7] - numbers[2])
        return self.left > 0 and numbers[6] > 0.0

    def arrays(self) -> dict[str, wp.array[Any]]:
        """The memory."""
        return {"moves": self.moves, "losses": self.losses, "last_force": self.last_force, "numbers": self.numbers,
                "curvature": self.curvature}  # fmt: skip


def _doubles(model: Model, shape: int | tuple[int, int]) -> wp.array[Any]:
    return wp.zeros(shape, dtype=wp.float64, device=model.device)
