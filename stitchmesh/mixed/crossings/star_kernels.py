# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Kernels over the stars of all crossing nodes: energies, forces, products with the Hessian, and the sums at nodes."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.mixed.crossings.star import (
    coordinate_of,
    leg_vector,
    quadrant_energy,
    quadrant_force,
    quadrant_product,
    slot_behind,
    yarn_energy,
    yarn_force,
    yarn_product,
)

HALF_TURN = wp.constant(3.141592653589793)


@wp.func
def with_coordinate(on_leg: Any, at_coordinate: Any, like: Any) -> Any:
    """The force on a leg and on its coordinate, as a slot."""
    return type(like)(on_leg[0], on_leg[1], on_leg[2], at_coordinate)


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
    here, own = nodes[i], sliding[i]
    k0, k1, k2, k3 = link[i, 0], link[i, 1], link[i, 2], link[i, 3]
    a, b, c, d = leg_vector(k0, nodes, here), leg_vector(k1, nodes, here), leg_vector(k2, nodes, here), leg_vector(k3, nodes, here)
    ua, ub = coordinate_of(k0, sliding, own[0]) - own[0], coordinate_of(k1, sliding, own[0]) - own[0]
    uc, ud = coordinate_of(k2, sliding, own[1]) - own[1], coordinate_of(k3, sliding, own[1]) - own[1]
    total = yarn_energy(k0, k1, a, b, ua, ub, segment[i, 0], bend[i, 0], turn[i, 0])
    total += yarn_energy(k2, k3, c, d, uc, ud, segment[i, 1], bend[i, 1], turn[i, 1])
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
    """Forces of each star on its legs [dyn]; slot 4 i + k for leg k."""
    i = wp.tid()
    here, own = nodes[i], sliding[i]
    k0, k1, k2, k3 = link[i, 0], link[i, 1], link[i, 2], link[i, 3]
    a, b, c, d = leg_vector(k0, nodes, here), leg_vector(k1, nodes, here), leg_vector(k2, nodes, here), leg_vector(k3, nodes, here)
    ua, ub = coordinate_of(k0, sliding, own[0]) - own[0], coordinate_of(k1, sliding, own[0]) - own[0]
    uc, ud = coordinate_of(k2, sliding, own[1]) - own[1], coordinate_of(k3, sliding, own[1]) - own[1]
    fa, ta, fb, tb = yarn_force(k0, k1, a, b, ua, ub, segment[i, 0], bend[i, 0], turn[i, 0])
    fc, tc, fd, td = yarn_force(k2, k3, c, d, uc, ud, segment[i, 1], bend[i, 1], turn[i, 1])
    stiffness, angle = shear[i], shear_rest[i]
    other = type(angle)(HALF_TURN) - angle
    if wp.max(stiffness) > type(angle)(0.0):
        ac, ca = quadrant_force(k0, k2, a, c, angle, stiffness[0])
        ad, da = quadrant_force(k0, k3, a, d, other, stiffness[1])
        bc, cb = quadrant_force(k1, k2, b, c, other, stiffness[2])
        bd, db = quadrant_force(k1, k3, b, d, angle, stiffness[3])
        fa += ac + ad
        fb += bc + bd
        fc += ca + cb
        fd += da + db
    slots[4 * i] = with_coordinate(fa, ta, slots[4 * i])
    slots[4 * i + 1] = with_coordinate(fb, tb, slots[4 * i])
    slots[4 * i + 2] = with_coordinate(fc, tc, slots[4 * i])
    slots[4 * i + 3] = with_coordinate(fd, td, slots[4 * i])


