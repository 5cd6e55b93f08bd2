# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The star of a crossing node: its four neighbours, and all energies that have their middle in the node.

A star has four legs k: to the node after (0) and before (1) along the u yarn of the node, and after (2) and before (3)
along its v yarn. A leg is a vector of four components: the vector from the node to the neighbour in space, and the
difference of their coordinates along the yarn, positive after and negative before. All energies of a star depend on its
legs alone. A rigid motion therefore costs nothing and forces add up to zero: the force on a leg acts on the neighbour,
and its opposite on the node.

A star has

- for each yarn the segment to the node after: stretch, contact of parallel yarns and the opening spring,
- for each yarn the bending at the node,
- for a weave the shear of the four quadrants.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.mixed.crossings.energies.angle import angle_gradient, angle_of, lifted, place_of, unit_of
from stitchmesh.mixed.crossings.energies.crossing_energies import (
    bending_blocks,
    bending_energy,
    bending_slopes,
    contact_terms,
    opening_spring,
    shear_blocks,
    shear_energy,
    stretch_curvatures,
    stretch_energy,
    stretch_slopes,
)

# A link is 2 j + c for the coordinate c of a neighbour j, and -1 where a yarn ends.


@wp.func
def leg_vector(link: int, nodes: wp.array[Any], here: Any) -> Any:
    """Vector from a node to the neighbour of a link; zero without one."""
    leg = here - here
    if link >= 0:
        leg = nodes[link // 2] - here
    return leg


@wp.func
def coordinate_of(link: int, sliding: wp.array[Any], here: Any) -> Any:
    """Coordinate of the neighbour of a link; that of the node itself without one."""
    result = here
    if link >= 0:
        result = sliding[link // 2][link % 2]
    return result


@wp.func
def leg_of(link: wp.array2d[wp.int32], nodes: wp.array[Any], sliding: wp.array[Any], i: int, k: int) -> Any:
    """Leg k of node i; zero without a neighbour."""
    leg = leg_vector(link[i, k], nodes, nodes[i])
    own = sliding[i][k // 2]
    return wp.vector(leg[0], leg[1], leg[2], coordinate_of(link[i, k], sliding, own) - own)


@wp.func
def leg_change(
    link: wp.array2d[wp.int32], slides: wp.array[Any], nodes: wp.array[Any], sliding: wp.array[Any], i: int, k: int
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
def segment_energy(leg: Any, segment: Any) -> Any:
    """Energy [erg] of a segment; ``segment`` is (k_s, k_c L, contact distance, merging distance)."""
    touch, _push, _stiff = contact_terms(leg[3], segment[2], segment[1])
    spring, _pull, _rate = opening_spring(leg[3], segment[3], segment[0])
    return stretch_energy(wp.length(place_of(leg)), leg[3], segment[3], segment[0]) + touch + spring


@wp.func
def segment_force(leg: Any, segment: Any) -> Any:
    """Force of a segment on its leg [dyn]."""
    direction, _inverse = unit_of(place_of(leg))
    by_length, by_rest = stretch_slopes(wp.length(place_of(leg)), leg[3], segment[3], segment[0])
    _touch, push, _stiff = contact_terms(leg[3], segment[2], segment[1])
    _spring, pull, _rate = opening_spring(leg[3], segment[3], segment[0])
    pull += by_rest + push
    return -wp.vector(direction[0] * by_length, direction[1] * by_length, direction[2] * by_length, pull)


@wp.func
def segment_block(leg: Any, segment: Any, exact: Any) -> Any:
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
def yarn_energy(link_after: int, link_before: int, after: Any, before: Any, segment: Any, bend: Any, turn: Any) -> Any:
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
    link_after: int, link_before: int, after: Any, before: Any, segment: Any, bend: Any, turn: Any
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
    link_after: int, link_before: int, after: Any, before: Any, segment: Any, bend: Any, turn: Any, exact: Any
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
def quadrant_energy(link: int, other: int, leg: Any, other_leg: Any, rest: Any, stiffness: Any) -> Any:
    """Energy [erg] of the shear of one quadrant."""
    energy = rest - rest
    if link >= 0 and other >= 0:
        energy = shear_energy(angle_of(place_of(leg), place_of(other_leg)), rest, stiffness)
    return energy


@wp.func
def quadrant_force(link: int, other: int, leg: Any, other_leg: Any, rest: Any, stiffness: Any) -> tuple[Any, Any]:
    """Forces [dyn] of the shear of one quadrant on its two legs."""
    on_leg, on_other = leg - leg, other_leg - other_leg
    if link >= 0 and other >= 0:
        angle, by_leg, by_other = angle_gradient(place_of(leg), place_of(other_leg))
        pull = stiffness * (rest - angle)
        on_leg, on_other = lifted(by_leg) * pull, lifted(by_other) * pull
    return on_leg, on_other


@wp.func
def quadrant_blocks(
    link: int, other: int, leg: Any, other_leg: Any, rest: Any, stiffness: Any, exact: Any
) -> tuple[Any, Any, Any]:
    """Blocks of the Hessian of one quadrant: of its first leg, of both, of its second leg."""
    aa, ab, bb = wp.outer(leg, leg), wp.outer(leg, leg), wp.outer(leg, leg)
    zero = exact - exact
    aa, ab, bb = aa * zero, ab * zero, bb * zero
    if link >= 0 and other >= 0:
        aa, ab, bb = shear_blocks(leg, other_leg, rest, stiffness, exact)
    return aa, ab, bb
