# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The energies of yarns that cross: stretch, contact of parallel yarns, bending and shear.

A guard keeps the energies finite where two nodes of a yarn come close along it and merge. The energies of a segment
contain 1 / D, where D is the rest length of yarn between two nodes. When sliding makes D small, the stiffness grows
without bound, and at D = 0 the energy has no value. Two measures keep it finite.

*The inverse.* Below the merging distance e, 1 / D is replaced by its Taylor polynomial of second order at e. The
polynomial has a value for every D, and is nowhere stiffer than at e:

    i(D) = 1 / D  for D >= e,   else  (1 + t + t^2) / e  with  t = (e - D) / e

*The spring.* A segment whose nodes have merged in space (length 0) has the stretch energy k_s D / 2, which shortens D
with the force k_s / 2. The published contact of parallel yarns is far weaker than this force. A spring therefore opens
D below twice the merging distance, g = 2 e:

    E = 1/2 (STRENGTH k_s / g) (g - D)^2  for D < g, else 0

At length 0 it balances the stretch at D = g (1 - 1 / (2 STRENGTH)) = 1.9 e. Only a strain above
sqrt(STRENGTH) - 1 = 2.2 in the neighbouring segment presses D below e. The merging distance is ``MERGING_SHARE`` of the
rest length or of the contact distance, whichever is smaller. Both measures therefore have no effect in any state that
yarns of their thickness can reach.

*Stretch* of a segment of yarn between two crossing nodes (Cirio et al. 2014, section 4.2).

With the length l = |x1 - x0| in space and the rest length D = u1 - u0 of the yarn between the nodes, |w| = l / D and

    E = 1/2 k_s D (|w| - 1)^2 = 1/2 k_s (l^2 / D - 2 l + D)

The energy is convex in (l, D): its second derivatives k_s / D (1, -|w|; -|w|, w^2) have rank one. Below the merging
distance 1 / D is replaced by i(D), where D i(D) - 1 = -t^3.

The functions subtract l and D before anything else, because strains of 1e-4 are common and single precision has seven
digits: l^2 i(D) - 2 l + D = (l - D)^2 i(D) - t^3 (2 l - D).

*Contact* of neighbouring parallel yarns, along the yarn that both cross (Cirio et al. 2014, section 4.5).

    E = 1/2 k_c L (D - d)^2  for D < d, else 0

D is the rest length of yarn between the two crossings, L its value in the layout, and d the contact distance. If the
yarn passes above at one crossing and below at the other, d = 4 R; if it passes on the same side, d = 2 R. Where the
layout is denser, d = L, so a fabric as laid out has no contact energy.

*Bending* of a yarn at a crossing node (Cirio et al. 2014, section 4.3).

    E = k_b (t - r)^2 / D

t is the angle by which the yarn turns at the node, r the same angle at rest, and D = u2 - u1 the rest length of yarn
from the node before to the node after. The node stands for the length D / 2, over which the curvature is 2 t / D, and
1/2 EI (2 t / D)^2 D / 2 = EI t^2 / D: the flexural rigidity is EI = k_b = B pi R^2.

Rest angles are the angles of the centre lines in the plane in which a fabric is laid out: zero for the straight yarns
of a weave, whose crimp the planar nodes do not show, and the turns of the loops in a knit. Yield changes them
(``crossing_term``). The angle has no sign: where r is not zero, a yarn may fold to either side, through a straight
state with the energy k_b r^2 / D.

The energy is convex in (t, D). Below the merging distance of the two segments 1 / D is replaced by i(D).

*Shear* of a weave at a crossing node (Cirio et al. 2014, section 4.4).

    E = 1/2 k_x L (f - r)^2,    k_x = S R^2

f is the angle between a segment of the warp and a segment of the weft that meet in the node, r the same angle in the
layout (usually pi / 2), and L the rest length between crossings. An inner node has four such pairs of segments, one for
each quadrant, each with this energy; a node at a border has only the pairs whose segments exist.

*Angle* between two vectors, its gradient, and the Hessian of an energy of this angle. With unit vectors p = a / |a| and
q = b / |b|, the angle t, the unit normal z of their plane, m = z x p and n = q x z,

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

from stitchmesh.compute.precision import Scalar, Vec2, Vec3, Vec4

NO_SINE = wp.constant(1.0e-6)
"""Sine below which two vectors count as parallel."""
LEAST_SINE = wp.constant(1.0e-3)
"""Smallest sine by which a Hessian is divided."""
NO_LENGTH = wp.constant(1.0e-12)
"""Length [cm] at or below which a vector has no direction."""


