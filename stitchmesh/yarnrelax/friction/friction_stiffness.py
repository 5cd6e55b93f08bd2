# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The second derivatives of friction: the stiffness of each pair that presses, for the assembled Hessian."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.yarnrelax.friction.friction_law import slip_stiffness_block, vector_from
from stitchmesh.yarnrelax.model.lattice_images import sample_number


@kernel
def friction_stiffness(
    # model
    images: Any,
    law: Any,
    tangent: wp.array[Any],
    contact_count: wp.array[wp.int32],
    contact_entry: wp.array2d[wp.int32],
    anchor: wp.array2d[Any],
    press: wp.array2d[Any],
    # state in
    samples: wp.array[Any],
    # state out
    stiffness: wp.array2d[Any],
) -> None:
    """The block of each pair, as (xx, yy, zz, xy, xz, yz)."""
    p = wp.tid()
    for c in range(contact_count[p]):
        force, entry = press[p, c], contact_entry[p, c]
        slip = vector_from(images, samples, p, samples[p], entry, force) - anchor[p, c]
        q = sample_number(images, entry)
        stiffness[p, c] = slip_stiffness_block(force, slip, tangent[p], tangent[q], law, type(stiffness[p, c])())
