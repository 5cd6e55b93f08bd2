# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One segment of a uniform cubic B-spline, written in the three legs between its four control points.

With legs d0, d1, d2 the derivatives by the parameter s in [0, 1] are convex combinations,

    y'  = (1-s)^2/2 d0 + (1/2 + s - s^2) d1 + s^2/2 d2        y'' = (1-s) (d1 - d0) + s (d2 - d1)

so |y'| and |y''| are bounded by the longest leg and the largest difference of legs, and a force that acts through the
legs sums to zero over the four points by construction. One row of a quadrature rule is
(weight of d0, d1, d2; 1-s, s; quadrature weight).

Gauss points converge exponentially here: three reach what eleven equidistant samples reach by Simpson's rule.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.yarnrelax.model.lattice_images import corner_place


@wp.func
def segment_corners(model: Any, points: wp.array[Any], s: int) -> tuple[Any, Any, Any, Any]:
    """The four control points of a segment, each where its image lies."""
    corner = model.segment_points[s]
    q0 = corner_place(model.images, points, s, 0, corner[0])
    q1 = corner_place(model.images, points, s, 1, corner[1])
    q2 = corner_place(model.images, points, s, 2, corner[2])
    q3 = corner_place(model.images, points, s, 3, corner[3])
    return q0, q1, q2, q3


@wp.func
def weight_row(model: Any, count: int, k: int) -> int:
    """Row of the tables of sample weights for sample ``k`` of a segment with ``count`` samples."""
    return (count * (count - 1)) // 2 + k


def leg_weights(parameter: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of the three legs in y' at each parameter, shape (n, 3)."""
    first, last = (1 - parameter) ** 2 / 2, parameter**2 / 2
    return np.stack([first, 1 - first - last, last], axis=1)


def gauss_rule(count: int) -> NDArray[np.float64]:
    """Rows of a Gauss rule on [0, 1], shape (count, 6)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    s = (nodes + 1) / 2
    return np.column_stack([leg_weights(s), 1 - s, s, weights / 2])


def sample_places(most: int) -> NDArray[np.float64]:
    """Parameters of 1, 2, ... ``most`` equidistant samples of a segment, one after the other."""
    return np.concatenate([(np.arange(count) + 0.5) / count for count in range(1, most + 1)])
