# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Optional first and last stitches: yarn-overs as a cast-on, and the chain bind-off of hand knitting.

In a chain bind-off each loop of the last row is knitted, and the bound-off loop before it is passed over the new one.
Every bound-off loop lies along the edge, comes through the loop below it and is held by the next one. Three strands
therefore cross between two stitches: the yarn, at a ninth of the height, and the two legs of a bound-off loop. The
first of these legs passes in front, the second behind. No loop is passed over the first loop; the yarn itself is drawn
through the last loop.

The default first and last stitches are the backward-loop cast-on, and a yarn drawn through the last loops. A backward
loop is a yarn-over whose legs cross, so that it does not open although there is no row below (Yuksel et al. 2012,
section 4.3, y with a twisted top). The loops of the last row are held by a yarn that runs behind the left leg and in
front of the right leg of each loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

import numpy as np
from scipy.interpolate import CubicSpline

from stitchmesh.yarngen.templates.plain import HEIGHT_FADE, HEIGHT_IN_RADII, knit
from stitchmesh.yarngen.templates.template import (
    CURVE_POINTS,
    STITCH_HEIGHT,
    Crossing,
    Template,
    TemplatePart,
    bottom,
    centripetal_parameters,
    crossing_point,
    left_wale,
    mirrored,
    right_wale,
    spline_part,
    top,
    trapezoid,
    twisted,
)

THREAD_WAYPOINTS = ((0.09, 0.15, -1.7), (0.5, 0.44, 0.0), (0.91, 0.15, 1.7))
"""Waypoints of the drawn-through yarn in one loop: position across the column, height over the height of the face, and
height in yarn radii."""
CROSSED_WAYPOINTS = ((0.25, 0.14, 0.4), (0.62, 0.38, 1.0), (0.82, 0.70, 0.6))
"""Waypoints of the first leg of a backward loop, in the same coordinates. The second leg is the mirror image, behind
the first."""
Waypoints = Sequence[tuple[float, float, float]]
"""Waypoints (x, y, height): x and y in stitch widths, height in yarn radii."""

CHAIN_HEIGHT = 1.7
"""Height of a face of the chain over the height of a plain stitch; its loops stand above the head below."""
FRONT_SLOT, BACK_SLOT = 1, 2
"""Slots of a wale side at which the front and the back leg of a bound-off loop cross it."""
RISING_WAYPOINTS: Waypoints = (
    (0.18, 0.2, -1.2), (0.37, 0.33, -0.3), (0.38, 0.52, 1.0), (0.43, 0.78, 0.7), (0.54, 1.01, 0.2), (0.75, 1.14, 0.8),
    (1.0, 1.13, 1.4),
)  # fmt: skip
"""The yarn from the stitch before, behind the fabric, and the first leg of the bound-off loop: up through the loop
below and the loop that is passed over it, and on to the next stitch in front."""
OVER_WAYPOINTS: Waypoints = (
    (0.0, 1.13, 1.4), (0.24, 1.07, 1.9), (0.48, 1.01, 2.3), (0.72, 0.95, 2.3), (0.93, 0.84, 1.8), (0.99, 0.73, 0.1),
    (0.92, 0.75, -1.7), (0.71, 0.84, -2.2), (0.47, 0.91, -1.9), (0.23, 0.96, -1.4), (0.0, 0.99, -0.7),
)  # fmt: skip
"""The bound-off loop of the stitch before, which is passed over the loop of this stitch."""
FALLING_WAYPOINTS: Waypoints = (
    (1.0, 0.99, -0.7), (0.79, 0.89, -0.1), (0.69, 0.7, 1.0), (0.64, 0.46, 1.1), (0.64, 0.31, -0.5), (0.83, 0.19, -1.2),
)  # fmt: skip
"""The second leg of the bound-off loop, which comes back from the next stitch behind, and the yarn on to that
stitch."""
DRAWN_WAYPOINTS: Waypoints = (
    *RISING_WAYPOINTS[:5], (0.68, 1.2, 0.9), (0.85, 1.2, 2.5), (1.02, 0.98, 3.7), (1.12, 0.6, 2.8), (1.12, 0.27, 1.2),
)  # fmt: skip
"""The yarn through the last loop, and in front of it down to the end of the row."""
YARN_OVER_WAYPOINTS = ((0.23, 0.18, -0.6), (0.364, 0.37, 0.0), (0.356, 0.66, 0.9))
"""The first leg of a yarn-over: position across its column, height over the height of the face, and height in yarn
radii. The second leg is the mirror image."""


