# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One segment of a uniform cubic B-spline, written in the three legs between its four control points, and its samples.

With legs d0, d1, d2 the derivatives by the parameter s in [0, 1] are convex combinations,

    y'  = (1-s)^2/2 d0 + (1/2 + s - s^2) d1 + s^2/2 d2        y'' = (1-s) (d1 - d0) + s (d2 - d1)

so |y'| and |y''| are bounded by the longest leg and by the largest difference of legs. A force that acts through the
legs sums to zero over the four points by construction. One row of a quadrature rule is
(weight of d0, d1, d2; 1-s, s; quadrature weight). Gauss points converge exponentially here: three Gauss points are as
accurate as eleven equidistant points with Simpson's rule.

Contact samples are equidistant points of the curve, y_p = sum over j of B_j(s_p) q_j (L section 3.1). The spheres
around the samples leave no gap along a yarn. The arc around a sample stays within its *reach* of the sample, which is
half the longest leg between control points over the number of samples. The spheres touch while the reach is at most
one radius.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Vec3, Vec4, load_vector, store_vector
from stitchmesh.yarnrelax.model.constants import YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import LatticeImages, corner_place, entry_shift, sample_number

if TYPE_CHECKING:
    from stitchmesh.yarnrelax.model.constants import Model
    from stitchmesh.yarnrelax.model.state import State

LARGEST_REACH = 0.85
"""Largest reach of a contact sample at the start, over the yarn radius; the rest is for yarns that become longer."""


@wp.func
def segment_corners(model: YarnConstants, points: wp.array[Vec3], s: int) -> tuple[Any, Any, Any, Any]:
    """The four control points of a segment, each where its image lies."""
    corner = model.segment_points[s]
    q0 = corner_place(model.images, points, s, 0, corner[0])
    q1 = corner_place(model.images, points, s, 1, corner[1])
    q2 = corner_place(model.images, points, s, 2, corner[2])
    q3 = corner_place(model.images, points, s, 3, corner[3])
    return q0, q1, q2, q3


@wp.func
def weight_row(model: YarnConstants, count: int, k: int) -> int:
    """Row of the tables of sample weights for sample ``k`` of a segment with ``count`` samples."""
    return (count * (count - 1)) // 2 + k


@wp.func
def put_samples(model: YarnConstants, s: int, q0: Vec3, q1: Vec3, q2: Vec3, q3: Vec3, samples: wp.array[Vec4]) -> None:
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
    model: YarnConstants,
    # state in
    points: wp.array[Vec3],
    # state out
    samples: wp.array[Vec4],
) -> None:
    """Contact samples: place and yarn radius."""
    s = wp.tid()
    q0, q1, q2, q3 = segment_corners(model, points, s)
    put_samples(model, s, q0, q1, q2, q3, samples)


@wp.func
def from_entry(images: LatticeImages, samples: wp.array[Vec4], p: int, here: Vec4, entry: int) -> Any:
    """Vector from a sample that ``p`` lists, in its image, to ``here``, where p lies; the sum of the two radii last."""
    there = load_vector(samples, sample_number(images, entry))
    apart = here - there
    return type(here)(apart[0], apart[1], apart[2], here[3] + there[3]) - entry_shift(images, type(here)(), p, entry)


def place_contact_samples(model: Model, state: State, launcher: Launcher) -> Any:
    """Return the launch that places the contact samples on the curves."""
    return launcher(place_samples, model.segment_count, [model.constants, state.points], [state.samples])
