# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The second derivatives of a yarn's energy on itself: stretch, length penalty and bending of each segment.

The energy of a segment depends only on its three legs d0, d1, d2 (``spline``). Take a point of the quadrature rule with
t = y' = sum of w_j d_j and a = y'' = sum of v_j d_j. The second derivatives there by the legs j and k are

    H_jk = w_j w_k E_tt + v_j v_k E_aa + w_j v_k E_ta + v_j w_k E_at

With s = |t|, l the rest length and P = I - t t^T / s^2, stretch has (``segment_forces``)

    E_tt = 2 k_len / (l l0) (t t^T / s^2 + (1 - l / s) P)

and bending with phi = kappa^2 = (s^2 |a|^2 - (t . a)^2) / s^6 and the natural curvature k

    k_bend l (f M + 2 (1 - f) g g^T),     f = 1 - k / kappa,    g = the gradient of kappa,    M = the Hessian of phi

The matrix is indefinite where a yarn is compressed or strongly bent. Far from rest the Gauss-Newton matrix replaces it:
P only where s > l, M = 2 J^T J with J the derivative of the curvature vector c = t x a / s^3, and f at least 0. The
Gauss-Newton matrix is never negative, and equals the exact matrix for a yarn with its rest length and little curvature.
In between, the blocks mix both, with the share ``exact`` of the exact matrix.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Mat33, Scalar, Vec3
from stitchmesh.yarnrelax.energies.segment_forces import NEARLY_STRAIGHT, length_slope, natural_ends
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of, rests
from stitchmesh.yarnrelax.model.spline import segment_corners


@wp.func
def gauss_newton_bend(t: Vec3, a: Vec3, c: Vec3) -> tuple[Any, Any, Any]:
    """Blocks tt, ta, aa of 2 J^T J, with J the derivative of the curvature vector; c is t x a."""
    two, three = type(t[0])(2.0), type(t[0])(3.0)
    s2 = wp.dot(t, t)
    inverse = type(t[0])(1.0) / s2
    i3 = inverse * inverse * inverse
    ta, aa, cc = wp.dot(t, a), wp.dot(a, a), wp.dot(c, c)
    identity = wp.identity(n=3, dtype=type(t[0]))
    across = (t * aa - a * ta) * (i3 * inverse)  # J_t without its part along t, times the curvature vector, over s^2
    tt = (identity * aa - wp.outer(a, a)) * i3 - (wp.outer(across, t) + wp.outer(t, across)) * three
    tt += wp.outer(t, t) * (three * three * cc * i3 * inverse * inverse)
    bent = (a * s2 - t * ta) * (three * i3 * inverse)
    mixed = (wp.outer(t, a) - identity * ta) * i3 - wp.outer(t, bent)
    turned = (identity - wp.outer(t, t) * inverse) * (inverse * inverse)
    return tt * two, mixed * two, turned * two


@wp.func
def exact_bend(t: Vec3, a: Vec3) -> tuple[Any, Any, Any]:
    """Blocks tt, ta, aa of the Hessian of the square of the curvature."""
    one, two, three, four, six, twelve = (
        type(t[0])(1.0), type(t[0])(2.0), type(t[0])(3.0), type(t[0])(4.0), type(t[0])(6.0), type(t[0])(12.0)
    )  # fmt: skip
    inverse = one / wp.dot(t, t)
    i2 = inverse * inverse
    i3, i4 = i2 * inverse, i2 * i2
    b, c = wp.dot(a, a), wp.dot(t, a)
    identity = wp.identity(n=3, dtype=type(t[0]))
    by_square, by_product = three * c * c * i4 - two * b * i3, -two * c * i3
    twice_square = six * b * i4 - twelve * c * c * i4 * inverse
    t_t, t_a, a_t, a_a = wp.outer(t, t), wp.outer(t, a), wp.outer(a, t), wp.outer(a, a)
    tt = identity * (two * by_square) + t_t * (four * twice_square) + (t_a + a_t) * (twelve * c * i4) - a_a * (two * i3)
    mixed = identity * by_product - t_a * (four * two * i3) + t_t * (twelve * c * i4) - a_t * (two * i3)
    turned = identity * (two * i2) - t_t * (two * i3)
    return tt, mixed, turned


@wp.func
def bend_hessian(t: Vec3, a: Vec3, stiffness: Scalar, natural: Scalar, exact: Scalar) -> tuple[Any, Any, Any]:
    """Blocks tt, ta, aa of bending at a point of the rule; ``stiffness`` is k_bend times the rest length."""
    zero, one, two = type(stiffness)(0.0), type(stiffness)(1.0), type(stiffness)(2.0)
    c = wp.cross(t, a)
    tt, mixed, turned = gauss_newton_bend(t, a, c)
    if exact > zero:
        exact_tt, exact_mixed, exact_turned = exact_bend(t, a)
        tt += (exact_tt - tt) * exact
        mixed += (exact_mixed - mixed) * exact
        turned += (exact_turned - turned) * exact
    if natural > zero:
        s2 = wp.dot(t, t)
        least = natural * type(natural)(NEARLY_STRAIGHT)
        curvature2 = wp.dot(c, c) / (s2 * s2 * s2)
        curvature = wp.max(wp.sqrt(curvature2), least)
        part = one - natural / curvature
        rest = one - part
        if curvature2 < least * least:
            rest = zero
        part = wp.max(part, part * exact)
        rest = wp.max(rest * exact, wp.min(rest, one))
        i3 = one / (s2 * s2 * s2)
        by_t = (wp.cross(a, c) * i3 - t * (type(one)(3.0) * wp.dot(c, c) * i3 / s2)) / curvature
        by_a = wp.cross(c, t) * (i3 / curvature)
        tt = tt * part + wp.outer(by_t, by_t) * (two * rest)
        mixed = mixed * part + wp.outer(by_t, by_a) * (two * rest)
        turned = turned * part + wp.outer(by_a, by_a) * (two * rest)
    return tt * stiffness, mixed * stiffness, turned * stiffness


