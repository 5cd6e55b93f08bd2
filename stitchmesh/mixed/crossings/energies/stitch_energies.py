# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The energies of a stitch: its length, and the angle by which yarns wrap round each other.

*Length* of a stitch contact of a knit (Cirio et al. 2017, section 4).

    E = 1/2 k_l L (l / L - 1)^2

l is the distance of the two nodes of the contact, and L is its value in the layout. The energy does not depend on
sliding: yarn can run through a contact, but the yarn inside the contact keeps its length.

*Angle* between two half planes that share an axis, its gradient, and products with its Hessian.

The axis is the vector e. The vectors a and b lead from its first end to one point of each half plane. With the normals
n = a x e and m = e x b the angle is

    t = atan2((n x m) . e / |e|, n . m),    t = 0 where the half planes lie on opposite sides, flat

in (-pi, pi], and with A = (a . e) / |e|^2, B = (b . e) / |e|^2

    dt/da = |e| n / |n|^2,    dt/db = |e| m / |m|^2,    dt/de = - A dt/da - B dt/db

The Hessian is the derivative of these. A vector f(n) = n / |n|^2 has the derivative (I - 2 n n^T / |n|^2) / |n|^2.
Where a or b lies on the axis the angle has no value; gradient and Hessian are zero there.

*Wrapping* of two yarns around one another in a stitch contact of a knit (Cirio et al. 2017, section 4).

    E = 1/2 k_w L (t - r)^2 f(x_a) f(x_b)

The axis of a stitch contact joins its two nodes; L is its length in the layout. A leg of one yarn and a leg of the
other yarn each span a half plane with the axis, and t is the angle between these half planes: 0 in the flat layout, in
which the legs lie on opposite sides. The angle at rest is a quarter turn: r = +pi/2 or -pi/2. Seen with the axis
upwards and the first leg on its left, a positive angle turns both legs away from the viewer.

A leg that lies along the axis spans no half plane, and the gradient of t has no bound near there. The factors f let
the energy fade out: x is the square of the sine of the angle between the leg and the axis, and

    f(x) = 1  for x >= FADE,   else  s (2 - s)  with  s = x / FADE

so that gradients are continuous and bounded. In an unloaded knit the legs make more than 30 degrees with the axis.
There f = 1, and the energy is the published one. The matrix that is never negative keeps k_w L f f grad t grad t^T.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.precision import Scalar, Vec3
from stitchmesh.mixed.crossings.energies.crossing_energies import unit_of

FLAT = wp.constant(1.0e-6)
"""Sine of the angle between the axis and a leg below which they count as parallel."""
TURN = wp.constant(6.283185307179586)
FADE = wp.constant(0.25)
"""Square of the sine of 30 degrees."""


@wp.func
def stitch_length_energy(axis: Vec3, rest: Scalar, stiffness: Scalar) -> Any:
    """E [erg]; ``stiffness`` is k_l [dyn]."""
    apart = wp.length(axis) - rest
    return type(rest)(0.5) * stiffness * apart * apart / rest


@wp.func
def stitch_length_force(axis: Vec3, rest: Scalar, stiffness: Scalar) -> Any:
    """Force [dyn] on the axis."""
    direction, _inverse = unit_of(axis)
    return direction * (stiffness * (type(rest)(1.0) - wp.length(axis) / rest))


@wp.func
def stitch_length_product(axis: Vec3, d_axis: Vec3, rest: Scalar, stiffness: Scalar, exact: Scalar) -> Any:
    """Product of the Hessian with the direction of the axis."""
    direction, inverse = unit_of(axis)
    along = wp.dot(direction, d_axis)
    slope = stiffness * (wp.length(axis) / rest - type(rest)(1.0))
    tight = wp.max(slope, slope * exact) * inverse
    return direction * (along * stiffness / rest) + (d_axis - direction * along) * tight


@wp.func
def side_of(axis: Vec3, leg: Vec3, normal: Vec3) -> Any:
    """f(n) |e| = |e| n / |n|^2; zero without a half plane."""
    length, across = wp.length(axis), wp.length(normal)
    result = normal - normal
    if across > type(across)(FLAT) * length * wp.length(leg):
        result = normal * (length / (across * across))
    return result


@wp.func
def dihedral_of(axis: Vec3, a: Vec3, b: Vec3) -> Any:
    """The angle."""
    direction, _inverse = unit_of(axis)
    n, m = wp.cross(a, axis), wp.cross(axis, b)
    return wp.atan2(wp.dot(wp.cross(n, m), direction), wp.dot(n, m))


