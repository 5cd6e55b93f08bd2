# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact force per length of yarn: how hard the yarns press on each segment.

The contact forces on a yarn between others cancel, so their sum does not show how hard the yarn is pressed. The contact
load therefore sums the magnitudes of the forces between pairs of contact samples (``energies/contact``), and divides
the sum of each segment by its rest length.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.device import alone
from stitchmesh.compute.kernel import kernel
from stitchmesh.mesh import FloatArray
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.contact import contact_force_scale
from stitchmesh.yarnrelax.evaluate import put_evaluations
from stitchmesh.yarnrelax.model.lattice_images import sample_number
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.model.spline import from_entry


@kernel
def contact_magnitudes(
    # model
    model: Any,
    # state in
    samples: wp.array[Any],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    magnitude: wp.array[Any],
) -> None:
    """Sum of the magnitudes of the contact forces on each sample."""
    p = wp.tid()
    here = samples[p]
    scale = model.sample_stiffness[p]
    total = scale - scale
    for c in range(candidate_count[p]):
        entry = candidates[p, c]
        apart = from_entry(model.images, samples, p, here, entry)
        distance2 = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
        reach2 = apart[3] * apart[3]
        if distance2 < reach2:
            weight = model.sample_weight[sample_number(model.images, entry)]
            push, _stiff, _inverse = contact_force_scale(distance2, reach2, weight)
            total += push * wp.sqrt(distance2)
    magnitude[p] = total * scale


@alone()
def contact_load(
    yarns: YarnSet, material: YarnMaterial, *, precision: str = "float64", contact_samples: int = 11,
    device: str | None = None,
) -> FloatArray:  # fmt: skip
    """Return the contact force per rest length on each segment [dyn/cm], shape (S,).

    Args:
        yarns: the yarns, on a lattice or not.
        material: stiffnesses, used without change (``YarnMaterial.scaled`` adapts them to another radius).
        precision: "float32" or "float64".
        contact_samples: contact samples for each segment.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.

    Raises:
        ParameterError: the device or the precision is unknown, or a count is below 1.
    """
    model, state, candidates = put_evaluations([(yarns, material)], precision, 1, contact_samples, device)
    magnitude = model.empty(model.sample_count)
    model.launch(
        contact_magnitudes, model.sample_count,
        [model.constants, state.samples, candidates.count, candidates.lists], [magnitude],
    )  # fmt: skip
    total = np.add.reduceat(magnitude.numpy().astype(np.float64), np.asarray(model.sample_start)[:-1])
    return total / model.unit / yarns.rest_length
