# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The rotation of a frame that is transported along a yarn without twist: the holonomy of the centreline.

The yarn is represented by the polyline through its knots. The chord of this polyline over a segment with legs d0, d1,
d2 is (d0 + 4 d1 + d2) / 6. From chord to chord a frame turns by the smallest rotation (Bergou 2008, section 4.2). For
unit directions a, b this is the quaternion

    r = (1 + a . b, a x b) / |...|

Along a closed yarn, the frame returns to the first chord, rotated about this chord by psi. An open yarn has one more
chord at each end, in the direction of its clamp; a fixed rotation from the last clamp to the first closes the loop. In
both cases R = r_n ... r_2 r_1 is a rotation about the first chord, and psi = 2 atan2(R_vector . chord, R_scalar). The
formula gives psi up to multiples of 4 pi; the value nearest to the previous one is chosen.

When chords turn, psi changes by the curvature binormals k = 2 a x b / (1 + a . b) at the two corners of each chord
(Bergou 2008, eqs 9 and 10). This is exact also for large turns:

    d psi / d chord = -(k_before + k_after) / (2 |chord|)

The rotations of a long yarn are multiplied within strands of about the square root of their number, and then strand by
strand, always in the same order, in double precision.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.yarnrelax.model.spline import segment_corners


@wp.func
def direction_of(chord: Any) -> Any:
    """Direction of a chord in double precision."""
    return wp.normalize(wp.vec3d(wp.float64(chord[0]), wp.float64(chord[1]), wp.float64(chord[2])))


@wp.func
def turn_between(first: wp.vec3d, second: wp.vec3d) -> wp.quatd:
    """Smallest rotation that takes one unit vector to another; none where they are opposite."""
    axis = wp.cross(first, second)
    scalar = wp.max(wp.float64(1.0) + wp.dot(first, second), wp.float64(1.0e-12))
    return wp.normalize(wp.quatd(axis[0], axis[1], axis[2], scalar))


@wp.func
def binormal(first: Any, second: Any) -> Any:
    """Curvature binormal of the corner between two chords."""
    size = wp.length(first) * wp.length(second)
    bottom = wp.max(size + wp.dot(first, second), size * type(size)(1.0e-3))
    return wp.cross(first, second) * (type(size)(2.0) / bottom)


@kernel
def find_chords(
    # model
    model: Any,
    # state in
    points: wp.array[Any],
    # state out
    chord: wp.array[Any],
) -> None:
    """From knot to knot along each segment."""
    s = wp.tid()
    q0, q1, q2, q3 = segment_corners(model, points, s)
    third = type(q0[0])(3.0)
    chord[s] = (q3 - q0 + (q2 - q1) * third) / type(third)(6.0)


@kernel
def multiply_strands(
    # model
    strand_start: wp.array[wp.int32],
    before: wp.array[wp.int32],
    # state in
    chord: wp.array[Any],
    # state out
    strand_turn: wp.array[wp.quatd],
) -> None:
    """Product of the rotations at the beginnings of a strand's segments."""
    strand = wp.tid()
    first, last = strand_start[strand], strand_start[strand + 1]
    here = direction_of(chord[before[first]])
    product = wp.quatd(wp.float64(0.0), wp.float64(0.0), wp.float64(0.0), wp.float64(1.0))
    for s in range(first, last):
        following = direction_of(chord[s])
        product = turn_between(here, following) * product
        here = following
    strand_turn[strand] = wp.normalize(product)


@kernel
def total_holonomy(
    # model
    yarn_strand: wp.array[wp.int32],
    yarn_start: wp.array[wp.int32],
    before: wp.array[wp.int32],
    after: wp.array[wp.int32],
    closing: wp.array[wp.quatd],
    # state in
    chord: wp.array[Any],
    strand_turn: wp.array[wp.quatd],
    # state out
    holonomy: wp.array[wp.float64],
) -> None:
    """The angle psi of each yarn, next to the one that it had."""
    y = wp.tid()
    product = wp.quatd(wp.float64(0.0), wp.float64(0.0), wp.float64(0.0), wp.float64(1.0))
    for strand in range(yarn_strand[y], yarn_strand[y + 1]):
        product = strand_turn[strand] * product
    last = yarn_start[y + 1] - 1
    start = direction_of(chord[before[yarn_start[y]]])
    if before[yarn_start[y]] != last:  # an open yarn turns once more, into its clamp
        product = turn_between(direction_of(chord[last]), direction_of(chord[after[last]])) * product
    product = closing[y] * product
    along = product[0] * start[0] + product[1] * start[1] + product[2] * start[2]
    angle = wp.float64(2.0) * wp.atan2(along, product[3])
    period = wp.float64(4.0 * 3.141592653589793)
    holonomy[y] = angle + period * wp.round((holonomy[y] - angle) / period)