def cast_on(n_bottom: int, n_top: int, twists: tuple[int, ...] = ()) -> Template:
    """Backward loops on every top side; no yarn crosses the bottom sides.

    Args:
        n_bottom: bottom sides of the face.
        n_top: top sides of the face.
        twists: half turns of the loops from left to right. At -1 the leg from the left lies behind, otherwise in front.
    """
    sign = [-1.0 if -1 in twists[loop : loop + 1] else 1.0 for loop in range(n_top)]
    n = (n_bottom, n_top)
    parts = []
    start: Crossing = left_wale(*n)
    for loop in range(n_top):
        rising = [
            column_waypoint(n, loop, n_top, u, v, h * sign[loop]) for u, v, h in CROSSED_WAYPOINTS[1 if loop else 0 :]
        ]
        falling = [(1.0 - u, v, -h * sign[loop - 1]) for u, v, h in CROSSED_WAYPOINTS[:0:-1]] if loop else []
        falling = [column_waypoint(n, loop - 1, n_top, *point) for point in falling]
        parts.append(spline_part(*n, start, top(*n, loop, 1), falling + rising))
        start = top(*n, loop, 0)
    last = [column_waypoint(n, n_top - 1, n_top, 1.0 - u, v, -h * sign[-1]) for u, v, h in CROSSED_WAYPOINTS[::-1]]
    parts.append(spline_part(*n, start, right_wale(n_bottom), last))
    return Template(*n, tuple(parts))


def draw_through(n_bottom: int, n_top: int) -> Template:
    """A yarn drawn through the heads of all bottom sides; no yarn crosses the top sides."""
    n = (n_bottom, n_top)
    heads = [_held_head(n, loop) for loop in range(n_bottom)]
    points = [column_waypoint(n, loop, n_bottom, *point) for loop in range(n_bottom) for point in THREAD_WAYPOINTS]
    thread = spline_part(*n, left_wale(*n), right_wale(n_bottom), points)
    return Template(*n, (*heads, thread))


def column_waypoint(
    n: tuple[int, int], loop: int, loops: int, u: float, v: float, height: float
) -> tuple[float, float, float]:
    """A waypoint from coordinates within the column of one loop, in a face that may narrow upwards.

    Args:
        n: numbers of bottom and top sides of the face.
        loop: number of the loop, from the left.
        loops: number of loops side by side in the face.
        u: position across the column, from 0 to 1.
        v: height over the height of the face, from 0 to 1.
        height: height in yarn radii.
    """
    corners = trapezoid(*n)
    left = corners[0, 0] + v * (corners[-1, 0] - corners[0, 0])
    right = corners[n[0], 0] + v * (corners[n[0] + 1, 0] - corners[n[0], 0])
    return left + (loop + u) / loops * (right - left), v, height


def _held_head(n: tuple[int, int], loop: int) -> TemplatePart:
    """The plain head, narrowed with its face.

    Its right leg lies behind at the place where the drawn-through yarn passes in front.
    """
    plain = next(part for part in knit().parts if part.is_head)
    u, v = plain.curve[:, 0], plain.curve[:, 1] / STITCH_HEIGHT
    share = np.linspace(0.0, 1.0, len(u))
    # Fraction of a held head over which its right leg, which lies behind, reaches height zero at the face below.
    height_factor = np.clip(np.minimum(share / HEIGHT_FADE, (1.0 - share) / 0.25), 0.0, 1.0)
    height = HEIGHT_IN_RADII * np.cos(np.pi * share) * np.sin(np.pi / 2 * height_factor)
    points = [column_waypoint(n, loop, n[0], *point) for point in zip(u, v, height, strict=True)]
    curve = np.array([(x, y * STITCH_HEIGHT, h) for x, y, h in points])
    return TemplatePart(bottom(loop, 0), bottom(loop, 1), curve, is_head=True)