@wp.func
def unit_of(a: Vec3) -> tuple[Any, Any]:
    """Direction of a vector and 1 / length; both zero without a direction."""
    length = wp.length(a)
    inverse = type(length)(0.0)
    if length > type(length)(NO_LENGTH):
        inverse = type(length)(1.0) / length
    return a * inverse, inverse


@wp.func
def any_normal(p: Vec3) -> Any:
    """A unit vector across a unit vector."""
    zero, one = type(p[0])(0.0), type(p[0])(1.0)
    other = type(p)(one, zero, zero)
    if wp.abs(p[0]) > type(p[0])(0.6):
        other = type(p)(zero, one, zero)
    return wp.normalize(wp.cross(p, other))


@wp.func
def angle_gradient(a: Vec3, b: Vec3) -> tuple[Any, Any, Any]:
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
def angle_of(a: Vec3, b: Vec3) -> Any:
    """The angle in [0, pi]."""
    p, _by_a = unit_of(a)
    q, _by_b = unit_of(b)
    return wp.atan2(wp.length(wp.cross(p, q)), wp.dot(p, q))


@wp.func
def angle_frame(a: Vec3, b: Vec3) -> tuple[Any, Any, Any, Any, Any, Any, Any]:
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
def paired(a: Vec4, b: Vec4) -> Any:
    """Sum of the outer products a b^T and b a^T."""
    return wp.outer(a, b) + wp.outer(b, a)


@wp.func
def angle_blocks(
    p3: Vec3, q3: Vec3, z3: Vec3, by_a: Scalar, by_b: Scalar, slope: Scalar, side: Scalar, stiffness: Scalar,
    exact: Scalar
) -> tuple[Any, Any, Any]:  # fmt: skip
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
def lifted(a: Vec3) -> Any:
    """A vector of three components with a zero as fourth one."""
    return wp.vector(a[0], a[1], a[2], a[0] - a[0])


@wp.func
def place_of(leg: Vec4) -> Any:
    """The first three components of a vector of four."""
    return wp.vector(leg[0], leg[1], leg[2])


@wp.func
def over_sine(value: Scalar, sine: Scalar) -> Any:
    """A value divided by a sine that does not go below ``LEAST_SINE``."""
    return value / wp.max(sine, type(sine)(LEAST_SINE))


MERGING_SHARE = 0.1
"""Merging distance e as a share of the rest length or of the contact distance of a segment."""
STRENGTH = wp.constant(10.0)
"""Force of the opening spring at D = 0, as a multiple of k_s."""


@wp.func
def guarded_inverse(rest: Scalar, merging: Scalar) -> tuple[Any, Any, Any]:
    """i(D) [1/cm] and its first and second derivative."""
    one, two = type(rest)(1.0), type(rest)(2.0)
    inverse = one / wp.max(rest, merging)
    t = wp.max(merging - rest, type(rest)(0.0)) * inverse
    return inverse * (one + t + t * t), -inverse * inverse * (one + two * t), two * inverse * inverse * inverse


@wp.func
def opening_spring(rest: Scalar, merging: Scalar, stiffness: Scalar) -> tuple[Any, Any, Any]:
    """Energy [erg] of the spring that opens a segment, and its derivatives by D [dyn], [dyn/cm]."""
    zero, half, two = type(rest)(0.0), type(rest)(0.5), type(rest)(2.0)
    reach = two * merging
    closed = reach - rest
    pull = stiffness * type(rest)(STRENGTH) / reach
    if closed <= zero:
        pull = zero
    return half * pull * closed * closed, -pull * closed, pull


@wp.func
def stretch_energy(length: Scalar, rest: Scalar, merging: Scalar, stiffness: Scalar) -> Any:
    """E [erg]."""
    zero, half, two = type(rest)(0.0), type(rest)(0.5), type(rest)(2.0)
    inverse, _slope, _bend = guarded_inverse(rest, merging)
    t = wp.max(merging - rest, zero) / wp.max(rest, merging)
    apart = length - rest
    return half * stiffness * (apart * apart * inverse - t * t * t * (two * length - rest))


@wp.func
def stretch_slopes(length: Scalar, rest: Scalar, merging: Scalar, stiffness: Scalar) -> tuple[Any, Any]:
    """E_l and E_D [dyn]."""
    zero, half, two = type(rest)(0.0), type(rest)(0.5), type(rest)(2.0)
    inverse, _slope, _bend = guarded_inverse(rest, merging)
    most = wp.max(rest, merging)
    t, strain = wp.max(merging - rest, zero) / most, (length - most) / most
    by_length = stiffness * ((length - rest) * inverse - t * t * t)
    return by_length, -half * stiffness * (strain * (length + most) + two * t * length * length / most) / most


