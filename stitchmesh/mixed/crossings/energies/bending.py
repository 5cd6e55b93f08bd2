# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bending of a yarn at a crossing node (Cirio et al. 2014, section 4.3).

    E = k_b (t - r)^2 / D

t is the angle by which the yarn turns at the node, r the same angle at rest, and D = u2 - u1 the rest length of yarn
from the node before to the node after. The node stands for the length D / 2, over which the curvature is 2 t / D, and
1/2 EI (2 t / D)^2 D / 2 = EI t^2 / D: the flexural rigidity is EI = k_b = B pi R^2.

Rest angles are those of the centre lines in the plane in which a fabric is laid out: zero for the straight yarns of a
weave, whose crimp the planar nodes do not show, and the turns of the loops in a knit. Yield changes them
(``bending_yield``). The angle has no sign: where r is not zero, a yarn may fold to either side, over a straight state
of energy k_b r^2 / D.

The energy is convex in (t, D). Below the merging distance of the two segments 1 / D is replaced by i(D) (``merging``).
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.mixed.crossings.energies.angle import (
    NO_SINE,
    angle_blocks,
    angle_frame,
    lifted,
    over_sine,
    paired,
    place_of,
)
from stitchmesh.mixed.crossings.energies.merging import guarded_inverse


@wp.func
def bending_energy(turn: Any, rest: Any, span: Any, merging: Any, stiffness: Any) -> Any:
    """E [erg]."""
    inverse, _slope, _bend = guarded_inverse(span, merging)
    return stiffness * (turn - rest) * (turn - rest) * inverse


@wp.func
def bending_slopes(turn: Any, rest: Any, span: Any, merging: Any, stiffness: Any) -> tuple[Any, Any]:
    """E_t [erg] and E_D [dyn]."""
    two = type(turn)(2.0)
    inverse, slope, _bend = guarded_inverse(span, merging)
    return two * stiffness * (turn - rest) * inverse, stiffness * (turn - rest) * (turn - rest) * slope


@wp.func
def turn_over_sine(turn: Any, sine: Any) -> Any:
    """Quotient of an angle and its sine, which is 1 for a straight yarn."""
    result = over_sine(turn, sine)
    if sine < type(sine)(0.01) and turn < type(turn)(1.0):
        # exact to t^4, where a quotient of rounded numbers is not
        result = type(turn)(1.0) + turn * turn / type(turn)(6.0)
    return result


@wp.func
def bending_blocks(before: Any, after: Any, bend: Any, rest: Any, exact: Any) -> tuple[Any, Any, Any]:
    """Blocks of the Hessian of the leg before, of before and after, and of the leg after.

    Args:
        before: leg to the node before, and the difference of the coordinates; four components.
        after: leg to the node after.
        bend: k_b and the merging distance of both segments.
        rest: r.
        exact: share of the exact Hessian.
    """
    zero, one, two = type(rest)(0.0), type(rest)(1.0), type(rest)(2.0)
    a, b = -place_of(before), place_of(after)
    angle, sine, p, q, z, by_a, by_b = angle_frame(a, b)
    inverse, slope, curve = guarded_inverse(after[3] - before[3], bend[1])
    straight, bent = two * bend[0] * inverse, angle - rest
    mixed, along = two * bend[0] * bent * slope, bend[0] * bent * bent * curve
    if along * straight < mixed * mixed:  # only below the merging distance
        along += (mixed * mixed / straight - along) * (one - exact)
    side = straight * (turn_over_sine(angle, sine) - over_sine(rest, sine))
    aa, ab, bb = angle_blocks(p, q, z, by_a, by_b, straight * bent, side, straight, exact)
    if sine <= type(sine)(NO_SINE):
        mixed = zero * mixed  # a straight yarn has no direction in which its angle grows
    # the leg before is -a, and the span grows with the coordinate after and shrinks with the coordinate before
    by_before, by_after = lifted(wp.cross(z, p) * by_a), lifted(wp.cross(z, q) * by_b)
    span = wp.vector(zero, zero, zero, one)
    along_span = wp.outer(span, span) * along
    of_before = aa + along_span - paired(by_before, span) * mixed
    of_after = bb + along_span + paired(by_after, span) * mixed
    of_both = (wp.outer(by_before, span) - wp.outer(span, by_after)) * mixed - ab - along_span
    return of_before, of_both, of_after
