# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The angle of a hinge, two triangles that share an edge, with its first two derivatives (Tamstorf and Grinspun 2013).

A hinge has the vertices x_0 and x_1 of its edge and the third vertices x_2 and x_3 of its first and second triangle
(``Cloth.hinges``). With e = x_1 - x_0, r_k = x_k - x_0, L = |e| and the normals n_2 = e x r_2 and n_3 = r_3 x e

    theta = atan2(-L n_2 . r_3, n_2 . n_3)
    grad_2 theta = -L n_2 / |n_2|^2,    grad_3 theta = -L n_3 / |n_3|^2
    grad_1 theta = -a_2 grad_2 - a_3 grad_3,    grad_0 theta = -(1 - a_2) grad_2 - (1 - a_3) grad_3

with a_k = e . r_k / L^2.

The product of the Hessian with a direction is the derivative of these gradients along the direction, which needs no
matrix. A triangle that has lost its area in space has no angle; L and |n_k| are therefore bounded below by the
ten-thousandth part of their rest values, with which gradients and products stay finite.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.mixed.cloth.cloth import Cloth

SMALLEST_PART = 1e-4
"""Smallest length of an edge, and smallest area of a triangle, as a part of the rest value."""


@wp.func
def hinge_frame(corner: wp.vec4i, vertices: Any) -> tuple[Any, Any, Any]:
    """The vectors e, r_2 and r_3 of a hinge, or their change along a direction."""
    start = vertices[corner[0]]
    return vertices[corner[1]] - start, vertices[corner[2]] - start, vertices[corner[3]] - start


@wp.func
def hinge_angle(e: Any, r2: Any, r3: Any) -> Any:
    """Angle [rad], zero where the triangles are flat and positive on a ridge seen from outside."""
    n2 = wp.cross(e, r2)
    return wp.atan2(-wp.length(e) * wp.dot(n2, r3), wp.dot(n2, wp.cross(r3, e)))


@wp.func
def angle_gradient(e: Any, r2: Any, r3: Any, least: Any) -> tuple[Any, Any, Any, Any]:
    """Gradient of the angle at x_0 to x_3; ``least`` holds the bounds of L^2, |n_2|^2 and |n_3|^2."""
    one = type(e[0])(1.0)
    per_square = one / wp.max(wp.dot(e, e), least[0])
    length = wp.sqrt(wp.dot(e, e))
    n2, n3 = wp.cross(e, r2), wp.cross(r3, e)
    g2 = n2 * (-length / wp.max(wp.dot(n2, n2), least[1]))
    g3 = n3 * (-length / wp.max(wp.dot(n3, n3), least[2]))
    a2, a3 = wp.dot(e, r2) * per_square, wp.dot(e, r3) * per_square
    return g2 * (a2 - one) + g3 * (a3 - one), -g2 * a2 - g3 * a3, g2, g3


@wp.func
def normal_change(n: Any, dn: Any, length: Any, length_change: Any, least: Any) -> Any:
    """Derivative of -L n / |n|^2."""
    two = type(length)(2.0)
    per_square = type(length)(1.0) / wp.max(wp.dot(n, n), least)
    return (n * length_change + dn * length - n * (two * length * wp.dot(n, dn) * per_square)) * -per_square


@wp.func
def gradient_change(e: Any, r2: Any, r3: Any, de: Any, dr2: Any, dr3: Any, least: Any) -> tuple[Any, Any, Any]:
    """Derivative of the gradient at x_1, x_2 and x_3 as the frame changes: the Hessian times a direction."""
    two = type(e[0])(2.0)
    square = wp.max(wp.dot(e, e), least[0])
    length = wp.sqrt(square)
    length_change = wp.dot(e, de) / length
    n2, n3 = wp.cross(e, r2), wp.cross(r3, e)
    dn2, dn3 = wp.cross(de, r2) + wp.cross(e, dr2), wp.cross(dr3, e) + wp.cross(r3, de)
    dg2 = normal_change(n2, dn2, length, length_change, least[1])
    dg3 = normal_change(n3, dn3, length, length_change, least[2])
    g2 = n2 * (-length / wp.max(wp.dot(n2, n2), least[1]))
    g3 = n3 * (-length / wp.max(wp.dot(n3, n3), least[2]))
    a2, a3 = wp.dot(e, r2) / square, wp.dot(e, r3) / square
    da2 = (wp.dot(de, r2) + wp.dot(e, dr2) - two * a2 * wp.dot(e, de)) / square
    da3 = (wp.dot(de, r3) + wp.dot(e, dr3) - two * a3 * wp.dot(e, de)) / square
    return -dg2 * a2 - g2 * da2 - dg3 * a3 - g3 * da3, dg2, dg3


def least_squares_of(cloth: Cloth) -> NDArray[np.float64]:
    """The bounds of L^2 [cm^2], |n_2|^2 and |n_3|^2 [cm^4] of each hinge of a cloth, shape (H, 3)."""
    sides = cloth.hinge_sides
    lengths = np.linalg.norm(np.diff(cloth.side_rest, axis=1)[:, 0], axis=1)[sides].mean(axis=1)
    doubled = 2.0 * cloth.rest_area[sides // 3]
    bounds: NDArray[np.float64] = (SMALLEST_PART * np.column_stack([lengths, doubled])) ** 2
    return bounds
