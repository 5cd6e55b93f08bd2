# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The energy of two contact points whose spheres overlap.

With the distance d of the points, the sum h of their radii, x = d / h, their areas a_i and a_j and a pressure P:

    E = P / (2 pi h) a_i a_j f(x)                                      [erg],    x < 1
    f(x) = 1/x^2 + x^2 - 2                                             for x >= 1/10
    f(x) = f(1/10) + f'(1/10) (x - 1/10) + f''(1/10) (x - 1/10)^2 / 2  below: 98.01, -1999.8, 60002

f is the contact energy of yarns (Kaldor et al. 2008), continued with constant curvature so that it is finite. The sum
over pairs is a double integral over both layers: two parallel layers whose points are much denser than h press on each
other with

    p = P x f(x) = P (1/x + x^3 - 2x)        [dyn / cm^2],

which is 0.04 P at x = 0.9, 0.37 P at 0.7 and 1.1 P at 0.5. With the unit vector n from one point to the other, the
second derivative by the difference of the two places is

    H = P a_i a_j / (2 pi h) (f'' / h^2 n n^T + f' / (h d) (1 - n n^T))

The second part is negative; the Hessian that is never negative leaves it out.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.precision import Scalar, Vec3

LEAST = wp.constant(0.1)
"""Distance over the sum of radii below which the curvature is constant."""


@wp.func
def pair_energy(x: Scalar) -> Any:
    """f, for x below 1."""
    one = type(x)(1.0)
    y = x - type(x)(LEAST)
    if y < one - one:
        return type(x)(98.01) - type(x)(1999.8) * y + type(x)(30001.0) * y * y
    return one / (x * x) + x * x - one - one


@wp.func
def pair_slope(x: Scalar) -> Any:
    """First derivative of f, for x below 1."""
    two = type(x)(2.0)
    y = x - type(x)(LEAST)
    if y < two - two:
        return type(x)(60002.0) * y - type(x)(1999.8)
    return two * x - two / (x * x * x)


@wp.func
def pair_curvature(x: Scalar) -> Any:
    """Second derivative of f, for x below 1."""
    y = wp.max(x, type(x)(LEAST))
    return type(x)(6.0) / (y * y * y * y) + type(x)(2.0)


@wp.func
def pair_size(pressure: Scalar, reach: Scalar, area: Scalar, other_area: Scalar) -> Any:
    """P a_i a_j / (2 pi h) [erg]."""
    return pressure * area * other_area / (type(reach)(2.0 * 3.141592653589793) * reach)


@wp.func
def pair_stiffness(size: Scalar, distance: Scalar, reach: Scalar, exact: Scalar) -> tuple[Any, Any]:
    """Second derivatives along and across the vector between the points [dyn / cm], with a part of the exact ones."""
    x = distance / reach
    along = size * pair_curvature(x) / (reach * reach)
    return along, exact * size * pair_slope(x) / (reach * distance)


@wp.func
def times_stiffness(apart: Vec3, distance: Scalar, along: Scalar, across: Scalar, change: Vec3) -> Any:
    """The second derivative times a change of the difference of two places."""
    normal = apart / distance
    return change * across + normal * (wp.dot(normal, change) * (along - across))


@wp.func
def distance_of(apart: Vec3) -> Any:
    """Length of a vector; a tiny number in place of zero, so that coincident points have no force and no error."""
    return wp.max(wp.length(apart), type(apart[0])(1.0e-18))
