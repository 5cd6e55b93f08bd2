# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact: yarns push each other apart where they overlap (L eqs 9, 10; Kaldor 2008).

Energy of two segments of rest lengths l_i, l_j, each unordered pair counted once:

    E = k_contact l_i l_j int int f(|y_i(s) - y_j(s')| / 2r) ds ds'        [erg]
    f(d) = 1/d^2 + d^2 - 2  for d < 1, else 0

with r_i + r_j in place of 2r where radii differ. The integrals are midpoint sums over the contact samples, which
converge fast because the integrand is smooth along yarns that are many samples long. The force on a sample p is

    F_p = sum over q of  2 k_contact w_p w_q (R^4 / d^4 - 1) / R^2 (y_p - y_q),   R = r_p + r_q,  d = |y_p - y_q|

where w = l / samples per segment. It is computed from p's side and from q's side, so that each sample gathers its own
force; both sides use the same numbers, so the forces sum to zero up to rounding.
"""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.yarnrelax.aligned import read_whole, write_whole
from stitchmesh.yarnrelax.images import entry_shift, sample_number

wp.set_module_options({"enable_backward": False})


@wp.func
def contact_energy(distance2: Any, reach2: Any, stiffness: Any) -> Any:
    """Energy [erg] of two samples at a squared distance below ``reach2``."""
    d2 = distance2 / reach2
    return stiffness * (type(d2)(1.0) / d2 + d2 - type(d2)(2.0))


@wp.func
def contact_push(distance2: Any, reach2: Any, stiffness: Any) -> Any:
    """Force over the vector from the other sample."""
    ratio = reach2 / distance2
    return type(ratio)(2.0) * stiffness * (ratio * ratio - type(ratio)(1.0)) / reach2


@wp.func
def contact_stiffness(distance2: Any, reach2: Any, stiffness: Any) -> Any:
    """Second derivative of the energy by the distance."""
    ratio = reach2 / distance2
    return stiffness * (type(ratio)(6.0) * ratio * ratio + type(ratio)(2.0)) / reach2


@wp.func
def from_entry(images: Any, samples: wp.array[Any], here: Any, entry: int) -> Any:
    """Vector from a listed sample, in its image, to ``here``; the sum of the two radii last."""
    there = read_whole(samples, sample_number(images, entry))
    apart = here - there
    return type(here)(apart[0], apart[1], apart[2], here[3] + there[3]) - entry_shift(images, type(here)(), entry)


@wp.func
def pair_push(apart: Any, weight: Any) -> tuple[Any, Any]:
    """Force from one listed sample with its stiffness, and stiffness over squared distance.

    ``weight`` is that sample's, or 0 to leave it out.
    """
    distance2 = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
    reach2 = apart[3] * apart[3]
    push = type(apart)()
    stiff = weight - weight
    if distance2 < reach2:
        size = contact_push(distance2, reach2, weight)
        stiff = contact_stiffness(distance2, reach2, weight)
        push = type(apart)(apart[0] * size, apart[1] * size, apart[2] * size, stiff)
        stiff = stiff / distance2
    return push, stiff


@wp.func
def outer_product(apart: Any, size: Any, zero: Any) -> Any:
    """The product apart apart^T times size as (xx, yy, zz, xy, xz, yz)."""
    x, y, z = apart[0] * size, apart[1] * size, apart[2] * size
    return type(zero)(x * apart[0], y * apart[1], z * apart[2], x * apart[1], x * apart[2], y * apart[2])


@wp.kernel(module="unique")
def contact_forces(
    # model
    model: Any,
    # state in
    samples: wp.array[Any],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    sample_force: wp.array[Any],
    sample_block: wp.array[Any],
) -> None:
    """Contact force on each sample and the row sum of its stiffness; its 3 x 3 block of stiffness where there is room.

    Four entries at a time, so that their places are on the way together; those past the end count for nothing.
    """
    p = wp.tid()
    here = read_whole(samples, p)
    push = type(here)()
    block = type(sample_block[0])()
    count = candidate_count[p]
    last = count - 1
    nothing = here[0] - here[0]
    for c in range(0, count, 4):
        entry0 = candidates[p, c]
        entry1 = candidates[p, wp.min(c + 1, last)]
        entry2 = candidates[p, wp.min(c + 2, last)]
        entry3 = candidates[p, wp.min(c + 3, last)]
        apart0 = from_entry(model.images, samples, here, entry0)
        apart1 = from_entry(model.images, samples, here, entry1)
        apart2 = from_entry(model.images, samples, here, entry2)
        apart3 = from_entry(model.images, samples, here, entry3)
        weight0 = model.sample_weight[sample_number(model.images, entry0)]
        weight1 = wp.where(c + 1 < count, model.sample_weight[sample_number(model.images, entry1)], nothing)
        weight2 = wp.where(c + 2 < count, model.sample_weight[sample_number(model.images, entry2)], nothing)
        weight3 = wp.where(c + 3 < count, model.sample_weight[sample_number(model.images, entry3)], nothing)
        push0, stiff0 = pair_push(apart0, weight0)
        push1, stiff1 = pair_push(apart1, weight1)
        push2, stiff2 = pair_push(apart2, weight2)
        push3, stiff3 = pair_push(apart3, weight3)
        push += push0 + push1 + push2 + push3
        block += outer_product(apart0, stiff0, block) + outer_product(apart1, stiff1, block)
        block += outer_product(apart2, stiff2, block) + outer_product(apart3, stiff3, block)
    scale = model.sample_weight[p] * model.k_contact
    write_whole(sample_force, p, push * scale)
    if sample_block.shape[0] > 0:
        sample_block[p] = block * scale


@wp.kernel(module="unique")
def contact_energies(
    # model
    model: Any,
    # state in
    samples: wp.array[Any],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    sample_energy: wp.array[Any],
) -> None:
    """Half of each pair's energy [erg], at both of its samples."""
    p = wp.tid()
    here = samples[p]
    energy = model.k_contact - model.k_contact
    weight = model.sample_weight[p] * model.k_contact
    for c in range(candidate_count[p]):
        entry = candidates[p, c]
        apart = from_entry(model.images, samples, here, entry)
        distance2 = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
        reach2 = apart[3] * apart[3]
        if distance2 < reach2:
            stiffness = weight * model.sample_weight[sample_number(model.images, entry)]
            energy += contact_energy(distance2, reach2, stiffness)
    sample_energy[p] = energy * type(energy)(0.5)
