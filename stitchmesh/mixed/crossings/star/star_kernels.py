# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Kernels over the stars of all crossing nodes: energies, forces, and their sums at the nodes.

A node writes the forces on its legs to four slots of its own, 4 i + k (``star_memory`` says where they lie). The link
tells in which slot a neighbour keeps the force of the same segment, so a second pass adds up the slots of each node in
a fixed order.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.mixed.crossings.star.star import (
    leg_of,
    quadrant_energy,
    quadrant_force,
    slot_behind,
    yarn_energy,
    yarn_force,
)
from stitchmesh.mixed.crossings.star.star_memory import load_leg, store_leg

HALF_TURN = wp.constant(3.141592653589793)


@kernel
def find_star_energies(
    # model
    link: wp.array2d[wp.int32],
    segment: wp.array2d[Any],
    bend: wp.array2d[Any],
    shear: wp.array[Any],
    shear_rest: wp.array[Any],
    # state in
    turn: wp.array2d[Any],
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    energy: wp.array[wp.float64],
) -> None:
    """Energy of each star [erg]."""
    i = wp.tid()
    k0, k1, k2, k3 = link[i, 0], link[i, 1], link[i, 2], link[i, 3]
    a, b = leg_of(link, nodes, sliding, i, 0), leg_of(link, nodes, sliding, i, 1)
    c, d = leg_of(link, nodes, sliding, i, 2), leg_of(link, nodes, sliding, i, 3)
    total = yarn_energy(k0, k1, a, b, segment[i, 0], bend[i, 0], turn[i, 0])
    total += yarn_energy(k2, k3, c, d, segment[i, 1], bend[i, 1], turn[i, 1])
    stiffness, angle = shear[i], shear_rest[i]
    other = type(angle)(HALF_TURN) - angle
    if wp.max(stiffness) > type(angle)(0.0):
        total += quadrant_energy(k0, k2, a, c, angle, stiffness[0])
        total += quadrant_energy(k0, k3, a, d, other, stiffness[1])
        total += quadrant_energy(k1, k2, b, c, other, stiffness[2])
        total += quadrant_energy(k1, k3, b, d, angle, stiffness[3])
    energy[i] = wp.float64(total)


@kernel
def find_star_forces(
    # model
    link: wp.array2d[wp.int32],
    segment: wp.array2d[Any],
    bend: wp.array2d[Any],
    shear: wp.array[Any],
    shear_rest: wp.array[Any],
    # state in
    turn: wp.array2d[Any],
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    slots: wp.array[Any],
) -> None:
    """Forces of each star on its legs [dyn]."""
    i = wp.tid()
    k0, k1, k2, k3 = link[i, 0], link[i, 1], link[i, 2], link[i, 3]
    a, b = leg_of(link, nodes, sliding, i, 0), leg_of(link, nodes, sliding, i, 1)
    c, d = leg_of(link, nodes, sliding, i, 2), leg_of(link, nodes, sliding, i, 3)
    on_a, on_b = yarn_force(k0, k1, a, b, segment[i, 0], bend[i, 0], turn[i, 0])
    on_c, on_d = yarn_force(k2, k3, c, d, segment[i, 1], bend[i, 1], turn[i, 1])
    stiffness, angle = shear[i], shear_rest[i]
    other = type(angle)(HALF_TURN) - angle
    if wp.max(stiffness) > type(angle)(0.0):
        ac, ca = quadrant_force(k0, k2, a, c, angle, stiffness[0])
        ad, da = quadrant_force(k0, k3, a, d, other, stiffness[1])
        bc, cb = quadrant_force(k1, k2, b, c, other, stiffness[2])
        bd, db = quadrant_force(k1, k3, b, d, angle, stiffness[3])
        on_a += ac + ad
        on_b += bc + bd
        on_c += ca + cb
        on_d += da + db
    store_leg(slots, i, 0, on_a)
    store_leg(slots, i, 1, on_b)
    store_leg(slots, i, 2, on_c)
    store_leg(slots, i, 3, on_d)


@kernel
def add_star_slots(
    # model
    link: wp.array2d[wp.int32],
    slides: wp.array[Any],
    # state in
    slots: wp.array[Any],
    # state out
    on_nodes: wp.array[Any],
    on_sliding: wp.array[Any],
) -> None:
    """Add what acts on each node, from its own slots and those of its neighbours."""
    i = wp.tid()
    zero = on_sliding[i][0] - on_sliding[i][0]
    total_u = wp.vector(zero, zero, zero, zero)
    total_v = wp.vector(zero, zero, zero, zero)
    for k in range(2):
        if link[i, k] >= 0:
            total_u += load_leg(slots, slot_behind(link[i, k], k), zero) - load_leg(slots, 4 * i + k, zero)
        if link[i, 2 + k] >= 0:
            behind = slot_behind(link[i, 2 + k], 2 + k)
            total_v += load_leg(slots, behind, zero) - load_leg(slots, 4 * i + 2 + k, zero)
    whole = total_u + total_v
    on_nodes[i] += type(on_nodes[0])(whole[0], whole[1], whole[2])
    on_sliding[i] += wp.cw_mul(type(on_sliding[0])(total_u[3], total_v[3]), slides[i])
