# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact samples: equidistant points of the curves, y_p = sum over j of B_j(s_p) q_j (L section 3.1).

Spheres around the samples leave no gap along a yarn (L section 3.1). The arc that a sample stands for lies within its
*reach* of the sample, half the longest leg between control points over the number of samples. The spheres touch while
that is one radius; ``LARGEST_REACH`` leaves room for a yarn that stretches.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.vector_loads import store_vector
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.model.spline import segment_corners, weight_row

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.model.constants import Model
    from stitchmesh.yarnrelax.model.state import State

LARGEST_REACH = 0.85
"""Largest reach of a contact sample over the yarn radius at the start."""


@wp.func
def put_samples(model: Any, s: int, q0: Any, q1: Any, q2: Any, q3: Any, samples: wp.array[Any]) -> None:
    """Write place and radius of the samples of segment ``s``."""
    first = model.sample_start[s]
    count = model.sample_start[s + 1] - first
    radius = model.yarn_radius[model.segment_yarn[s]]
    row = weight_row(model, count, 0)
    for k in range(count):
        weight = model.sample_basis[row + k]
        place = q0 * weight[0] + q1 * weight[1] + q2 * weight[2] + q3 * weight[3]
        store_vector(samples, first + k, type(samples[0])(place[0], place[1], place[2], radius))


@kernel
def place_samples(
    # model
    model: Any,
    # state in
    points: wp.array[Any],
    # state out
    samples: wp.array[Any],
) -> None:
    """Contact samples: place and yarn radius."""
    s = wp.tid()
    q0, q1, q2, q3 = segment_corners(model, points, s)
    put_samples(model, s, q0, q1, q2, q3, samples)


def sample_counts(yarns: YarnSet, contact_samples: int) -> NDArray[np.int64]:
    """Contact samples of each segment, at least ``contact_samples``, shape (S,)."""
    corners = yarns.points[yarns.segment_points]
    if yarns.point_shift is not None:
        corners = corners + yarns.point_shift
    leg = np.linalg.norm(np.diff(corners, axis=1), axis=2).max(axis=1)
    reach = np.maximum(leg, yarns.rest_length) / (2 * yarns.radius[yarns.segment_yarn])
    return np.maximum(contact_samples, np.ceil(reach / LARGEST_REACH)).astype(np.int64)


def place_contact_samples(model: Model, state: State, launcher: Callable[..., Any]) -> Any:
    """The launch that places the contact samples on the curves."""
    return launcher(place_samples, model.segment_count, [model.constants, state.points], [state.samples])
