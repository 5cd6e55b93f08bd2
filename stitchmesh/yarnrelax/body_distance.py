# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Distance of yarns from a surface, such as a body."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import scalar_named
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.body_surface import gap_to, put_surface
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import put_model


@kernel
def surface_distances(
    # model
    surface: Any,
    limit: Any,
    # state in
    samples: wp.array[Any],
    # state out
    distance: wp.array[Any],
) -> None:
    """Signed distance of each sample from a surface, at most ``limit``."""
    p = wp.tid()
    distance[p] = gap_to(surface, samples[p], limit)[3]


@alone()
def body_distance(yarns: YarnSet, body: Mesh, *, contact_samples: int = 3, device: str | None = None) -> FloatArray:
    """Return the least distance [cm] from the surface of a body to the surface of the yarn in each segment, shape (S,).

    The distance is negative where the yarn is inside the body.

    Args:
        yarns: the yarns.
        body: the surface, with its faces outwards.
        contact_samples: number of places along each segment at which the distance is measured.
        device: "cpu", "cuda:0" ...; None for the first GPU, or the CPU if there is no GPU.

    Raises:
        ParameterError: the device is unknown, or the count is below 1.
    """
    model = put_model(
        yarns, YarnMaterial.named(), quadrature_points=1, contact_samples=contact_samples,
        scalar=scalar_named("float64"), device=device_named(device),
    )  # fmt: skip
    state = make_state(model)
    place_contact_samples(model, state, model.launch)
    surface = put_surface(model, body)
    everything = np.concatenate([yarns.points, body.vertices])
    limit = 2.0 * float(np.linalg.norm(np.ptp(everything, axis=0))) / model.unit
    distance = model.empty(model.sample_count)
    inputs = [surface.constants, model.number(limit), state.samples]
    model.launch(surface_distances, model.sample_count, inputs, [distance])
    least = np.minimum.reduceat(distance.numpy().astype(np.float64), np.asarray(model.sample_start)[:-1])
    return least * model.unit - yarns.radius[yarns.segment_yarn]
