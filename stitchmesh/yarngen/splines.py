# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""B-spline control points of yarns that pass through given points.

At its knots a uniform cubic B-spline passes through (q_(i-1) + 4 q_i + q_(i+1)) / 6. The control points q solve this
tridiagonal system. Richardson iteration solves it for all yarns at once; each iteration reduces the error to two
thirds.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray


def control_points_through(points: FloatArray, start: IntArray, closed: np.ndarray, step: FloatArray) -> FloatArray:
    """Control points [cm] of B-splines through given points, shape (N, 3).

    The first and the last control point of an open yarn are its first and its last point.

    Args:
        points: the points through which the yarns pass [cm], shape (N, 3).
        start: index of the first point of each yarn, shape (Y + 1,).
        closed: whether each yarn is closed, shape (Y,).
        step: for each closed yarn the vector from its first point to the image of that point at which the yarn
            continues after its last point [cm], shape (Y, 3); zero where the yarn ends where it begins.
    """
    counts = np.diff(start)
    yarn = np.repeat(np.arange(len(counts)), counts)
    index = np.arange(len(points)) - start[:-1][yarn]
    before = start[:-1][yarn] + (index - 1) % counts[yarn]
    after = start[:-1][yarn] + (index + 1) % counts[yarn]
    is_solved = (closed[yarn] | ((index > 0) & (index < counts[yarn] - 1)))[:, None]
    # 1 or -1 where a neighbour lies in another period
    period_offset = (index == counts[yarn] - 1).astype(np.float64) - (index == 0)
    knots = points - period_offset[:, None] * step[yarn] / 6.0
    control = points.copy()
    # Number of iterations. (2/3)^45 = 1e-8, so the error of the control points is less than a ten-millionth of
    # their spacing.
    for _ in range(45):
        at_knots = (control[before] + 4.0 * control + control[after]) / 6.0
        control += np.where(is_solved, knots - at_knots, 0.0)
    return control
