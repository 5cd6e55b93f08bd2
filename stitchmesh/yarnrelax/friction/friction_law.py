# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Coulomb's law for two contact samples: their normal force and their resistance to slip (``friction``).

A law is four numbers: the larger coefficient mu, (mu_along / mu)^2, (mu_across / mu)^2 and the slip length.

The energy mu N phi(s) is convex in the relative displacement u, because s is a norm and phi is convex and rises. Its
second derivative H has the upper bound K. Both are symmetric and have no negative eigenvalues:

    H = mu N (phi' / s A - c (A u) (A u)^T),    c = 1 / (e^2 s)  for s < e, else 1 / s^3        [erg / unit^2]
    K = mu N phi' / s A  >=  H

At s = 0, where the pair sticks without force, H = K = (2 mu N / e) A. Along a slip beyond e, H is zero.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.precision import Scalar, Vec3, Vec4, Vec6
from stitchmesh.simulation.friction_law import slip_curvature, slip_slope, within
from stitchmesh.yarnrelax.energies.contact import contact_force_scale, outer_product
from stitchmesh.yarnrelax.model.constants import YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import LatticeImages, sample_number
from stitchmesh.yarnrelax.model.spline import from_entry

# Two yarns cross where the difference of their unit tangents is longer than sqrt(0.1), an angle of 18 degrees; below
# that their contact is long, and only the direction that they share counts as along.


@wp.func
def across_both(apart: Vec3, first: Vec3, second: Vec3) -> Any:
    """Part of a vector across two yarns with these unit tangents."""
    same = type(apart[0])(1.0)
    if wp.dot(first, second) < type(same)(0.0):
        same = -same
    shared, other = first + second * same, first - second * same
    result = apart - shared * (wp.dot(apart, shared) / wp.dot(shared, shared))
    size2 = wp.dot(other, other)
    if size2 > type(same)(0.1):
        result -= other * (wp.dot(apart, other) / size2)
    return result


@wp.func
def vector_from(images: LatticeImages, samples: wp.array[Vec4], p: int, here: Vec4, entry: int, zero: Vec3) -> Any:
    """Vector from a listed sample, in its image, to ``here``, the place of ``p``."""
    apart = from_entry(images, samples, p, here, entry)
    return type(zero)(apart[0], apart[1], apart[2])


@wp.func
def press_of_pair(model: YarnConstants, samples: wp.array[Vec4], tangent: wp.array[Vec3], p: int, entry: int) -> Any:
    """N n of sample p and a listed one [erg / unit]; zero without contact, or where an end meets an end."""
    apart = from_entry(model.images, samples, p, samples[p], entry)
    away = type(tangent[p])(apart[0], apart[1], apart[2])
    distance2 = wp.dot(away, away)
    reach2 = apart[3] * apart[3]
    press = type(tangent[p])()
    if distance2 < reach2:
        q = sample_number(model.images, entry)
        stiffness = model.sample_stiffness[p] * model.sample_weight[q]
        push, _stiff, _inverse = contact_force_scale(model.contact, p, distance2, reach2, stiffness)
        press = across_both(away, tangent[p], tangent[q]) * push
    return press


@wp.func
def resisted_slip(slip: Vec3, normal: Vec3, first: Vec3, second: Vec3, law: Vec4) -> Any:
    """A u: the part of a slip that the contact resists, weighted by direction."""
    resisted = within(slip, normal) * law[2]
    if law[1] != law[2]:
        along = within(first, normal) * wp.dot(within(first, normal), slip)
        along += within(second, normal) * wp.dot(within(second, normal), slip)
        resisted += along * ((law[1] - law[2]) * type(slip[0])(0.5))
    return resisted


@wp.func
def slip_measure(slip: Vec3, resisted: Vec3) -> Any:
    """Slip of a pair in the measure of the law, s."""
    return wp.sqrt(wp.max(wp.dot(slip, resisted), type(slip[0])(0.0)))


@wp.func
def resistance_block(size: Scalar, normal: Vec3, first: Vec3, second: Vec3, law: Vec4, zero: Vec6) -> Any:
    """A times a number as (xx, yy, zz, xy, xz, yz); K of a pair for mu N phi' / s."""
    across, none = size * law[2], size - size
    block = type(zero)(across, across, across, none, none, none) - outer_product(normal, across, zero)
    if law[1] != law[2]:
        more = size * (law[1] - law[2]) * type(size)(0.5)
        block += outer_product(within(first, normal), more, zero) + outer_product(within(second, normal), more, zero)
    return block


@wp.func
def slip_stiffness_block(press: Vec3, slip: Vec3, first: Vec3, second: Vec3, law: Vec4, zero: Vec6) -> Any:
    """H of a pair as (xx, yy, zz, xy, xz, yz), by the place of one sample relative to the other [erg / unit^2].

    Args:
        press: N n of the pair [erg / unit].
        slip: u, the relative displacement from the anchor.
        first: unit tangent of the yarn at the sample.
        second: unit tangent at the other sample.
        law: the law.
        zero: a block of zeros.
    """
    normal = wp.normalize(press)
    resisted = resisted_slip(slip, normal, first, second, law)
    measure, size = slip_measure(slip, resisted), wp.length(press) * law[0]
    block = resistance_block(size * slip_slope(measure, law[3]), normal, first, second, law, zero)
    return block - outer_product(resisted, size * slip_curvature(measure, law[3]), zero)