@wp.func
def curve_length(model: YarnConstants, leg0: Vec3, leg1: Vec3, leg2: Vec3) -> Any:
    """Length of a segment by the quadrature rule."""
    length = leg0[0] - leg0[0]
    for g in range(model.quadrature_points):
        rule = model.rule[g]
        length += wp.length(leg0 * rule[0] + leg1 * rule[1] + leg2 * rule[2]) * rule[5]
    return length


@kernel
def find_leg_hessians(
    # model
    model: YarnConstants,
    # state in
    exact: wp.array[Scalar],
    points: wp.array[Vec3],
    # state out
    leg_hessian: wp.array2d[Mat33],
) -> None:
    """Find six blocks of each segment [erg / unit^2]: of the pairs of legs 00, 01, 02, 11, 12 and 22, in this order.

    The others are their transposes; ``exact`` is the share of the exact matrix.
    """
    s = wp.tid()
    if rests(model.images, cell_of(model.images, s)):
        return
    q0, q1, q2, q3 = segment_corners(model, points, s)
    leg0, leg1, leg2 = q1 - q0, q2 - q1, q3 - q2
    rest_length = model.segment_rest_length[s]
    k = model.segment_stiffness[s] * rest_length
    natural = natural_ends(model, s)
    wanted = exact[s]
    zero, one, two = type(rest_length)(0.0), type(rest_length)(1.0), type(rest_length)(2.0)
    per_length = one / rest_length
    slope = length_slope(curve_length(model, leg0, leg1, leg2), rest_length, k[1])
    slope = wp.max(slope, slope * wanted)
    identity = wp.identity(n=3, dtype=type(rest_length))
    h00, h01, h02, h11, h12, h22 = (
        identity * zero, identity * zero, identity * zero, identity * zero, identity * zero, identity * zero
    )  # fmt: skip
    along0, along1, along2 = leg0 * zero, leg0 * zero, leg0 * zero
    for g in range(model.quadrature_points):
        rule = model.rule[g]
        t = leg0 * rule[0] + leg1 * rule[1] + leg2 * rule[2]
        a = (leg1 - leg0) * rule[3] + (leg2 - leg1) * rule[4]
        speed = wp.length(t)
        curvature = wp.abs(natural[0] * rule[3] + natural[1] * rule[4])
        tt, ta, aa = bend_hessian(t, a, k[2] * rule[5], curvature, wanted)
        at = wp.transpose(ta)
        direction = wp.outer(t, t) / (speed * speed)
        pull = two * k[0] * rule[5] * per_length * per_length
        tight = one - rest_length / speed
        tight = wp.max(tight, tight * wanted)
        tt += direction * pull + (identity - direction) * (pull * tight + slope * rule[5] / speed)
        w0, w1, w2 = rule[0], rule[1], rule[2]
        v0, v1, v2 = -rule[3], rule[3] - rule[4], rule[4]
        h00 += tt * (w0 * w0) + aa * (v0 * v0) + (ta + at) * (w0 * v0)
        h11 += tt * (w1 * w1) + aa * (v1 * v1) + (ta + at) * (w1 * v1)
        h22 += tt * (w2 * w2) + aa * (v2 * v2) + (ta + at) * (w2 * v2)
        h01 += tt * (w0 * w1) + aa * (v0 * v1) + ta * (w0 * v1) + at * (v0 * w1)
        h02 += tt * (w0 * w2) + aa * (v0 * v2) + ta * (w0 * v2) + at * (v0 * w2)
        h12 += tt * (w1 * w2) + aa * (v1 * v2) + ta * (w1 * v2) + at * (v1 * w2)
        share = t * (rule[5] / speed)
        along0 += share * w0
        along1 += share * w1
        along2 += share * w2
    whole = two * k[1] * per_length * per_length
    leg_hessian[0, s] = h00 + wp.outer(along0, along0) * whole
    leg_hessian[1, s] = h01 + wp.outer(along0, along1) * whole
    leg_hessian[2, s] = h02 + wp.outer(along0, along2) * whole
    leg_hessian[3, s] = h11 + wp.outer(along1, along1) * whole
    leg_hessian[4, s] = h12 + wp.outer(along1, along2) * whole
    leg_hessian[5, s] = h22 + wp.outer(along2, along2) * whole


def leg_hessian_launch(
    model: Model, exact: wp.array[Any], points: wp.array[Any], leg_hessian: wp.array[Any], launcher: Launcher
) -> Any:
    """Return the launch that finds the blocks of all segments, shape (6, S)."""
    return launcher(find_leg_hessians, model.segment_count, [model.constants, exact, points], [leg_hessian])