class Edge(IntEnum):
    """Template of a face of the first or last row. The names with LEFTWARD are chains worked from right to left."""

    BY_STITCH = 0
    YARN_OVERS = 1
    CHAIN = 2
    CHAIN_FIRST = 3
    CHAIN_LAST = 4
    CHAIN_ALONE = 5
    LEFTWARD_CHAIN = 6
    LEFTWARD_FIRST = 7
    LEFTWARD_LAST = 8


def edge_template(edge: Edge, n_bottom: int, n_top: int, twists: tuple[int, ...]) -> Template:
    """The yarn of a face of the first or last row that does not use the template of its stitch.

    Args:
        edge: which template.
        n_bottom: bottom sides of the face; one for a chain.
        n_top: top sides of the face; one for a chain.
        twists: half turns of the loops on top, from left to right; loops beyond the end of the tuple have none.
    """
    if edge == Edge.YARN_OVERS:
        return twisted(yarn_overs(n_bottom, n_top), twists)
    if edge == Edge.CHAIN_ALONE:
        return chain(first=True, last=True)
    is_first = edge in (Edge.CHAIN_FIRST, Edge.LEFTWARD_FIRST)
    shape = chain(first=is_first, last=edge in (Edge.CHAIN_LAST, Edge.LEFTWARD_LAST))
    return mirrored(shape) if edge >= Edge.LEFTWARD_CHAIN else shape


def yarn_overs(n_bottom: int, n_top: int) -> Template:
    """Yarn-overs on every top side; no yarn crosses the bottom sides."""
    n = (n_bottom, n_top)
    parts = []
    start: Crossing = left_wale(*n)
    for loop in range(n_top):
        first_leg = [column_waypoint(n, loop, n_top, *point) for point in YARN_OVER_WAYPOINTS]
        parts.append(spline_part(*n, start, top(*n, loop, 0), [*_second_leg(n, loop - 1), *first_leg]))
        start = top(*n, loop, 1)
    parts.append(spline_part(*n, start, right_wale(n_bottom), _second_leg(n, n_top - 1)))
    return Template(*n, tuple(parts))


def _second_leg(n: tuple[int, int], loop: int) -> list[tuple[float, float, float]]:
    """Waypoints of the second leg of a yarn-over; empty for a negative loop number."""
    return [column_waypoint(n, loop, n[1], 1.0 - u, v, h) for u, v, h in YARN_OVER_WAYPOINTS[::-1]] if loop >= 0 else []


def chain(*, first: bool = False, last: bool = False) -> Template:
    """One stitch of a chain bind-off, worked from left to right.

    Args:
        first: whether the stitch is the first of the chain, over which no loop is passed.
        last: whether the stitch is the last of the chain, through which the yarn is drawn.
    """
    head = next(part for part in knit().parts if part.is_head)
    parts = [TemplatePart(bottom(0, 0), bottom(0, 1), head.curve / [1.0, CHAIN_HEIGHT, 1.0], is_head=True)]
    left, right = left_wale(1, 1), right_wale(1)
    if not first:
        parts.append(
            _part_through(
                Crossing(left.place, FRONT_SLOT), Crossing(left.place, BACK_SLOT), OVER_WAYPOINTS, is_head=True
            )
        )
    if last:
        parts.append(_part_through(left, right, (_foot(left), *DRAWN_WAYPOINTS, _foot(right))))
    else:
        parts.append(_part_through(left, Crossing(right.place, FRONT_SLOT), (_foot(left), *RISING_WAYPOINTS)))
        parts.append(_part_through(Crossing(right.place, BACK_SLOT), right, (*FALLING_WAYPOINTS, _foot(right))))
    return Template(1, 1, tuple(parts))


def _foot(wale: Crossing) -> tuple[float, float, float]:
    """Waypoint at which the foot of a loop crosses a wale side, in the proportions of a face of the chain."""
    x, y, _ = crossing_point(1, 1, wale)
    return x, y * CHAIN_HEIGHT, 0.0


def _part_through(start: Crossing, end: Crossing, waypoints: Waypoints, *, is_head: bool = False) -> TemplatePart:
    """A part along a natural cubic spline through waypoints; the first and the last waypoint are its ends."""
    points = np.array(waypoints)
    places = centripetal_parameters(points)
    curve = CubicSpline(places, points, bc_type="natural")(np.linspace(0.0, places[-1], CURVE_POINTS))
    return TemplatePart(start, end, curve / [1.0, CHAIN_HEIGHT, 1.0], is_head)
