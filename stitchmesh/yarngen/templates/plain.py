# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knit and purl: the plain loop (t + 1.5 sin 2t, 4 cos t, cos 2t), rows 4.5 apart (Crane 2023).

A loop is 2 pi wide, so lengths are divided by that. A face holds the lower row's head, t from -pi/2 to pi/2, and of
its own row the left foot, t from -pi to -pi/2, and the right foot, its mirror image. The curve's third coordinate
points to the wrong side of knit fabric. Heights are brought to zero at the crossings within a short way, so that
the four places where the two rows cross keep their full separation.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.yarngen.templates.template import (
    CURVE_POINTS,
    RADIUS_OVER_WIDTH,
    STITCH_HEIGHT,
    Part,
    Template,
    bottom,
    left_wale,
    right_wale,
    top,
    turned_over,
)

LOOP_WIDTH = 2 * np.pi
HEIGHT_IN_RADII = 1.0 / (LOOP_WIDTH * RADIUS_OVER_WIDTH)
"""The loop's unit of depth, in yarn radii."""
HEIGHT_FADE = 0.16
"""Share of a part's parameter range, from its end, within which the height falls to zero."""


def knit() -> Template:
    """A loop pulled through the loop below from the wrong side to the right side."""
    head = Part(bottom(0, 0), bottom(0, 1), _plain(-np.pi / 2, np.pi / 2, 0.0, HEIGHT_FADE / 2), is_head=True)
    left = Part(left_wale(1, 1), top(1, 1, 0, 0), _plain(-np.pi, -np.pi / 2, STITCH_HEIGHT, HEIGHT_FADE), is_head=False)
    right = Part(top(1, 1, 0, 1), right_wale(1), _plain(np.pi / 2, np.pi, STITCH_HEIGHT, HEIGHT_FADE), is_head=False)
    return Template(1, 1, (head, left, right))


def purl() -> Template:
    """A loop pulled through the loop below from the right side to the wrong side."""
    return turned_over(knit())


def _plain(first: float, last: float, shift_up: float, fade: float) -> FloatArray:
    """Points of the loop between two parameters, centred on a face, heights zero at both ends."""
    t = np.linspace(first, last, CURVE_POINTS)
    share = np.linspace(0.0, 1.0, CURVE_POINTS)
    height_factor = np.clip(np.minimum(share, 1.0 - share) / fade, 0.0, 1.0)
    x = (t + 1.5 * np.sin(2 * t)) / LOOP_WIDTH + 0.5
    y = 4 * np.cos(t) / LOOP_WIDTH + shift_up
    height = -np.cos(2 * t) * HEIGHT_IN_RADII * np.sin(np.pi / 2 * height_factor)
    return np.stack([x, y, height], axis=1)