@kernel
def find_star_products(
    # model
    link: wp.array2d[wp.int32],
    segment: wp.array2d[Any],
    bend: wp.array2d[Any],
    shear: wp.array[Any],
    shear_rest: wp.array[Any],
    slides: wp.array[Any],
    # state in
    turn: wp.array2d[Any],
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    share: wp.array[Any],
    d_nodes: wp.array[Any],
    d_sliding: wp.array[Any],
    # state out
    slots: wp.array[Any],
) -> None:
    """Products of the Hessian of each star with a direction [dyn]; slot 4 i + k for leg k."""
    i = wp.tid()
    exact = share[0]
    here, own = nodes[i], sliding[i]
    d_here, d_own = d_nodes[i], wp.cw_mul(d_sliding[i], slides[i])
    k0, k1, k2, k3 = link[i, 0], link[i, 1], link[i, 2], link[i, 3]
    a, b, c, d = leg_vector(k0, nodes, here), leg_vector(k1, nodes, here), leg_vector(k2, nodes, here), leg_vector(k3, nodes, here)
    xa, xb = leg_vector(k0, d_nodes, d_here), leg_vector(k1, d_nodes, d_here)
    xc, xd = leg_vector(k2, d_nodes, d_here), leg_vector(k3, d_nodes, d_here)
    ua, ub = coordinate_of(k0, sliding, own[0]) - own[0], coordinate_of(k1, sliding, own[0]) - own[0]
    uc, ud = coordinate_of(k2, sliding, own[1]) - own[1], coordinate_of(k3, sliding, own[1]) - own[1]
    one = type(exact)(1.0)
    va = coordinate_of(k0, d_sliding, d_own[0]) * coordinate_of(k0, slides, one) - d_own[0]
    vb = coordinate_of(k1, d_sliding, d_own[0]) * coordinate_of(k1, slides, one) - d_own[0]
    vc = coordinate_of(k2, d_sliding, d_own[1]) * coordinate_of(k2, slides, one) - d_own[1]
    vd = coordinate_of(k3, d_sliding, d_own[1]) * coordinate_of(k3, slides, one) - d_own[1]
    fa, ta, fb, tb = yarn_product(
        k0, k1, a, b, ua, ub, xa, xb, va, vb, segment[i, 0], bend[i, 0], turn[i, 0], exact
    )  # fmt: skip
    fc, tc, fd, td = yarn_product(
        k2, k3, c, d, uc, ud, xc, xd, vc, vd, segment[i, 1], bend[i, 1], turn[i, 1], exact
    )  # fmt: skip
    stiffness, angle = shear[i], shear_rest[i]
    other = type(angle)(HALF_TURN) - angle
    if wp.max(stiffness) > type(angle)(0.0):
        ac, ca = quadrant_product(k0, k2, a, c, xa, xc, angle, stiffness[0], exact)
        ad, da = quadrant_product(k0, k3, a, d, xa, xd, other, stiffness[1], exact)
        bc, cb = quadrant_product(k1, k2, b, c, xb, xc, other, stiffness[2], exact)
        bd, db = quadrant_product(k1, k3, b, d, xb, xd, angle, stiffness[3], exact)
        fa += ac + ad
        fb += bc + bd
        fc += ca + cb
        fd += da + db
    slots[4 * i] = with_coordinate(fa, ta, slots[4 * i])
    slots[4 * i + 1] = with_coordinate(fb, tb, slots[4 * i])
    slots[4 * i + 2] = with_coordinate(fc, tc, slots[4 * i])
    slots[4 * i + 3] = with_coordinate(fd, td, slots[4 * i])


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
    total_u = type(slots[0])()
    total_v = type(slots[0])()
    for k in range(2):
        if link[i, k] >= 0:
            total_u += slots[slot_behind(link[i, k], k)] - slots[4 * i + k]
        if link[i, 2 + k] >= 0:
            total_v += slots[slot_behind(link[i, 2 + k], 2 + k)] - slots[4 * i + 2 + k]
    whole = total_u + total_v
    on_nodes[i] += type(on_nodes[0])(whole[0], whole[1], whole[2])
    on_sliding[i] += wp.cw_mul(type(on_sliding[0])(total_u[3], total_v[3]), slides[i])


@kernel
def keep_state(
    # state in
    exact: Any,
    nodes: wp.array[Any],
    sliding: wp.array[Any],
    # state out
    kept_nodes: wp.array[Any],
    kept_sliding: wp.array[Any],
    share: wp.array[Any],
) -> None:
    """Keep the state at which products are taken, and the share of the exact Hessian."""
    i = wp.tid()
    kept_nodes[i] = nodes[i]
    kept_sliding[i] = sliding[i]
    if i == 0:
        share[0] = exact
