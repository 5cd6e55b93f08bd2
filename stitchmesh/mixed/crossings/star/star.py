# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The star of a crossing node: all energies that have their middle in the node, and the kernels over all stars.

A star has four legs k: to the node after (0) and before (1) along the u yarn of the node, and after (2) and before (3)
along its v yarn. A leg is a vector of four components: the vector from the node to the neighbour in space, and the
difference of their coordinates along the yarn, positive after and negative before. All energies of a star depend on its
legs alone. A rigid motion therefore costs nothing and forces add up to zero: the force on a leg acts on the neighbour,
and its opposite on the node.

A star has

- for each yarn the segment to the node after: stretch, contact of parallel yarns and the opening spring,
- for each yarn the bending at the node,
- for a weave the shear of the four quadrants.

*Kernels* find the energies, forces and Hessians of all stars, and their sums at the nodes. A node writes the forces on
its legs to four slots of its own, 4 i + k (``star_memory`` says where they lie). The link tells in which slot a
neighbour keeps the force of the same segment, so a second pass adds up the slots of each node in a fixed order.

*Hessian.* A star has ten blocks of 4 x 4, for these pairs of legs in this order: 00, 11, 22, 33, 10, 32, 02, 03, 12 and
13. The other blocks are their transposes. Blocks are computed once for a state and stored, which takes 160 scalars for
each node (``star_memory``). They may have less precision than the state: they are computed in the precision of the
state and then rounded. The changes of legs that they multiply are rounded in the same way, so a direction that moves
nothing has no product.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Mat22, Mat33, Mat44, Scalar, Stored, Vec2, Vec3, Vec4
from stitchmesh.mixed.crossings.energies.crossing_energies import (
    angle_gradient,
    angle_of,
    bending_blocks,
    bending_energy,
    bending_slopes,
    contact_terms,
    lifted,
    opening_spring,
    place_of,
    shear_blocks,
    shear_energy,
    stretch_curvatures,
    stretch_energy,
    stretch_slopes,
    unit_of,
)
from stitchmesh.mixed.crossings.star.star_memory import load_block, load_leg, store_block, store_leg

# A link is 2 j + c for the coordinate c of a neighbour j, and -1 where a yarn ends.