@wp.func
def share_along(axis: Vec3, leg: Vec3) -> Any:
    """A = (a . e) / |e|^2."""
    _direction, inverse = unit_of(axis)
    return wp.dot(axis, leg) * inverse * inverse


@wp.func
def dihedral_gradient(axis: Vec3, a: Vec3, b: Vec3) -> tuple[Any, Any, Any]:
    """Derivatives by the axis, a and b."""
    by_a, by_b = side_of(axis, a, wp.cross(a, axis)), side_of(axis, b, wp.cross(axis, b))
    return -by_a * share_along(axis, a) - by_b * share_along(axis, b), by_a, by_b


@wp.func
def side_change(axis: Vec3, normal: Vec3, side: Vec3, d_axis: Vec3, d_normal: Vec3) -> Any:
    """Change of |e| n / |n|^2."""
    direction, inverse = unit_of(axis)
    scale = wp.dot(side, side)  # |e|^2 / |n|^2
    per_normal = scale * inverse  # |e| / |n|^2
    along = type(per_normal)(2.0) * wp.dot(side, d_normal) * inverse  # 2 (n . dn) / |n|^2
    return side * (wp.dot(direction, d_axis) * inverse) + d_normal * per_normal - side * along


@wp.func
def share_change(axis: Vec3, leg: Vec3, share: Scalar, d_axis: Vec3, d_leg: Vec3) -> Any:
    """Change of (a . e) / |e|^2."""
    _direction, inverse = unit_of(axis)
    moved = wp.dot(axis, d_leg) + wp.dot(leg, d_axis) - type(share)(2.0) * share * wp.dot(axis, d_axis)
    return moved * inverse * inverse


@wp.func
def dihedral_hessian(axis: Vec3, a: Vec3, b: Vec3, d_axis: Vec3, da: Vec3, db: Vec3) -> tuple[Any, Any, Any]:
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


@wp.func
def unwrapped(axis: Vec3, a: Vec3, b: Vec3, rest: Scalar) -> Any:
    """T - r, in the turn around the axis that is shorter."""
    apart = dihedral_of(axis, a, b) - rest
    turn = type(rest)(TURN)
    return apart - turn * wp.floor(apart / turn + type(rest)(0.5))


@wp.func
def cosine_gradient(axis: Vec3, leg: Vec3) -> tuple[Any, Any, Any]:
    """Cosine of the angle between the axis and a leg, and its derivatives by both."""
    e, by_axis = unit_of(axis)
    a, by_leg = unit_of(leg)
    cosine = wp.dot(a, e)
    return cosine, (a - e * cosine) * by_axis, (e - a * cosine) * by_leg


@wp.func
def cosine_hessian(axis: Vec3, leg: Vec3, d_axis: Vec3, d_leg: Vec3) -> tuple[Any, Any]:
    """Product of the Hessian of the cosine with a direction; the parts of the axis and the leg."""
    e, by_axis = unit_of(axis)
    a, by_leg = unit_of(leg)
    cosine, of_axis, of_leg = cosine_gradient(axis, leg)
    longer, wider = wp.dot(e, d_axis) * by_axis, wp.dot(a, d_leg) * by_leg
    d_e, d_a = d_axis * by_axis - e * longer, d_leg * by_leg - a * wider
    change = wp.dot(of_axis, d_axis) + wp.dot(of_leg, d_leg)
    new_axis = (d_a - e * change - d_e * cosine) * by_axis - of_axis * longer
    return new_axis, (d_e - a * change - d_a * cosine) * by_leg - of_leg * wider


@wp.func
def fading(axis: Vec3, leg: Vec3) -> tuple[Any, Any, Any]:
    """F and its first and second derivative by x."""
    zero, one, two = type(axis[0])(0.0), type(axis[0])(1.0), type(axis[0])(2.0)
    e, _by_axis = unit_of(axis)
    a, _by_leg = unit_of(leg)
    across, inverse = wp.cross(a, e), one / type(axis[0])(FADE)
    s = wp.dot(across, across) * inverse
    factor, slope, bend = s * (two - s), two * (one - s) * inverse, -two * inverse * inverse
    if s >= one:
        factor, slope, bend = one, zero, zero * one
    return factor, slope, bend


