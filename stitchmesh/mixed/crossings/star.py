# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The star of a crossing node: its four neighbours, and all energies that have their middle in the node.

A star has four legs k: to the node after (0) and before (1) along the node's u yarn, and after (2) and before (3) along
its v yarn. The state of a leg is the vector from the node to the neighbour and the difference of their coordinates along
the yarn, positive after and negative before. All energies of a star depend on its legs alone, so that a rigid motion
costs nothing and forces add up to zero: what acts on a leg acts on the neighbour, and its opposite on the node.

A star has

- for each yarn the segment to the node after: stretch, contact of parallel yarns and the opening spring,
- for each yarn the bending at the node,
- for a weave the shear of the four quadrants.

A node writes the forces on its legs to four slots of its own. The slot in which a neighbour keeps the force of the same
segment follows from the numbers of the leg, so that a second pass adds up the slots of each node in a fixed order.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.mixed.crossings.angle import angle_gradient, angle_of, unit_of
from stitchmesh.mixed.crossings.bending import bending_energy, bending_product, bending_slopes
from stitchmesh.mixed.crossings.merging import opening_spring
from stitchmesh.mixed.crossings.parallel_contact import contact_terms
from stitchmesh.mixed.crossings.shear import shear_energy, shear_product
from stitchmesh.mixed.crossings.stretch import stretch_curvatures, stretch_energy, stretch_slopes

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
def slot_behind(link: int, k: int) -> int:
    """Slot in which the neighbour of leg k keeps the force on this node."""
    return 4 * (link // 2) + 2 * (link % 2) + 1 - k % 2


@wp.func
def segment_energy(leg: Any, rest: Any, segment: Any) -> Any:
    """Energy [erg] of a segment; ``segment`` is (k_s, k_c L, contact distance, merging distance)."""
    touch, _push, _stiff = contact_terms(rest, segment[2], segment[1])
    spring, _pull, _rate = opening_spring(rest, segment[3], segment[0])
    return stretch_energy(wp.length(leg), rest, segment[3], segment[0]) + touch + spring


@wp.func
def segment_force(leg: Any, rest: Any, segment: Any) -> tuple[Any, Any]:
    """Forces of a segment on its leg and on its rest length [dyn]."""
    direction, _inverse = unit_of(leg)
    by_length, by_rest = stretch_slopes(wp.length(leg), rest, segment[3], segment[0])
    _touch, push, _stiff = contact_terms(rest, segment[2], segment[1])
    _spring, pull, _rate = opening_spring(rest, segment[3], segment[0])
    return -direction * by_length, -(by_rest + push + pull)


@wp.func
def segment_product(leg: Any, rest: Any, d_leg: Any, d_rest: Any, segment: Any, exact: Any) -> tuple[Any, Any]:
    """Product of the Hessian of a segment with the directions of its leg and its rest length."""
    one = type(exact)(1.0)
    direction, inverse = unit_of(leg)
    by_length, _by_rest = stretch_slopes(wp.length(leg), rest, segment[3], segment[0])
    along, mixed, slack = stretch_curvatures(wp.length(leg), rest, segment[3], segment[0])
    if slack * along < mixed * mixed:  # only below the merging distance
        slack += (mixed * mixed / along - slack) * (one - exact)
    _touch, _push, stiff = contact_terms(rest, segment[2], segment[1])
    _spring, _pull, rate = opening_spring(rest, segment[3], segment[0])
    d_length = wp.dot(direction, d_leg)
    across = d_leg - direction * d_length
    tight = wp.max(by_length, by_length * exact) * inverse
    of_leg = direction * (along * d_length + mixed * d_rest) + across * tight
    return of_leg, mixed * d_length + (slack + stiff + rate) * d_rest


@wp.func
def yarn_energy(
    link_after: int, link_before: int, after: Any, before: Any, ahead: Any, behind: Any, segment: Any, bend: Any, turn: Any
) -> Any:
    """Energy [erg] of one yarn in a star; ``bend`` is (k_b, merging distance) and ``turn`` the rest angle."""
    energy = ahead - ahead
    if link_after >= 0:
        energy += segment_energy(after, ahead, segment)
        if link_before >= 0:
            energy += bending_energy(angle_of(-before, after), turn, ahead - behind, bend[1], bend[0])
    return energy


@wp.func
def yarn_force(
    link_after: int, link_before: int, after: Any, before: Any, ahead: Any, behind: Any, segment: Any, bend: Any, turn: Any
) -> tuple[Any, Any, Any, Any]:
    """Forces [dyn] of one yarn of a star on the leg after, its coordinate, the leg before and its coordinate."""
    on_after, on_before = after - after, before - before
    at_after, at_before = ahead - ahead, behind - behind
    if link_after >= 0:
        on_after, at_after = segment_force(after, ahead, segment)
        if link_before >= 0:
            angle, by_before, by_after = angle_gradient(-before, after)
            by_turn, by_span = bending_slopes(angle, turn, ahead - behind, bend[1], bend[0])
            on_after -= by_after * by_turn
            on_before += by_before * by_turn
            at_after -= by_span
            at_before += by_span
    return on_after, at_after, on_before, at_before


@wp.func
def yarn_product(
    link_after: int, link_before: int, after: Any, before: Any, ahead: Any, behind: Any,
    d_after: Any, d_before: Any, d_ahead: Any, d_behind: Any, segment: Any, bend: Any, turn: Any, exact: Any,
) -> tuple[Any, Any, Any, Any]:  # fmt: skip
    """Product of the Hessian of one yarn of a star; parts as for ``yarn_force``."""
    of_after, of_before = after - after, before - before
    at_after, at_before = ahead - ahead, behind - behind
    if link_after >= 0:
        of_after, at_after = segment_product(after, ahead, d_after, d_ahead, segment, exact)
        if link_before >= 0:
            bent_before, bent_after, of_span = bending_product(
                -before, after, -d_before, d_after, turn, ahead - behind, d_ahead - d_behind, bend[1], bend[0], exact
            )
            of_after += bent_after
            of_before -= bent_before
            at_after += of_span
            at_before -= of_span
    return of_after, at_after, of_before, at_before


@wp.func
def quadrant_energy(link: int, other: int, leg: Any, other_leg: Any, rest: Any, stiffness: Any) -> Any:
    """Energy [erg] of the shear of one quadrant."""
    energy = rest - rest
    if link >= 0 and other >= 0:
        energy = shear_energy(angle_of(leg, other_leg), rest, stiffness)
    return energy


@wp.func
def quadrant_force(link: int, other: int, leg: Any, other_leg: Any, rest: Any, stiffness: Any) -> tuple[Any, Any]:
    """Forces [dyn] of the shear of one quadrant on its two legs."""
    on_leg, on_other = leg - leg, other_leg - other_leg
    if link >= 0 and other >= 0:
        angle, by_leg, by_other = angle_gradient(leg, other_leg)
        slope = stiffness * (rest - angle)
        on_leg, on_other = by_leg * slope, by_other * slope
    return on_leg, on_other


@wp.func
def quadrant_product(
    link: int, other: int, leg: Any, other_leg: Any, d_leg: Any, d_other: Any, rest: Any, stiffness: Any, exact: Any
) -> tuple[Any, Any]:
    """Product of the Hessian of one quadrant; parts of its two legs."""
    of_leg, of_other = leg - leg, other_leg - other_leg
    if link >= 0 and other >= 0:
        of_leg, of_other = shear_product(leg, other_leg, d_leg, d_other, rest, stiffness, exact)
    return of_leg, of_other
