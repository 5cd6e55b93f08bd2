# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The angle between two vectors, its gradient, and the Hessian of an energy of this angle.

With unit vectors p = a / |a| and q = b / |b|, the angle t, the unit normal z of their plane, m = z x p and n = q x z,

    dt = - m . da / |a| - n . db / |b|
    d2t = (cot t z z^T + p m^T + m p^T)[da, da] / |a|^2 + (cot t z z^T + q n^T + n q^T)[db, db] / |b|^2
          - 2 (z . da) (z . db) / (|a| |b| sin t)

An energy E(t, D) has the Hessian E_ab grad a grad b^T + E_t d2t. Its second part is not positive in general. The matrix
that is never negative keeps only this part of it, where E_t > 0:

    (E_t / sin t) r r^T,    r = z . da / |a| - z . db / |b|

It is the stiffness of a straight yarn across its plane: for E = k t^2 it is the other half of the Gauss-Newton matrix
of the vector t z. Where a and b are parallel, z is any unit normal of a; the sum of both parts is the same for every
such z. In E_t / sin t, a sine below ``LEAST_SINE`` counts as ``LEAST_SINE``, which keeps the stiffness of folded angles
finite.
"""

from __future__ import annotations

from typing import Any

import warp as wp

NO_SINE = wp.constant(1.0e-6)
"""Sine below which two vectors count as parallel."""
LEAST_SINE = wp.constant(1.0e-3)
"""Smallest sine by which a Hessian is divided."""
NO_LENGTH = wp.constant(1.0e-12)
"""Length [cm] at or below which a vector has no direction."""


@wp.func
def unit_of(a: Any) -> tuple[Any, Any]:
    """Direction of a vector and 1 / length; both zero without a direction."""
    length = wp.length(a)
    inverse = type(length)(0.0)
    if length > type(length)(NO_LENGTH):
        inverse = type(length)(1.0) / length
    return a * inverse, inverse


@wp.func
def any_normal(p: Any) -> Any:
    """A unit vector across a unit vector."""
    zero, one = type(p[0])(0.0), type(p[0])(1.0)
    other = type(p)(one, zero, zero)
    if wp.abs(p[0]) > type(p[0])(0.6):
        other = type(p)(zero, one, zero)
    return wp.normalize(wp.cross(p, other))


@wp.func
def angle_gradient(a: Any, b: Any) -> tuple[Any, Any, Any]:
    """The angle in [0, pi] and its derivatives by a and b; these are zero where the vectors are parallel."""
    p, by_a = unit_of(a)
    q, by_b = unit_of(b)
    across = wp.cross(p, q)
    sine = wp.length(across)
    angle = wp.atan2(sine, wp.dot(p, q))
    inverse = type(sine)(0.0)
    if sine > type(sine)(NO_SINE):
        inverse = type(sine)(1.0) / sine
    z = across * inverse
    return angle, wp.cross(p, z) * by_a, wp.cross(z, q) * by_b


@wp.func
def angle_of(a: Any, b: Any) -> Any:
    """The angle in [0, pi]."""
    p, _by_a = unit_of(a)
    q, _by_b = unit_of(b)
    return wp.atan2(wp.length(wp.cross(p, q)), wp.dot(p, q))


@wp.func
def angle_frame(a: Any, b: Any) -> tuple[Any, Any, Any, Any, Any, Any, Any]:
    """The angle, its sine, unit vectors p and q, their unit normal z, 1 / |a| and 1 / |b|."""
    p, by_a = unit_of(a)
    q, by_b = unit_of(b)
    across = wp.cross(p, q)
    sine = wp.length(across)
    z = across / wp.max(sine, type(sine)(NO_SINE))
    if sine <= type(sine)(NO_SINE):
        z = any_normal(p)
    return wp.atan2(sine, wp.dot(p, q)), sine, p, q, z, by_a, by_b


@wp.func
def paired(a: Any, b: Any) -> Any:
    """Sum of the outer products a b^T and b a^T."""
    return wp.outer(a, b) + wp.outer(b, a)


@wp.func
def angle_blocks(
    p3: Any, q3: Any, z3: Any, by_a: Any, by_b: Any, slope: Any, side: Any, stiffness: Any, exact: Any
) -> tuple[Any, Any, Any]:
    """Blocks aa, ab and bb of the Hessian of E(t) at given D, as 4 x 4 matrices with a last row and column of zeros.

    Args:
        p3: p, with z and 1 / |a| as ``angle_frame`` finds them.
        q3: q.
        z3: z.
        by_a: 1 / |a|.
        by_b: 1 / |b|.
        slope: E_t [erg].
        side: E_t / sin t [erg], its limit where the sine is zero.
        stiffness: E_tt [erg].
        exact: share of the exact Hessian.
    """
    one = type(exact)(1.0)
    p, q, z = lifted(p3), lifted(q3), lifted(z3)
    m, n = lifted(wp.cross(z3, p3)), lifted(wp.cross(q3, z3))
    kept, level = wp.max(side, side * exact), slope * exact
    across = wp.outer(z, z) * kept
    beside = across * (one + (wp.dot(p, q) - one) * exact)
    aa = (beside + paired(p, m) * level + wp.outer(m, m) * stiffness) * (by_a * by_a)
    bb = (beside + paired(q, n) * level + wp.outer(n, n) * stiffness) * (by_b * by_b)
    ab = (wp.outer(m, n) * stiffness - across) * (by_a * by_b)
    return aa, ab, bb


@wp.func
def lifted(a: Any) -> Any:
    """A vector of three components with a zero as fourth one."""
    return wp.vector(a[0], a[1], a[2], a[0] - a[0])


@wp.func
def place_of(leg: Any) -> Any:
    """The first three components of a vector of four."""
    return wp.vector(leg[0], leg[1], leg[2])


@wp.func
def over_sine(value: Any, sine: Any) -> Any:
    """A value divided by a sine that does not go below ``LEAST_SINE``."""
    return value / wp.max(sine, type(sine)(LEAST_SINE))
