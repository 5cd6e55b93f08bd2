# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes of any size for the benchmarks: tubes of plain knit that a formula generates (Crane 2023)."""

from __future__ import annotations

import numpy as np

from stitchmesh.yarn import YarnSet

FORMULA_RADIUS, ROW_HEIGHT, STITCH_WIDTH = 0.78, 4.5, 2 * np.pi
"""Yarn radius, course spacing and wale spacing of rows of (t + 1.5 sin 2t, 4 cos t, cos 2t)."""


def stockinette_tube(rows: int, stitches: int, points_per_stitch: int, radius: float = 0.125) -> YarnSet:
    """Closed rows of plain knit around the y axis, knit side out; control points at equal arc length."""
    t = np.linspace(0.0, 2 * np.pi, 4001)
    curve = np.stack([t + 1.5 * np.sin(2 * t), 4 * np.cos(t), np.cos(2 * t)], axis=1)
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    place = np.arange(points_per_stitch) / points_per_stitch * arc[-1]
    one = np.stack([np.interp(place, arc, axis) for axis in curve.T], axis=1)
    number = np.repeat(np.arange(stitches), points_per_stitch)
    flat = np.tile(one, (stitches, 1)) + number[:, None] * [STITCH_WIDTH, 0.0, 0.0]
    around = stitches * STITCH_WIDTH / (2 * np.pi)
    angle, out = flat[:, 0] / around, around + flat[:, 2]
    ring = np.stack([out * np.sin(angle), flat[:, 1], out * np.cos(angle)], axis=1)
    ring -= np.diff(np.concatenate([ring[-1:], ring, ring[:1]]), 2, axis=0) / 6  # control points from curve points
    scale = radius / FORMULA_RADIUS
    rings = [scale * (ring + np.array([0.0, ROW_HEIGHT * row, 0.0])) for row in range(rows)]
    return YarnSet.from_curves(rings, closed=[True] * rows, radius=radius)