@wp.func
def wrapping_energy(axis: Vec3, a: Vec3, b: Vec3, rest: Scalar, stiffness: Scalar) -> Any:
    """E [erg]; ``stiffness`` is k_w L."""
    apart = unwrapped(axis, a, b, rest)
    f_a, _slope_a, _bend_a = fading(axis, a)
    f_b, _slope_b, _bend_b = fading(axis, b)
    return type(rest)(0.5) * stiffness * f_a * f_b * apart * apart


@wp.func
def wrapping_force(axis: Vec3, a: Vec3, b: Vec3, rest: Scalar, stiffness: Scalar) -> tuple[Any, Any, Any]:
    """Forces [dyn] on the axis, a and b."""
    by_axis, by_a, by_b = dihedral_gradient(axis, a, b)
    cos_a, axis_a, leg_a = cosine_gradient(axis, a)
    cos_b, axis_b, leg_b = cosine_gradient(axis, b)
    f_a, slope_a, _bend_a = fading(axis, a)
    f_b, slope_b, _bend_b = fading(axis, b)
    apart = unwrapped(axis, a, b, rest)
    pull = -stiffness * apart * f_a * f_b
    # x = 1 - cos^2 has the derivative -2 cos
    fade_a, fade_b = (
        stiffness * apart * apart * slope_a * f_b * cos_a,
        stiffness * apart * apart * f_a * slope_b * cos_b,
    )
    return (
        by_axis * pull + axis_a * fade_a + axis_b * fade_b,
        by_a * pull + leg_a * fade_a,
        by_b * pull + leg_b * fade_b,
    )


@wp.func
def wrapping_product(
    axis: Vec3, a: Vec3, b: Vec3, d_axis: Vec3, da: Vec3, db: Vec3, rest: Scalar, stiffness: Scalar, exact: Scalar
) -> tuple[Any, Any, Any]:
    """Product of the Hessian with a direction; the parts of the axis, a and b."""
    half, two = type(rest)(0.5), type(rest)(2.0)
    by_axis, by_a, by_b = dihedral_gradient(axis, a, b)
    f_a, slope_a, bend_a = fading(axis, a)
    f_b, slope_b, bend_b = fading(axis, b)
    apart = unwrapped(axis, a, b, rest)
    turned = wp.dot(by_axis, d_axis) + wp.dot(by_a, da) + wp.dot(by_b, db)
    # changes of x_a and x_b
    cos_a, axis_a, leg_a = cosine_gradient(axis, a)
    cos_b, axis_b, leg_b = cosine_gradient(axis, b)
    d_cos_a = wp.dot(axis_a, d_axis) + wp.dot(leg_a, da)
    d_cos_b = wp.dot(axis_b, d_axis) + wp.dot(leg_b, db)
    d_a, d_b = -two * cos_a * d_cos_a, -two * cos_b * d_cos_b
    # the energy is 1/2 k f f (t - r)^2; derivatives by t, x_a and x_b, and their changes
    change = stiffness * f_a * f_b * turned + exact * stiffness * apart * (slope_a * f_b * d_a + f_a * slope_b * d_b)
    level, square = exact * stiffness * apart * f_a * f_b, exact * half * stiffness * apart * apart
    cross = exact * stiffness * apart * turned
    by_x_a, by_x_b = square * slope_a * f_b, square * f_a * slope_b
    change_a = cross * slope_a * f_b + square * (bend_a * f_b * d_a + slope_a * slope_b * d_b)
    change_b = cross * f_a * slope_b + square * (f_a * bend_b * d_b + slope_a * slope_b * d_a)
    # d (E_x grad x) with grad x = -2 cos grad cos
    first_a, second_a = -two * (change_a * cos_a + by_x_a * d_cos_a), -two * by_x_a * cos_a
    first_b, second_b = -two * (change_b * cos_b + by_x_b * d_cos_b), -two * by_x_b * cos_b
    bent_axis, bent_a, bent_b = dihedral_hessian(axis, a, b, d_axis, da, db)
    curved_axis_a, curved_a = cosine_hessian(axis, a, d_axis, da)
    curved_axis_b, curved_b = cosine_hessian(axis, b, d_axis, db)
    of_axis = by_axis * change + bent_axis * level + axis_a * first_a + axis_b * first_b
    of_axis += curved_axis_a * second_a + curved_axis_b * second_b
    of_a = by_a * change + bent_a * level + leg_a * first_a + curved_a * second_a
    of_b = by_b * change + bent_b * level + leg_b * first_b + curved_b * second_b
    return of_axis, of_a, of_b
