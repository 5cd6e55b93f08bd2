# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact: yarns push each other apart where they overlap (L eqs 9, 10; Kaldor 2008).

Energy of two segments of rest lengths l_i, l_j, each unordered pair counted once:

    E = k_contact l_i l_j int int f(|y_i(s) - y_j(s')| / 2r) ds ds'        [erg]
    f(d) = 1/d^2 + d^2 - 2  for d < 1, else 0

with r_i + r_j instead of 2r if the radii differ. The integrals are midpoint sums over the contact samples. They
converge fast, because the integrand is smooth along yarns with many samples. The force on a sample p is

    F_p = sum over q of  2 k_contact w_p w_q (R^4 / d^4 - 1) / R^2 (y_p - y_q),   R = r_p + r_q,  d = |y_p - y_q|

where w = l / samples of the segment. Each sample of a pair computes its own force. Both use the same numbers, so the
forces sum to zero up to rounding.
"""

from __future__ import annotations

import functools
from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import kernel_factory
from stitchmesh.compute.precision import Scalar, ScalarType, Vec4, Vec6, Vec9, load_vector, store_vector, vector
from stitchmesh.yarnrelax.energies.cell_virial import add_contact_virial
from stitchmesh.yarnrelax.model.constants import YarnConstants, entries_at_once
from stitchmesh.yarnrelax.model.lattice_images import cell_of_sample, rests, sample_number
from stitchmesh.yarnrelax.model.spline import from_entry


@wp.func
def contact_energy(distance2: Scalar, reach2: Scalar, stiffness: Scalar) -> Any:
    """Energy [erg] of two samples at a squared distance below ``reach2``."""
    d2 = distance2 / reach2
    return stiffness * (type(d2)(1.0) / d2 + d2 - type(d2)(2.0))


@wp.func
def contact_force_scale(distance2: Scalar, reach2: Scalar, stiffness: Scalar) -> tuple[Any, Any, Any]:
    """Force over the vector from the other sample; second derivative of the energy by the distance; 1 / distance^2."""
    inverse = type(reach2)(1.0) / reach2
    ratio = reach2 / distance2
    ratio2 = ratio * ratio
    scale = stiffness * inverse
    push = type(ratio)(2.0) * scale * (ratio2 - type(ratio)(1.0))
    return push, scale * (type(ratio)(6.0) * ratio2 + type(ratio)(2.0)), ratio * inverse


@wp.func
def outer_product(apart: Any, size: Scalar, zero: Vec6) -> Any:
    """The product apart apart^T times size as (xx, yy, zz, xy, xz, yz)."""
    x, y, z = apart[0] * size, apart[1] * size, apart[2] * size
    return type(zero)(x * apart[0], y * apart[1], z * apart[2], x * apart[1], x * apart[2], y * apart[2])


@functools.cache
def contact_force_function(scalar: ScalarType, entries_at_once: int, cell_relaxes: bool) -> Any:
    """Return the function of a sample's contact force in one precision; it reads ``entries_at_once`` entries of a list.

    For cells that relax, the function also finds the sample's part of the virial of the cell. A GPU loads four entries
    at the same time; a CPU is fastest with one. Entries beyond the end of a list are left out.
    """
    vectors, scalars = wp.types.matrix(shape=(entries_at_once, 4), dtype=scalar), vector(entries_at_once, scalar)

    @wp.func
    def contact_force_at(
        model: YarnConstants, p: int, candidate_count: wp.array[wp.int32], candidates: wp.array2d[wp.int32],
        samples: wp.array[Vec4], sample_force: wp.array[Vec4], sample_block: wp.array[Vec6],
        sample_virial: wp.array[Vec9]
    ) -> None:  # fmt: skip
        """Write the force on a sample and the row sum of its stiffness; its block of stiffness where it is read."""
        here = load_vector(samples, p)
        force = type(here)()
        block = type(sample_block[0])()
        virial = type(sample_virial[0])()
        count = candidate_count[p]
        apart, weight = vectors(), scalars()
        for c in range(0, count, entries_at_once):
            for k in range(entries_at_once):
                entry = candidates[p, wp.min(c + k, count - 1)]
                apart[k] = from_entry(model.images, samples, p, here, entry)
                weight[k] = model.sample_weight[sample_number(model.images, entry)]
            for k in range(entries_at_once):
                gap = apart[k]
                distance2 = gap[0] * gap[0] + gap[1] * gap[1] + gap[2] * gap[2]
                reach2 = gap[3] * gap[3]
                if distance2 < reach2 and c + k < count:
                    size, stiff, inverse = contact_force_scale(distance2, reach2, weight[k])
                    force += type(here)(gap[0] * size, gap[1] * size, gap[2] * size, stiff)
                    block += outer_product(gap, stiff * inverse, block)
                    if wp.static(cell_relaxes):
                        virial = add_contact_virial(virial, model.images, p, gap, size, stiff, distance2, inverse)
        scale = model.sample_stiffness[p]
        store_vector(sample_force, p, force * scale)
        if sample_block.shape[0] > 0:
            sample_block[p] = block * scale
        if wp.static(cell_relaxes):
            sample_virial[p] = virial * scale

    return contact_force_at


@kernel_factory(
    lambda form: [(form.scalar, entries_at_once(on_gpu=form.on_gpu), relaxes) for relaxes in form.relaxing]
)
def contact_forces(scalar: ScalarType, entries_at_once: int, cell_relaxes: bool) -> wp.Kernel:
    """Return the kernel of ``contact_force_function`` for all samples."""
    contact_force_at = contact_force_function(scalar, entries_at_once, cell_relaxes)

    @kernel
    def contact_forces(
        # model
        model: YarnConstants,
        # state in
        candidate_count: wp.array[wp.int32],
        candidates: wp.array2d[wp.int32],
        samples: wp.array[Vec4],
        # state out
        sample_force: wp.array[Vec4],
        sample_block: wp.array[Vec6],
        sample_virial: wp.array[Vec9],
    ) -> None:
        """Contact force on each sample."""
        p = wp.tid()
        if not rests(model.images, cell_of_sample(model.images, p)):
            contact_force_at(model, p, candidate_count, candidates, samples, sample_force, sample_block, sample_virial)

    return contact_forces
