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

wp.set_module_options({"enable_backward": False})


@wp.func
def segment_legs(points: wp.array[Any], corner: wp.vec4i) -> Any:
    """The three legs [cm] between the four control points of a segment."""
    inner = points[corner[2]] - points[corner[1]]
    return points[corner[1]] - points[corner[0]], inner, points[corner[3]] - points[corner[2]]


@wp.func
def curve_speed(rule: Any, leg0: Any, leg1: Any, leg2: Any) -> Any:
    """Length |y'| [cm] of the derivative at one point of the rule."""
    return wp.length(leg0 * rule[0] + leg1 * rule[1] + leg2 * rule[2])


def leg_weights(parameter: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of the three legs in y' at each parameter, shape (n, 3)."""
    first, last = (1 - parameter) ** 2 / 2, parameter**2 / 2
    return np.stack([first, 1 - first - last, last], axis=1)


def gauss_rule(count: int) -> NDArray[np.float64]:
    """Rows of a Gauss rule on [0, 1], shape (count, 6)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    s = (nodes + 1) / 2
    return np.column_stack([leg_weights(s), 1 - s, s, weights / 2])
