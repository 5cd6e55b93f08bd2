# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact samples: equidistant points of the curves, y_p = sum over j of B_j(s_p) q_j (L section 3.1)."""

from __future__ import annotations

from typing import Any

import warp as wp

from stitchmesh.compute.kernel import kernel
from stitchmesh.yarnrelax.aligned import write_whole
from stitchmesh.yarnrelax.curve import segment_corners, weight_row


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
        write_whole(samples, first + k, type(samples[0])(place[0], place[1], place[2], radius))


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
