# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""B-spline control points of yarns that pass through given points.

At its knots a uniform cubic B-spline passes through (q_(i-1) + 4 q_i + q_(i+1)) / 6. The control points q solve this
tridiagonal system. The systems of all yarns are solved as one. In that of a closed yarn the first and the last equation
have a third unknown; with these two entries moved to the diagonal the matrix A stays tridiagonal, and the sum of A and
one outer product is the matrix of the yarn (Sherman and Morrison).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_banded

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
    first, last, ring = start[:-1], start[1:] - 1, np.flatnonzero(closed)
    before, diagonal, after = (np.full(len(points), value) for value in (1.0, 4.0, 1.0))
    before[first] = after[last] = 0.0
    open_ends = np.concatenate([first[~closed], last[~closed]])
    before[open_ends] = after[open_ends] = 0.0
    diagonal[open_ends] = 6.0
    knots = 6.0 * points
    # A neighbour in another period is an unknown of this period and the step.
    knots[first[ring]] += step[ring]
    knots[last[ring]] -= step[ring]
    # The outer product of (1, 0, ..., 0, 1) with itself, times one, holds the entries of the corners.
    diagonal[first[ring]] -= 1.0
    diagonal[last[ring]] -= 1.0
    corners = np.zeros(len(points))
    corners[first[ring]] = corners[last[ring]] = 1.0
    bands = np.stack([np.roll(after, 1), diagonal, np.roll(before, -1)])
    solved = solve_banded((1, 1), bands, np.column_stack([knots, corners]), overwrite_b=True, check_finite=False)
    control, along = solved[:, :3], solved[:, 3]
    factor = np.zeros((len(closed), 3))
    at_corners = control[first[ring]] + control[last[ring]]
    factor[ring] = at_corners / (1.0 + along[first[ring]] + along[last[ring]])[:, None]
    return np.ascontiguousarray(control - along[:, None] * np.repeat(factor, np.diff(start), axis=0))
