# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Default first and last stitches: the backward-loop cast-on, and a yarn drawn through the last loops.

A backward loop is a yarn-over whose legs cross, so that it does not open although there is no row below (Yuksel et al.
2012, section 4.3, y with a twisted top). The loops of the last row are held by a yarn that runs behind the left leg and
in front of the right leg of each loop.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.yarngen.templates.plain import HEIGHT_FADE, HEIGHT_IN_RADII, knit
from stitchmesh.yarngen.templates.template import (
    STITCH_HEIGHT,
    Crossing,
    Template,
    TemplatePart,
    bottom,
    left_wale,
    right_wale,
    spline_part,
    top,
    trapezoid,
)

THREAD_WAYPOINTS = ((0.09, 0.15, -1.7), (0.5, 0.44, 0.0), (0.91, 0.15, 1.7))
"""Waypoints of the drawn-through yarn in one loop: position across the column, height over that of the face, and height
in yarn radii."""
SLOW_HEIGHT_FADE = 0.25
"""Fraction of a held head over which its right leg, which lies behind, reaches height zero at the face below."""
CROSSED_WAYPOINTS = ((0.25, 0.14, 0.4), (0.62, 0.38, 1.0), (0.82, 0.70, 0.6))
"""Waypoints of the first leg of a backward loop, in the same coordinates. The second leg is the mirror image, behind
the first."""


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
        v: height over that of the face, from 0 to 1.
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
    height_factor = np.clip(np.minimum(share / HEIGHT_FADE, (1.0 - share) / SLOW_HEIGHT_FADE), 0.0, 1.0)
    height = HEIGHT_IN_RADII * np.cos(np.pi * share) * np.sin(np.pi / 2 * height_factor)
    points = [column_waypoint(n, loop, n[0], *point) for point in zip(u, v, height, strict=True)]
    curve = np.array([(x, y * STITCH_HEIGHT, h) for x, y, h in points])
    return TemplatePart(bottom(loop, 0), bottom(loop, 1), curve, is_head=True)
