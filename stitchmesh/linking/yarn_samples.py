# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Points of B-spline yarns in the coordinates of a projection, rounded to whole units on the device."""

from __future__ import annotations

import warp as wp

from stitchmesh.compute.kernel import kernel


@wp.struct
class Curves:
    """B-spline yarns in the coordinates of a projection."""

    points: wp.array[wp.vec3d]
    """Control points [cm], shape (N,)."""
    start: wp.array[wp.int32]
    """Where each yarn's control points start, shape (Y + 1,)."""
    segment_start: wp.array[wp.int32]
    """Where each yarn's segments start, shape (Y + 1,)."""
    shift: wp.array[wp.vec3d]
    """Displacement from each yarn's first control point to the one after its last [cm]; zero without a lattice."""
    scale: wp.array[wp.vec3d]
    """Units per cm along each axis in the projection of each yarn, shape (Y,)."""


@wp.func
def corner(curves: Curves, yarn: int, place: int) -> wp.vec3d:
    """Control point at a place along a yarn; places continue beyond the seam of a closed yarn."""
    count = curves.start[yarn + 1] - curves.start[yarn]
    turns = place / count
    return curves.points[curves.start[yarn] + place - turns * count] + curves.shift[yarn] * wp.float64(turns)


@wp.func
def whole_point(curves: Curves, yarn: int, place: int, s: wp.float64) -> wp.vec3d:
    """Point at parameter s of the segment at a place along a yarn, rounded to whole units."""
    one, three, four, t = wp.float64(1.0), wp.float64(3.0), wp.float64(4.0), wp.float64(1.0) - s
    point = t * t * t * corner(curves, yarn, place)
    point += (three * s * s * (s - wp.float64(2.0)) + four) * corner(curves, yarn, place + 1)
    point += (three * s * (one + s * t) + one) * corner(curves, yarn, place + 2)
    point += s * s * s * corner(curves, yarn, place + 3)
    point = wp.cw_mul(point, curves.scale[yarn]) / wp.float64(6.0)
    return wp.vec3d(wp.rint(point[0]), wp.rint(point[1]), wp.rint(point[2]))


@kernel
def measure_segments(
    # state in
    curves: Curves,
    # state out
    size: wp.array[wp.float64],
) -> None:
    """Largest step between a segment's control points along an axis [cm], which bounds its derivative."""
    s = wp.tid()
    yarn = wp.lower_bound(curves.segment_start, s + 1) - 1
    place = s - curves.segment_start[yarn]
    largest = wp.float64(0.0)
    for k in range(3):
        leg = corner(curves, yarn, place + k + 1) - corner(curves, yarn, place + k)
        largest = wp.max(largest, wp.max(wp.abs(leg)))
    size[s] = largest


@kernel
def sample_segments(
    # model
    segment_edge: wp.array[wp.int32],
    # state in
    curves: Curves,
    # state out
    vertices: wp.array[wp.vec3d],
    edge_yarn: wp.array[wp.int32],
) -> None:
    """First vertex and yarn of each of a segment's edges."""
    s = wp.tid()
    yarn = wp.lower_bound(curves.segment_start, s + 1) - 1
    first = segment_edge[s]
    count = segment_edge[s + 1] - first
    for k in range(count):
        along = wp.float64(k) / wp.float64(count)
        vertices[first + k + yarn] = whole_point(curves, yarn, s - curves.segment_start[yarn], along)
        edge_yarn[first + k] = yarn


@kernel
def end_yarns(
    # model
    yarn_edge: wp.array[wp.int32],
    closed: wp.array[wp.bool],
    step: wp.array[wp.vec2i],
    period: wp.array[wp.vec2d],
    # state in
    curves: Curves,
    # state out
    vertices: wp.array[wp.vec3d],
) -> None:
    """Last vertex of each yarn: the image of the first vertex for a closed yarn, the end for an open one."""
    yarn = wp.tid()
    last = yarn_edge[yarn + 1] + yarn
    if closed[yarn]:
        x = period[yarn][0] * wp.float64(step[yarn][0])
        y = period[yarn][1] * wp.float64(step[yarn][1])
        vertices[last] = vertices[yarn_edge[yarn] + yarn] + wp.vec3d(x, y, wp.float64(0.0))
    else:
        final = curves.segment_start[yarn + 1] - curves.segment_start[yarn] - 1
        vertices[last] = whole_point(curves, yarn, final, wp.float64(1.0))
