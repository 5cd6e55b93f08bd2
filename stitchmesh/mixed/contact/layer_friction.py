# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Dry friction between layers of cloth: Coulomb's law, smoothed, with lagged normal forces (Li et al. 2020).

The contact forces F_ij between two layers are taken from the beginning of the step. Their vector sum defines the normal
force N_i and the normal n_i of each contact point, and their sizes define the part w_ij of each touching point j:

    N_i n_i = sum over j of F_ij,    w_ij = |F_ij| / S_i,    S_i = sum over j of |F_ij|

With the displacements d of the points since the beginning of the step, the energy is

    E = 1/2 sum over i of  mu N_i phi(|t_i|)        [erg],    t_i = (1 - n_i n_i^T) (d_i - sum over j of w_ij d_j)

with phi as in ``simulation.friction_law``. Each of two layers that slide on one another has half of the energy, so the
friction is mu times their normal force. Friction of single pairs would instead add the sizes of forces whose vector sum
is smaller. The force on a point is -g_i + sum over j of w_ji g_j with g_i = mu N_i / 2 phi' / |t_i| t_i, so all forces
add up to zero. The Hessian is never negative.

Slip is measured from the beginning of the step, so layers that rest on one another creep, more slowly than
``SLIP_SPEED``. A static equilibrium has no friction between layers.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import Mat33, Scalar, Vec2, Vec3, vector
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.contact.body_distance import block_products
from stitchmesh.mixed.contact.pair_penalty import distance_of, pair_size, pair_slope
from stitchmesh.mixed.contact.self_collision import SelfCollision
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.term import MixedTerm
from stitchmesh.simulation.friction_law import slip_block, slip_energy, slip_force, within

SLIP_SPEED = 1.0
"""Relative speed of layers at which friction reaches its full size [cm/s]."""


@kernel
def find_layer_loads(
    # model
    radius: wp.array[Scalar],
    area: wp.array[Scalar],
    pressure: Scalar,
    # state in
    place: wp.array[Vec3],
    count: wp.array[wp.int32],
    lists: wp.array2d[wp.int32],
    # state out
    load: wp.array[Scalar],
    normal: wp.array[Vec3],
    touch_count: wp.array[wp.int32],
    touching: wp.array2d[wp.int32],
    part: wp.array2d[Scalar],
) -> None:
    """Normal force and normal of each point; the points that touch it, with the sizes of their forces over the sum."""
    i = wp.tid()
    force, total, found = type(place[i])(), pressure - pressure, int(0)
    for k in range(count[i]):
        j = lists[i, k]
        reach = radius[i] + radius[j]
        apart = place[i] - place[j]
        distance = distance_of(apart)
        if distance < reach:
            push = -pair_size(pressure, reach, area[i], area[j]) * pair_slope(distance / reach) / reach
            force += apart * (push / distance)
            total += push
            touching[i, found] = j
            part[i, found] = push
            found += 1
    for k in range(found):
        part[i, k] = part[i, k] / total
    touch_count[i] = found
    load[i] = wp.length(force)
    normal[i] = wp.normalize(force)


@kernel
def subtract_touching(
    # model
    touch_count: wp.array[wp.int32],
    touching: wp.array2d[wp.int32],
    part: wp.array2d[Scalar],
    normal: wp.array[Vec3],
    # state in
    place: wp.array[Vec3],
    start: wp.array[Vec3],
    # state out
    relative: wp.array[Vec3],
) -> None:
    """t_i, from places and places at the start, or from a direction and zeros."""
    i = wp.tid()
    move = place[i] - start[i]
    for k in range(touch_count[i]):
        j = touching[i, k]
        move -= (place[j] - start[j]) * part[i, k]
    relative[i] = within(move, normal[i])


@kernel
def slip_energies(
    # model
    law: wp.array[Vec2],
    load: wp.array[Scalar],
    # state in
    slip: wp.array[Vec3],
    # state out
    energy: wp.array[Scalar],
) -> None:
    """Energy of each point [erg]; the law is mu / 2 and the slip length."""
    i = wp.tid()
    energy[i] = law[0][0] * load[i] * slip_energy(wp.length(slip[i]), law[0][1])


@kernel
def slip_pulls(
    # model
    law: wp.array[Vec2],
    load: wp.array[Scalar],
    # state in
    slip: wp.array[Vec3],
    # state out
    pull: wp.array[Vec3],
) -> None:
    """-g_i [dyn]."""
    i = wp.tid()
    pull[i] = slip_force(slip[i], law[0][0] * load[i], law[0][1])


@kernel
def slip_blocks(
    # model
    law: wp.array[Vec2],
    load: wp.array[Scalar],
    normal: wp.array[Vec3],
    # state in
    slip: wp.array[Vec3],
    # state out
    block: wp.array[Mat33],
) -> None:
    """Second derivative of the energy of each point by t_i [dyn / cm]."""
    i = wp.tid()
    block[i] = slip_block(slip[i], normal[i], law[0][1]) * (law[0][0] * load[i])