@wp.func
def stretch_curvatures(length: Scalar, rest: Scalar, merging: Scalar, stiffness: Scalar) -> tuple[Any, Any, Any]:
    """E_ll, E_lD and E_DD [dyn/cm]."""
    half = type(rest)(0.5)
    inverse, slope, bend = guarded_inverse(rest, merging)
    return stiffness * inverse, stiffness * length * slope, half * stiffness * length * length * bend


@wp.func
def contact_terms(rest: Scalar, distance: Scalar, stiffness: Scalar) -> tuple[Any, Any, Any]:
    """E [erg], E_D [dyn] and E_DD [dyn/cm]; ``stiffness`` is k_c L."""
    zero, half = type(rest)(0.0), type(rest)(0.5)
    depth = distance - rest
    push = stiffness
    if depth <= zero:
        push = zero
    return half * push * depth * depth, -push * depth, push


@wp.func
def bending_energy(turn: Scalar, rest: Scalar, span: Scalar, merging: Scalar, stiffness: Scalar) -> Any:
    """E [erg]."""
    inverse, _slope, _bend = guarded_inverse(span, merging)
    return stiffness * (turn - rest) * (turn - rest) * inverse


@wp.func
def bending_slopes(turn: Scalar, rest: Scalar, span: Scalar, merging: Scalar, stiffness: Scalar) -> tuple[Any, Any]:
    """E_t [erg] and E_D [dyn]."""
    two = type(turn)(2.0)
    inverse, slope, _bend = guarded_inverse(span, merging)
    return two * stiffness * (turn - rest) * inverse, stiffness * (turn - rest) * (turn - rest) * slope


@wp.func
def turn_over_sine(turn: Scalar, sine: Scalar) -> Any:
    """Quotient of an angle and its sine, which is 1 for a straight yarn."""
    result = over_sine(turn, sine)
    if sine < type(sine)(0.01) and turn < type(turn)(1.0):
        # exact to t^4, where a quotient of rounded numbers is not
        result = type(turn)(1.0) + turn * turn / type(turn)(6.0)
    return result


@wp.func
def bending_blocks(before: Vec4, after: Vec4, bend: Vec2, rest: Scalar, exact: Scalar) -> tuple[Any, Any, Any]:
    """Blocks of the Hessian of the leg before, of before and after, and of the leg after.

    Args:
        before: leg to the node before, and the difference of the coordinates; four components.
        after: leg to the node after.
        bend: k_b and the merging distance of both segments.
        rest: r.
        exact: share of the exact Hessian.
    """
    zero, one, two = type(rest)(0.0), type(rest)(1.0), type(rest)(2.0)
    a, b = -place_of(before), place_of(after)
    angle, sine, p, q, z, by_a, by_b = angle_frame(a, b)
    inverse, slope, curve = guarded_inverse(after[3] - before[3], bend[1])
    straight, bent = two * bend[0] * inverse, angle - rest
    mixed, along = two * bend[0] * bent * slope, bend[0] * bent * bent * curve
    if along * straight < mixed * mixed:  # only below the merging distance
        along += (mixed * mixed / straight - along) * (one - exact)
    side = straight * (turn_over_sine(angle, sine) - over_sine(rest, sine))
    aa, ab, bb = angle_blocks(p, q, z, by_a, by_b, straight * bent, side, straight, exact)
    if sine <= type(sine)(NO_SINE):
        mixed = zero * mixed  # a straight yarn has no direction in which its angle grows
    # the leg before is -a, and the span grows with the coordinate after and shrinks with the coordinate before
    by_before, by_after = lifted(wp.cross(z, p) * by_a), lifted(wp.cross(z, q) * by_b)
    span = wp.vector(zero, zero, zero, one)
    along_span = wp.outer(span, span) * along
    of_before = aa + along_span - paired(by_before, span) * mixed
    of_after = bb + along_span + paired(by_after, span) * mixed
    of_both = (wp.outer(by_before, span) - wp.outer(span, by_after)) * mixed - ab - along_span
    return of_before, of_both, of_after


@wp.func
def shear_energy(angle: Scalar, rest: Scalar, stiffness: Scalar) -> Any:
    """E [erg]; ``stiffness`` is k_x L."""
    return type(angle)(0.5) * stiffness * (angle - rest) * (angle - rest)


@wp.func
def shear_blocks(warp: Vec4, weft: Vec4, rest: Scalar, stiffness: Scalar, exact: Scalar) -> tuple[Any, Any, Any]:
    """Blocks of the Hessian of the leg of the warp, of both legs, and of the leg of the weft."""
    angle, sine, p, q, z, by_a, by_b = angle_frame(place_of(warp), place_of(weft))
    slope = stiffness * (angle - rest)
    aa, ab, bb = angle_blocks(p, q, z, by_a, by_b, slope, over_sine(slope, sine), stiffness, exact)
    return aa, ab, bb
