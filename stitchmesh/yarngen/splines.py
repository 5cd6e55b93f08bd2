# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""B-spline control points of yarns that pass through given points.

At its knots a uniform cubic B-spline passes through (q_(i-1) + 4 q_i + q_(i+1)) / 6; solving for q is a tridiagonal
system, which Richardson iteration solves for all yarns at once: its error shrinks by 2/3 a turn.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray

TURNS = 45
"""(2/3)^45 = 1e-8: control points to a ten-millionth of their spacing."""


def control_points_through(
    points: FloatArray, start: IntArray, closed: np.ndarray, step: FloatArray
) -> FloatArray:
    """Control points [cm] of splines through ``points``, shape (N, 3); ends of open yarns stay where they are.

    Args:
        points: what the yarns pass through [cm], shape (N, 3).
        start: where each yarn's points start, shape (Y + 1,).
        closed: whether each yarn is closed, shape (Y,).
        step: from each closed yarn's first point to where it goes on after its last [cm], zero where it ends where it
            begins, shape (Y, 3).
    """
    counts = np.diff(start)
    yarn = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(points)) - start[:-1][yarn]
    before = start[:-1][yarn] + (place - 1) % counts[yarn]
    after = start[:-1][yarn] + (place + 1) % counts[yarn]
    inner = (closed[yarn] | ((place > 0) & (place < counts[yarn] - 1)))[:, None]
    beyond = (place == counts[yarn] - 1).astype(np.float64) - (place == 0)  # the neighbours a step away
    knots = points - beyond[:, None] * step[yarn] / 6.0
    control = points.copy()
    for _ in range(TURNS):
        at_knots = (control[before] + 4.0 * control + control[after]) / 6.0
        control += np.where(inner, knots - at_knots, 0.0)
    return control
