# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The forces of a yarn on itself: stretch, bending and length penalty of all segments in one launch.

Stretch is the resistance of a yarn to another length, or distribution of length, than at rest (L eq 8; Kaldor 2008).
The energy of one segment of rest length l, with y' the derivative by its parameter s in [0, 1], is

    E = k_len (l / l0) int (1 - |y'| / l)^2 ds        [erg]

where k_len is the coefficient of a segment of length l0 (``material``). Under a uniform stretch by lambda a yarn of
length L has the energy k_len (L / l0) (1 - lambda)^2, however it is cut into segments. The length penalty depends on
the length of the whole segment. It replaces the constraint of inextensible segments (L eq 1):

    E = k_length (l / l0) (1 - (1 / l) int |y'| ds)^2        [erg]

Bending is the resistance of a yarn that is straight at rest (L eq 7; Kaldor 2008), or has a natural curvature k:

    E = k_bend l int (kappa - k)^2 ds,   kappa = |c| / |y'|^3,   c = y' x y'',   k >= 0        [erg]

A ring of radius R has the energy 2 pi R k_bend (1 / R - k)^2; the flexural rigidity EI is 2 k_bend. The yarn can rotate
about its own axis without energy. Its natural curvature therefore points in the direction of its curvature, because
this rotation has the least energy of all. The gradients are the gradients of a straight yarn, with t = y'
and a = y'', times 1 - k / kappa:

    d kappa^2 / dt = 2 (a x c) / |t|^6 - 6 |c|^2 t / |t|^8,    d kappa^2 / da = 2 (c x t) / |t|^6

This energy has a kink at kappa = 0. Below q k, with q = 1/4, it continues as the parabola in kappa that has the same
value and slope at q k, (1 - q) k^2 - (1/q - 1) kappa^2. A straight segment has 3/4 of the exact energy.

A force on a segment acts through the three legs between its control points (``spline``). Three leg forces are stored
for each segment, and the four control points get differences of the leg forces (``evaluation``).
"""

from __future__ import annotations

import functools
from itertools import product
from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import kernel_factory
from stitchmesh.compute.precision import Scalar, Vec2, Vec3, Vec4, Vec7, Vec9
from stitchmesh.yarnrelax.energies.cell_virial import add_leg_virial
from stitchmesh.yarnrelax.model.constants import YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of, rests
from stitchmesh.yarnrelax.model.spline import put_samples, segment_corners

NEARLY_STRAIGHT = wp.constant(0.25)
"""Below this part of the natural curvature the energy continues as a parabola."""


@wp.func
def stretch_energy(speed: Scalar, rest_length: Scalar, stiffness: Scalar) -> Any:
    """Energy [erg] at a point of the curve where |y'| is ``speed`` [cm]."""
    strain = speed / rest_length - type(speed)(1.0)
    return stiffness * strain * strain


@wp.func
def stretch_slope(speed: Scalar, per_length: Scalar, stiffness: Scalar) -> Any:
    """Derivative of the energy by the speed; ``per_length`` is 1 over the rest length."""
    return type(speed)(2.0) * stiffness * (speed * per_length - type(speed)(1.0)) * per_length


@wp.func
def length_energy(length: Scalar, rest_length: Scalar, stiffness: Scalar) -> Any:
    """Energy [erg] of a segment that is ``length`` long."""
    strain = length / rest_length - type(length)(1.0)
    return stiffness * strain * strain


@wp.func
def length_slope(length: Scalar, rest_length: Scalar, stiffness: Scalar) -> Any:
    """Derivative of the energy by the length."""
    return type(length)(2.0) * stiffness * (length / rest_length - type(length)(1.0)) / rest_length


@wp.func
def bend_energy(tangent: Vec3, turn: Vec3, stiffness: Scalar, natural: Scalar) -> Any:
    """Energy [erg] at a point of the curve; ``stiffness`` is k_bend times the rest length."""
    normal = wp.cross(tangent, turn)
    speed2 = wp.dot(tangent, tangent)
    curvature2 = wp.dot(normal, normal) / (speed2 * speed2 * speed2)
    if natural > type(natural)(0.0):
        part, one = type(natural)(NEARLY_STRAIGHT), type(natural)(1.0)
        least, away = part * natural, wp.sqrt(curvature2) - natural
        if curvature2 < least * least:
            return stiffness * ((one - part) * natural * natural - (one / part - one) * curvature2)
        return stiffness * away * away
    return stiffness * curvature2


@wp.func
def bend_slopes(tangent: Vec3, turn: Vec3, inverse: Scalar, stiffness: Scalar, natural: Scalar) -> tuple[Any, Any]:
    """Derivatives of the energy by y' and by y''; ``inverse`` is 1 / |y'|^2."""
    normal = wp.cross(tangent, turn)
    scale = type(stiffness)(2.0) * stiffness * inverse * inverse * inverse
    if natural > type(natural)(0.0):
        curvature = wp.sqrt(wp.dot(normal, normal) * inverse) * inverse
        scale *= type(natural)(1.0) - natural / wp.max(curvature, type(natural)(NEARLY_STRAIGHT) * natural)
    shrink = type(stiffness)(3.0) * wp.dot(normal, normal) * inverse
    by_tangent = (wp.cross(turn, normal) - tangent * shrink) * scale
    by_turn = wp.cross(normal, tangent) * scale
    return by_tangent, by_turn


@functools.cache
def leg_force_function(quadrature_points: int) -> Any:
    """Return the function of a segment's leg forces, for a number of quadrature points that the compiler knows.

    The compiler unrolls a loop of known length, so that square roots and divisions of different points overlap. Small
    scenes run twice as fast, measured on a GPU.
    """

    @wp.func
    def leg_forces(
        model: YarnConstants, k: Vec3, rest_length: Scalar, natural: Vec2, leg0: Vec3, leg1: Vec3, leg2: Vec3
    ) -> tuple[Any, Any, Any]:
        """Force on the end of each leg; the start of the leg feels its opposite."""
        of_segment = k * rest_length
        k_len, k_length, k_bend = of_segment[0], of_segment[1], of_segment[2]
        turn0, turn1 = leg1 - leg0, leg2 - leg1
        force0, force1, force2 = type(leg0)(), type(leg0)(), type(leg0)()
        along0, along1, along2 = type(leg0)(), type(leg0)(), type(leg0)()
        length = rest_length - rest_length
        per_length = type(rest_length)(1.0) / rest_length
        for g in range(quadrature_points):
            rule = model.rule[g]
            tangent = leg0 * rule[0] + leg1 * rule[1] + leg2 * rule[2]
            turn = turn0 * rule[3] + turn1 * rule[4]
            speed = wp.length(tangent)
            inverse = type(speed)(1.0) / speed
            direction = tangent * inverse
            length += speed * rule[5]
            curvature = wp.abs(natural[0] * rule[3] + natural[1] * rule[4])
            by_tangent, by_turn = bend_slopes(tangent, turn, inverse * inverse, k_bend * rule[5], curvature)
            by_tangent += direction * stretch_slope(speed, per_length, k_len * rule[5])
            first, last = by_turn * rule[3], by_turn * rule[4]
            force0 += by_tangent * rule[0] - first
            force1 += by_tangent * rule[1] + first - last
            force2 += by_tangent * rule[2] + last
            share = direction * rule[5]
            along0 += share * rule[0]
            along1 += share * rule[1]
            along2 += share * rule[2]
        slope = length_slope(length, rest_length, k_length)
        return -(force0 + along0 * slope), -(force1 + along1 * slope), -(force2 + along2 * slope)

    return leg_forces


@wp.func
def natural_ends(model: YarnConstants, s: int) -> Any:
    """Natural curvature at both ends of a segment [1 / unit]; the array is empty where all yarns are straight."""
    ends = type(model.segment_natural[0])()
    if model.segment_natural.shape[0] > 0:
        ends = model.segment_natural[s]
    return ends


@wp.func
def mean_direction(rest_length: Scalar, leg0: Vec3, leg1: Vec3, leg2: Vec3, zero: Vec7) -> Any:
    """Means over a segment by Simpson's rule: t t^T as (xx, yy, zz, xy, xz, yz), t the unit tangent; (l / |y'|)^4."""
    half = type(rest_length)(0.5)
    first, last = (leg0 + leg1) * half, (leg1 + leg2) * half
    middle = (first + last) * half + (leg1 + leg1 - leg0 - leg2) * (half * half * half)
    return simpson_part(first, type(half)(1.0 / 6.0), rest_length, zero) + (
        simpson_part(middle, type(half)(4.0 / 6.0), rest_length, zero)
        + simpson_part(last, type(half)(1.0 / 6.0), rest_length, zero)
    )


@wp.func
def simpson_part(tangent: Vec3, weight: Scalar, rest_length: Scalar, zero: Vec7) -> Any:
    """Contribution of one point of the rule to ``mean_direction``."""
    # where control points coincide the parameter speed is zero, and the mean would not be a number
    slowest = rest_length * rest_length * type(weight)(1.0e-3)
    inverse = type(weight)(1.0) / wp.max(wp.dot(tangent, tangent), slowest)
    x, y, z = tangent[0], tangent[1], tangent[2]
    scale = weight * inverse
    slow = rest_length * rest_length * inverse
    return type(zero)(
        x * x * scale, y * y * scale, z * z * scale, x * y * scale, x * z * scale, y * z * scale, weight * slow * slow
    )


@functools.cache
def segment_force_function(quadrature_points: int, cell_relaxes: bool) -> Any:
    """Return the function that finds the forces of a segment with given control points.

    For cells that relax, the function also finds the segment's part of the virial of the cell.
    """
    leg_forces = leg_force_function(quadrature_points)

    @wp.func
    def segment_forces_at(
        model: YarnConstants, s: int, terms: Vec3, q0: Vec3, q1: Vec3, q2: Vec3, q3: Vec3, leg_force: wp.array2d[Vec3],
        segment_virial: wp.array[Vec9]
    ) -> None:  # fmt: skip
        """Write the leg forces of a segment [erg / unit]; ``terms`` is 1 or 0 for stretch, length and bending."""
        rest_length = model.segment_rest_length[s]
        k = wp.cw_mul(model.segment_stiffness[s], terms)
        natural = natural_ends(model, s)
        force0, force1, force2 = leg_forces(model, k, rest_length, natural, q1 - q0, q2 - q1, q3 - q2)
        leg_force[0, s] = force0
        leg_force[1, s] = force1
        leg_force[2, s] = force2
        if wp.static(cell_relaxes):
            cell = cell_of(model.images, s)
            e1, e2 = model.images.frame[2 * cell], model.images.frame[2 * cell + 1]
            third = (k[0] + k[1]) * rest_length * type(rest_length)(2.0 / 3.0)
            virial = add_leg_virial(type(segment_virial[0])(), e1, e2, q1 - q0, force0, third)
            virial = add_leg_virial(virial, e1, e2, q2 - q1, force1, third)
            segment_virial[s] = add_leg_virial(virial, e1, e2, q3 - q2, force2, third)

    return segment_forces_at


@wp.func
def mean_direction_at(
    model: YarnConstants, s: int, q0: Vec3, q1: Vec3, q2: Vec3, q3: Vec3, segment_block: wp.array[Vec7]
) -> None:
    """Write ``mean_direction`` of a segment with given control points."""
    segment_block[s] = mean_direction(model.segment_rest_length[s], q1 - q0, q2 - q1, q3 - q2, segment_block[0])


@kernel_factory(lambda form: product((*form.quadratures, *form.measured_quadratures), form.relaxing))
def samples_and_segment_forces(quadrature_points: int, cell_relaxes: bool) -> wp.Kernel:
    """Return the kernel that places samples and finds leg forces; it reads each segment's control points once."""
    segment_forces_at = segment_force_function(quadrature_points, cell_relaxes)

    @kernel
    def samples_and_segment_forces(
        # model
        model: YarnConstants,
        terms: Vec3,
        # state in
        points: wp.array[Vec3],
        # state out
        samples: wp.array[Vec4],
        leg_force: wp.array2d[Vec3],
        segment_block: wp.array[Vec7],
        segment_virial: wp.array[Vec9],
    ) -> None:
        """Contact samples and leg forces of each segment; ``mean_direction`` where a solver reads it."""
        s = wp.tid()
        if rests(model.images, cell_of(model.images, s)):
            return
        q0, q1, q2, q3 = segment_corners(model, points, s)
        put_samples(model, s, q0, q1, q2, q3, samples)
        segment_forces_at(model, s, terms, q0, q1, q2, q3, leg_force, segment_virial)
        if segment_block.shape[0] > 0:
            mean_direction_at(model, s, q0, q1, q2, q3, segment_block)

    return samples_and_segment_forces
