# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Narrow phase of the contact search: for each contact sample the samples that may touch it, kept over many iterations.

The candidate list of a sample contains every sample of a segment that may collide with its own segment, up to the
contact distance plus a margin, in ascending order. On a lattice an entry is the sample plus the number of samples times
its image (``lattice_images``). Each pair is listed from both sides. A list stays complete while no control point has
moved by more than half the margin since the list was made: the weights of the spline sum to one, so samples move no
farther than control points. The step limit keeps control points from moving farther. The force does not depend on the
margin, because samples beyond the contact distance add nothing.

The broad phase gives each segment a list of the segments near it, which lasts longer (``broad_phase``). The narrow
phase compares the samples of these segments. Lists of both phases have a fixed capacity. A list that does not fit is
counted in full, and the search is repeated with more capacity (``captured_search``), so that no pair is dropped. On a
GPU the lists of neighbouring samples are interleaved, so that a warp reads whole lines of memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3, Vec4, load_vector
from stitchmesh.simulation.pair_lists import FIRST_CAPACITY, allocate_lists
from stitchmesh.yarnrelax.collision.broad_phase import (
    NearSegments,
    make_near_segments,
)
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import cell_of, image_of, shifted_by

NARROWEST_MARGIN = 0.3
"""Margin of the candidate lists where motion is slow, in mean radii."""
MARGIN_CHANGE = 1.5
"""Factor by which the margin becomes narrower or wider."""
SHORT_LIFE, LONG_LIFE = 10, 40
"""Lists that last at most the first number of iterations get a wider margin; above the second, a narrower one."""
WIDEST_MARGIN = 0.6
"""Margin of the candidate lists at the start of a relaxation, in mean radii; it is the widest one."""


@kernel
def list_samples(
    # model
    model: YarnConstants,
    margin: Scalar,
    segment_count: int,
    # state in
    samples: wp.array[Vec4],
    centre: wp.array[Vec3],
    extent: wp.array[Scalar],
    near_count: wp.array[wp.int32],
    near: wp.array2d[wp.int32],
    # state out
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
) -> None:
    """Samples near each sample, in ascending order; an entry counts images by the number of samples."""
    p = wp.tid()
    s = model.sample_segment[p]
    here4 = load_vector(samples, p)
    here = type(centre[0])(here4[0], here4[1], here4[2])
    cell = cell_of(model.images, s)
    reach = here4[3] + margin
    found = int(0)
    for n in range(wp.min(near_count[s], near.shape[1])):  # a list beyond its capacity is made again
        entry = near[s, n]
        image = image_of(model.images, entry, segment_count)
        j = entry - image * segment_count
        seen_from = here + here - shifted_by(model.images, here, cell, image)
        away = centre[j] - seen_from
        limit = reach + extent[j]
        if wp.dot(away, away) < limit * limit:
            for q in range(model.sample_start[j], model.sample_start[j + 1]):
                there = load_vector(samples, q)
                apart = type(here)(there[0], there[1], there[2]) - seen_from
                limit = reach + there[3]
                if wp.dot(apart, apart) < limit * limit:
                    if found < candidates.shape[1]:
                        candidates[p, found] = image * samples.shape[0] + q
                    found += 1
    candidate_count[p] = found


@dataclass(eq=False)
class Candidates:
    """Candidate lists of all samples."""

    margin: float
    """Distance beyond contact up to which pairs are listed, in units."""
    count: wp.array[Any]
    """Length of each list, shape (P,)."""
    lists: wp.array[Any]
    """Samples in each list, ascending, shape (P, capacity)."""
    near: NearSegments
    """The near lists of the broad phase."""


def make_candidates(model: Model, margin: float) -> Candidates:
    """Return empty lists for the samples of a model."""
    count = wp.zeros(model.sample_count, dtype=wp.int32, device=model.device)
    lists = allocate_lists(model.sample_count, FIRST_CAPACITY, model.device)
    return Candidates(margin, count, lists, make_near_segments(model))


def narrow_launch(model: Model, samples: wp.array[Any], candidates: Candidates, launcher: Launcher) -> Any:
    """Return the launch that fills the candidate lists from the near lists of the broad phase."""
    near = candidates.near
    inputs = [model.constants, model.number(candidates.margin), model.segment_count, samples, near.centre, near.extent,
              near.count, near.lists]  # fmt: skip
    return launcher(list_samples, model.sample_count, inputs, [candidates.count, candidates.lists])


def fitting_margin(margin: float, age: int) -> float:
    """Return the margin of the next candidate lists [units]: wider if lists do not last, narrower if they do.

    Args:
        margin: the margin of the present lists.
        age: number of iterations that they have lasted.
    """
    if age <= SHORT_LIFE:
        return min(margin * MARGIN_CHANGE, WIDEST_MARGIN)
    return max(margin / MARGIN_CHANGE, NARROWEST_MARGIN) if age > LONG_LIFE else margin
