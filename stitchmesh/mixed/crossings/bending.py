# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bending of a yarn at a crossing node (Cirio et al. 2014, section 4.3).

    E = k_b (t - r)^2 / D

t is the angle by which the yarn turns at the node, r the same angle at rest, and D = u2 - u1 the rest length of yarn
from the node before to the node after. The node stands for the length D / 2, over which the curvature is 2 t / D, and
1/2 EI (2 t / D)^2 D / 2 = EI t^2 / D: the flexural rigidity is EI = k_b = B pi R^2.

Rest angles are those of the centre lines in the plane in which a fabric is laid out: zero for the straight yarns of a
weave, whose crimp the planar nodes do not show, and the turns of the loops in a knit. Yield changes them
(``bending_yield``). The angle has no sign: where r is not zero, a yarn may fold to either side, over a straight state of
energy k_b r^2 / D.

The energy is convex in (t, D). Below the merging distance of the two segments 1 / D is replaced by i(D) (``merging``).
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.mixed.crossings.angle import angle_frame, angle_of, angle_product, over_sine
from stitchmesh.mixed.crossings.merging import guarded_inverse


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
    """t / sin t, which is 1 for a straight yarn."""
    result = over_sine(turn, sine)
    if sine < type(sine)(0.01) and turn < type(turn)(1.0):
        result = type(turn)(1.0) + turn * turn / type(turn)(6.0)  # exact to t^4, where a quotient of rounded numbers is not
    return result


@wp.func
def bending_product(
    before: Any, after: Any, d_before: Any, d_after: Any, rest: Any, span: Any, d_span: Any, merging: Any,
    stiffness: Any, exact: Any,
) -> tuple[Any, Any, Any]:  # fmt: skip
    """Product of the Hessian with the directions of the segments before and after and of D; parts of these three."""
    two = type(rest)(2.0)
    inverse, slope, bend = guarded_inverse(span, merging)
    turn = angle_of(before, after)
    _p, _q, _z, sine = angle_frame(before, after)
    bent = turn - rest
    mixed = two * stiffness * bent * slope
    along = stiffness * bent * bent * bend
    straight = two * stiffness * inverse
    if along * straight < mixed * mixed:  # only below the merging distance
        along += (mixed * mixed / straight - along) * (type(exact)(1.0) - exact)
    side = straight * (turn_over_sine(turn, sine) - over_sine(rest, sine))
    curvatures = type(before)(straight, mixed, along)
    return angle_product(before, after, d_before, d_after, d_span, straight * bent, side, curvatures, exact)
