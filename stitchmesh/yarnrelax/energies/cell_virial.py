# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contributions of elements of a relaxing cell to the forces on its strains and to their stiffness (``cell_strain``).

There are nine sums: the forces W_11, W_22, W_12, and the block of stiffness (aa, bb, cc, ab, ac, bc) with the strains
m = (t1^2, t2^2, t1 t2) of an element along t. Friction acts across the gap g of its pair, with at most the stiffness k
in each direction, so its block is k times the block of |dF g|^2: (g1^2, g2^2, g2^2, 0, g1 g2, 0).
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.precision import Scalar, Vec3, Vec4, Vec9
from stitchmesh.yarnrelax.model.lattice_images import LatticeImages, cell_of_sample


@wp.func
def add_virial(
    total: Vec9, first: Scalar, second: Scalar, force1: Scalar, force2: Scalar, stiffness: Scalar, inverse: Scalar
) -> Any:
    """Add an element of in-plane extent (first, second), force, stiffness by its strain, and 1 / length^2."""
    m0, m1, m2 = first * first * inverse, second * second * inverse, first * second * inverse
    k0, k1, k2 = stiffness * m0, stiffness * m1, stiffness * m2
    return total + type(total)(
        force1 * first, force2 * second, force1 * second, k0 * m0, k1 * m1, k2 * m2, k0 * m1, k0 * m2, k1 * m2
    )


@wp.func
def add_leg_virial(total: Vec9, e1: Vec3, e2: Vec3, leg: Vec3, pull: Vec3, stiffness: Scalar) -> Any:
    """Add a leg of a segment."""
    inverse = type(stiffness)(1.0) / wp.max(wp.dot(leg, leg), type(stiffness)(1.0e-30))
    return add_virial(total, wp.dot(leg, e1), wp.dot(leg, e2), wp.dot(pull, e1), wp.dot(pull, e2), stiffness, inverse)


@wp.func
def add_contact_virial(
    total: Vec9, images: LatticeImages, p: int, gap: Vec4, size: Scalar, stiffness: Scalar, distance2: Scalar,
    inverse: Scalar
) -> Any:  # fmt: skip
    """Add half of the virial of a pair in contact; the other sample of the pair adds the other half.

    The force is ``size`` times the gap. ``inverse`` is 1 / distance^2, which contact has computed already: a division
    is slow on a GPU.
    """
    cell = cell_of_sample(images, p)
    e1, e2 = images.frame[2 * cell], images.frame[2 * cell + 1]
    half = type(size)(0.5)
    g1, g2 = gap[0] * e1[0] + gap[1] * e1[1] + gap[2] * e1[2], gap[0] * e2[0] + gap[1] * e2[1] + gap[2] * e2[2]
    return add_virial(total, g1, g2, g1 * size * half, g2 * size * half, stiffness * distance2 * half, inverse)


@wp.func
def add_friction_virial(total: Vec9, images: LatticeImages, p: int, gap: Vec3, force: Vec3, stiffness: Scalar) -> Any:
    """Add half of the virial of a pair that friction holds; the other sample of the pair adds the other half."""
    cell = cell_of_sample(images, p)
    e1, e2 = images.frame[2 * cell], images.frame[2 * cell + 1]
    half = type(stiffness)(0.5)
    g1, g2, k, none = wp.dot(gap, e1), wp.dot(gap, e2), stiffness * half, stiffness - stiffness
    f1, f2 = wp.dot(force, e1) * half, wp.dot(force, e2) * half
    aa, bb, ac = k * g1 * g1, k * g2 * g2, k * g1 * g2
    return total + type(total)(f1 * g1, f2 * g2, f1 * g2, aa, bb, bb, none, ac, none)
