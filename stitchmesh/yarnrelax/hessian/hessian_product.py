# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The product of the Hessian of stretch, bending and contact with a motion of the control points.

In a mixed system, splines are solved for together with triangles, without a matrix (``stitchmesh.mixed.splines``). A
motion changes each leg, and each gap of a pair in contact. The products with the matrices of ``segment_hessian`` and
``contact_hessian`` are gathered at the control points like forces (``evaluation``). The periods of a lattice stay.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Mat33, Vec3, Vec4, load_vector, matrix, store_vector
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.evaluation import leg_forces_on, sample_forces_on
from stitchmesh.yarnrelax.hessian.contact_hessian import TouchingPairs
from stitchmesh.yarnrelax.hessian.segment_hessian import leg_hessian_launch
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import sample_number
from stitchmesh.yarnrelax.model.spline import weight_row
from stitchmesh.yarnrelax.model.state import State


@kernel
def segment_product(
    # model
    model: YarnConstants,
    # state in
    leg_hessian: wp.array2d[Mat33],
    motion: wp.array[Vec3],
    # state out
    sample_motion: wp.array[Vec4],
    leg_product: wp.array2d[Vec3],
) -> None:
    """The product for each leg, and the motion of each contact sample."""
    s = wp.tid()
    corner = model.segment_points[s]
    u0, u1, u2, u3 = motion[corner[0]], motion[corner[1]], motion[corner[2]], motion[corner[3]]
    first = model.sample_start[s]
    count = model.sample_start[s + 1] - first
    row = weight_row(model, count, 0)
    for k in range(count):
        weight = model.sample_basis[row + k]
        u = u0 * weight[0] + u1 * weight[1] + u2 * weight[2] + u3 * weight[3]
        store_vector(sample_motion, first + k, type(sample_motion[0])(u[0], u[1], u[2], u[0] - u[0]))
    change0, change1, change2 = u1 - u0, u2 - u1, u3 - u2
    h01, h02, h12 = leg_hessian[1, s], leg_hessian[2, s], leg_hessian[4, s]
    leg_product[0, s] = leg_hessian[0, s] * change0 + h01 * change1 + h02 * change2
    leg_product[1, s] = wp.transpose(h01) * change0 + leg_hessian[3, s] * change1 + h12 * change2
    leg_product[2, s] = wp.transpose(h02) * change0 + wp.transpose(h12) * change1 + leg_hessian[5, s] * change2


@kernel
def contact_product(
    # model
    model: YarnConstants,
    # state in
    touching_count: wp.array[wp.int32],
    touching: wp.array2d[wp.int32],
    stiffness: wp.array2d[Vec4],
    sample_motion: wp.array[Vec4],
    # state out
    sample_product: wp.array[Vec4],
) -> None:
    """The product for each sample."""
    p = wp.tid()
    own = load_vector(sample_motion, p)
    total = type(own)()
    for c in range(touching_count[p]):
        k = stiffness[p, c]
        change = own - load_vector(sample_motion, sample_number(model.images, touching[p, c]))
        along = k[0] * change[0] + k[1] * change[1] + k[2] * change[2]
        total += type(own)(
            k[0] * along - k[3] * change[0], k[1] * along - k[3] * change[1], k[2] * along - k[3] * change[2], own[3]
        )
    store_vector(sample_product, p, total)


@kernel
def gather_product(
    # model
    model: YarnConstants,
    # state in
    leg_product: wp.array2d[Vec3],
    sample_product: wp.array[Vec4],
    # state out
    product: wp.array[Vec3],
) -> None:
    """The product for each control point."""
    i = wp.tid()
    slots = model.point_segments[i]
    total = type(leg_product[0, 0])()
    contact = type(sample_product[0])()
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            total += leg_forces_on(leg_product, s, slot)
            contact += sample_forces_on(model, sample_product, s, slot)
    product[i] = total + type(total)(contact[0], contact[1], contact[2])


class Hessian:
    """The matrices of the current state and the arrays of a product."""

    def __init__(self, model: Model, state: State, candidates: Candidates) -> None:
        """Allocate the arrays for a state."""
        self.model, self.state = model, state
        self.exact = model.empty(model.segment_count)
        """Share of the exact matrix of each segment, shape (S,); the rest is the Gauss-Newton matrix."""
        self.leg_hessian = wp.zeros((6, model.segment_count), dtype=matrix(3, model.scalar), device=model.device)
        self.touching = TouchingPairs(model, candidates)
        self._sample_motion = model.empty(model.sample_count, 4)
        self._sample_product = model.empty(model.sample_count, 4)
        self._leg_product = model.empty((3, model.segment_count), 3)

    def find_launches(self, launcher: Launcher) -> list[Any]:
        """Return the launches that find the matrices at the current points and samples."""
        return [
            leg_hessian_launch(self.model, self.exact, self.state.points, self.leg_hessian, launcher),
            *self.touching.pair_stiffness(self.exact, self.state.samples, launcher).launches,
        ]

    def product_launches(self, motion: wp.array[Any], product: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launches that find the product with a motion, both of shape (N, 3)."""
        model, pairs = self.model, self.touching
        return [
            launcher(segment_product, model.segment_count, [model.constants, self.leg_hessian, motion],
                     [self._sample_motion, self._leg_product]),
            launcher(contact_product, model.sample_count,
                     [model.constants, pairs.count, pairs.entries, pairs.stiffness, self._sample_motion],
                     [self._sample_product]),
            launcher(gather_product, model.point_count,
                     [model.constants, self._leg_product, self._sample_product], [product]),
        ]  # fmt: skip
