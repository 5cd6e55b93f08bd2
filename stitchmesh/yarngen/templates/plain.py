# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knit: the plain loop (t + 1.5 sin 2t, 4 cos t, cos 2t) with rows 4.5 apart (Crane 2023).

The loop is 2 pi wide, so all lengths are divided by 2 pi. A face holds three parts: the head of the lower row, with t
from -pi/2 to pi/2; the left foot of its own row, with t from -pi to -pi/2; and the right foot, the mirror image of the
left one. The third coordinate of the curve points to the wrong side of knit fabric. Heights fade to zero close to the
crossings of the sides, so that the four places where the two rows cross keep their full separation.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.yarngen.templates.template import (
    CURVE_POINTS,
    RADIUS_OVER_WIDTH,
    STITCH_HEIGHT,
    Template,
    TemplatePart,
    bottom,
    left_wale,
    right_wale,
    top,
)

LOOP_WIDTH = 2 * np.pi
"""Width of the loop in the units of the formula."""
HEIGHT_IN_RADII = 1.0 / (LOOP_WIDTH * RADIUS_OVER_WIDTH)
"""Unit of the third coordinate of the formula, in yarn radii."""
HEIGHT_FADE = 0.16
"""Fraction of the parameter range of a part, from each end, over which the height fades to zero."""


def knit() -> Template:
    """The knit stitch: a loop pulled through the loop below from the wrong side to the right side."""
    over = _plain(-np.pi / 2, np.pi / 2, 0.0, HEIGHT_FADE / 2)
    rising = _plain(-np.pi, -np.pi / 2, STITCH_HEIGHT, HEIGHT_FADE)
    falling = _plain(np.pi / 2, np.pi, STITCH_HEIGHT, HEIGHT_FADE)
    head = TemplatePart(bottom(0, 0), bottom(0, 1), over, is_head=True)
    left = TemplatePart(left_wale(1, 1), top(1, 1, 0, 0), rising, is_head=False)
    right = TemplatePart(top(1, 1, 0, 1), right_wale(1), falling, is_head=False)
    return Template(1, 1, (head, left, right))


def _plain(first: float, last: float, shift_up: float, fade: float) -> FloatArray:
    """Points (x, y, height) of the plain loop between two parameters, shape (CURVE_POINTS, 3).

    Args:
        first: parameter t at the first point.
        last: parameter t at the last point.
        shift_up: distance by which the curve is moved up [stitch widths].
        fade: fraction of the parameter range, from each end, over which the height fades to zero.
    """
    t = np.linspace(first, last, CURVE_POINTS)
    share = np.linspace(0.0, 1.0, CURVE_POINTS)
    height_factor = np.clip(np.minimum(share, 1.0 - share) / fade, 0.0, 1.0)
    x = (t + 1.5 * np.sin(2 * t)) / LOOP_WIDTH + 0.5
    y = 4 * np.cos(t) / LOOP_WIDTH + shift_up
    height = -np.cos(2 * t) * HEIGHT_IN_RADII * np.sin(np.pi / 2 * height_factor)
    return np.stack([x, y, height], axis=1)
