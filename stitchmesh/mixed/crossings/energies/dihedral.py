# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The angle between two half planes that share an axis, its gradient, and products with its Hessian.

The axis has the vector e, and from its first end the vectors a and b reach one point of each half plane. With the
normals n = a x e and m = e x b the angle is

    t = atan2((n x m) . e / |e|, n . m),    t = 0 where the half planes lie on opposite sides, flat

in (-pi, pi], and with A = (a . e) / |e|^2, B = (b . e) / |e|^2

    dt/da = |e| n / |n|^2,    dt/db = |e| m / |m|^2,    dt/de = - A dt/da - B dt/db

The Hessian is the derivative of these. A vector f(n) = n / |n|^2 has the derivative (I - 2 n n^T / |n|^2) / |n|^2.
Where a or b lies on the axis the angle has no value; gradient and Hessian are zero there.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.mixed.crossings.energies.angle import unit_of

FLAT = wp.constant(1.0e-6)
"""Sine of the angle between the axis and a leg below which they count as parallel."""


@wp.func
def side_of(axis: Any, leg: Any, normal: Any) -> Any:
    """f(n) |e| = |e| n / |n|^2; zero without a half plane."""
    length, across = wp.length(axis), wp.length(normal)
    result = normal - normal
    if across > type(across)(FLAT) * length * wp.length(leg):
        result = normal * (length / (across * across))
    return result


@wp.func
def dihedral_of(axis: Any, a: Any, b: Any) -> Any:
    """The angle."""
    direction, _inverse = unit_of(axis)
    n, m = wp.cross(a, axis), wp.cross(axis, b)
    return wp.atan2(wp.dot(wp.cross(n, m), direction), wp.dot(n, m))


@wp.func
def share_along(axis: Any, leg: Any) -> Any:
    """A = (a . e) / |e|^2."""
    _direction, inverse = unit_of(axis)
    return wp.dot(axis, leg) * inverse * inverse


@wp.func
def dihedral_gradient(axis: Any, a: Any, b: Any) -> tuple[Any, Any, Any]:
    """Derivatives by the axis, a and b."""
    by_a, by_b = side_of(axis, a, wp.cross(a, axis)), side_of(axis, b, wp.cross(axis, b))
    return -by_a * share_along(axis, a) - by_b * share_along(axis, b), by_a, by_b


@wp.func
def side_change(axis: Any, normal: Any, side: Any, d_axis: Any, d_normal: Any) -> Any:
    """Change of |e| n / |n|^2."""
    direction, inverse = unit_of(axis)
    scale = wp.dot(side, side)  # |e|^2 / |n|^2
    per_normal = scale * inverse  # |e| / |n|^2
    along = type(per_normal)(2.0) * wp.dot(side, d_normal) * inverse  # 2 (n . dn) / |n|^2
    return side * (wp.dot(direction, d_axis) * inverse) + d_normal * per_normal - side * along


@wp.func
def share_change(axis: Any, leg: Any, share: Any, d_axis: Any, d_leg: Any) -> Any:
    """Change of (a . e) / |e|^2."""
    _direction, inverse = unit_of(axis)
    moved = wp.dot(axis, d_leg) + wp.dot(leg, d_axis) - type(share)(2.0) * share * wp.dot(axis, d_axis)
    return moved * inverse * inverse


@wp.func
def dihedral_hessian(axis: Any, a: Any, b: Any, d_axis: Any, da: Any, db: Any) -> tuple[Any, Any, Any]:
    """Product of the Hessian of the angle with a direction; the parts of the axis, a and b."""
    n, m = wp.cross(a, axis), wp.cross(axis, b)
    by_a, by_b = side_of(axis, a, n), side_of(axis, b, m)
    share_a, share_b = share_along(axis, a), share_along(axis, b)
    of_a = side_change(axis, n, by_a, d_axis, wp.cross(a, d_axis) + wp.cross(da, axis))
    of_b = side_change(axis, m, by_b, d_axis, wp.cross(axis, db) + wp.cross(d_axis, b))
    of_axis = -of_a * share_a - of_b * share_b
    of_axis -= by_a * share_change(axis, a, share_a, d_axis, da)
    of_axis -= by_b * share_change(axis, b, share_b, d_axis, db)
    return of_axis, of_a, of_b