@kernel
def add_to_touching(
    # model
    touch_count: wp.array[wp.int32],
    touching: wp.array2d[wp.int32],
    part: wp.array2d[Scalar],
    # state in
    pull: wp.array[Vec3],
    # state out
    force: wp.array[Vec3],
) -> None:
    """The pull of each point less the parts of the pulls of those that touch it."""
    i = wp.tid()
    total = pull[i]
    for k in range(touch_count[i]):
        j = touching[i, k]
        for other in range(touch_count[j]):
            if touching[j, other] == i:
                total -= pull[j] * part[j, other]
    force[i] = total


class LayerFriction(MixedTerm):
    """Friction between the layers of a cloth that collides with itself, on a device."""

    name = "layer friction"

    def __init__(self, collision: SelfCollision, coefficient: float) -> None:
        """Add friction to self-collision.

        Args:
            collision: the contact; it must come before this term in the list of a solver.
            coefficient: mu.

        Raises:
            ParameterError: the coefficient is below 0.
        """
        if not (np.isfinite(coefficient) and coefficient >= 0.0):
            raise ParameterError(f"layer friction: got a coefficient of {coefficient}; expected at least 0")
        self.collision, self.points = collision, collision.points
        self.coefficient = coefficient
        points, device = self.points, self.points.device
        self._law = wp.zeros(1, dtype=vector(2, points.scalar), device=device)
        self._load, self._numbers, self._block = points.scalars(), points.scalars(), points.blocks()
        self._normal, self._start, self._place, self._zero = (points.vectors() for _ in range(4))
        self._slip, self._pull, self._force = (points.vectors() for _ in range(3))
        self._touch_count = wp.zeros(len(points), dtype=wp.int32, device=device)
        self._fit_lists()

    @property
    def generation(self) -> int:
        """How often the lists have grown."""
        return self._generation

    def begin_step(self, state: MixedVector, time: float, time_step: float) -> None:
        """Find normal forces and touching points. A step without length has no friction."""
        if self._generation != self.collision.generation:
            self._fit_lists()
        run = partial(launch, device=self.points.device)
        self.points.place(state, self._start, run)
        length = SLIP_SPEED * time_step
        self._law.assign([[0.5 * self.coefficient if length > 0.0 else 0.0, length if length > 0.0 else 1.0]])
        outputs = [self._load, self._normal, *self._lists]
        run(find_layer_loads, len(self.points), self.collision.inputs(self._start), outputs)

    def element_energies(self, state: MixedVector, launcher: Launcher) -> tuple[list[Any], wp.array[Any]]:
        """The launch that finds the energy of each point, and the array of the energies."""
        launches = self._slips(state, launcher)
        inputs = [self._law, self._load, self._slip]
        return [*launches, launcher(slip_energies, len(self.points), inputs, [self._numbers])], self._numbers

    def forces(self, state: MixedVector, force: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add friction."""
        launches = self._slips(state, launcher)
        launches.append(launcher(slip_pulls, len(self.points), [self._law, self._load, self._slip], [self._pull]))
        return launches + self._spread(force, launcher)

    def linearize(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that store the second derivative of each point."""
        inputs = [self._law, self._load, self._normal, self._slip]
        return [*self._slips(state, launcher), launcher(slip_blocks, len(self.points), inputs, [self._block])]

    def products(self, direction: MixedVector, product: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that add H d."""
        launches = self.points.place(direction, self._place, launcher)
        launches.append(self._relative(self._zero, launcher))
        launches.append(launcher(block_products, len(self.points), [self._block, self._slip], [self._pull]))
        return launches + self._spread(product, launcher)

    def diagonal(self, blocks: MixedBlocks, launcher: Launcher) -> list[Any]:
        """The launches that add diagonal blocks, without the share of each point in the slip of touching points."""
        return self.points.spread_blocks(self._block, blocks, launcher)

    def _slips(self, state: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that find t_i of each point at a state."""
        return [*self.points.place(state, self._place, launcher), self._relative(self._start, launcher)]

    def _relative(self, start: wp.array[Any], launcher: Launcher) -> Any:
        inputs = [*self._lists, self._normal, self._place, start]
        return launcher(subtract_touching, len(self.points), inputs, [self._slip])

    def _spread(self, target: MixedVector, launcher: Launcher) -> list[Any]:
        """The launches that distribute pulls to touching points, and from all points to vertices and nodes."""
        launches = [launcher(add_to_touching, len(self.points), [*self._lists, self._pull], [self._force])]
        return launches + self.points.spread(self._force, target, launcher)

    def _fit_lists(self) -> None:
        """Allocate lists with the capacity of the contact lists."""
        lists = self.collision.pairs.lists
        self._touching = wp.zeros(lists.shape, dtype=wp.int32, device=lists.device)
        self._part = wp.zeros(lists.shape, dtype=self.points.scalar, device=lists.device)
        self._lists = [self._touch_count, self._touching, self._part]
        self._generation = self.collision.generation
