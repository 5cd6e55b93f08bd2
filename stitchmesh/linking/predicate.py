# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Whether two edges cross in the projection, and with which sign: the exact rule of all linking numbers.

Edges ab and cd cross if c and d lie on different sides of the line ab, and a and b on different sides of the line cd. A
crossing is positive if a turn to the left, by less than half a turn, takes the direction of the upper strand to the
direction of the lower one. Its sign is the sign of the volume

    -((b - a) x (d - c)) . (c - a)

All coordinates are whole numbers, so that no sign is rounded.

If curves meet in a point, or a vertex lies above an edge or another vertex, the later curve counts as displaced by
(e, e^2, e^3) relative to the earlier one, with an infinitesimal e (simulation of simplicity, Edelsbrunner and Muecke
1990). Every answer is therefore valid for two polylines in general position, each displaced as a whole. In particular,
closed polylines cross an even number of times. Of two copies of one yarn, a rule that does not depend on where they
meet says which is the later one. The rule cannot decide between a copy and the copy half a step farther. Only in this
case, and only for coordinates that agree to the last unit, a crossing may be decided wrongly.
"""

from __future__ import annotations

import warp as wp

EDGE = 2**19
"""Longest edge along each axis [units]; the volume of two edges and their distance then fit 63 bits."""
APART = wp.constant(wp.float64(4 * EDGE))
"""If the heights of two edges differ by more than this [units], one lies above the other whatever their slopes."""
SURE = wp.constant(wp.float64(2.0**61))
"""A larger cross product has the sign of its float64 estimate, and a smaller one fits 64 bits."""


@wp.func
def is_left(direction: wp.vec3d, product: wp.float64, later: wp.float64) -> bool:
    """Whether a point lies left of a line, from its cross product; ``later`` is 1 if its curve is later, else -1."""
    if product != wp.float64(0.0):
        return product > wp.float64(0.0)
    if direction[1] != wp.float64(0.0):
        return direction[1] * later < wp.float64(0.0)
    return direction[0] * later > wp.float64(0.0)


@wp.func
def lies_left(tail: wp.vec3d, head: wp.vec3d, point: wp.vec3d, later: wp.float64) -> bool:
    """Whether a point lies left of a near edge; float64 holds the products exactly."""
    direction = head - tail
    return is_left(direction, direction[0] * (point[1] - tail[1]) - direction[1] * (point[0] - tail[0]), later)


@wp.func
def edges_cross(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d, d: wp.vec3d, later: wp.float64) -> bool:
    """Whether near edges ab and cd cross in the projection; ``later`` is 1 if the curve of cd is later, else -1."""
    if lies_left(a, b, c, later) == lies_left(a, b, d, later):
        return False
    return lies_left(c, d, a, -later) != lies_left(c, d, b, -later)


@wp.func
def crossing_is_positive(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d, d: wp.vec3d, later: wp.float64) -> bool:
    """Sign of the crossing of edges ab and cd."""
    normal = wp.cross(b - a, d - c)
    apart = c - a
    # a height above the slopes of both edges does not change the sign
    height = wp.clamp(apart[2], -APART, APART)
    volume = wp.int64(normal[0]) * wp.int64(apart[0]) + wp.int64(normal[1]) * wp.int64(apart[1])
    volume += wp.int64(normal[2]) * wp.int64(height)
    if volume != wp.int64(0):
        return volume < wp.int64(0)
    for axis in range(3):
        if normal[axis] != wp.float64(0.0):
            return normal[axis] * later < wp.float64(0.0)
    return False  # not reached: the edges of a crossing are not parallel


@wp.func
def later_copy(image: wp.vec2i, step: wp.vec2i) -> int:
    """1 where the copy of a yarn in an image counts as later than the yarn, -1 as earlier, 0 where it is the yarn."""
    turn = step[0] * image[1] - step[1] * image[0]
    if turn != 0:
        return wp.sign(turn)
    length = step[0] * step[0] + step[1] * step[1]
    if length == 0:
        return wp.where(image[0] != 0, wp.sign(image[0]), wp.where(image[1] != 0, wp.sign(image[1]), 0))
    along = (step[0] * image[0] + step[1] * image[1]) % length
    if along < 0:
        along += length
    return wp.where(along == 0, 0, wp.where(2 * along < length, 1, -1))


@wp.func
def cross_product(p: wp.vec3d, q: wp.vec3d) -> wp.float64:
    """Cross product of whole vectors of any length in the projection, with an exact sign."""
    estimate = p[0] * q[1] - p[1] * q[0]
    if wp.abs(estimate) > SURE:
        return estimate
    # the exact value fits 64 bits, so overflows of the two products cancel
    first = wp.uint64(wp.int64(p[0])) * wp.uint64(wp.int64(q[1]))
    second = wp.uint64(wp.int64(p[1])) * wp.uint64(wp.int64(q[0]))
    return wp.float64(wp.int64(first - second))
