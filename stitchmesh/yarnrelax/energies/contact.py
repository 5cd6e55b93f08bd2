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

Yarn is a mass of fibres, and soft when squeezed. On request (``YarnMaterial.compression``) the law is van Wyk's (Note
on the compressibility of wool, J. Text. Inst. 37, T285, 1946): a mass of fibres of the volume V resists with a pressure
K Y (phi^3 - phi0^3), where phi = phi0 V0 / V is the part of the volume that is fibre, Y the modulus of the fibres and K
a number. Two parallel yarns whose axes are rho diameters apart are squeezed to the height rho, at constant width. Their
surfaces are hairy and round, and touch little by little, so the first order in 1 - rho is left out:

    F / L = k_contact (rho^-3 - 1 - 3 (1 - rho)),    k_contact = 2r K Y phi0^3        [dyn/cm]

The integral of f along a straight yarn must have this derivative. Abel's transform inverts the integral, and gives with
theta = arccos rho and s = sqrt(1 - rho^2)

    f(rho)   = [(theta + rho s) / (2 rho^3) - 4 arcosh(1 / rho) + 3 s] / pi
    f'(rho)  = [3 s / rho - 3 (theta + rho s) / (2 rho^4)] / pi
    f''(rho) = 6 (theta + rho s) / (pi rho^5)

Yarns that cross at an angle phi press with 4 pi r k_contact rho f(rho) / sin(phi). Under a high pressure p the distance
follows p^(-1/3); the law of Kaldor leads to p^(-1/2).
"""

# overloads, which Warp distinguishes by the types of their arguments
# ruff: noqa: F811
# mypy: disable-error-code="no-redef"

from __future__ import annotations

import functools
from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import kernel_factory
from stitchmesh.compute.precision import Scalar, ScalarType, Vec4, Vec6, Vec9, load_vector, store_vector, vector
from stitchmesh.yarnrelax.energies.cell_virial import add_contact_virial
from stitchmesh.yarnrelax.model.constants import StiffContact, YarnConstants, YarnContact, entries_at_once
from stitchmesh.yarnrelax.model.lattice_images import cell_of_sample, rests, sample_number
from stitchmesh.yarnrelax.model.spline import from_entry

INVERSE_PI = 0.3183098861837907
"""1 / pi."""


@wp.func
def stiff_energy(distance2: Scalar, reach2: Scalar, stiffness: Scalar) -> Any:
    """Energy [erg] of two samples by the law of Kaldor."""
    d2 = distance2 / reach2
    return stiffness * (type(d2)(1.0) / d2 + d2 - type(d2)(2.0))


@wp.func
def soft_energy(distance2: Scalar, reach2: Scalar, stiffness: Scalar) -> Any:
    """Energy [erg] of two samples by van Wyk's law."""
    rho, s = wp.sqrt(distance2 / reach2), wp.sqrt((reach2 - distance2) / reach2)
    inverse = type(rho)(1.0) / rho
    lens = (wp.atan2(s, rho) + rho * s) * type(rho)(0.5) * inverse * inverse * inverse
    far = wp.log((type(rho)(1.0) + s) * inverse)
    return stiffness * type(rho)(INVERSE_PI) * (lens - type(rho)(4.0) * far + type(rho)(3.0) * s)


@wp.func
def contact_energy(contact: StiffContact, p: int, distance2: Scalar, reach2: Scalar, stiffness: Scalar) -> Any:
    """Energy [erg] of sample ``p`` and another one at a squared distance below ``reach2``."""
    return stiff_energy(distance2, reach2, stiffness)


@wp.func
def contact_energy(contact: YarnContact, p: int, distance2: Scalar, reach2: Scalar, stiffness: Scalar) -> Any:
    """Energy [erg] of sample ``p`` and another one at a squared distance below ``reach2``."""
    if contact.soft[p] != 0:
        return soft_energy(distance2, reach2, stiffness)
    return stiff_energy(distance2, reach2, stiffness)


@wp.func
def soft_force_scale(distance2: Scalar, reach2: Scalar, stiffness: Scalar) -> tuple[Any, Any, Any]:
    """The same three numbers as ``stiff_force_scale``, by van Wyk's law."""
    rho, s = wp.sqrt(distance2 / reach2), wp.sqrt((reach2 - distance2) / reach2)
    inverse = type(rho)(1.0) / rho
    inverse2 = inverse * inverse
    scale = stiffness / reach2 * type(rho)(INVERSE_PI)
    lens = (wp.atan2(s, rho) + rho * s) * inverse2 * inverse2 * inverse
    push = type(rho)(1.5) * lens - type(rho)(3.0) * s * inverse2
    return scale * push, scale * type(rho)(6.0) * lens, inverse2 / reach2


@wp.func
def stiff_force_scale(distance2: Scalar, reach2: Scalar, stiffness: Scalar) -> tuple[Any, Any, Any]:
    """Force over the vector from the other sample; second derivative of the energy by the distance; 1 / distance^2."""
    inverse = type(reach2)(1.0) / reach2
    ratio = reach2 / distance2
    ratio2 = ratio * ratio
    scale = stiffness * inverse
    push = type(ratio)(2.0) * scale * (ratio2 - type(ratio)(1.0))
    return push, scale * (type(ratio)(6.0) * ratio2 + type(ratio)(2.0)), ratio * inverse


@wp.func
def contact_force_scale(
    contact: StiffContact, p: int, distance2: Scalar, reach2: Scalar, stiffness: Scalar
) -> tuple[Any, Any, Any]:
    """Force over the vector from the other sample; second derivative of the energy by the distance; 1 / distance^2."""
    return stiff_force_scale(distance2, reach2, stiffness)


@wp.func
def contact_force_scale(
    contact: YarnContact, p: int, distance2: Scalar, reach2: Scalar, stiffness: Scalar
) -> tuple[Any, Any, Any]:
    """Force over the vector from the other sample; second derivative of the energy by the distance; 1 / distance^2."""
    if contact.soft[p] != 0:
        return soft_force_scale(distance2, reach2, stiffness)
    return stiff_force_scale(distance2, reach2, stiffness)


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
                    size, stiff, inverse = contact_force_scale(model.contact, p, distance2, reach2, weight[k])
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