@wp.func
def leg_vector(link: int, nodes: wp.array[Vec3], here: Vec3) -> Any:
    """Vector from a node to the neighbour of a link; zero without one."""
    leg = here - here
    if link >= 0:
        leg = nodes[link // 2] - here
    return leg


@wp.func
def coordinate_of(link: int, sliding: wp.array[Vec2], here: Scalar) -> Any:
    """Coordinate of the neighbour of a link; that of the node itself without one."""
    result = here
    if link >= 0:
        result = sliding[link // 2][link % 2]
    return result


@wp.func
def leg_of(link: wp.array2d[wp.int32], nodes: wp.array[Vec3], sliding: wp.array[Vec2], i: int, k: int) -> Any:
    """Leg k of node i; zero without a neighbour."""
    leg = leg_vector(link[i, k], nodes, nodes[i])
    own = sliding[i][k // 2]
    return wp.vector(leg[0], leg[1], leg[2], coordinate_of(link[i, k], sliding, own) - own)


@wp.func
def leg_change(
    link: wp.array2d[wp.int32], slides: wp.array[Vec2], nodes: wp.array[Vec3], sliding: wp.array[Vec2], i: int, k: int
) -> Any:
    """Change of leg k of node i along a direction, in which fixed coordinates do not take part."""
    leg = leg_vector(link[i, k], nodes, nodes[i])
    own, free = sliding[i][k // 2], slides[i][k // 2]
    other = coordinate_of(link[i, k], sliding, own) * coordinate_of(link[i, k], slides, free)
    return wp.vector(leg[0], leg[1], leg[2], other - own * free)


@wp.func
def slot_behind(link: int, k: int) -> int:
    """Slot in which the neighbour of leg k keeps what acts on this node: 4 j + its leg."""
    return 4 * (link // 2) + 2 * (link % 2) + 1 - k % 2


@wp.func
def segment_energy(leg: Vec4, segment: Vec4) -> Any:
    """Energy [erg] of a segment; ``segment`` is (k_s, k_c L, contact distance, merging distance)."""
    touch, _push, _stiff = contact_terms(leg[3], segment[2], segment[1])
    spring, _pull, _rate = opening_spring(leg[3], segment[3], segment[0])
    return stretch_energy(wp.length(place_of(leg)), leg[3], segment[3], segment[0]) + touch + spring


@wp.func
def segment_force(leg: Vec4, segment: Vec4) -> Any:
    """Force of a segment on its leg [dyn]."""
    direction, _inverse = unit_of(place_of(leg))
    by_length, by_rest = stretch_slopes(wp.length(place_of(leg)), leg[3], segment[3], segment[0])
    _touch, push, _stiff = contact_terms(leg[3], segment[2], segment[1])
    _spring, pull, _rate = opening_spring(leg[3], segment[3], segment[0])
    pull += by_rest + push
    return -wp.vector(direction[0] * by_length, direction[1] * by_length, direction[2] * by_length, pull)


@wp.func
def segment_block(leg: Vec4, segment: Vec4, exact: Scalar) -> Any:
    """Hessian of a segment by its leg, 4 x 4."""
    zero, one = type(exact)(0.0), type(exact)(1.0)
    direction, inverse = unit_of(place_of(leg))
    length = wp.length(place_of(leg))
    by_length, _by_rest = stretch_slopes(length, leg[3], segment[3], segment[0])
    along, mixed, slack = stretch_curvatures(length, leg[3], segment[3], segment[0])
    if slack * along < mixed * mixed:  # only below the merging distance
        slack += (mixed * mixed / along - slack) * (one - exact)
    _touch, _push, stiff = contact_terms(leg[3], segment[2], segment[1])
    _spring, _pull, rate = opening_spring(leg[3], segment[3], segment[0])
    tight = wp.max(by_length, by_length * exact) * inverse
    e, u = lifted(direction), wp.vector(zero, zero, zero, one)
    across = wp.identity(n=4, dtype=type(exact)) - wp.outer(e, e) - wp.outer(u, u)
    block = wp.outer(e, e) * along + across * tight + wp.outer(u, u) * (slack + stiff + rate)
    return block + (wp.outer(e, u) + wp.outer(u, e)) * mixed


@wp.func
def yarn_energy(
    link_after: int, link_before: int, after: Vec4, before: Vec4, segment: Vec4, bend: Vec2, turn: Scalar
) -> Any:
    """Energy [erg] of one yarn of a star; ``bend`` is (k_b, merging distance) and ``turn`` the rest angle."""
    energy = turn - turn
    if link_after >= 0:
        energy += segment_energy(after, segment)
        if link_before >= 0:
            angle = angle_of(-place_of(before), place_of(after))
            energy += bending_energy(angle, turn, after[3] - before[3], bend[1], bend[0])
    return energy


@wp.func
def yarn_force(
    link_after: int, link_before: int, after: Vec4, before: Vec4, segment: Vec4, bend: Vec2, turn: Scalar
) -> tuple[Any, Any]:
    """Forces [dyn] of one yarn of a star on the legs after and before."""
    on_after, on_before = after - after, before - before
    if link_after >= 0:
        on_after = segment_force(after, segment)
        if link_before >= 0:
            angle, by_before, by_after = angle_gradient(-place_of(before), place_of(after))
            by_turn, by_span = bending_slopes(angle, turn, after[3] - before[3], bend[1], bend[0])
            on_after -= wp.vector(by_after[0] * by_turn, by_after[1] * by_turn, by_after[2] * by_turn, by_span)
            on_before = wp.vector(by_before[0] * by_turn, by_before[1] * by_turn, by_before[2] * by_turn, by_span)
    return on_after, on_before


@wp.func
def yarn_blocks(
    link_after: int, link_before: int, after: Vec4, before: Vec4, segment: Vec4, bend: Vec2, turn: Scalar, exact: Scalar
) -> tuple[Any, Any, Any]:
    """Blocks of the Hessian of one yarn of a star: of the leg after, of before and after, of the leg before."""
    of_after, of_both, of_before = wp.outer(after, after), wp.outer(after, after), wp.outer(after, after)
    zero = exact - exact
    of_after, of_both, of_before = of_after * zero, of_both * zero, of_before * zero
    if link_after >= 0:
        of_after = segment_block(after, segment, exact)
        if link_before >= 0:
            of_before, of_both, bent = bending_blocks(before, after, bend, turn, exact)
            of_after += bent
    return of_after, of_both, of_before


@wp.func
def quadrant_energy(link: int, other: int, leg: Vec4, other_leg: Vec4, rest: Scalar, stiffness: Scalar) -> Any:
    """Energy [erg] of the shear of one quadrant."""
    energy = rest - rest
    if link >= 0 and other >= 0:
        energy = shear_energy(angle_of(place_of(leg), place_of(other_leg)), rest, stiffness)
    return energy


@wp.func
def quadrant_force(
    link: int, other: int, leg: Vec4, other_leg: Vec4, rest: Scalar, stiffness: Scalar
) -> tuple[Any, Any]:
    """Forces [dyn] of the shear of one quadrant on its two legs."""
    on_leg, on_other = leg - leg, other_leg - other_leg
    if link >= 0 and other >= 0:
        angle, by_leg, by_other = angle_gradient(place_of(leg), place_of(other_leg))
        pull = stiffness * (rest - angle)
        on_leg, on_other = lifted(by_leg) * pull, lifted(by_other) * pull
    return on_leg, on_other


@wp.func
def quadrant_blocks(
    link: int, other: int, leg: Vec4, other_leg: Vec4, rest: Scalar, stiffness: Scalar, exact: Scalar
) -> tuple[Any, Any, Any]:
    """Blocks of the Hessian of one quadrant: of its first leg, of both, of its second leg."""
    aa, ab, bb = wp.outer(leg, leg), wp.outer(leg, leg), wp.outer(leg, leg)
    zero = exact - exact
    aa, ab, bb = aa * zero, ab * zero, bb * zero
    if link >= 0 and other >= 0:
        aa, ab, bb = shear_blocks(leg, other_leg, rest, stiffness, exact)
    return aa, ab, bb


HALF_TURN = wp.constant(3.141592653589793)


@kernel
def find_star_energies(
    # model
    link: wp.array2d[wp.int32],
    segment: wp.array2d[Vec4],
    bend: wp.array2d[Vec2],
    shear: wp.array[Vec4],
    shear_rest: wp.array[Scalar],
    # state in
    turn: wp.array2d[Scalar],
    nodes: wp.array[Vec3],
    sliding: wp.array[Vec2],
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
    segment: wp.array2d[Vec4],
    bend: wp.array2d[Vec2],
    shear: wp.array[Vec4],
    shear_rest: wp.array[Scalar],
    # state in
    turn: wp.array2d[Scalar],
    nodes: wp.array[Vec3],
    sliding: wp.array[Vec2],
    # state out
    slots: wp.array[Scalar],
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
    slides: wp.array[Vec2],
    # state in
    slots: wp.array[Stored],
    # state out
    on_nodes: wp.array[Vec3],
    on_sliding: wp.array[Vec2],
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


@wp.func
def rounded_leg(leg: Vec4, one: Scalar) -> Any:
    """A leg in the precision of a scalar."""
    return wp.vector(type(one)(leg[0]), type(one)(leg[1]), type(one)(leg[2]), type(one)(leg[3]))


@kernel
def find_star_blocks(
    # model
    link: wp.array2d[wp.int32],
    segment: wp.array2d[Vec4],
    bend: wp.array2d[Vec2],
    shear: wp.array[Vec4],
    shear_rest: wp.array[Scalar],
    # state in
    exact: Scalar,
    turn: wp.array2d[Scalar],
    nodes: wp.array[Vec3],
    sliding: wp.array[Vec2],
    # state out
    block: wp.array[Stored],
) -> None:
    """The ten blocks of each star [dyn/cm]."""
    i = wp.tid()
    k0, k1, k2, k3 = link[i, 0], link[i, 1], link[i, 2], link[i, 3]
    a, b = leg_of(link, nodes, sliding, i, 0), leg_of(link, nodes, sliding, i, 1)
    c, d = leg_of(link, nodes, sliding, i, 2), leg_of(link, nodes, sliding, i, 3)
    aa, ba, bb = yarn_blocks(k0, k1, a, b, segment[i, 0], bend[i, 0], turn[i, 0], exact)
    cc, dc, dd = yarn_blocks(k2, k3, c, d, segment[i, 1], bend[i, 1], turn[i, 1], exact)
    store_block(block, i, 4, ba)
    store_block(block, i, 5, dc)
    stiffness, angle = shear[i], shear_rest[i]
    other = type(angle)(HALF_TURN) - angle
    if wp.max(stiffness) > type(angle)(0.0):
        own, both, far = quadrant_blocks(k0, k2, a, c, angle, stiffness[0], exact)
        aa += own
        cc += far
        store_block(block, i, 6, both)
        own, both, far = quadrant_blocks(k0, k3, a, d, other, stiffness[1], exact)
        aa += own
        dd += far
        store_block(block, i, 7, both)
        own, both, far = quadrant_blocks(k1, k2, b, c, other, stiffness[2], exact)
        bb += own
        cc += far
        store_block(block, i, 8, both)
        own, both, far = quadrant_blocks(k1, k3, b, d, angle, stiffness[3], exact)
        bb += own
        dd += far
        store_block(block, i, 9, both)
    store_block(block, i, 0, aa)
    store_block(block, i, 1, bb)
    store_block(block, i, 2, cc)
    store_block(block, i, 3, dd)


@kernel
def multiply_star_blocks(
    # model
    link: wp.array2d[wp.int32],
    slides: wp.array[Vec2],
    shear: wp.array[Vec4],
    # state in
    block: wp.array[Stored],
    d_nodes: wp.array[Vec3],
    d_sliding: wp.array[Vec2],
    # state out
    slots: wp.array[Stored],
) -> None:
    """Products of the stored blocks with a direction [dyn]; slot 4 i + k for leg k."""
    i = wp.tid()
    one = block[0]
    a = rounded_leg(leg_change(link, slides, d_nodes, d_sliding, i, 0), one)
    b = rounded_leg(leg_change(link, slides, d_nodes, d_sliding, i, 1), one)
    c = rounded_leg(leg_change(link, slides, d_nodes, d_sliding, i, 2), one)
    d = rounded_leg(leg_change(link, slides, d_nodes, d_sliding, i, 3), one)
    # a vector times a matrix is the transpose of the matrix times the vector
    both, other = load_block(block, i, 4), load_block(block, i, 5)
    of_a, of_b = load_block(block, i, 0) * a + b * both, load_block(block, i, 1) * b + both * a
    of_c, of_d = load_block(block, i, 2) * c + d * other, load_block(block, i, 3) * d + other * c
    if wp.max(shear[i]) > type(shear[i][0])(0.0):
        ac, ad = load_block(block, i, 6), load_block(block, i, 7)
        of_a += ac * c + ad * d
        of_c += a * ac
        of_d += a * ad
        bc, bd = load_block(block, i, 8), load_block(block, i, 9)
        of_b += bc * c + bd * d
        of_c += b * bc
        of_d += b * bd
    store_leg(slots, i, 0, of_a)
    store_leg(slots, i, 1, of_b)
    store_leg(slots, i, 2, of_c)
    store_leg(slots, i, 3, of_d)


@wp.func
def column_of(block: Mat44, zero: Vec3) -> Any:
    """Rows of the position and column of the coordinate of a block of legs, in the precision of ``zero``."""
    kind = zero[0] - zero[0]
    return type(zero)(type(kind)(block[0, 3]), type(kind)(block[1, 3]), type(kind)(block[2, 3]))


@wp.func
def positions_of(block: Mat44, like: Mat33) -> Any:
    """The part of a 4 x 4 block that belongs to positions, in the precision of another block."""
    return type(like)(
        type(like[0, 0])(block[0, 0]), type(like[0, 0])(block[0, 1]), type(like[0, 0])(block[0, 2]),
        type(like[0, 0])(block[1, 0]), type(like[0, 0])(block[1, 1]), type(like[0, 0])(block[1, 2]),
        type(like[0, 0])(block[2, 0]), type(like[0, 0])(block[2, 1]), type(like[0, 0])(block[2, 2]),
    )  # fmt: skip


@kernel
def add_star_diagonal(
    # model
    link: wp.array2d[wp.int32],
    slides: wp.array[Vec2],
    # state in
    block: wp.array[Stored],
    # state out
    of_nodes: wp.array[Mat33],
    of_sliding: wp.array[Mat22],
    coupling_u: wp.array[Vec3],
    coupling_v: wp.array[Vec3],
) -> None:
    """Add the diagonal blocks of the Hessian, from the stored blocks of each node's star and of its neighbours."""
    i = wp.tid()
    # a node moves against all its legs, a coordinate against the two legs of its yarn
    ba, dc = load_block(block, i, 4), load_block(block, i, 5)
    along = load_block(block, i, 0) + load_block(block, i, 1) + ba + wp.transpose(ba)
    across = load_block(block, i, 2) + load_block(block, i, 3) + dc + wp.transpose(dc)
    both = load_block(block, i, 6) + load_block(block, i, 7) + load_block(block, i, 8) + load_block(block, i, 9)
    whole = along + across + both + wp.transpose(both)
    uu, vv = along[3, 3], across[3, 3]
    # columns of the coordinates: rows of all legs, and columns of the legs of one yarn
    column_u, column_v = along + wp.transpose(both), across + both
    n = int(4)
    for k in range(n):
        if link[i, k] >= 0:
            slot = slot_behind(link[i, k], k)
            there = load_block(block, slot // 4, slot % 4)
            whole += there
            if k < 2:
                uu += there[3, 3]
                column_u += there
            else:
                vv += there[3, 3]
                column_v += there
    of_nodes[i] += positions_of(whole, of_nodes[i])
    u, v = type(slides[i][0])(uu), type(slides[i][0])(vv)
    of_sliding[i] += wp.diag(wp.cw_mul(type(slides[i])(u, v), slides[i]))
    coupling_u[i] += column_of(column_u, coupling_u[i]) * slides[i][0]
    coupling_v[i] += column_of(column_v, coupling_v[i]) * slides[i][1]
